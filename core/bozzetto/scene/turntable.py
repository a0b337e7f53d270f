"""Turntables: a scene that turns once around its upright axis, as a row of pictures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto.scene.renderer import Shading, render
from bozzetto.scene.snapshot import framed, without_handles
from bozzetto.scene.thickness_view import thickness_view
from bozzetto.view.page_views import framing

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.scene.display_list import Scene
    from bozzetto.view.camera import Camera

MOST_PICTURES: Final = 720
"""Pictures of one turn: two for each degree."""

RIM: Final = 32
"""Points on the rims of the cylinder that is framed."""


def turned_pictures(
    scene: Scene,
    count: int,
    *,
    view: str = "three-quarter",
    palette: Palette = LIGHT,
    size: tuple[int, int] = (1200, 900),
    shading: Shading = "clay",
) -> Iterator[NDArray[np.uint8]]:
    """Yield pictures of a scene from all around; all of it lies in each of them.

    Parameters
    ----------
    scene : Scene
        What turns, without its handles; its axis is upright, through the middle.
    count : int
        How many pictures: after so many more the first one would come again.
    view : str
        Name of the standard view of the first one.
    palette, size, shading
        As in `scene.picture`.

    Raises
    ------
    UserError
        If there are too many pictures, or the view has no such name.
    """
    if not 1 <= count <= MOST_PICTURES:
        raise UserError(f"A turntable has 1 to {MOST_PICTURES} pictures.")
    scene = without_handles(scene)
    points = np.asarray(scene.points(), float)
    if not len(points):
        camera, middle = framed(scene, view, size), np.zeros(3)
    else:
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        page = (float(max(size[0], 1)), float(max(size[1], 1)))
        camera = framing(_cylinder(points, middle), view, page)
    if shading == "thickness":
        scene = thickness_view(scene, palette).scene
    for number in range(count):
        seen = turned(camera, 2.0 * np.pi * number / count, middle)
        yield render(scene, seen, palette, size=size, shading=shading)


def turned(camera: Camera, angle: float, middle: Array) -> Camera:
    """Return a camera carried around the upright axis through a point; to the right, radians."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def carried(values: Array) -> tuple[float, float, float]:
        x, y, z = (float(value) for value in turn @ values)
        return x, y, z

    eye, target = (
        carried(np.asarray(one) - middle) + middle for one in (camera.eye, camera.target)
    )
    return replace(
        camera,
        eye=(float(eye[0]), float(eye[1]), float(eye[2])),
        target=(float(target[0]), float(target[1]), float(target[2])),
        up=carried(np.asarray(camera.up)),
    )


def _cylinder(points: Array, middle: Array) -> Array:
    """Return points on the rims of the upright cylinder around some points."""
    radius = float(np.hypot(*(points[:, :2] - middle[:2]).T).max())
    angles = np.linspace(0.0, 2.0 * np.pi, RIM, endpoint=False)
    ring = middle[:2] + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return np.concatenate(
        [np.column_stack([ring, np.full(RIM, z)]) for z in (points[:, 2].min(), points[:, 2].max())]
    )
