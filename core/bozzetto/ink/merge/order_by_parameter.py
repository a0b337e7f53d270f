"""Order by one parameter for all strokes together: neighbours across strokes agree on it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.ink.merge.resample_all import Ordering, ResampledInk

RADIUS: Final = 6.0
"""Greatest distance of neighbours across strokes, in spacings."""

ALIGNED: Final = 0.6
"""Least |cosine| between the tangents of neighbours: crossing strokes are none."""

BESIDE: Final = 0.75
"""Farthest a neighbour can be ahead or behind, in spacings: it lies sideways."""

SHORTEST: Final = 3
"""Points of the shortest piece that has a direction."""

LINK: Final = 0.3
"""Weight of a link across strokes against a step along one."""

ANCHOR: Final = 1e-7
"""Weight of a pull of the parameter towards 0: makes the equations solvable, moves nothing."""

ROUNDS: Final = 4
"""Rounds of reweighting: links that contradict the rest lose their say."""

TOLERANCE: Final = 2.0
"""Disagreement at which a link has half its say, in spacings."""

BROKEN: Final = 8.0
"""Disagreement at which a link has none, in spacings."""

ROUND: Final = 20.0
"""Least length of a closed curve, in spacings."""

LAP: Final = 0.35
"""Least jump of a link that tells of another lap, as a share of the range of parameters."""

EVIDENCE: Final = 3
"""Fewest links that show a curve to be closed."""


@dataclass(frozen=True, eq=False)
class _Links:
    """Pairs of points that should have parameters at a given difference.

    Attributes
    ----------
    one, other : (k,) int
    agree : (k,) float
        Cosine between the tangents.
    """

    one: Index
    other: Index
    agree: Array

    def only(self, kept: Flags) -> _Links:
        return _Links(self.one[kept], self.other[kept], self.agree[kept])


def order_by_parameter(ink: ResampledInk) -> Ordering | None:
    """Solve for one parameter along the strip that all strokes make together.

    Steps along a stroke are known; neighbours on different strokes that run side by side
    should agree (after Pagurek van Mossel et al. 2021, "StrokeStrip", as linear least
    squares with reweighting). Right for loops, crossings and closed curves.
    """
    pieces = [numbers for numbers in ink.pieces if len(numbers) >= SHORTEST]
    if not pieces:
        return None
    links, own = _links(ink)
    sense = np.zeros(len(ink.points))
    bridges = _oriented(ink, pieces, links, sense)
    links = links.only(links.agree * sense[links.one] * sense[links.other] > 0)
    behind = np.concatenate([numbers[:-1] for numbers in pieces])
    steps = np.linalg.norm(ink.points[behind + 1] - ink.points[behind], axis=1) * sense[behind]

    rough = _unrolled(len(ink.points), behind, steps, links, bridges)
    numbers = np.concatenate(pieces)
    period, links = _period(ink, rough, numbers, links, own)
    laps = np.zeros(len(links.one))
    if period > 0:
        laps = np.round((rough[links.one] - rough[links.other]) / period)
    along = _solved(ink, behind, steps, links, bridges, laps * period)[numbers]
    extent = period if period > 0 else float(np.ptp(along))
    if not extent > 0:
        return None
    share = (along - along.min()) / extent
    return Ordering(numbers, np.mod(share, 1.0) if period > 0 else share, period > 0)


def _links(ink: ResampledInk) -> tuple[_Links, _Links]:
    """Link neighbours side by side: the nearest on each other piece, and all on the same piece."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(ink.points).query_pairs(RADIUS * ink.spacing, output_type="ndarray")
    one, other = np.vstack((pairs, pairs[:, ::-1])).T
    between = ink.points[other] - ink.points[one]
    agree = (ink.tangents[one] * ink.tangents[other]).sum(axis=1)
    ahead = np.abs((between * ink.tangents[one]).sum(axis=1))
    beside = (np.abs(agree) > ALIGNED) & (ahead < BESIDE * ink.spacing)
    same = ink.piece[one] == ink.piece[other]
    distance = np.linalg.norm(between, axis=1)
    across = np.flatnonzero(beside & ~same)
    order = across[np.lexsort((distance[across], ink.piece[other[across]], one[across]))]
    key = np.column_stack((one[order], ink.piece[other[order]]))
    first = np.append(True, (key[1:] != key[:-1]).any(axis=1))[: len(order)]
    chosen = order[first]
    rest = np.flatnonzero(beside & same & (one < other))
    links, own = (_Links(one[i], other[i], agree[i]) for i in (chosen, rest))
    return links, own


def _oriented(
    ink: ResampledInk, pieces: list[Index], links: _Links, sense: Array
) -> list[tuple[int, int, float]]:
    """Give all pieces a common sense (written into `sense`); bridge what is not linked.

    Returns
    -------
    list of (int, int, float)
        Bridges: the point before, the point after, and the gap.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

    count = int(ink.piece[-1]) + 1
    votes = np.zeros((count, count))
    np.add.at(votes, (ink.piece[links.one], ink.piece[links.other]), links.agree)
    votes += votes.T
    tree = minimum_spanning_tree(csr_array(-np.abs(votes)))
    tree = csr_array(tree + tree.T)
    sizes = np.bincount(ink.piece, minlength=count)
    turn = np.zeros(count)
    for start in np.argsort(-sizes):
        if turn[start]:
            continue
        turn[start] = 1.0
        waiting = [int(start)]
        while waiting:
            here = waiting.pop()
            for there in tree.indices[tree.indptr[here] : tree.indptr[here + 1]]:
                if not turn[there]:
                    turn[there] = turn[here] * np.sign(votes[here, there])
                    waiting.append(int(there))
    _, island = connected_components(tree, directed=False)
    real = [int(ink.piece[numbers[0]]) for numbers in pieces]
    bridges = _bridges(ink, pieces, np.asarray(island, np.intp), turn, real)
    sense[:] = turn[ink.piece]
    return bridges


def _bridges(
    ink: ResampledInk, pieces: list[Index], island: Index, turn: Array, real: list[int]
) -> list[tuple[int, int, float]]:
    """Join islands of strokes at the nearest ends, turning one where that is shorter."""
    ends = np.array([[numbers[0], numbers[-1]] for numbers in pieces])
    group = island[real].copy()
    found = []
    places = ink.points[ends]
    distance = np.linalg.norm(places[:, :, None, None] - places[None, None], axis=-1)
    while len(np.unique(group)) > 1:
        apart = (group[:, None] != group)[:, None, :, None]
        best = np.argmin(np.where(apart, distance, np.inf))
        a, end_a, b, end_b = (int(i) for i in np.unravel_index(best, distance.shape))
        # A piece runs from its end 0 to its end 1 where its turn is +1.
        leaves = (end_a == 1) == (turn[real[a]] > 0)
        enters = (end_b == 0) == (turn[real[b]] > 0)
        moved = group == group[b]
        if leaves != enters:
            turn[np.asarray(real)[moved]] *= -1.0
        pair = (ends[a, end_a], ends[b, end_b]) if leaves else (ends[b, end_b], ends[a, end_a])
        found.append((int(pair[0]), int(pair[1]), float(distance.flat[best])))
        group[moved] = group[a]
    return found


def _unrolled(
    count: int, behind: Index, steps: Array, links: _Links, bridges: list[tuple[int, int, float]]
) -> Array:
    """Return parameters by walking outwards from the middle of the ink; the first way counts."""
    ways: list[list[tuple[int, float]]] = [[] for _ in range(count)]
    for one, other, difference in [
        *zip(behind.tolist(), (behind + 1).tolist(), steps.tolist(), strict=True),
        *((a, b, 0.0) for a, b in zip(links.one.tolist(), links.other.tolist(), strict=True)),
        *bridges,
    ]:
        ways[one].append((other, difference))
        ways[other].append((one, -difference))
    along = np.full(count, np.nan)
    start = int(behind[len(behind) // 2])
    along[start] = 0.0
    waiting = deque([start])
    while waiting:
        here = waiting.popleft()
        for there, difference in ways[here]:
            if np.isnan(along[there]):
                along[there] = along[here] + difference
                waiting.append(there)
    return np.asarray(np.nan_to_num(along))


def _period(
    ink: ResampledInk, rough: Array, numbers: Index, links: _Links, own: _Links
) -> tuple[float, _Links]:
    """Return the length of a lap, 0 for an open curve, and the links, with those within strokes."""
    extent = float(np.ptp(rough[numbers]))
    least = max(2.0 * RADIUS * ink.spacing, LAP * extent)
    lap = own.only((own.agree > ALIGNED) & (np.abs(rough[own.one] - rough[own.other]) > least))
    every = _Links(
        np.concatenate((links.one, lap.one)),
        np.concatenate((links.other, lap.other)),
        np.concatenate((links.agree, lap.agree)),
    )
    jump = np.abs(rough[every.one] - rough[every.other])
    jump = jump[jump > least]
    if len(jump) < EVIDENCE:
        return 0.0, links
    period = float(np.median(jump))
    if period < ROUND * ink.spacing or np.std(jump) > 0.25 * period:
        return 0.0, links
    return period, every


def _solved(
    ink: ResampledInk,
    behind: Index,
    steps: Array,
    links: _Links,
    bridges: list[tuple[int, int, float]],
    difference: Array,
) -> Array:
    """Solve all steps, links and bridges by reweighted least squares."""
    from scipy.sparse import csc_array, csr_array, diags_array, eye_array
    from scipy.sparse.linalg import spsolve

    count = len(ink.points)
    gaps = np.array(bridges, float).reshape(-1, 3)
    before, after = gaps[:, 0].astype(np.intp), gaps[:, 1].astype(np.intp)
    plus = np.concatenate((behind + 1, links.one, after))
    minus = np.concatenate((behind, links.other, before))
    target = np.concatenate((steps, difference, gaps[:, 2]))
    rows = np.arange(len(target))
    ones = np.ones(len(target))
    matrix = csr_array(
        (np.concatenate((ones, -ones)), (np.tile(rows, 2), np.concatenate((plus, minus)))),
        (len(target), count),
    )
    along = np.zeros(count)
    say = np.ones(len(links.one))
    for turn in range(ROUNDS):
        weight = np.concatenate((np.ones(len(steps)), (LINK * say) ** 2, np.ones(len(gaps))))
        scaled = matrix.T @ diags_array(weight)
        normal = csc_array(scaled @ matrix + ANCHOR * eye_array(count))
        along = spsolve(normal, scaled @ target)
        wrong = np.abs(along[links.one] - along[links.other] - difference) / ink.spacing
        say = 1.0 / (1.0 + (wrong / TOLERANCE) ** 2)
        if turn:
            say[wrong > BROKEN] = 0.0
    return np.asarray(along)
