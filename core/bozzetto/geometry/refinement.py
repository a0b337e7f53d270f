"""Knot insertion and degree elevation of B-splines, exactly: by blossoms.

The blossom of a polynomial of degree p is the symmetric function of p arguments, linear in each,
that is the polynomial where all are equal. Control points are its values at knots (Ramshaw 1989,
"Blossoms are polar forms").
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Index


def refined(degree: int, knots: Array, points: Array, new_knots: Array) -> Array:
    """Return control points of the same spline over a knot vector that holds all of its knots.

    Parameters
    ----------
    degree : int
        At least 1.
    knots : (m + degree + 1,) float
        Full knot vector, not decreasing.
    points : (m, d) float
        Control points; homogeneous ones of a rational spline.
    new_knots : (k + degree + 1,) float
        Full knot vector within the range of the old one.

    Returns
    -------
    (k, d) float
    """
    numbers = np.arange(len(new_knots) - degree - 1)
    home = _home(degree, knots, new_knots, degree)
    arguments = new_knots[numbers[:, None] + np.arange(1, degree + 1)]
    return _blossom(degree, knots, points, home, arguments)


def elevated(degree: int, knots: Array, points: Array) -> tuple[Array, Array]:
    """Return knots and control points of the same spline of one degree more.

    Parameters
    ----------
    degree, knots, points
        As in `refined`; the knots are clamped.

    Returns
    -------
    knots : (k + degree + 2,) float
        Each inner knot once more often.
    points : (k, d) float
        The blossom of degree p + 1 is the mean of those of degree p without one argument.
    """
    begin, end = knots[degree], knots[len(points)]
    places, times = np.unique(knots[(knots >= begin) & (knots <= end)], return_counts=True)
    new_knots = np.repeat(places, times + 1)
    numbers = np.arange(len(new_knots) - degree - 2)
    home = _home(degree, knots, new_knots, degree + 1)
    arguments = new_knots[numbers[:, None] + np.arange(1, degree + 2)]
    each = [
        _blossom(degree, knots, points, home, np.delete(arguments, left, axis=1))
        for left in range(degree + 1)
    ]
    made = np.mean(each, axis=0)
    made[[0, -1]] = points[[0, -1]]  # without the rounding of a mean
    return new_knots, np.asarray(made)


def _home(degree: int, knots: Array, new_knots: Array, new_degree: int) -> Index:
    """Return the old span whose polynomial tells each new control point: the widest it acts on."""
    count = len(new_knots) - new_degree - 1
    span = np.arange(count)[:, None] + np.arange(new_degree + 1)
    widths = new_knots[span + 1] - new_knots[span]
    widest = span[np.arange(count), np.argmax(widths, axis=1)]
    middle = 0.5 * (new_knots[widest] + new_knots[widest + 1])
    last = len(knots) - degree - 2
    return np.asarray(np.clip(np.searchsorted(knots, middle, "right") - 1, degree, last))


def _blossom(degree: int, knots: Array, points: Array, home: Index, arguments: Array) -> Array:
    """Evaluate blossoms of spans: de Boor's scheme with an argument of its own at each level."""
    row = points[home[:, None] + np.arange(-degree, 1)]
    for level in range(1, degree + 1):
        at = arguments[:, level - 1, None]
        left = home[:, None] + np.arange(level - degree, 1)
        low, high = knots[left], knots[left + degree + 1 - level]
        share = ((at - low) / (high - low))[..., None]
        row = (1.0 - share) * row[:, :-1] + share * row[:, 1:]
    return np.asarray(row[:, 0])
