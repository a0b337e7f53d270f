"""Places where a curve crosses itself, or ends on itself: an 8, a loop, a 6."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Spline
from bozzetto_product.operations.clusters import LOOP
from bozzetto_product.operations.meetings import share_at

PIECES: Final = 8
"""Segments by which a span of the curve is known: a crossing is found from its nearest corner."""

AROUND: Final = 4
"""Least way along the curve from one passage to the other, in these segments."""

STEPS: Final = 12
"""Steps of Newton's method to the places where both passages are closest."""

FLATTEST: Final = float(np.sin(np.radians(15.0)))
"""Sine of the least angle of a crossing: what runs along itself does not cross itself."""


def own_crossings(spline: Spline, gap: float) -> list[tuple[float, float, Array]]:
    """Find where a curve crosses itself, or where one of its ends lies on it.

    Parameters
    ----------
    spline : Spline
        In space, mm.
    gap : float
        Largest distance between both passages, mm. Stretches of less than six of them do not count
        as loops.

    Returns
    -------
    list of (float, float, (3,) array)
        Shares of the range of both passages, 0 or 1 where it is the end of an open curve that is
        meant, and the place between them, mm.
    """
    if _turning(spline.control_points) <= np.pi:
        return []  # a loop turns by more (Milnor 1950), and its control polygon by no less
    at = np.linspace(*spline.range, PIECES * len(spline.control_points) + 1)
    points = spline.value(at)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    run = np.concatenate(([0.0], np.cumsum(steps)))
    least = max(LOOP * gap, AROUND * float(steps.max()))
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    apart[_way(run[:, None], run, spline, run[-1]) < least] = np.inf
    apart[np.tril_indices(len(at))] = np.inf
    padded = np.pad(apart, 1, constant_values=np.inf)
    count = len(at)
    lowest = np.min(
        [padded[i : i + count, j : j + count] for i in (0, 1, 2) for j in (0, 1, 2)], axis=0
    )
    shares = (at - at[0]) / (at[-1] - at[0])
    found: list[tuple[float, float, Array]] = []
    met: list[Array] = []
    for row, column in zip(
        *np.nonzero((apart <= lowest) & (apart <= gap + steps.max())), strict=True
    ):
        crossing = _crossing(spline, float(at[row]), float(at[column]), gap, gap / run[-1])
        if crossing is None:
            continue
        here = np.interp(crossing[:2], shares, run)
        ways = [_way(here, there, spline, run[-1]).max() for there in met]
        if min(ways, default=np.inf) <= least or _way(here[0], here[1], spline, run[-1]) < least:
            continue
        met.append(here)
        found.append(crossing)
    return found


def _turning(points: Array) -> float:
    """Return by how much a polygon turns, radians."""
    ways = np.diff(points, axis=0)
    ways = ways[np.linalg.norm(ways, axis=1) > 0.0]
    sine = np.linalg.norm(cross_product(ways[1:], ways[:-1]), axis=1)
    return float(np.arctan2(sine, (ways[1:] * ways[:-1]).sum(axis=1)).sum())


def _way(one: Array, other: Array, spline: Spline, length: float) -> Array:
    """Return the way along a curve between places on it, the shorter one round a closed curve."""
    way = np.abs(one - other)
    return np.asarray(np.minimum(way, length - way) if spline.closed else way)


def _crossing(
    spline: Spline, first: float, second: float, gap: float, short: float
) -> tuple[float, float, Array] | None:
    """Return the crossing near two parameters; None if there is none.

    A place within a short share of the range of an end is that end.
    """
    at = np.array((first, second))
    for _ in range(STEPS):
        here, there = spline.value(at)
        way, back = spline.derivative(at)
        at = spline.within(
            at - np.linalg.lstsq(np.stack((way, -back), axis=1), here - there, rcond=1e-9)[0]
        )
    places, (way, back) = spline.value(at), spline.derivative(at)
    size = float(np.linalg.norm(way) * np.linalg.norm(back))
    if np.linalg.norm(places[0] - places[1]) > gap:
        return None
    if not np.linalg.norm(cross_product(way, back)) > FLATTEST * size:
        return None
    shares = [share_at(spline, float(one)) for one in at]
    middle = places.mean(axis=0)
    if not spline.closed:
        ends = [
            next((end for end in (0.0, 1.0) if abs(share - end) <= short), None) for share in shares
        ]
        if None not in ends:
            return None  # its ends meet one another
        for end, other in zip(ends, places[::-1], strict=True):
            middle = middle if end is None else other
        shares = [share if end is None else end for share, end in zip(shares, ends, strict=True)]
    return shares[0], shares[1], middle
