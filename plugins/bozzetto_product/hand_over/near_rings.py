"""Rows of points that nearly return to their start, and would run on there without a corner.

A hand stops a little short of where it began, runs a little past it, or comes back beside it.
Joined at its ends like two curves, such a row would have a corner there that nobody drew.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array

SHORT: Final = 0.02
"""Farthest that a row stops from its start, as share of the diagonal of the network: the widest gap
that is closed."""

PART: Final = 0.05
"""Farthest that it stops from its start, or runs past it, as share of its own length."""

BESIDE: Final = 0.01
"""Farthest that it comes back beside its start, as share of the diagonal."""

BEND: Final = np.radians(25.0)
"""Largest turn where a row comes back that is no corner."""

WIDEST_BEND: Final = np.radians(60.0)
"""The same at most, where points tremble and tell directions less."""

WINDOW: Final = 0.06
"""Share of the length of a row that tells how it runs at an end."""

REMAINDER: Final = 2.0
"""Way across, in that of a circle from the parabola that foretells it (the remainder of Lagrange's
interpolation), which is no miss: so far the points do not tell where they would have come."""


TOLD_BY: Final = 3
"""Fewest points that tell how a row runs at an end."""

NOISE: Final = 3.5
"""Farthest that noise brings the ends apart, in its standard deviation."""

SURE: Final = np.radians(5.0)
"""Standard deviation of its direction there, where points tremble: more of them are taken. That of
the slope at the end of a parabola by least squares through n points at steps of h is
√192 σ / (h n^1.5)."""

MOST: Final = 1.0 / 3.0
"""Share of the points that tell it at most."""


class _Course(NamedTuple):
    """A parabola by the length along a row, 0 at its end, from a length before it."""

    place: Array
    slope: Array
    bend: Array
    before: float

    def unknown(self, way: float) -> float:
        """Return how far a circle of this bend is from the parabola at a length beyond the end.

        Through three points, and by least squares through many, of which it misses the last.
        """
        third = 4.0 * float(self.bend @ self.bend)
        between = way * (way + 0.5 * self.before) * (way + self.before)
        return third * (between + self.before**3 / 20.0) / 6.0

    def at(self, way: float) -> tuple[Array, Array]:
        """Return place and direction, (3,) each, at a length."""
        slope = self.slope + 2.0 * way * self.bend
        return (
            self.place + way * self.slope + way * way * self.bend,
            slope / np.linalg.norm(slope),
        )


def ring_of_row(points: Array, size: float, tolerance: float, noise: float = 0.0) -> Array | None:
    """Return the points of a ring that a row is meant to be; None where it is none.

    What runs past the start is left out. What comes back beside it is moved there by the whole
    course, half at each end, so that the ring has no jog.

    Parameters
    ----------
    points : (n, 3) float
        Points along a curve, no two neighbours the same, mm.
    size : float
        Diagonal of the network, mm.
    tolerance : float
        Distance of a point from the curve that does not count, mm.
    noise : float
        Standard deviation of each coordinate of the points, mm.

    Returns
    -------
    (m, 3) float or None
        The first one not repeated.
    """
    if len(points) < 2 * TOLD_BY:
        return None
    run = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    length = float(run[-1])
    reach = PART * length
    slack = min(SHORT * size, NOISE * noise)
    if np.linalg.norm(points[-1] - points[0]) > reach + slack:
        return None
    step = length / (len(points) - 1)
    fewest = int(np.ceil((np.sqrt(192.0) * noise / (step * SURE)) ** (2.0 / 3.0)))
    fewest = max(TOLD_BY, min(fewest, int(MOST * len(points))))
    start = _course(points[::-1], length - run[::-1], fewest)
    direction = -start.at(0.0)[1]
    kept = np.ones(len(points), dtype=bool)
    kept[run >= length - reach] = (points[run >= length - reach] - points[0]) @ direction < 0.0
    last = int(np.argmin(kept)) if not kept.all() else len(points)
    ring, run = points[:last], run[:last]
    if len(ring) < max(2 * TOLD_BY, fewest):
        return None
    end = _course(ring, run, fewest)
    gap = float((ring[0] - ring[-1]) @ direction)
    place, forward = end.at(gap)
    miss = ring[0] - place
    across = float(np.linalg.norm(miss))
    turn = float(np.arccos(np.clip(forward @ direction, -1.0, 1.0)))
    stops_short = last == len(points)
    unsure = NOISE * np.sqrt(192.0) * noise / (step * fewest**1.5)
    if turn > min(BEND + unsure, WIDEST_BEND) or across > max(BESIDE * size, slack):
        return None
    if stops_short and gap > min(SHORT * size, reach) + slack:
        return None
    if across <= max(tolerance, REMAINDER * end.unknown(gap)):
        return ring
    share = (run / run[-1])[:, None]
    return np.asarray(ring + (share * share * (3.0 - 2.0 * share) - 0.5) * miss)


def _course(points: Array, run: Array, fewest: int) -> _Course:
    """Return how a row of points runs at its last one; `run` is the length up to each."""
    back = run - run[-1]
    count = max(fewest, int((back >= -WINDOW * (run[-1] - run[0])).sum()))
    rows = np.polynomial.polynomial.polyvander(back[-count:], 2)
    place, slope, bend = np.linalg.lstsq(rows, points[-count:], rcond=None)[0]
    return _Course(place, slope, bend, -float(back[-count]))
