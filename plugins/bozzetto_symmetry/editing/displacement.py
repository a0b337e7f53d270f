"""A spline that is changed in places only.

The curve itself is not fitted again. Knots are added without changing it, and then those
control points are moved that act nowhere else than where the curve has to move: all the
rest stays what it is, to rounding.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.geometry import Spline
from bozzetto.ink import displaced_spline, held_solution, spline_weights
from bozzetto_symmetry.fitting.half_curve import Halves, halves_of, symmetrize
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

CLOSE_ENOUGH: Final = 0.3
"""Distance from where a place should be, px, that is not worth a further knot."""

MOST_HALVINGS: Final = 6
"""How often spans are halved at most."""


def displace(
    spline: Spline,
    at: ArrayLike,
    shifts: ArrayLike,
    pixel: ArrayLike,
    *,
    symmetric: bool = False,
) -> Spline:
    """Move a curve where it is said to move, and nowhere else.

    Least squares for the displacement over the curve's own knots; spans on which it is off
    by more than 0.3 px are halved, and it is solved again.

    Parameters
    ----------
    spline : Spline
        In space.
    at : (n,) array_like
        Parameters of places along the curve, close enough to show all that is to change.
    shifts : (n, 3) array_like
        Where each of them goes from where it is, mm. Those that are exactly 0 stay.
    pixel : (n,) array_like
        Length of a pixel there, mm.
    symmetric : bool
        The curve is its own mirror image and stays so; what moves on one half moves on the
        other, and where both move they meet in the middle.

    Returns
    -------
    Spline
        The same object where nothing moves by as much as 0.3 px.
    """
    station, wanted = np.asarray(at, float), np.asarray(shifts, float)
    unit = np.asarray(pixel, float)
    moved = np.asarray((wanted != 0.0).any(axis=1))
    if symmetric:
        known = _known(halves_of(spline), station, moved)
        station, wanted, unit, moved = station[known], wanted[known], unit[known], moved[known]
    if (np.linalg.norm(wanted, axis=1) <= CLOSE_ENOUGH * unit).all():
        return spline

    def refined(finer: Spline, knots: Array) -> Spline:
        return symmetrize(finer.refined(_both_sides(finer, knots)))

    return displaced_spline(
        spline,
        station,
        lambda finer: _change(finer, station, wanted, unit, moved, symmetric),
        close=CLOSE_ENOUGH,
        halvings=MOST_HALVINGS,
        refined=refined if symmetric else Spline.refined,
    )


def _known(halves: Halves, at: Array, moved: Flags) -> Flags:
    """Return which places say what the curve should do.

    A place at rest does not where its mirror image moves.
    """
    away, beyond = halves.folded(at)
    known = moved.copy()
    for side in (beyond, ~beyond):
        rest = side & ~moved
        order = np.flatnonzero(~side)
        order = order[np.argsort(away[order])]
        if len(order):
            image = np.interp(away[rest], away[order], moved[order].astype(float))
            known[rest] = image == 0.0
        else:
            known[rest] = True
    return known


def _change(
    spline: Spline, at: Array, shifts: Array, unit: Array, moved: Flags, symmetric: bool
) -> tuple[Array, Array]:
    """Return the displacement of the control points, and how far each place is off then, px."""
    basis = spline_weights(spline, at)
    numbers = np.arange(basis.shape[1])
    partner = halves_of(spline).partner if symmetric else numbers
    touched = basis + basis[:, partner]
    free = (touched[~moved] == 0.0).all(axis=0) & (touched > 0.0).any(axis=0)
    change = np.zeros((len(numbers), 3))
    for axis, factor in enumerate(MIRROR if symmetric else np.ones(3)):
        # Of control points that belong together the first one is sought; one that is its own
        # partner does not leave the plane.
        lone = numbers == partner
        sought = np.flatnonzero(free & ((numbers < partner) | (lone & (factor > 0.0))))
        columns = basis[:, sought] + np.where(lone[sought], 0.0, factor * basis[:, partner[sought]])
        solution = held_solution(columns / unit[:, None], shifts[:, axis] / unit)
        change[partner[sought], axis] = factor * solution
        change[sought, axis] = solution
    off = np.linalg.norm(basis @ change - shifts, axis=1) / unit
    return change, np.asarray(off)


def _both_sides(spline: Spline, knots: Array) -> Array:
    halves = halves_of(spline)
    away = np.unique(np.round(halves.folded(knots)[0] / halves.span, 12)) * halves.span
    return np.concatenate((halves.middle - away, halves.middle + away))
