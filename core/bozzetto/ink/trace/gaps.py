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

OUTLINE_REACH: Final = 2.0
"""Longest gap of an outline, in gaps that are bridged anywhere."""

OUTLINE_DRAWN: Final = 0.92
"""Least share of an outline that is drawn, not gap."""

ALONE: Final = 1.5
"""Least distance to any third end, in gaps, where two ends belong to one another; and the
distance at which lines touch beyond that."""

FAR_END: Final = 4.0
"""Least length of a line whose two ends are ends beside one another, in gaps."""

BESIDE: Final = 6
"""Ends that are looked at beside each one, itself included."""


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
    closed = [line for line in lines if is_closed(line)]
    open_lines = _bridged_open([line for line in lines if not is_closed(line)], reach, width)
    closed += [line for line in open_lines if is_closed(line)]
    open_lines = [line for line in open_lines if not is_closed(line)]
    return [*closed, *_closed_outlines(open_lines, closed, OUTLINE_REACH * reach, width)]


def _bridged_open(lines: list[Array], reach: float, width: float) -> list[Array]:
    """Join lines over gaps across which both point to one another."""
    from scipy.spatial import cKDTree

    closed: list[Array] = []
    rows = dict(enumerate(lines))
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


def _closed_outlines(
    lines: list[Array], closed: list[Array], reach: float, width: float
) -> list[Array]:
    """Close each ring of lines that nothing but gaps divides; lines of no ring stay as they are.

    Gaps lie at corners, where the ends do not point to one another, and beside short pieces, which
    might be dashes. That they are gaps is known from the ring: each end has one other end beside
    it, no third one, and no line passes there.
    """
    mate = _lone_mates(lines, closed, reach, width)
    rings: list[Array] = []
    walked: set[int] = set()
    closing: set[int] = set()
    for start in range(len(lines)):
        ring = _ring(2 * start, mate, walked)
        if not ring:
            continue
        pieces = [lines[end // 2] if end % 2 == 0 else lines[end // 2][::-1] for end in ring]
        line = np.vstack((*pieces, pieces[0][:1]))
        if sum(length(piece) for piece in pieces) >= OUTLINE_DRAWN * length(line):
            closing.update(end // 2 for end in ring)
            rings.append(line)
    return [*rings, *(line for number, line in enumerate(lines) if number not in closing)]


def _ring(start: int, mate: dict[int, int], walked: set[int]) -> list[int]:
    """Return the ends at which the lines of a ring begin, from one on; none where it is open.

    The numbers of the lines that are passed go to `walked`, and no line is passed twice.
    """
    ring = []
    end: int | None = start
    while end is not None and end // 2 not in walked:
        walked.add(end // 2)
        ring.append(end)
        end = mate.get(end ^ 1)
    return ring if ring and end == start else []


def _lone_mates(
    lines: list[Array], closed: list[Array], reach: float, width: float
) -> dict[int, int]:
    """Return the other end of each gap at which nothing else lies.

    The ends of line k have the numbers 2 k and 2 k + 1.
    """
    from scipy.spatial import cKDTree

    if not lines:
        return {}
    ends = np.array([line[side] for line in lines for side in (0, -1)])
    lengths = [length(line) for line in lines]
    apart = TOUCHING * width
    found = cKDTree(ends).query(ends, k=BESIDE, distance_upper_bound=ALONE * reach + apart)
    nearest: dict[int, list[tuple[float, int]]] = {}
    for end, (gaps, others) in enumerate(zip(*found, strict=True)):
        beside = zip(gaps.tolist(), others.tolist(), strict=True)
        # The far end of a short piece is as near as a gap is wide, and is no end beside another.
        nearest[end] = [
            (gap, other)
            for gap, other in beside
            if other not in (end, len(ends))
            and (other != end ^ 1 or lengths[end // 2] >= FAR_END * gap)
        ]
    every = [*lines, *closed]
    owner = np.repeat(np.arange(len(every)), [len(line) for line in every])
    body = cKDTree(np.vstack(every))
    mates: dict[int, int] = {}
    for end, beside_it in nearest.items():
        if not beside_it or beside_it[0][0] > reach:
            continue
        gap, other = beside_it[0]
        short = lengths[other // 2] < FAR_END * gap
        third = [far for far, one in beside_it[1:] if not (short and one == other ^ 1)]
        if third and third[0] < ALONE * gap + apart:
            continue
        passing = owner[body.query_ball_point(ends[end], apart)]
        if np.isin(passing, (end // 2, other // 2)).all():
            mates[end] = other
    return {end: other for end, other in mates.items() if mates.get(other) == end}


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
