"""Flat outlines from the closed lines of a drawing, such as a logo in an SVG file."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.ink import Strokes
from bozzetto_product.details.outline_places import polygon_corners
from bozzetto_product.model.emblems import FlatOutlines

MOST_OUTLINES: Final = 200
"""Outlines of one drawing: each is carved by itself."""

MOST_POINTS: Final = 20_000
"""Points of all of them."""

OPEN: Final = 0.01
"""Gap between the ends of a line, as share of its length, up to which it is closed."""

NEAR: Final = 1e-4
"""Distance between points, as share of the drawing's size, up to which they are one."""

STRAIGHT: Final = 3.0
"""Times the shorter side beside it: so long is a straight side, and no step of a curve."""

NO_OUTLINES: Final = "There is no closed outline in “{name}”. Close its lines, or fill them."


def drawing_outlines(strokes: Strokes, name: str) -> tuple[FlatOutlines, float]:
    """Return the closed lines of a drawing as flat outlines, and their height on its sheet.

    Parameters
    ----------
    strokes : Strokes
        The lines, on the sheet of the drawing.
    name : str
        Of the drawing, for messages.

    Returns
    -------
    FlatOutlines
        In heights of the whole, y up.
    float
        Their height, mm, where the sheet is seen in parallel; else px.

    Raises
    ------
    UserError
        If a line is open, or there are no outlines, too many, or none that encloses anything.
    """
    rows = [np.asarray(stroke.points, float) * (1.0, -1.0) for stroke in strokes]
    rows = [row for row in rows if len(row)]
    if not rows:
        raise UserError(NO_OUTLINES.format(name=name[:80]))
    size = float(np.ptp(np.concatenate(rows), axis=0).max())
    whole = [row for row in rows if _is_closed(row)]
    if len(whole) < len(rows):
        raise UserError(
            f"{len(rows) - len(whole)} of {len(rows)} lines in “{name[:80]}” are open. Close them "
            "where they were drawn, or make areas of them."
        )
    made = [_open_ended(row, NEAR * size) for row in whole]
    made = [row for row in made if len(row) >= 3 and np.ptp(row, axis=0).min() > 0.0]
    if not made:
        raise UserError(NO_OUTLINES.format(name=name[:80]))
    count = sum(map(len, made))
    if len(made) > MOST_OUTLINES or count > MOST_POINTS:
        raise UserError(
            f"“{name[:80]}” has {len(made)} outlines of {count} points. {MOST_OUTLINES} of "
            f"{MOST_POINTS} at most can be laid on a surface: use a simpler drawing."
        )
    marked = [_with_straight_sides(row) for row in made]
    points = np.concatenate([row for row, _ in marked])
    low, high = points.min(axis=0), points.max(axis=0)
    height = float(high[1] - low[1])
    camera = strokes[0].camera
    scale = camera.height / camera.viewport[1] if camera.kind == "orthographic" else 1.0
    starts = np.cumsum([0, *(len(row) for row, _ in marked[:-1])]).astype(np.int32)
    corners = np.concatenate([flags for _, flags in marked]).astype(np.uint8)
    return FlatOutlines((points - 0.5 * (low + high)) / height, corners, starts), scale * height


def _is_closed(row: Array) -> bool:
    length = float(np.linalg.norm(np.diff(row, axis=0), axis=1).sum())
    return float(np.linalg.norm(row[-1] - row[0])) <= OPEN * length


def _open_ended(row: Array, near: float) -> Array:
    """Return the points of a closed line, each once, without its first at the end."""
    kept = [row[0]]
    for point in row[1:]:
        if np.linalg.norm(point - kept[-1]) > near:
            kept.append(point)
    while len(kept) > 1 and np.linalg.norm(kept[-1] - kept[0]) <= near:
        kept.pop()
    return np.array(kept)


def _with_straight_sides(row: Array) -> tuple[Array, Flags]:
    """Return a polygon with its corners marked, and a point in the middle of straight sides.

    A smooth curve through the two ends of a side alone might bulge.
    """
    corners = polygon_corners(row)
    side = np.linalg.norm(np.roll(row, -1, axis=0) - row, axis=1)
    beside = np.minimum(np.roll(side, 1), np.roll(side, -1))
    straight = (side > STRAIGHT * beside) | (corners & np.roll(corners, -1))
    corners = corners | straight | np.roll(straight, 1)
    middles = 0.5 * (row + np.roll(row, -1, axis=0))
    order = np.argsort(np.concatenate((np.arange(len(row)), np.flatnonzero(straight) + 0.5)))
    points = np.concatenate((row, middles[straight]))[order]
    return points, np.concatenate((corners, np.zeros(int(straight.sum()), bool)))[order]
