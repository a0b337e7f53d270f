"""The cubic spline through places of a line: third derivatives do not jump beside its ends.

It is SciPy's `CubicSpline` with its default ends (*not-a-knot*; de Boor, *A Practical Guide to
Splines*, 1978, chapter IV) in a quarter of the time: a car whose styling lines are laid out anew in
each frame of a drag has some twenty of them, and most of what SciPy does is to check its input.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from bozzetto.arrays import Array


@dataclass(frozen=True, eq=False)
class CubicSpline:
    """A cubic spline.

    Attributes
    ----------
    knots : (n,) float
        Increasing.
    places : (n, d) float
        Values at the knots.
    slopes : (n, d) float
        Derivatives there.
    """

    knots: Array
    places: Array
    slopes: Array

    @classmethod
    def through(cls, knots: Array, places: Array) -> Self:
        """Return the spline through places (n, d) at increasing knots (n,); n is 2 or more.

        Two places give a straight line, and three a parabola.
        """
        from scipy.linalg.lapack import dgtsv

        steps = np.diff(knots)
        rises = np.diff(places, axis=0) / steps[:, None]
        if len(knots) == 2:
            return cls(knots, places, np.repeat(rises, 2, axis=0))
        if len(knots) == 3:
            bend = (rises[1] - rises[0]) / (knots[2] - knots[0])
            first, last = rises[0] - bend * steps[0], rises[1] + bend * steps[1]
            return cls(knots, places, np.stack((first, 2.0 * rises[0] - first, last)))
        before, after = steps[:-1], steps[1:]
        # One row for each knot: below, on and above the diagonal, and the right side.
        below, above = np.append(after, 0.0), np.append(0.0, before)
        on = np.concatenate(([after[0]], 2.0 * (before + after), [before[-1]]))
        right = np.empty_like(places)
        right[1:-1] = 3.0 * (after[:, None] * rises[:-1] + before[:, None] * rises[1:])
        for end, own, other in ((0, before[0], after[0]), (-1, after[-1], before[-1])):
            near, far = (rises[0], rises[1]) if end == 0 else (rises[-1], rises[-2])
            both = own + other
            (above if end == 0 else below)[end] = both
            right[end] = ((own + 2.0 * both) * other * near + own * own * far) / both
        *_, slopes, _ = dgtsv(below, on, above, right)
        return cls(knots, places, slopes)

    def __call__(self, at: Array) -> Array:
        """Return the places (m, d) at parameters (m,); beyond the knots its ends go on."""
        piece = np.searchsorted(self.knots[1:-1], at, "right")
        step = (self.knots[piece + 1] - self.knots[piece])[:, None]
        t = (at - self.knots[piece])[:, None] / step
        begin, rise = self.places[piece], self.places[piece + 1] - self.places[piece]
        leaving, arriving = step * self.slopes[piece], step * self.slopes[piece + 1]
        square, cube = 3.0 * rise - 2.0 * leaving - arriving, leaving + arriving - 2.0 * rise
        return np.asarray(begin + t * (leaving + t * (square + t * cube)))
