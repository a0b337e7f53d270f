"""What a whole solid explains of a drawing of its visible lines, and which lines it adds."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.missing_lines import Whole
from bozzetto_polyhedron.reconstruction.visible_regions import Junctions

LEAST_HIDDEN: Final = 0.01
"""Share of a line that is hidden at least where it goes behind others."""


def compared(
    drawing: Drawing, junctions: Junctions, whole: Whole, reach: float
) -> tuple[Array, float]:
    """Return the share of each line of a whole that was not drawn, (k,), and of ink beside it.

    A line that was drawn from end to end has the share 0 however it was drawn, and others more.
    """
    starts, stops = whole.points[whole.lines[:, 0]], whole.points[whole.lines[:, 1]]
    ends = drawing.points[drawing.lines]
    stems = junctions.is_stem[drawing.lines]
    first = _at_ends(ends[:, 0], stems[:, 0], starts, stops, reach)
    second = _at_ends(ends[:, 1], stems[:, 1], starts, stops, reach)
    fit: Flags = first & second
    long = np.linalg.norm(stops - starts, axis=1) > reach
    explained = (fit & long).any(1)
    lengths = drawing.lengths
    whole_lines = ~(stems[:, 0] | stems[:, 1])
    complete = fit & whole_lines[:, None]
    drawn = ((fit & long) * lengths[:, None]).sum(0) / np.maximum(
        np.linalg.norm(stops - starts, axis=1), 1e-12
    )
    hidden = np.where(long & ~complete.any(0), np.clip(1.0 - drawn, LEAST_HIDDEN, 1.0), 0.0)
    return hidden, float(lengths[~explained].sum() / max(lengths.sum(), 1e-12))


def _at_ends(places: Array, loose: Flags, starts: Array, stops: Array, reach: float) -> Flags:
    """Whether places (m, 2) are at an end of stretches (k, 2), or on them where loose, (m, k)."""
    to_start = np.linalg.norm(places[:, None] - starts, axis=2)
    to_stop = np.linalg.norm(places[:, None] - stops, axis=2)
    steps = stops - starts
    square = np.maximum((steps**2).sum(1), 1e-12)
    at = np.clip(((places[:, None] - starts) * steps).sum(2) / square, 0.0, 1.0)
    away = np.linalg.norm(places[:, None] - starts - at[..., None] * steps, axis=2)
    made: Flags = (np.minimum(to_start, to_stop) < reach) | (loose[:, None] & (away < reach))
    return made
