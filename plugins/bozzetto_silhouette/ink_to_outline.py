"""From ink on a sheet to a checked outline, with mistakes pointed out where they were drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto_silhouette.memory import Memory
from bozzetto_silhouette.outline import Outline, outline_from_strokes
from bozzetto_silhouette.sheet import Sheet
from bozzetto_silhouette.state import Part

__all__ = ["outline_of", "points_on_sheet", "surrounds"]

Array = NDArray[np.float64]

_outlines: Memory[Outline] = Memory(limit=512)
"""The tool looks at an outline before the solver does, and at those of all parts at every
stroke."""


def points_on_sheet(strokes: Sequence[Stroke], sheet: Sheet) -> list[Array]:
    """Every stroke's samples on the sheet, shape (n, 2) each, mm.

    Raises
    ------
    UserError
        If a line of sight misses the sheet: the view looks along it.
    """
    found = [sheet.from_pixels(stroke.points, stroke.camera) for stroke in strokes]
    if not all(np.isfinite(points).all() for points in found):
        raise UserError(
            "From this side the drawing lies edge-on to the sheet. Turn the view, then draw."
        )
    return found


def outline_of(part: Part) -> Outline:
    """The closed rings that a part's ink describes, in the part's object frame.

    Raises
    ------
    UserError
        If the ink does not close or crosses itself; its places are canvas pixels.
    """
    return _outlines.recall(part, lambda: _outline_of(part))


def _outline_of(part: Part) -> Outline:
    strokes = tuple(part.strokes)
    try:
        return outline_from_strokes(points_on_sheet(strokes, part.sheet))
    except UserError as problem:
        if not problem.places:
            raise
        camera = strokes[-1].camera
        pixels, _ = camera.project(part.sheet.to_world(np.asarray(problem.places)))
        raise UserError(problem.message, places=[(x, y) for x, y in pixels]) from None


def surrounds(outline: Outline, points: Array) -> bool:
    """Whether all points lie inside the outline (in a hole is outside)."""
    from shapely import contains_xy, prepare

    region = outline.polygon()
    prepare(region)
    return bool(contains_xy(region, points[:, 0], points[:, 1]).all())
