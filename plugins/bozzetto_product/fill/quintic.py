"""Polynomials of degree five on 0 … 1: Bernstein form, quadrature, the same over more knots."""

from __future__ import annotations

from functools import cache
from math import comb
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, frozen
from bozzetto.plugin import remembered

DEGREE: Final = 5
"""The least degree that gave tangent planes to 0.05° and fair insides; six is no better."""

POINTS: Final = DEGREE + 1
"""Control points of a polynomial."""

GAUSS_POINTS: Final = 7
"""Nodes of the quadrature along each direction of a patch."""


NODES_PER_SPAN: Final = 8
"""Gauss nodes on every span of a spline that is fitted."""


@cache
def gauss(count: int) -> tuple[Array, Array]:
    """Return the nodes and weights of Gauss–Legendre quadrature on 0 … 1."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return frozen(0.5 * (1.0 + nodes), np.float64), frozen(0.5 * weights, np.float64)


NODES, WEIGHTS = gauss(GAUSS_POINTS)

FADE: Final = frozen((1.0, 1.0, 0.4, 0.0, 0.0, 0.0), np.float64)
"""Control values of (1 - v)³ (1 + 3 v): one with slope nought at 0, nought to third order at 1."""

FADE_SLOPE: Final = frozen((0.0, 0.2, 0.1, 0.0, 0.0, 0.0), np.float64)
"""Control values of v (1 - v)³: slope one at 0, nought to third order at 1."""


def bernstein(at: ArrayLike, order: int = 0) -> Array:
    """Evaluate the Bernstein polynomials of degree five, or a derivative of them.

    Parameters
    ----------
    at : (n,) array_like
        Parameters.
    order : int
        Order of the derivative.

    Returns
    -------
    (n, 6) float
    """
    t = np.asarray(at, float)[:, None]
    degree = DEGREE - order
    numbers = np.arange(degree + 1)
    counts = np.array([comb(degree, i) for i in range(degree + 1)], float)
    rows = counts * t**numbers * (1.0 - t) ** (degree - numbers)
    for level in range(degree + 1, POINTS):
        nought = np.zeros((len(rows), 1))
        rows = level * (np.hstack((nought, rows)) - np.hstack((rows, nought)))
    return np.asarray(rows)


def spline_rows(knots: Array, at: Array, order: int = 0) -> Array:
    """Return the values of all basis functions of degree five, or derivatives, (n, m)."""
    from scipy.interpolate import BSpline

    return np.asarray(BSpline(knots, np.eye(len(knots) - POINTS), DEGREE)(at, order))


@remembered(limit=1000, key=lambda knots: knots.tobytes())
def spline_fit(knots: Array) -> tuple[Array, Array]:
    """Return places in knots' range, and what takes values there to the inner control values.

    Those of the least-squares spline that is nought with slope nought at both ends.
    """
    nodes, weights = gauss(NODES_PER_SPAN)
    spans = np.unique(knots)
    width = np.diff(spans)
    at = (spans[:-1, None] + width[:, None] * nodes).ravel()
    size = np.sqrt((width[:, None] * weights).ravel())
    inverse = np.asarray(np.linalg.pinv(size[:, None] * spline_rows(knots, at)[:, 2:-2]))
    return at, inverse * size


@remembered(limit=1000, key=lambda knots: knots.tobytes())
def refinement(knots: Array) -> Array:
    """Return the matrix from control points of one polynomial to those over a knot vector.

    Each row is the blossom of the Bernstein polynomials at five knots that follow one another
    (Ramshaw 1989, "Blossoms are polar forms").

    Parameters
    ----------
    knots : (m + 6,) float
        Clamped, over 0 … 1.

    Returns
    -------
    (m, 6) float
    """
    count = len(knots) - POINTS
    rows = np.repeat(np.eye(POINTS)[None], count, axis=0)
    for level in range(DEGREE):
        at = knots[np.arange(count) + 1 + level][:, None, None]
        rows = (1.0 - at) * rows[:, :-1] + at * rows[:, 1:]
    return np.asarray(rows[:, 0])


@remembered(limit=1000, key=lambda knots, finer: (knots.tobytes(), finer.tobytes()))
def insertion(knots: Array, finer: Array) -> Array:
    """Return the matrix from control points of a spline to those over more knots.

    Each row is a blossom, as in `refinement`, of the polynomial of the old span that holds most of
    where the new control point acts; the ends stay to the last bit.

    Parameters
    ----------
    knots : (m + 6,) float
        Clamped.
    finer : (k + 6,) float
        Of the same range; holds them, but for rounding.

    Returns
    -------
    (k, m) float
    """
    size, count = len(knots) - POINTS, len(finer) - POINTS
    begin = np.arange(count)[:, None] + np.arange(POINTS)
    widest = np.argmax(finer[begin + 1] - finer[begin], axis=1) + np.arange(count)
    middles = 0.5 * (finer[widest] + finer[widest + 1])
    spans = np.searchsorted(knots, middles, "right") - 1
    rows = np.eye(size)[spans[:, None] + np.arange(-DEGREE, 1)]
    for level in range(1, POINTS):
        number = spans[:, None] + np.arange(level - DEGREE, 1)
        low, high = knots[number], knots[number + POINTS - level]
        at = ((finer[level : count + level, None] - low) / (high - low))[..., None]
        rows = (1.0 - at) * rows[:, :-1] + at * rows[:, 1:]
    return np.asarray(rows[:, 0])
