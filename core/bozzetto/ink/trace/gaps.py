"""Gaps in lines: where the pencil left the paper white and the line goes on."""

from __future__ import annotations

import heapq
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.ink.trace.skeleton import length

if TYPE_CHECKING:
    from bozzetto.arrays import Array

TOUCHING: Final = 1.5
"""Gap that is bridged whatever the directions, in widths of the line."""

LEANING: Final = float(np.cos(np.deg2rad(40.0)))
"""Cosine of the largest angle between a line and the bridge that goes on from it."""

SHARE: Final = 2.0
"""Length of each of two lines in gaps: dashes are shorter, and stay dashes."""

LOOKED_AT: Final = 5.0
"""Length of a line's end that tells its direction, in widths."""


def bridged(lines: list[Array], reach: float, width: float) -> list[Array]:
    """Join lines over gaps, the shortest gaps first.

    Parameters
    ----------
    lines : list of (n, 2) float
        Lines; closed ones begin and end in one place.
    reach : float
        Longest gap, pixels.
    width : float
        Width of the lines, pixels.

    Returns
    -------
    list of (n, 2) float
        A line that meets its own beginning is closed.
    """
    from scipy.spatial import cKDTree

    closed = [line for line in lines if is_closed(line)]
    rows = {number: line for number, line in enumerate(lines) if not is_closed(line)}
    if not rows:
        return lines
    numbers = list(rows)
    ends = np.array([rows[number][side] for number in numbers for side in (0, -1)])
    tree = cKDTree(ends)
    found: list[tuple[float, int, int]] = [
        (float(np.linalg.norm(ends[a] - ends[b])), int(a), int(b))
        for a, b in tree.query_pairs(max(reach, TOUCHING * width))
    ]
    heapq.heapify(found)
    owner = {2 * k + side: (number, side) for k, number in enumerate(numbers) for side in (0, 1)}
    opposite = {end: end ^ 1 for end in owner}  # the other end of its line
    while found:
        gap, a, b = heapq.heappop(found)
        if a not in owner or b not in owner:
            continue
        (one, side), (other, far) = owner[a], owner[b]
        if not _goes_on(rows[one], side, rows[other], far, gap, width):
            continue
        del owner[a], owner[b]
        start, end = opposite[a], opposite[b]
        if one == other:
            line = rows.pop(one)
            closed.append(np.vstack((line, line[:1])))
            continue
        first = rows.pop(one) if side == 1 else rows.pop(one)[::-1]
        second = rows.pop(other) if far == 0 else rows.pop(other)[::-1]
        rows[one] = np.vstack((first, second))
        owner[start], owner[end] = (one, 0), (one, 1)
        opposite[start], opposite[end] = end, start
    return [*closed, *rows.values()]


def is_closed(line: Array) -> bool:
    """Whether a line ends where it begins."""
    return len(line) > 3 and bool(np.array_equal(line[0], line[-1]))


def _goes_on(one: Array, side: int, other: Array, far: int, gap: float, width: float) -> bool:
    if one is other and length(one) < 4.0 * gap + 4.0 * width:
        return False
    if gap <= TOUCHING * width:
        return True
    if min(length(one), length(other)) < SHARE * gap:
        return False
    p, q = one[-side], other[-far]
    bridge = (q - p) / gap
    return bool(
        direction_at(one, side, width) @ bridge > LEANING
        and direction_at(other, far, width) @ -bridge > LEANING
    )


def direction_at(line: Array, side: int, width: float) -> Array:
    """Return the direction, (2,), in which a line leaves the paper at its beginning or its end."""
    inward = line if side == 0 else line[::-1]
    apart = np.linalg.norm(inward - inward[0], axis=1)
    beyond = np.flatnonzero(apart > LOOKED_AT * width)
    back = inward[beyond[0] if len(beyond) else -1]
    span = float(np.linalg.norm(inward[0] - back))
    return np.asarray((inward[0] - back) / span) if span > 0.0 else np.zeros(2)
