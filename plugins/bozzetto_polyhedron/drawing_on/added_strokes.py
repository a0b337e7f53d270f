"""Strokes added to a body, read in the way in which they close.

Where lines lie in space is said end by end (`stroke_ends`). From nearly above, an end off a face
looks as if it lay on it, and no single line tells. So lines that leave something open are read once
more with everything off the first ring that was drawn on a face, and that is taken if it leaves
nothing open: who draws a ring and lines from it to another ring means what these bound.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.drawing_on.circuits import with_lines
from bozzetto_polyhedron.drawing_on.stroke_ends import PlacedLines, placed_lines


def with_strokes_added(
    before: Changed, strokes: Sequence[ArrayLike], camera: Camera, reach: float
) -> tuple[PlacedLines, Changed]:
    """Return where strokes lie in space, and a body with what they bound.

    Parameters
    ----------
    before : Changed
        With the lines that were added earlier and are left.
    strokes : sequence of (n, 2) array_like
        Canvas px.
    camera : Camera
        Through which they were drawn.
    reach : float
        Distance within which ends meet corners, edges and one another, px.

    Raises
    ------
    UserError
        If a stroke is a dot, or there is none.
    """
    placed = placed_lines(before.body, strokes, camera, reach, before.points)
    after = with_lines(before, placed.points, placed.lines)
    if not len(after.lines):
        return placed, after
    raised = placed_lines(before.body, strokes, camera, reach, before.points, off_rings=True)
    if np.array_equal(raised.points, placed.points):
        return placed, after
    try:
        closed = with_lines(before, raised.points, raised.lines)
    except UserError:
        return placed, after
    return (placed, after) if len(closed.lines) else (raised, closed)
