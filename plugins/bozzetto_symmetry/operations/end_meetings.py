"""Ends that meet one another: which do, and the place that all their ink says together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_symmetry.operations.open_ends import FreeEnd
from bozzetto_symmetry.operations.snap_candidates import SMOOTH


class Meeting(NamedTuple):
    """Ends that meet.

    Attributes
    ----------
    members : list of int
        Their numbers.
    held : int
        The number of the fixed point that they meet in; -1 for none.
    """

    members: list[int]
    held: int


def meetings(ends: list[FreeEnd], points: Array) -> list[Meeting]:
    """Return which ends meet, each within reach of the common place or the fixed point."""
    count = len(ends)
    if not count:
        return []
    own = [_nearest(end, points) for end in ends]
    places = np.array([end.place for end in ends])
    rooms = np.array([end.room for end in ends])
    near = np.linalg.norm(places[:, None] - places, axis=2) <= rooms[:, None] + rooms
    links = [
        (i, j)
        for i, j in zip(*np.nonzero(np.tril(near, -1)), strict=True)
        if ends[i].owner != ends[j].owner and _apart(ends[i], ends[j]) <= 1.0
    ]
    group = _hanging_together(links, count)
    made: list[Meeting] = []
    for number in range(int(group.max()) + 1):
        made += _parted(np.flatnonzero(group == number).tolist(), ends, own, points)
    return made


def _hanging_together(links: Sequence[tuple[int, int]], count: int) -> Index:
    """Return to which group each of so many ends belongs, (count,), for links between two."""
    if not links:  # the first curve waits for no import
        return np.arange(count)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    rows = np.array(links)
    graph = coo_array((np.ones(len(rows)), (rows[:, 0], rows[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])


def _nearest(end: FreeEnd, points: Array) -> int:
    """Return the number of the fixed point that an end is meant to be at; -1 for none."""
    if not len(points):
        return -1
    ratios = end.reach.ratios(points - end.place, end.sigma)
    return int(np.argmin(ratios)) if float(ratios.min()) <= 1.0 else -1


def _parted(
    members: list[int], ends: list[FreeEnd], own: Sequence[int], points: Array
) -> Iterator[Meeting]:
    """Yield clusters of ends that hang together, after those are left out that are too far off."""
    left = members
    while left:
        held = sorted({own[k] for k in left if own[k] >= 0})
        known = np.sum([ends[k].known for k in left], axis=0)
        seen = np.sum([ends[k].known @ ends[k].place for k in left], axis=0)
        middle: Array = np.linalg.solve(known, seen)
        number = -1
        if held:
            worst = [max(ends[k].away(points[p]) for k in left) for p in held]
            number = held[int(np.argmin(worst))]
            middle = points[number]
        off = {k: ends[k].away(middle) for k in left}
        for k in left:  # both ends of a curve do not meet
            twins = [j for j in left if ends[j].owner == ends[k].owner]
            if len(twins) > 1 and k == max(twins, key=off.__getitem__):
                off[k] += 1.0
        worst_end = max(left, key=off.__getitem__)
        if off[worst_end] <= 1.0:
            yield Meeting(left, number)
            left = []
        elif len(left) == 1:
            yield Meeting(left, -1)
            left = []
        else:
            yield Meeting([worst_end], own[worst_end])
            left = [k for k in left if k != worst_end]


def _apart(one: FreeEnd, other: FreeEnd) -> float:
    """Return how far two ends are apart, in what both may be off."""
    sigma = float(np.hypot(one.sigma, other.sigma))
    return max(one.away(other.place, sigma), other.away(one.place, sigma))


def common_places(
    ends: Sequence[FreeEnd],
    met: Sequence[Meeting],
    points: Array,
    axes: Mapping[str, Array],
) -> Array:
    """Return the places of ends that meet, (n, 3), by what all their ink says.

    Curves that were drawn along an axis of the box join places along that axis: these are equations
    that hold, and the rest is least squares.

    Parameters
    ----------
    ends : sequence of FreeEnd
        All free ends.
    met : sequence of Meeting
        Each of them in one.
    points : (p, 3) float array
        The fixed ones.
    axes : mapping of str to (3,) float array
        Unit directions of pairs that run along an axis, by the id of the curve.
    """
    count = len(met)
    matrix, right = np.zeros((3 * count, 3 * count)), np.zeros(3 * count)
    of_end = {}
    for number, (members, held) in enumerate(met):
        rows = slice(3 * number, 3 * number + 3)
        for k in members:
            of_end[ends[k].owner, ends[k].number] = number, ends[k].side
            if held < 0:
                matrix[rows, rows] += ends[k].known
                right[rows] += ends[k].known @ ends[k].place
        if held >= 0:
            matrix[rows, rows], right[rows] = np.eye(3), points[held]
    laws, values = [], []
    for name, axis in axes.items():
        if not {(name, 0), (name, 1)} <= of_end.keys():
            continue
        both = of_end[name, 0], of_end[name, 1]
        if both[0][0] == both[1][0] or all(met[number].held >= 0 for number, _ in both):
            continue
        for way in np.linalg.svd(axis[None])[2][1:]:
            law, value = np.zeros(3 * count), 0.0
            for (number, side), sign in zip(both, (1.0, -1.0), strict=True):
                if met[number].held >= 0:
                    value -= sign * float(way @ (points[met[number].held] * side))
                else:
                    law[3 * number : 3 * number + 3] = sign * way * side
            laws.append(law)
            values.append(value)
    if not laws:
        return np.asarray(np.linalg.solve(matrix, right).reshape(-1, 3))
    # Least squares among all that the equations leave open; some of them follow from others.
    law = np.stack(laws)
    first, stretch, open_ways = np.linalg.svd(law)
    rank = int((stretch > 1e-9 * stretch[0]).sum())
    base = open_ways[:rank].T @ (first[:, :rank].T @ np.array(values) / stretch[:rank])
    rest = open_ways[rank:]
    left = np.linalg.solve(rest @ matrix @ rest.T, rest @ (right - matrix @ base))
    return np.asarray((base + rest.T @ left).reshape(-1, 3))


def continued(members: list[int], ends: list[FreeEnd], known: Array | None) -> list[Array | None]:
    """Return the direction that each end takes, if it nearly goes on another one or a known one."""
    if known is not None and known.any():
        cosines = [float(ends[k].leaving @ known) for k in members]
        return [np.copysign(1.0, c) * known if abs(c) > SMOOTH else None for c in cosines]
    ways: list[Array | None] = [None] * len(members)
    pairs = sorted(
        (float(ends[members[i]].leaving @ ends[members[j]].leaving), i, j)
        for i in range(len(members)) for j in range(i)
    )  # fmt: skip
    for cosine, i, j in pairs:
        if cosine < -SMOOTH and ways[i] is None and ways[j] is None:
            way = ends[members[i]].leaving - ends[members[j]].leaving
            way = way / np.linalg.norm(way)
            ways[i], ways[j] = way, -way
    return ways
