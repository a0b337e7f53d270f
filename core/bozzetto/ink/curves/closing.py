"""Outlines from single strokes: whether one is meant, and how its ends meet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.ink.curves.intersections import self_crossings
from bozzetto.ink.curves.resample import arc_length, distinct, points_along

if TYPE_CHECKING:
    from bozzetto.arrays import Array

END_SHARE: Final = 0.2
"""Share of the length at each end within which the ends may overlap or be trimmed."""

TRIM_COST: Final = 0.25
"""What a unit of trimmed ink costs, against a unit of gap bridged. Below 1 an overlap or a
hook is rather cut off than bridged; above 0 nothing is cut off for a hair's breadth."""

GAP_SHARE: Final = 0.15
"""Widest gap of a stroke that is meant to be closed, as a share of the diagonal."""

FLATNESS: Final = 0.005
"""Least area of a loop over its squared length; a circle has 0.08, a line drawn there and
back has none. (A 40 : 1 strip has 0.006.)"""

SEARCH_POINTS: Final = 200
"""Places tried on each end in the search for the best joint."""


def signed_area(points: ArrayLike) -> float:
    """Return the area inside a closed polyline.

    Parameters
    ----------
    points : (n, 2) array_like
        The last point joins the first, whether that is repeated or not.

    Returns
    -------
    float
        Positive for a counter-clockwise curve in axes with y up, which is a clockwise one
        on a canvas, where y points down.
    """
    place = np.asarray(points, float)
    if len(place) < 3:
        return 0.0
    x, y = (place - place[0]).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def end_gap(points: ArrayLike) -> float:
    """Return the distance between a stroke's ends over the diagonal of its bounding box."""
    place = np.asarray(points, float)
    diagonal = float(np.linalg.norm(np.ptp(place, axis=0)))
    return float(np.linalg.norm(place[-1] - place[0])) / diagonal if diagonal > 0 else 0.0


def is_closed_gesture(points: ArrayLike) -> bool:
    """Decide whether a stroke was meant as a closed outline.

    It was if its ends, after the overlap is trimmed, leave a gap below `GAP_SHARE` of the
    diagonal, and if what it encloses then is no mere line (`FLATNESS`).

    Parameters
    ----------
    points : (n, 2) array_like
        Canvas pixels.
    """
    place = np.asarray(points, float)
    loop = close_stroke(place)
    if len(loop) < 3 or end_gap(loop) > GAP_SHARE:
        return False
    length = float(arc_length(np.vstack((loop, loop[:1])))[-1])
    return abs(signed_area(loop)) >= FLATNESS * length**2


def close_stroke(points: ArrayLike) -> Array:
    """Close a stroke that nearly closes.

    Overlapping ends are cut where they cross, or where they come closest; hooks that the
    pen left when it landed or lifted go the same way; what gap remains is bridged by the
    straight line from the last point to the first. Of all joints the one with the least
    ``gap + TRIM_COST * trimmed length`` is taken.

    Parameters
    ----------
    points : (n, 2) array_like
        ``n >= 1``.

    Returns
    -------
    (m, 2) float
        A closed polyline that does not repeat its first point.
    """
    place = np.asarray(points, float)
    place = place[distinct(place)]
    along = arc_length(place)
    length = float(along[-1])
    if len(place) < 3:
        return place
    begin, end = best_joint(place, along, length)
    inner = (along > begin) & (along < end)
    first, last = (points_along(place, along, at) for at in (begin, end))
    loop = np.vstack((first, place[inner], last))
    return loop[distinct(loop, closed=True)]


def best_joint(place: Array, along: Array, length: float) -> tuple[float, float]:
    """Return the arc lengths at which to cut the beginning and the end."""
    reach = END_SHARE * length
    heads = np.linspace(0.0, reach, SEARCH_POINTS)
    tails = length - heads
    head, tail = (points_along(place, along, at) for at in (heads, tails))
    gap = np.linalg.norm(head[:, None] - tail, axis=2)
    cost = gap + TRIM_COST * (heads[:, None] + heads)
    best = np.unravel_index(int(np.argmin(cost)), cost.shape)
    begin, end, least = heads[best[0]], tails[best[1]], float(cost[best])

    met = self_crossings(place)
    at, to = (np.interp(k, np.arange(len(place)), along) for k in (met.first, met.second))
    trimmed = TRIM_COST * (at + length - to)
    good = np.flatnonzero((at <= reach) & (to >= length - reach) & (trimmed <= least))
    if len(good):
        cheapest = good[trimmed[good] == trimmed[good].min()][-1]
        begin, end = at[cheapest], to[cheapest]
    return float(begin), float(end)
