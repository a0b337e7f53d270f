"""A spline that is moved in places only.

The curve is not fitted anew. Knots are added without changing it, and control points are moved
that act only where the curve has to move: the rest stays what it is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.geometry import DEGREE, Spline

FEWEST: Final = 4
"""Places on a span that is halved, at least: what lies between places is not known."""

HOLD: Final = 1e-7
"""Weight, per weight of the places, with which a control point stays that they leave free."""

Change = Callable[[Spline], tuple[Array, Array]]
"""How control points, (k, 3), each once, are to move, and how far each place is off then, px."""


def displaced_spline(
    spline: Spline,
    at: Array,
    change: Change,
    *,
    close: float,
    halvings: int,
    refined: Callable[[Spline, Array], Spline] = Spline.refined,
) -> Spline:
    """Return a curve moved in places; spans are halved while places on them are off.

    Parameters
    ----------
    spline : Spline
        In space, mm.
    at : (n,) float
        Parameters of places along it.
    change : callable
        Solves for the displacement of a curve that has more knots.
    close : float
        Distance from where a place should be, px, that is not worth a further knot.
    halvings : int
        How often spans are halved at most.
    refined : callable
        The curve with further knots; its course stays.
    """
    finer = spline
    moved, off = change(finer)
    for _ in range(halvings):
        knots = _halvings(finer, at, off > close)
        if not len(knots):
            break
        finer = refined(finer, knots)
        moved, off = change(finer)
    if spline.closed:
        moved = np.vstack((moved, moved[:DEGREE]))
    return Spline(finer.knots, finer.control_points + moved, finer.closed)


def spline_weights(spline: Spline, parameters: ArrayLike, order: int = 0) -> Array:
    """Return the weight of each control point at each place, or a derivative of it, (n, k).

    Control points of a closed curve that are repeated beyond the seam count once.

    Parameters
    ----------
    spline : Spline
        Open or closed.
    parameters : (n,) array_like
        Where, within its range.
    order : int
        Of the derivative.
    """
    from scipy.interpolate import BSpline

    at = spline.within(parameters)
    count = len(spline.control_points)
    functions = BSpline(spline.knots, np.eye(count), DEGREE)
    rows = np.asarray(functions.derivative(order)(at) if order else functions(at))
    if not spline.closed:
        return rows
    once = rows[:, :-DEGREE].copy()
    once[:, :DEGREE] += rows[:, -DEGREE:]
    return once


def held_solution(rows: Array, wanted: Array) -> Array:
    """Return the least squares solution that keeps still what rows leave free, (k, …).

    Parameters
    ----------
    rows : (n, k) float
        Weights of the unknowns at each place.
    wanted : (n, …) float
        What they are to give there.
    """
    normal = rows.T @ rows
    normal[np.diag_indices_from(normal)] += HOLD * max(1e-300, float(np.trace(normal)))
    return np.asarray(np.linalg.solve(normal, rows.T @ wanted))


def _halvings(spline: Spline, at: Array, off: Flags) -> Array:
    """Return the middles of the spans that hold a place that is off, and places enough."""
    breaks = np.unique(spline.knots[DEGREE:-DEGREE])
    count = len(breaks) - 1
    span = np.clip(np.searchsorted(breaks, spline.within(at), "right") - 1, 0, count - 1)
    enough = np.bincount(span, minlength=count) >= FEWEST
    bad = np.bincount(span, off, minlength=count) > 0
    middles = 0.5 * (breaks[:-1] + breaks[1:])
    return np.asarray(middles[enough & bad])
