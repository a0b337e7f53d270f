"""One view on canvases of several sizes: a window that is resized shows the same view."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from bozzetto.ink import Stroke
from bozzetto.view import Camera

SAME: Final = 1e-9
"""Difference between two cameras that carrying them into another frame can make."""


def is_one_view(one: Camera, other: Camera) -> bool:
    """Return whether two cameras show the same, whatever the sizes of their canvases.

    The point about which a view turns, and which way counts as up, do not matter.
    """
    if one == other:
        return True
    wide = [c.fov_y if one.kind == "perspective" else c.height for c in (one, other)]
    return bool(
        one.kind == other.kind
        and abs(wide[0] - wide[1]) < SAME * wide[0]
        and np.abs(np.subtract(one.eye, other.eye)).max() < SAME * one.distance
        and np.abs(one.axes - other.axes).max() < SAME
    )


def on_canvas(stroke: Stroke, camera: Camera) -> Stroke:
    """Return a stroke as it would be on the canvas of a camera of the same view.

    The canvas is as high as the view, whatever its width: places keep their distance from
    the middle, in heights of the canvas.
    """
    if stroke.camera == camera:
        return stroke
    (width, height), (wide, high) = stroke.camera.viewport, camera.viewport
    scale = high / height
    return Stroke(
        0.5 * wide + scale * (stroke.x.astype(float) - 0.5 * width),
        0.5 * high + scale * (stroke.y.astype(float) - 0.5 * height),
        camera,
        pressure=stroke.pressure if stroke.has_pressure else None,
        t=stroke.t if stroke.has_time else None,
        tool=stroke.tool,
        color=stroke.color,
        group=stroke.group,
    )


def by_view(strokes: Iterable[Stroke]) -> tuple[tuple[Stroke, ...], ...]:
    """Return the strokes of each view, on the canvas of the first of them, in the order drawn."""
    views: list[list[Stroke]] = []
    for stroke in strokes:
        for drawn in views:
            if is_one_view(stroke.camera, drawn[0].camera):
                drawn.append(on_canvas(stroke, drawn[0].camera))
                break
        else:
            views.append([stroke])
    return tuple(tuple(drawn) for drawn in views)
