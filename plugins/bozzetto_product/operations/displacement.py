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
from bozzetto_product.projection.spline_basis import basis, free_controls, with_controls

CLOSE: Final = 0.5
"""Distance from where a place should be, px, that is not worth a further knot."""

FEWEST: Final = 4
"""Places on a span that is halved, at least: what lies between places is not known."""

HALVINGS: Final = 7
"""How often spans are halved at most."""

HOLD: Final = 1e-7
"""Weight with which a control point stays that the places leave free."""


def displaced(spline: Spline, at: ArrayLike, shifts: ArrayLike, unit: ArrayLike) -> Spline:
    """Move a curve where it is said to move, and nowhere else.

    Least squares for the displacement over the curve's own knots; spans on which it is off by
    more than `CLOSE` units are halved, and it is solved again. The ends of an open curve move by
    the shifts of the first and the last place, exactly.

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
    finer = spline
    change, off = _change(finer, station, wanted, pixel, moved)
    for _ in range(HALVINGS):
        knots = _halvings(finer, station, off > CLOSE)
        if not len(knots):
            break
        finer = finer.refined(knots)
        change, off = _change(finer, station, wanted, pixel, moved)
    return with_controls(finer, free_controls(finer) + change)


def _change(
    spline: Spline, at: Array, shifts: Array, unit: Array, moved: Flags
) -> tuple[Array, Array]:
    """Return the displacement of the control points, and how far each place is off then, px."""
    rows = basis(spline, at)
    free = (rows[~moved] == 0.0).all(axis=0) & (rows > 0.0).any(axis=0)
    change = np.zeros((rows.shape[1], 3))
    rest = shifts
    if not spline.closed:
        free[[0, -1]] = False
        change[0], change[-1] = shifts[0], shifts[-1]
        rest = shifts - rows @ change
    columns = rows[:, free] / unit[:, None]
    normal = columns.T @ columns
    normal[np.diag_indices_from(normal)] += HOLD * max(1e-300, float(np.trace(normal)))
    change[free] = np.linalg.solve(normal, columns.T @ (rest / unit[:, None]))
    off = np.linalg.norm(rows @ change - shifts, axis=1) / unit
    return change, np.asarray(off)


def _halvings(spline: Spline, at: Array, off: Flags) -> Array:
    """Return the middles of the spans that hold a place that is off, and places enough."""
    breaks = np.unique(spline.knots[DEGREE:-DEGREE])
    count = len(breaks) - 1
    span = np.clip(np.searchsorted(breaks, spline.within(at), "right") - 1, 0, count - 1)
    enough = np.bincount(span, minlength=count) >= FEWEST
    bad = np.bincount(span, off, minlength=count) > 0
    middles = 0.5 * (breaks[:-1] + breaks[1:])
    return np.asarray(middles[enough & bad])
