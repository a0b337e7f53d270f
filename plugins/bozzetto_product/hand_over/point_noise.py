"""How exact the points of a file are: the last digit that is written, and how a hand trembled."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from bozzetto.arrays import Array

DIGITS: Final = range(9)
"""Decimals that a file may have rounded its numbers to; more are exact."""

LEADING: Final = range(2, 9)
"""The same of digits that count."""

WHOLE: Final = 1e-6
"""Distance from a whole number, in units of the last digit, at which a number ends there."""

COARSEST: Final = 1e-3
"""Largest step between numbers, as share of the diagonal, that is a rounding: what is coarser was
typed, and is meant as it stands."""

FEWEST: Final = 9
"""Points of a curve from which on they tell whether they tremble."""

SAME: Final = 1e-9
"""Distance of neighbours below which they are one point, as share of the diagonal."""

TREMBLING: Final = 0.3
"""Share of what the neighbours of points do not foretell that no smooth curve explains, below which
there is no noise: the curve is bent more than its points show."""

STRONGEST: Final = 0.01
"""Most that is taken for noise, as share of the diagonal."""


def rounding_of(points: Array, size: float) -> float:
    """Return the step to which the coordinates of a file are rounded, in their unit.

    Parameters
    ----------
    points : (n, 3) float
        All points of the file, as it gives them.
    size : float
        Diagonal of their box.

    Returns
    -------
    float
        0 where they are exact, and where so coarse a step must be meant.
    """
    values = np.abs(points[points != 0.0])
    if not len(values):
        return 0.0
    largest = float(np.floor(np.log10(values.max())))
    steps = [0.0]
    for digits in DIGITS:
        if _ends_at(values * 10.0**digits):
            steps.append(10.0**-digits)
            break
    for count in LEADING:
        if _ends_at(values * 10.0 ** (count - 1 - np.floor(np.log10(values)))):
            steps.append(10.0 ** (largest + 1 - count))
            break
    return max(step for step in steps if step <= COARSEST * size)


def _ends_at(values: Array) -> bool:
    return bool((np.abs(values - np.round(values)) <= np.maximum(WHOLE, 1e-13 * values)).all())


def noise_of(rows: Iterable[Array], size: float) -> float:
    """Return the standard deviation of each coordinate of points from smooth curves.

    A cubic through two points on both sides foretells each point. What it misses grows with the
    fourth power of the distance of the points where the curve is smooth, and not at all where they
    tremble, so points two apart tell both.

    Parameters
    ----------
    rows : iterable of (n, 3) float
        Points along each curve.
    size : float
        Diagonal of them all.

    Returns
    -------
    float
        In the unit of the points: of the curves that tremble most, but a quarter of them. 0 where
        they do not.
    """
    found = []
    for row in rows:
        steps = np.linalg.norm(np.diff(row, axis=0), axis=1)
        points = row[np.concatenate(([True], steps > SAME * size))]
        if len(points) < FEWEST:
            continue
        near, far = (float(np.median(_missed(points, step))) for step in (1, 2))
        trembling = max(0.0, (256.0 * near - far) / 255.0)
        found.append(trembling if trembling > TREMBLING * near else 0.0)
    if not found:
        return 0.0
    # What moves a point along its curve moves its share of the length along: two directions are
    # left, and of a normal deviation in two the median of the squared length is 1.39 of its square.
    variance = float(np.quantile(found, 0.75)) / 1.386
    return min(float(np.sqrt(variance)), STRONGEST * size)


def _missed(points: Array, step: int) -> Array:
    """Return squared distances of points from where neighbours foretell them, by their noise."""
    run = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    middle = np.arange(2 * step, len(points) - 2 * step)
    rows = [middle + step * k for k in (-2, -1, 1, 2)]
    at = run[middle]
    weights = []
    for row in rows:
        weight = np.ones(len(middle))
        for other in rows:
            if other is not row:
                weight *= (at - run[other]) / (run[row] - run[other])
        weights.append(weight)
    shares = np.array(weights)
    told = np.einsum("kn,knd->nd", shares, points[np.array(rows)])
    return np.asarray(((points[middle] - told) ** 2).sum(axis=1) / (1.0 + (shares**2).sum(axis=0)))
