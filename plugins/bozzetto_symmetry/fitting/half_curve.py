"""The two halves of a symmetric spline; in the frame of the plane (y = 0), mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import DEGREE, Spline
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

ALIKE: Final = 1e-6
"""Departure from symmetry, as a share of the curve's size or range, that counts as rounding. A ring
is symmetric about two places only, and elsewhere by far more."""


@dataclass(frozen=True, eq=False)
class Halves:
    """Where a symmetric spline crosses the plane, and which of its control points are partners.

    Attributes
    ----------
    middle : float
        Parameter at which the curve crosses the plane; beyond it lies the half that counts.
    end : float
        Parameter of that half's other end: the free one, or of a ring the other crossing,
        which may lie beyond the range.
    partner : (n,) int
        Number of the mirrored control point of each; of a ring those that differ.
    ring : bool
        The curve is closed and crosses the plane twice.
    """

    middle: float
    end: float
    partner: Index
    ring: bool

    @property
    def span(self) -> float:
        """Length of a half in the parameter."""
        return self.end - self.middle

    def folded(self, parameters: ArrayLike) -> tuple[Array, Flags]:
        """Return distances from the middle, 0 … `span`, and which parameters are on the other half.

        Parameters
        ----------
        parameters : (n,) array_like
            Of an open curve within its range; of a ring they may run round.
        """
        away = np.asarray(parameters, float) - self.middle
        away = (away + self.span) % (2.0 * self.span) - self.span if self.ring else away
        return np.asarray(np.abs(away)), np.asarray(away < 0.0)


def halves_of(spline: Spline) -> Halves:
    """Return the halves of a curve across the plane.

    Of the two crossings of a ring the one nearer to where its range begins is the middle.

    Raises
    ------
    ValueError
        If the curve is not symmetric.
    """
    begin, end = spline.range
    if not spline.closed:
        partner = np.arange(len(spline.control_points))[::-1]
        return Halves(0.5 * (begin + end), end, partner, ring=False)
    period = end - begin
    points = spline.control_points[:-DEGREE]
    knots = spline.knots[DEGREE : -DEGREE - 1]
    count = len(points)
    size = ALIKE * max(float(np.ptp(points, axis=0).max()), float(np.abs(points[:, 1]).max()))
    found = []
    for twice in range(2 * count):
        # Knots mirror as k[j] <-> k[twice - j]; control point i acts on knots i - 3 … i + 1.
        partner = (twice + 2 - np.arange(count)) % count
        if np.abs(points[partner] * MIRROR - points).max() > size:
            continue
        number = twice - np.arange(count)
        sums = knots + knots[number % count] + period * (number // count)
        if np.ptp(sums) > ALIKE * period:
            continue
        middle = begin + (0.5 * float(sums[0]) - begin + 0.5 * period) % period - 0.5 * period
        found.append((abs(middle - begin), middle, partner))
    if not found:
        raise ValueError("the closed curve is not symmetric")
    _, middle, partner = min(found, key=lambda entry: entry[0])
    return Halves(middle, middle + 0.5 * period, partner, ring=True)


def symmetrize(spline: Spline) -> Spline:
    """Return a spline that is symmetric up to rounding as one that is so exactly.

    Control points and their partners become exact negations of each other in y, and the
    knots of an open curve symmetric about 0.

    Raises
    ------
    ValueError
        If a closed curve is not symmetric.
    """
    points = spline.control_points
    if not spline.closed:
        knots = spline.knots
        image = points[::-1] * MIRROR
        return Spline(0.5 * (knots - knots[::-1]), 0.5 * (points + image))
    once = points[:-DEGREE]
    exact = 0.5 * (once + once[halves_of(spline).partner] * MIRROR)
    return Spline(spline.knots, np.vstack((exact, exact[:DEGREE])), closed=True)
