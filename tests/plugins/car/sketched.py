"""Cars that no template knows, and sketches of them with marks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.view import Camera
from bozzetto.view.calibration import resect
from bozzetto_car.camera.marked_view import MarkedView
from bozzetto_car.camera.visibility import facing
from bozzetto_car.template.model import Template

Array = NDArray[np.float64]

PICTURE = (1200.0, 800.0)

FRONT = ((0.0, 6.0), (1.0, 8.0), (8.0, 12.0))
FRONT_QUARTER = ((30.0, 60.0), (3.0, 20.0), (6.0, 10.0))
SIDE = ((84.0, 90.0), (1.0, 6.0), (10.0, 14.0))
REAR_QUARTER = ((120.0, 150.0), (3.0, 20.0), (6.0, 10.0))
"""Views: ranges of azimuth and elevation, degrees, and of the distance, m."""

View = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


def styled(template: Template, seed: int) -> Array:
    """A car as a designer might change one: bonnet, roof, waist, glass, tail, width; mm."""
    rng = np.random.default_rng(seed)
    car = template.positions.copy()
    side = np.sign(car[:, 1])

    def nodes(*halves: str) -> list[int]:
        return [i for name, i in template.node.items() if name.split(".")[0] in halves]

    roof, rails = nodes("C3", "C4", "C5", "R1", "R2", "R3"), nodes("R1", "R2", "R3")
    car[nodes("C0", "C1", "S1", "B1", "WF"), 0] -= rng.normal(0.0, 90.0)
    car[nodes("WF"), 0] -= rng.normal(0.0, 30.0)
    car[roof, 2] += rng.normal(0.0, 60.0)
    car[rails, 1] += side[rails] * rng.normal(0.0, 35.0)
    car[nodes("S1", "S2", "S3", "S4", "S5", "C1", "C2", "C6", "C7"), 2] += rng.normal(0.0, 40.0)
    car[nodes("C6", "S4"), 0] += rng.normal(0.0, 80.0)
    car[nodes("C2", "C3", "R1", "S2"), 0] += rng.normal(0.0, 60.0)
    car[nodes("C7", "C8", "S5", "S6", "B5", "B4", "WR"), 0] += rng.normal(0.0, 90.0)
    car[:, 1] *= 1.0 + rng.normal(0.0, 0.04)
    return car


def rubbery(template: Template, seed: int) -> Array:
    """A car stretched along each axis by some six per cent, with smooth bumps of 50 mm."""
    rng = np.random.default_rng(seed)
    stretch = 1.0 + rng.normal(0.0, 0.06, 3)
    count = len(template.names)
    nearness = np.exp(
        -(((template.positions[:, None] - template.positions) / 800.0) ** 2).sum(axis=2)
    )
    bumps = nearness @ rng.normal(0.0, 40.0, (count, 3)) / np.sqrt(nearness.sum(1))[:, None]
    image = bumps[template.mirrored] * [1.0, -1.0, 1.0]
    return template.positions * stretch + 0.5 * (bumps + image) * np.sqrt(2.0)


def looking(car: Array, view: View, rng: np.random.Generator, kind: str = "perspective") -> Camera:
    """A camera within the ranges of a view; the car fills three quarters of the width."""
    azimuth, elevation = np.radians(rng.uniform(*view[0])), np.radians(rng.uniform(*view[1]))
    toward = np.array(
        [
            -np.cos(azimuth) * np.cos(elevation),
            np.sin(azimuth) * np.cos(elevation),
            np.sin(elevation),
        ]
    )
    middle = car.mean(axis=0)
    eye = middle + 1000.0 * rng.uniform(*view[2]) * toward
    wide = Camera("perspective", tuple(eye), tuple(middle), fov_y=30.0, viewport=PICTURE)
    share = float(np.ptp(wide.project(car)[0][:, 0])) / (0.75 * PICTURE[0])
    if kind == "orthographic":
        height = wide.visible_height * share
        return Camera("orthographic", tuple(eye), tuple(middle), height=height, viewport=PICTURE)
    opening = 2.0 * np.degrees(np.arctan(np.tan(np.radians(15.0)) * share))
    return Camera("perspective", tuple(eye), tuple(middle), fov_y=opening, viewport=PICTURE)


@dataclass(frozen=True)
class Sketched:
    """A car, its sketches with cameras found from the template, and where all nodes are."""

    car: Array
    views: tuple[MarkedView, ...]
    places: tuple[Array, ...]


def sketched(
    template: Template,
    car: Array,
    views: tuple[View, ...],
    seed: int,
    hand: float = 2.0,
    kind: str = "perspective",
) -> Sketched:
    """Draw the car: marks on all nodes that a view shows, with a hand's noise in px."""
    rng = np.random.default_rng(seed)
    made, places = [], []
    for view in views:
        camera = looking(car, view, rng, kind)
        nodes = np.flatnonzero(facing(template, car, camera))
        seen = camera.project(car)[0]
        marks = seen[nodes] + rng.normal(0.0, hand, (len(nodes), 2))
        start = resect(template.positions[nodes], marks, PICTURE, kind=kind).camera
        made.append(MarkedView(start, nodes, marks))
        places.append(seen)
    return Sketched(car, tuple(made), tuple(places))


def apart(car: Array, other: Array) -> Array:
    """Distance of each node from that of another car laid over it by a similarity, mm, (n,)."""
    mine, theirs = car - car.mean(axis=0), other - other.mean(axis=0)
    left, sizes, right = np.linalg.svd(theirs.T @ mine)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    grown = (sizes * signs).sum() / (mine**2).sum()
    return np.linalg.norm(grown * mine @ (left * signs @ right).T - theirs, axis=1)


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
