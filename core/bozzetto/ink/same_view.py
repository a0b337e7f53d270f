"""One view on canvases of several sizes: a window that is resized shows the same view."""

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

    The point about which a view turns, and which way counts as up, do not matter.
    """
    if one == other:
        return True
    wide = [c.fov_y if c.kind == "perspective" else c.height for c in (one, other)]
    return bool(
        one.kind == other.kind
        and abs(wide[0] - wide[1]) < slack * wide[0]
        and np.abs(np.subtract(one.eye, other.eye)).max() < slack * one.distance
        and np.abs(one.axes - other.axes).max() < slack
    )


def carried_places(points: ArrayLike, before: Camera, now: Camera) -> Array:
    """Return places (n, 2) of one canvas on another one of the same view, px.

    A canvas is as high as the view, whatever its width: places keep their distance from the
    middle, in heights of the canvas.
    """
    scale = now.viewport[1] / before.viewport[1]
    middles = [0.5 * np.asarray(camera.viewport) for camera in (before, now)]
    return np.asarray(middles[1] + scale * (np.asarray(points, float) - middles[0]))


def on_canvas(stroke: Stroke, camera: Camera) -> Stroke:
    """Return a stroke as it would be on the canvas of a camera of the same view."""
    if stroke.camera == camera:
        return stroke
    x, y = carried_places(stroke.points, stroke.camera, camera).T
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
