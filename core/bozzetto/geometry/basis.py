"""B-spline basis functions and rational curves: values and derivatives, for many places at once."""

from __future__ import annotations

from math import comb
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Index


def basis(degree: int, knots: Array, at: ArrayLike, order: int = 0) -> tuple[Index, Array]:
    """Return the basis functions, or derivatives of them, that act at parameters.

    Cox–de Boor recursion (de Boor 1972, "On calculating with B-splines"); derivatives by
    differences of functions of lower degree.

    Parameters
    ----------
    degree : int
        At least 1.
    knots : (m + degree + 1,) float
        Full knot vector, not decreasing.
    at : (n,) array_like
        Parameters within ``knots[degree] … knots[m]``.
    order : int
        Order of the derivative.

    Returns
    -------
    first : (n,) int
        Number of the first function that acts at each parameter.
    values : (n, degree + 1) float
        Of that function and those that follow it.
    """
    x = np.asarray(at, float)
    last = len(knots) - degree - 1
    end = int(np.searchsorted(knots, knots[last], "left")) - 1
    span = np.clip(np.searchsorted(knots, x, "right") - 1, degree, end)
    rows = np.full((len(x), 1), 1.0 if order <= degree else 0.0)
    place = x[:, None]
    for level in range(1, degree + 1):
        number = span[:, None] + np.arange(1, level + 1)
        low, high = knots[number - level], knots[number]
        share = rows / (high - low)
        rows = np.zeros((len(x), level + 1))
        if level <= degree - order:
            rows[:, 1:] += (place - low) * share
            rows[:, :-1] += (high - place) * share
        else:
            rows[:, 1:] += level * share
            rows[:, :-1] -= level * share
    return span - degree, rows


def lifted(points: Array, weights: Array | None) -> Array:
    """Return homogeneous points (…, d + 1): coordinates times weight, and the weight."""
    if weights is None:
        weights = np.ones(points.shape[:-1])
    return np.concatenate((points * weights[..., None], weights[..., None]), axis=-1)


def lowered(homogeneous: Array) -> tuple[Array, Array | None]:
    """Return points and weights of homogeneous points; no weights where all are equal."""
    weights = homogeneous[..., -1]
    points = homogeneous[..., :-1] / weights[..., None]
    return points, None if np.ptp(weights) == 0.0 else weights


def curve_derivative(
    degree: int, knots: Array, points: Array, weights: Array | None, at: ArrayLike, order: int
) -> Array:
    """Return derivatives of a B-spline curve by its parameter; order 0 gives places.

    Parameters
    ----------
    degree, knots
        As in `basis`.
    points : (m, d) float
        Control points.
    weights : (m,) float, optional
        Positive.
    at : (n,) array_like
        Parameters within the range.
    order : int
        Order of the derivative, by the quotient rule where there are weights (Piegl & Tiller
        1997, "The NURBS book", 4.3).

    Returns
    -------
    (n, d) float
    """
    rows = points if weights is None else lifted(points, weights)
    across = np.arange(degree + 1)
    orders = range(order + 1) if weights is not None else (order,)
    found = []
    for each in orders:
        first, values = basis(degree, knots, at, each)
        found.append(np.einsum("nk,nkd->nd", values, rows[first[:, None] + across]))
    if weights is None:
        return np.asarray(found[0])
    made: list[Array] = []
    for each, sums in enumerate(found):
        top = sums[:, :-1]
        for k in range(1, each + 1):
            top = top - comb(each, k) * found[k][:, -1:] * made[each - k]
        made.append(top / found[0][:, -1:])
    return made[order]


def span_parameters(degree: int, knots: Array, steps: int) -> Array:
    """Return parameters at equal steps of every span of a knot vector, ends included, rising."""
    breaks = np.unique(knots[degree : len(knots) - degree])
    shares = np.arange(steps) / steps
    inner = (breaks[:-1, None] + np.diff(breaks)[:, None] * shares).ravel()
    return np.append(inner, breaks[-1])
