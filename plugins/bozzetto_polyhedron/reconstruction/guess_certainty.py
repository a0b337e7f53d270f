"""How likely guessed hidden lines are those that were meant.

That a solid explains all visible lines does not make it the one that was meant: its back may have
what nobody sees, and where the hand is unsteady lines may be another solid's. A logistic regression
over what is known of a guess tells how often; its numbers are in `guess_numbers`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.certainty import closest_corners
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.guess_numbers import LOG_ODDS, TRAITS
from bozzetto_polyhedron.reconstruction.missing_lines import Whole
from bozzetto_polyhedron.reconstruction.parallel_classes import parallel_classes

ALIGNED: Final = np.sin(np.radians(6.0))
"""Sine of the angle up to which a guessed line runs in a direction of drawn ones."""

SHORTEST: Final = 1e-3
"""Length under which a guessed line is as good as none, diagonals."""

CROWDED: Final = 4
"""Lines at a corner from which on it has more than most corners of solids."""


def guess_traits(
    drawing: Drawing,
    whole: Whole,
    hidden: Array,
    unexplained: float,
    misfit: float | None,
) -> Array:
    """Return what tells how likely a guess is, (len(TRAITS) - 1,): all but whether it is alone.

    Parameters
    ----------
    drawing : Drawing
        Of the visible lines.
    whole : Whole
        What they are completed to.
    hidden : (m,) array
        Share of each of its lines that was not drawn.
    unexplained : float
        Share of what was drawn that is no part of it.
    misfit : float, optional
        Share of its lines that a solid shows otherwise; not given where that is not told.
    """
    spans = whole.points[whole.lines[:, 1]] - whole.points[whole.lines[:, 0]]
    lengths = np.maximum(np.linalg.norm(spans, axis=1), SHORTEST)
    missing = hidden > 0.0
    ways = parallel_classes(drawing).directions
    sines = np.abs(spans[:, :1] * ways[:, 1] - spans[:, 1:] * ways[:, 0]).min(axis=1) / lengths
    odd = float(lengths[missing & (sines > ALIGNED)].sum() / lengths[missing].sum())
    degrees = np.bincount(whole.lines.ravel(), minlength=len(whole.points))
    return np.array(
        (
            unexplained,
            0.0 if misfit is None else misfit,
            float(misfit is None),
            float(np.log(missing.sum())),
            float(np.log(len(drawing.lines))),
            drawing.noise,
            odd,
            float((degrees >= CROWDED).sum()),
            float(np.log(closest_corners(drawing.points) / drawing.noise)),
            float(np.log(lengths[missing].min())),
        )
    )


def certainty_of_guess(traits: Array) -> float:
    """Return the probability that a guess is what was meant from its traits, (len(TRAITS),)."""
    low, high, weights = np.array(list(TRAITS.values())).T
    odds = LOG_ODDS + float(weights @ np.clip(traits, low, high))
    return float(1.0 / (1.0 + np.exp(-odds)))
