"""One view on several canvases: of a window that is resized, and of parts of a parallel view."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.ink.stroke import Stroke

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.view.camera import Camera

SAME_VIEW: Final = 1e-9
"""Difference between two cameras, relative to their distance, that carrying them into another frame
can make."""


def is_one_view(one: Camera, other: Camera, slack: float = SAME_VIEW) -> bool:
    """Return whether two cameras show the same, whatever the sizes of their canvases.

    The point about which a view turns, and which way counts as up, do not matter. A parallel view
    that is moved over the sheet or enlarged is still the same one: it shows another part of it.
    """
    if one == other:
        return True
    if one.kind != other.kind or np.abs(one.axes - other.axes).max() >= slack:
        return False
    return one.kind == "orthographic" or bool(
        abs(one.fov_y - other.fov_y) < slack * one.fov_y
        and np.abs(np.subtract(one.eye, other.eye)).max() < slack * one.distance
    )


def carried_places(points: ArrayLike, before: Camera, now: Camera) -> Array:
    """Return places (n, 2) of one canvas on another one of the same view, px.

    A canvas is as high as the view, whatever its width: places keep their distance from the
    middle, in heights of the canvas. The canvas of a parallel view may be moved over the sheet.
    """
    scale = now.viewport[1] / before.viewport[1]
    middle = 0.5 * np.asarray(now.viewport)
    if now.kind == "orthographic":
        scale *= before.height / now.height
        right, up, _ = now.axes @ np.subtract(before.eye, now.eye)
        middle = middle + now.pixels_per_mm * np.array((right, -up))
    return np.asarray(
        middle + scale * (np.asarray(points, float) - 0.5 * np.asarray(before.viewport))
    )


def on_canvas(stroke: Stroke, camera: Camera) -> Stroke:
    """Return a stroke as it would be on the canvas of a camera of the same view."""
    if stroke.camera == camera:
        return stroke
    return drawn_at(stroke, carried_places(stroke.points, stroke.camera, camera), camera)


def on_sheet_of(stroke: Stroke, camera: Camera) -> Stroke:
    """Return a stroke as it lies on the sheet of a camera that looks the same way.

    The sheet is the plane through the camera's target, square to its view. Lines that are drawn on
    it stay where they are while a view is moved and enlarged, and while its perspective is
    switched on and off.
    """
    if is_one_view(stroke.camera, camera):
        return on_canvas(stroke, camera)
    places = stroke.camera.on_plane(stroke.points, camera.target, camera.axes[2])
    return drawn_at(stroke, camera.project(places)[0], camera)


def drawn_at(stroke: Stroke, places: Array, camera: Camera) -> Stroke:
    """Return a stroke with the same pen at other places (n, 2) px, on another canvas."""
    x, y = places.T
    return Stroke(
        x,
        y,
        camera,
        pressure=stroke.pressure if stroke.has_pressure else None,
        t=stroke.t if stroke.has_time else None,
        tool=stroke.tool,
        color=stroke.color,
        group=stroke.group,
    )
