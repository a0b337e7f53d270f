"""A checked outline from ink on a sheet; mistakes are pointed out where they were drawn."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import remembered
from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes
from bozzetto_silhouette.model.sketch_plane import Sheet
from bozzetto_silhouette.model.state import Oversketch, Part, Removal, Smoothing
from bozzetto_silhouette.outline.edits import Rings, edited
from bozzetto_silhouette.outline.outline import Outline, outline_from_rings

GRAINS = tuple(1.0 / scale for scale in (1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0))
"""Distances of the places that a mouse can tell, px: those of the screen's own pixels."""

ON_GRAIN = 2e-3
"""Rounding of such places, in grains: strokes are kept in single precision."""


def points_on_sheet(strokes: Sequence[Stroke], sheet: Sheet) -> list[Array]:
    """Project every stroke's samples onto the sheet, shape (n, 2) each, mm.

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


# The tool looks at an outline before the solver does, and at those of all parts at every stroke.
@remembered(limit=512, key=lambda part: (part.strokes, part.sheet, part.edits))
def outline_of(part: Part) -> Outline:
    """Return the closed rings of a part's ink after all edits, in the part's object frame.

    Raises
    ------
    UserError
        If the ink does not close or crosses itself; its places are canvas pixels.
    """
    outline = outline_from_rings([ring for ring in rings_of(part) if ring is not None])
    if not outline.rings:
        raise UserError("Nothing is left of this outline. Undo the last step on it.")
    return outline


def rings_of(part: Part) -> Rings:
    """Return the rings by their numbers, as edits name them, in the part's object frame.

    Raises
    ------
    UserError
        As `outline_of`.
    """
    rings: Rings = ()
    ink = (tuple(stroke.digest for stroke in part.strokes), part.sheet)
    edits = [(type(e), e.ring, b"" if isinstance(e, Removal) else e.stroke.digest)
             for e in part.edits]  # fmt: skip
    for count in range(len(edits) + 1):
        rings = _after((ink, tuple(edits[:count])), part, rings, count)
    return rings


# After every edit: the next one begins there.
@remembered(limit=512, key=lambda ink_and_edits, part, before, count: ink_and_edits)
def _after(ink_and_edits: Hashable, part: Part, before: Rings, count: int) -> Rings:
    """Return the rings after so many edits, from those after one edit less."""
    edit = part.edits[count - 1] if count else None
    strokes = (edit.stroke,) if isinstance(edit, Oversketch | Smoothing) else tuple(part.strokes)
    lines = points_on_sheet(strokes, part.sheet)
    try:
        if edit is None:
            by_hand = any(stroke.tool != "imported" for stroke in strokes)
            return tuple(rings_from_strokes(lines, grain=_grain(strokes, lines), by_hand=by_hand))
        return edited(before, edit, lines[0])
    except UserError as problem:
        if not problem.places:
            raise
        camera = strokes[-1].camera
        pixels, _ = camera.project(part.sheet.to_world(np.asarray(problem.places)))
        raise UserError(problem.message, places=[(x, y) for x, y in pixels]) from None


def _grain(strokes: Sequence[Stroke], lines: Sequence[Array]) -> float:
    """Return the distance on the sheet of the places that samples can have, mm; 0 for a pen's.

    A mouse tells whole pixels of the screen.
    """
    if not strokes:
        return 0.0
    points = np.concatenate([stroke.points for stroke in strokes]).astype(np.float64)
    grain = next((g for g in GRAINS if _lies_on(points, g)), 0.0)
    if not grain:
        return 0.0
    ways = [np.diff(stroke.points.astype(np.float64), axis=0) for stroke in strokes]
    pixels = np.hypot(*np.concatenate(ways).T)
    moved = np.hypot(*np.concatenate([np.diff(line, axis=0) for line in lines]).T)
    return grain * float(moved.sum() / max(pixels.sum(), 1e-300))


def _lies_on(points: Array, grain: float) -> bool:
    """Whether all coordinates are multiples of a grain."""
    return bool((np.abs(points / grain - np.rint(points / grain)) < ON_GRAIN).all())


def surrounds(outline: Outline, points: Array) -> bool:
    """Whether all points lie inside the outline (in a hole is outside)."""
    from shapely import contains_xy, prepare

    region = outline.polygon()
    prepare(region)
    return bool(contains_xy(region, points[:, 0], points[:, 1]).all())
