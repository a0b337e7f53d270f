"""A spline that is moved in places only.

The curve is not fitted anew. Knots are added without changing it, and control points are moved
that act only where the curve has to move: the rest stays what it is.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.geometry import DEGREE, Spline
from bozzetto.ink import displaced_spline, held_solution, spline_weights

CLOSE: Final = 0.5
"""Distance from where a place should be, px, that is not worth a further knot."""

HALVINGS: Final = 7
"""How often spans are halved at most."""

THINNED: Final = 0.25
"""Distance, px, by which a curve may leave its course so that a knot is spared."""

CHECKS: Final = 24
"""Places over the six spans that a knot acts on at which that distance is measured."""


def displaced(spline: Spline, at: ArrayLike, shifts: ArrayLike, unit: ArrayLike) -> Spline:
    """Move a curve where it is said to move, and nowhere else.

    Least squares for the displacement over the curve's own knots; spans on which it is off by
    more than `CLOSE` units are halved, and it is solved again. Knots that act where it moves only,
    and of which the new course has no need, go: however often a curve is drawn over, it has as many
    as its shape asks for. The ends of an open curve move by the shifts of the first and the last
    place, exactly.

    Parameters
    ----------
    spline : Spline
        mm.
    at : (n,) array_like
        Parameters of places along the curve, increasing.
    shifts : (n, 3) array_like
        Where each goes from where it is, mm. Those that are 0 stay.
    unit : (n,) array_like
        Length of a pixel there, mm.

    Returns
    -------
    Spline
        The same object where nothing moves by as much as `CLOSE` units.
    """
    station, wanted = np.asarray(at, float), np.asarray(shifts, float)
    pixel = np.asarray(unit, float)
    if (np.linalg.norm(wanted, axis=1) <= CLOSE * pixel).all():
        return spline
    moved = np.asarray((wanted != 0.0).any(axis=1))
    made = displaced_spline(
        spline,
        station,
        lambda finer: _change(finer, station, wanted, pixel, moved),
        close=CLOSE,
        halvings=HALVINGS,
    )
    return _without_idle_knots(made, station, pixel, moved)


def _without_idle_knots(course: Spline, at: Array, unit: Array, moved: Flags) -> Spline:
    """Return a curve without knots that act on moved places only and are not needed there.

    One after the other goes, the one that is missed least first (Piegl & Tiller 1997, section
    9.4.1), while the curve stays within `THINNED` units of its course.
    """
    still = np.sort(course.within(at[~moved]))
    thin, costs = course, dict[float, float]()
    while True:
        found: tuple[float, int] = (np.inf, 0)
        for number in _inner_knots(thin):
            knot = float(thin.knots[number])
            if knot not in costs:
                low, high = thin.knots[[number - DEGREE, number + DEGREE]]
                first, last = np.searchsorted(still, (low, high))
                costs[knot] = np.inf
                if first == last:
                    pixel = float(np.interp(knot, at, unit))
                    costs[knot] = _without_knot(thin, number, course)[1] / pixel
            found = min(found, (costs[knot], number))
        cost, number = found
        if cost > THINNED:
            return thin
        # What knots near to it would be missed by is asked anew.
        for near in thin.knots[max(0, number - 2 * DEGREE) : number + 2 * DEGREE + 1]:
            if costs.get(float(near), np.inf) < np.inf:
                del costs[float(near)]
        thin = _without_knot(thin, number, course)[0]


def _inner_knots(spline: Spline) -> range:
    """Return the numbers of the knots that can go; of a closed curve those away from its seam."""
    seam = DEGREE + 1 if spline.closed else 0
    return range(DEGREE + 1 + seam, len(spline.knots) - DEGREE - 1 - seam)


def _without_knot(spline: Spline, number: int, course: Spline) -> tuple[Spline, float]:
    """Return a curve without a knot, and how far it is then from its course, mm.

    Two control points take the place of three, by least squares; all others stay.
    """
    from scipy.interpolate import BSpline

    knots = np.delete(spline.knots, number)
    points = np.delete(spline.control_points, number - 2, axis=0)
    low, high = spline.knots[[number - DEGREE, number + DEGREE]]
    places = np.linspace(low, high, CHECKS)
    free = [number - 3, number - 2]
    wanted = course.value(places)
    rest = points.copy()
    rest[free] = 0.0
    rows = np.asarray(BSpline(knots, np.eye(len(points)), DEGREE)(places))
    points[free] = np.linalg.lstsq(rows[:, free], wanted - rows @ rest, rcond=None)[0]
    off = np.linalg.norm(rows @ points - wanted, axis=1)
    return Spline(knots, points, spline.closed), float(off.max())


def _change(
    spline: Spline, at: Array, shifts: Array, unit: Array, moved: Flags
) -> tuple[Array, Array]:
    """Return the displacement of the control points, and how far each place is off then, px."""
    rows = spline_weights(spline, at)
    free = (rows[~moved] == 0.0).all(axis=0) & (rows > 0.0).any(axis=0)
    change = np.zeros((rows.shape[1], 3))
    rest = shifts
    if not spline.closed:
        free[[0, -1]] = False
        change[0], change[-1] = shifts[0], shifts[-1]
        rest = shifts - rows @ change
    change[free] = held_solution(rows[:, free] / unit[:, None], rest / unit[:, None])
    off = np.linalg.norm(rows @ change - shifts, axis=1) / unit
    return change, np.asarray(off)
