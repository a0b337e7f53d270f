"""Pictures of the gallery's cars that look like photographs: shaded, on a road under a sky."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter
from shapely import MultiPoint, Polygon, contains_xy

from bozzetto.scene import LIGHT, Layer, Scene, Shaded, in_look, render
from bozzetto.view import Camera
from bozzetto_car.body.build import body_of
from bozzetto_car.parts.part_list import (
    added_lines,
    added_parts,
    seen_body,
    seen_parts,
    wheel_parts,
)
from bozzetto_car.state import CarState
from bozzetto_car.template.network import Network
from bozzetto_car.view.edge_items import network_lines

Array = NDArray[np.float64]

SKY: Final = np.array([(150, 176, 204), (222, 226, 226)], float)
"""Colours overhead and at the horizon."""

ROAD: Final = np.array([(150, 148, 146), (96, 95, 95)], float)
"""Colours far away and at the feet."""

HILLS: Final = np.array((108, 122, 106), float)

FAR: Final = 30_000.0
"""Distance, mm, at which half of the road's colour is that of far away."""

BESIDE: Final = 12.0
"""Blur of the shadow below a car, px."""

GRAIN: Final = 3.0
"""Standard deviation of the film's grain."""

PAINTS: Final = {"coupe": (150, 36, 40), "estate": (44, 74, 110)}

GAP: Final = (40, 38, 36)
"""Colour of shut lines."""


def photograph(network: Network, camera: Camera, rng: np.random.Generator) -> Image.Image:
    """One picture of a car, as large as the camera's."""
    width, height = (int(side) for side in camera.viewport)
    scene = _painted(network, PAINTS[network.template.id])
    car = render(scene, camera, LIGHT, size=(width, height), background=False).astype(float)
    ground = _ground(camera, network.positions, rng)
    share = car[..., 3:] / 255.0
    mixed = share * car[..., :3] + (1.0 - share) * ground
    soft = gaussian_filter(mixed, (0.6, 0.6, 0.0))
    down, across = np.mgrid[-1.0 : 1.0 : height * 1j, -1.0 : 1.0 : width * 1j]
    lens = 1.0 - 0.16 * (down**2 + across**2)[..., None] / 2.0
    grained = soft * lens + rng.normal(0.0, GRAIN, (height, width, 1))
    return Image.fromarray(np.clip(np.rint(grained), 0, 255).astype(np.uint8))


def _painted(network: Network, paint: tuple[int, int, int]) -> Scene:
    """Return a complete car with mirrors in a colour, with nothing of a drawing about it."""
    state = CarState(template=network.template.id, complete=True, mirrors=True, network=False)
    body = replace(body_of(state), network=network)
    parts = [*added_parts(state, body), *wheel_parts(state, body)]
    seen = [in_look(mesh, look) for mesh, look in (*seen_body(state, body), *seen_parts(parts))]
    solid = [replace(item, opacity=1.0) for item in seen]
    lines = np.array([points for _, points in added_lines(state, body)])
    items = (
        *(_in_paint(item, paint) for item in solid),
        network_lines(lines, GAP, 1.1, 1.0, "hide"),
    )
    return Scene((Layer("car", items),))


def _in_paint(item: Shaded, paint: tuple[int, int, int]) -> Shaded:
    return replace(item, color=paint) if item.color == "clay" else item


def _ground(camera: Camera, car: Array, rng: np.random.Generator) -> Array:
    """Return sky, hills and a road with the shadow of a car, (h, w, 3)."""
    width, height = (int(side) for side in camera.viewport)
    across, down = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    rays = camera.rays(np.stack((across.ravel(), down.ravel()), axis=1))
    up = rays.directions[:, 2].reshape(height, width)
    rise = np.clip(up / 0.35, 0.0, 1.0)[..., None]
    sheet = SKY[1] + rise * (SKY[0] - SKY[1])
    wave = np.cumsum(rng.normal(0.0, 0.004, width))
    hills = 0.05 + 0.02 * np.sin(np.arange(width) / 210.0) + gaussian_filter(wave, 25.0) * 0.2
    sheet[up < hills] = HILLS
    away = np.full(up.shape, np.inf)
    low = up < -1e-4
    away[low] = np.broadcast_to(rays.origins, rays.directions.shape)[low.ravel(), 2] / -up[low]
    far = 1.0 / (1.0 + FAR / away)[..., None]
    sheet = np.where(low[..., None], ROAD[1] + far * (ROAD[0] - ROAD[1]), sheet)
    places = np.zeros((height, width), bool)
    points = rays.origins + rays.directions * np.where(np.isfinite(away), away, 0.0).reshape(-1, 1)
    below = Polygon(MultiPoint(car[:, :2]).convex_hull.buffer(-60.0).exterior)
    places[low] = contains_xy(below, *points[low.ravel(), :2].T)
    shadow = gaussian_filter(places.astype(float), BESIDE)[..., None]
    return np.asarray(sheet * (1.0 - 0.72 * shadow))
