"""How a hand errs: mark by mark, and by bending a drawing as a whole.

A pen trembles at every mark by itself, and a drawing made by eye is bent besides: neighbouring
places are off in the same way. What the hand has bent is an unknown of each sketch, a smooth field
of displacements with a Gaussian covariance, so that it is not taken for the shape of the car.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_car.camera.marked_view import Reprojection
from bozzetto_car.solver.prior import Cost

BEND_REACH: Final = 0.4
"""Distance at which what places are off by in common has fallen to e^(-1/2), in diagonals of the
marks."""

LEAST_PART: Final = 1e-3
"""Least share of the variance of a bend, of the greatest one, that counts."""


def bend_correlation(sight: Reprojection) -> Array:
    """Return the correlation of what the hand bends at the marks of a sketch, (k, k)."""
    places = sight.marks / sight.extent
    away = ((places[:, None] - places) ** 2).sum(axis=2)
    return np.asarray(np.exp(-0.5 * away / BEND_REACH**2))


def bent_by_hand(sight: Reprojection, cost: Cost) -> Array:
    """Return the ways in which the hand bends a sketch, each of them of the variance 1.

    Parameters
    ----------
    sight : Reprojection
        The sketch.
    cost : Cost
        Tells how much a hand bends.

    Returns
    -------
    (k, b) float
        By how much each mark is off, along either axis, in diagonals of the marks.
    """
    if cost.bend <= 0.0:
        return np.zeros((len(sight.marks), 0))
    sizes, ways = np.linalg.eigh(bend_correlation(sight))
    counted = sizes > LEAST_PART * sizes[-1]
    return np.asarray(cost.bend * ways[:, counted] * np.sqrt(sizes[counted]))
