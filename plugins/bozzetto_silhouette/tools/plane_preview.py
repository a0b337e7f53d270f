"""The plane on which a part will lie, and where its first point meets a shape."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import Context
from bozzetto.scene import Item, Layer, Lines, Points, Scene
from bozzetto.view import Camera
from bozzetto_silhouette.model.sketch_plane import Sheet, sheet_at

SHARE = 0.12
"""Half the side of the square that stands for the plane, as a share of the picture's height."""

DOT = 9.0
"""Size of the dot, px."""


def plane_scene(x: float, y: float, camera: Camera, context: Context) -> Scene:
    """Show where an outline that begins at a place of the canvas will lie.

    A dot where its first point comes to lie, filled where that is on a shape; around it a square
    in the plane of the part, with a cross. Of the square, what is behind shapes is faint.
    """
    sheet, landed = sheet_at(x, y, camera, context)
    (middle,) = sheet.from_pixels([(x, y)], camera)
    (above,) = sheet.from_pixels([(x, y - SHARE * camera.viewport[1])], camera)
    half = float(np.hypot(*(above - middle)))
    if not np.isfinite([*middle, half]).all() or half <= 0.0:
        return Scene()
    items: list[Item] = [
        _lines(sheet, middle + half * _SQUARE, [0]),
        _lines(sheet, middle + half * _CROSS, [0, 2]),
        Points(
            sheet.to_world([middle]).astype(np.float32),
            color="accent",
            size=DOT,
            opacity=1.0 if landed else 0.4,
            hidden="show",
        ),
    ]
    return Scene((Layer("preview", tuple(items)),))


_SQUARE = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1.0]])
_CROSS = np.array([[-1, 0], [1, 0], [0, -1], [0, 1.0]])


def _lines(sheet: Sheet, points: Array, starts: list[int]) -> Lines:
    """Draw polylines (n, 2) on the sheet."""
    places = sheet.to_world(points).astype(np.float32)
    return Lines(places, np.array(starts, np.int32), color="accent", width=1.0, opacity=0.6)
