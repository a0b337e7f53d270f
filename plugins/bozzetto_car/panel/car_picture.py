"""The picture of a small car that shows the point to mark, from where it is seen best."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.geometry.patches import Patchwork, shaded
from bozzetto.plugin import remembered
from bozzetto.scene import Layer, Palette, Scene, Shaded, in_look, render
from bozzetto.view import Camera, fit_points, triple
from bozzetto_car.parts.part_list import seen_parts
from bozzetto_car.parts.wheels import wheels_of
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.model import Template, ViewHint
from bozzetto_car.template.network import Network
from bozzetto_car.view.edge_items import network_lines

DIVISIONS: Final = 8
"""Steps along each side of a patch."""

AWAY: Final = 12_000.0
"""Distance of the eye from the middle of the car, mm."""

OPENING: Final = 24.0
"""Opening angle of the camera, degrees."""

MARGIN: Final = 0.04
"""Part of the picture left free on each side."""

GLASS: Final = (74, 84, 98)
"""Colour of windows."""

TINT: Final = 0.62
"""Share of the accent in the colour of the patches that a prompt names, and of glass in that of
windows: the clay below holds the picture together."""

USUAL: Final = ViewHint(40.0, 15.0)
"""View hint for a node without one in the template."""


@dataclass(frozen=True)
class Pose:
    """The direction from which the small car is seen, degrees; see `ViewHint`."""

    azimuth: float
    elevation: float


@dataclass(frozen=True, eq=False)
class SmallCar:
    """A picture of the template with one node marked.

    Attributes
    ----------
    pixels : (h, w, 4) uint8
        RGBA, transparent around the car.
    place : (x, y)
        Place of the node in the picture, in units of `size`.
    """

    pixels: NDArray[np.uint8]
    place: tuple[float, float]


def pose_of(template: Template, node: str) -> Pose:
    """Return the pose from which a node is seen best."""
    picture = template.pictures.get(node, USUAL)
    return Pose(picture.azimuth, picture.elevation)


def between(start: Pose, end: Pose, share: float) -> Pose:
    """Return a pose on the shorter way between two, with a soft start and end; share 0 … 1."""
    soft = share * share * (3.0 - 2.0 * share)
    turn = (end.azimuth - start.azimuth + 180.0) % 360.0 - 180.0
    rise = end.elevation - start.elevation
    return Pose(start.azimuth + soft * turn, start.elevation + soft * rise)


def small_car(
    template: Template,
    node: str,
    pose: Pose,
    palette: Palette,
    size: tuple[int, int],
    scale: float = 1.0,
) -> SmallCar:
    """Draw the template as seen from a pose, with the patches of a prompt tinted.

    Parameters
    ----------
    template : Template
        The template.
    node : str
        Name of the node to mark; "" for none.
    pose : Pose
        The direction of the view.
    palette : Palette
        The colours of the window.
    size : (width, height)
        Size of the picture, px.
    scale : float
        Pixels of the picture per px of `size`.
    """
    scene = _painted(template, node, palette)
    camera = _camera(template, pose, size)
    pixels = render(scene, camera, palette, size=size, scale=scale, background=False)
    at = template.positions[[template.node.get(node, 0)]]
    x, y = camera.project(at)[0][0].tolist()
    return SmallCar(pixels, (x, y))


def _camera(template: Template, pose: Pose, size: tuple[int, int]) -> Camera:
    middle = 0.5 * (template.positions.min(axis=0) + template.positions.max(axis=0))
    eye = middle + AWAY * ViewHint(pose.azimuth, pose.elevation).toward_eye
    camera = Camera("perspective", triple(eye), triple(middle), fov_y=OPENING, viewport=size)
    return fit_points(camera, _outline(template), MARGIN)


def _outline(template: Template) -> Array:
    """Return the nodes, and the lowest points of the wheels."""
    wheels = template.positions[template.wheels.ravel()]
    return np.vstack((template.positions, wheels * (1.0, 1.0, 0.0)))


def _painted(template: Template, node: str, palette: Palette) -> Scene:
    tinted = template.pictures.get(node, USUAL).patches
    return _scene(template, tinted, palette)


@remembered(limit=8)
def _scene(template: Template, tinted: tuple[str, ...], palette: Palette) -> Scene:
    network = Network.of(template)
    sides = template.sides.astype(np.int32)
    nets = fair_nets(network)
    mesh = shaded(Patchwork(nets, network.control_points, sides), DIVISIONS)
    clay = np.array(palette.clay, float)
    colors = np.full((len(template.patches), (DIVISIONS + 1) ** 2, 4), 255, np.uint8)
    for number, patch in enumerate(template.patches):
        over = palette.accent if patch.name in tinted else GLASS if patch.glass else palette.clay
        colors[number, :, :3] = np.rint(TINT * np.array(over) + (1.0 - TINT) * clay)
    body = Shaded(replace(mesh, colors=colors.reshape(-1, 4)))
    lines = network_lines(network.control_points, "ink", 1.0, 0.35, hidden="hide")
    seen = seen_parts(wheels_of(network, nets, sunk=False))
    wheels = tuple(in_look(mesh, look) for mesh, look in seen)
    return Scene((Layer("car", (body, *wheels, lines)),))
