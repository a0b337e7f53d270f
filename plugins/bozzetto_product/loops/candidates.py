"""Loops that may be meant: walks that turn always to the next edge, and short cycles.

After Zhuang, Zou, Carr & Ju 2013, "A general and efficient method for finding cycles in 3D curve
networks", who pair the ends at each node; here pairs are tried and a programme chooses.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto_product.loops.sampling import SampledNet

Halves = tuple[int, ...]
"""Numbers of half-edges, head to tail."""

Way = tuple[int, float, int]
"""Head, price and number of a half-edge."""

MOST_BESIDE: Final = 12
"""Ends that each one is paired with where many meet in a node, so that effort grows with their
number and not with its square."""

LONGEST_WALK: Final = 24
"""Nodes of three ends or more on the way: a side with several T-joints counts several."""

LONGEST_CYCLE: Final = 14
"""Edges: longer ones are short of nothing but sense."""

STEEP: Final = 0.85
"""Share of a direction along the normal that is carried above which an end leaves the surface."""

CORNER: Final = 0.15
"""Sine of an angle below which two directions define no normal."""

RENEWING: Final = 0.3
"""Sine of an angle above which a corner renews the normal that is carried."""

EDGE_PRICES: Final = (0.0, 1.5)
"""What an edge costs in cycles beside its length, in mean lengths: once cycles of least length
and once those of few edges."""


def candidate_loops(sampled: SampledNet) -> tuple[Halves, ...]:
    """Find the loops that may be meant.

    Parameters
    ----------
    sampled : SampledNet
        Its closed edges without a node are loops by themselves.

    Returns
    -------
    tuple of tuple of int
        Half-edges, head to tail; no two have the same edges, none comes to a node twice. With each
        loop its mirror image is there, where the net has it.
    """
    found: dict[frozenset[int], Halves] = {}
    for loop in _tried(sampled):
        nodes = set(sampled.tails[list(loop)].tolist())
        if edges_of(loop) not in found and len(nodes) == len(loop):
            found[edges_of(loop)] = loop
            image = mirror_image(sampled, loop)
            if image is not None:
                found.setdefault(edges_of(image), image)
    return tuple(found.values())


def edges_of(loop: Iterable[int]) -> frozenset[int]:
    """Return the numbers of a loop's edges, which tell it from any other."""
    return frozenset(half // 2 for half in loop)


def mirror_image(sampled: SampledNet, loop: Halves) -> Halves | None:
    """Return the mirror image of a loop; None where an edge has none."""
    image = tuple(int(sampled.images[half]) for half in loop)
    return image if min(image, default=-1) >= 0 else None


def _tried(sampled: SampledNet) -> Iterable[Halves]:
    edges = sampled.net.edges
    yield from ((2 * number,) for number, edge in enumerate(edges) if edge.start == edge.end)
    yield from _two_sided(sampled)
    yield from rotation_walks(sampled)
    for price in EDGE_PRICES if edges else ():
        mean = float(sampled.lengths.mean()) or 1.0
        yield from short_cycles(sampled, sampled.lengths / mean + price)


def _corners(sampled: SampledNet, halves: tuple[int, ...]) -> list[tuple[int, int]]:
    """Return pairs of ends at a node, in order: all, or each with those beside it if many meet."""
    if len(halves) <= MOST_BESIDE + 1:
        return list(itertools.combinations(halves, 2))
    ends = sampled.leaving[list(halves)]
    nearest = np.argsort(-(ends @ ends.T), axis=1, kind="stable")[:, : MOST_BESIDE + 1]
    pairs = {
        (min(half, halves[other]), max(half, halves[other]))
        for half, row in zip(halves, nearest.tolist(), strict=True)
        for other in row
        if halves[other] != half
    }
    return sorted(pairs)


def _two_sided(sampled: SampledNet) -> Iterable[Halves]:
    """Return the loops of two edges between the same nodes."""
    between: dict[frozenset[int], list[int]] = {}
    for number, edge in enumerate(sampled.net.edges):
        if edge.start != edge.end:
            between.setdefault(frozenset((edge.start, edge.end)), []).append(2 * number)
    for halves in between.values():
        for first, second in itertools.combinations(halves, 2):
            yield first, second ^ int(sampled.tails[second] == sampled.tails[first])


# -- walks -----------------------------------------------------------------------------------


def rotation_walks(sampled: SampledNet) -> list[Halves]:
    """Walk from each corner, turning always to the next edge about a normal that is carried along.

    The normal begins as that of the corner; each later corner renews it. Walks that do not come
    back within `LONGEST_WALK` nodes at which there is a choice are given up.
    """
    corners = [
        (into ^ 1, out)
        for halves in sampled.outgoing
        for pair in _corners(sampled, halves)
        for into, out in (pair, pair[::-1])
    ]
    if not corners:
        return []
    first, half = np.array(corners).T
    normal = _corner_normals(sampled, first, half)
    walks, path, done = np.arange(len(half)), [half], {}
    choice = np.array([len(halves) > 2 for halves in sampled.outgoing])
    choices = np.zeros(len(half), int)
    for step in range(1, len(sampled.net.edges) + 1):
        back = half == first[walks]
        done.update(dict.fromkeys(walks[back].tolist(), step))
        walks, half, normal = walks[~back], half[~back], normal[~back]
        half, normal, found = _next_edges(sampled, half, normal)
        walks, half, normal = walks[found], half[found], normal[found]
        choices[walks] += choice[sampled.tails[half]]
        kept = choices[walks] < LONGEST_WALK
        walks, half, normal = walks[kept], half[kept], normal[kept]
        if not len(walks):
            break
        path.append(np.zeros(len(first), int))
        path[-1][walks] = half
    steps = np.array(path)
    return [tuple(steps[: done[walk], walk].tolist()) for walk in sorted(done)]


def _corner_normals(sampled: SampledNet, into: Index, out: Index) -> Array:
    normal = cross_product(-sampled.leaving[into ^ 1], sampled.leaving[out])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    at_node = sampled.normals[sampled.heads[into]]
    return np.where(size < CORNER, at_node, normal / np.maximum(size, CORNER))


def _next_edges(sampled: SampledNet, half: Index, normal: Array) -> tuple[Index, Array, Flags]:
    """Return for each walk the next half-edge, the normal there, and whether there is one."""
    normal = np.einsum("kij,kj->ki", sampled.turns[half], normal)
    arriving = -sampled.leaving[half ^ 1]
    ahead = arriving - (arriving * normal).sum(axis=1, keepdims=True) * normal
    frame = np.stack((normal, ahead, cross_product(normal, ahead)), axis=1)
    ways = sampled.ways[sampled.heads[half]]
    up, along, across = np.einsum("kdi,kfi->fkd", sampled.leaving[ways], frame)
    angle = np.arctan2(across, along)
    angle[(ways < 0) | (ways // 2 == half[:, None] // 2) | (np.abs(up) > STEEP)] = -np.inf
    best, rows = angle.argmax(axis=1), np.arange(len(half))
    found = angle[rows, best] > -np.inf
    chosen = np.where(found, ways[rows, best], half)
    out = sampled.leaving[chosen]
    corner = cross_product(arriving, out)
    size = np.linalg.norm(corner, axis=1, keepdims=True)
    corner = np.where(size > RENEWING, corner / np.maximum(size, RENEWING), 0.0)
    normal = normal + corner * np.sign((corner * normal).sum(axis=1, keepdims=True))
    normal -= (normal * out).sum(axis=1, keepdims=True) * out
    return chosen, normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9), found


# -- short cycles ----------------------------------------------------------------------------


def short_cycles(sampled: SampledNet, prices: Array) -> list[Halves]:
    """Find the cheapest cycle through each corner, by a search around the corner's node.

    Parameters
    ----------
    sampled : SampledNet
        The net.
    prices : (m,) float
        Of the edges, positive.
    """
    cheapest: dict[tuple[int, int], int] = {}
    for number in np.argsort(prices, kind="stable").tolist():
        edge = sampled.net.edges[number]
        if edge.start != edge.end:
            cheapest.setdefault((edge.start, edge.end), 2 * number)
            cheapest.setdefault((edge.end, edge.start), 2 * number + 1)
    ways: list[list[Way]] = [[] for _ in sampled.net.nodes]
    for (tail, head), half in cheapest.items():
        ways[tail].append((head, float(prices[half // 2]), half))
    found = []
    for node, halves in enumerate(sampled.outgoing):
        for out, pairs in itertools.groupby(_corners(sampled, halves), lambda pair: pair[0]):
            start = int(sampled.heads[out])
            goals = {back: int(sampled.heads[back]) for _, back in pairs}
            if start == node:
                continue
            before = _search(ways, start, set(goals.values()) - {node}, node)
            for back, goal in goals.items():
                path = _path(before, goal, sampled.tails)
                if goal != node and path is not None:
                    found.append((out, *path, back ^ 1))
    return found


def _search(ways: list[list[Way]], start: int, goals: set[int], barred: int) -> dict[int, int]:
    """Return the half-edge by which the cheapest way from a node comes to each other one.

    Dijkstra's search, which ends when all goals are reached; -1 for the start.
    """
    before: dict[int, int] = {}
    left = set(goals)
    waiting = [(0.0, start, -1)]
    while waiting and left:
        cost, node, half = heapq.heappop(waiting)
        if node in before:
            continue
        before[node] = half
        left.discard(node)
        for head, price, way in ways[node]:
            if head != barred and head not in before:
                heapq.heappush(waiting, (cost + price, head, way))
    return before


def _path(before: dict[int, int], goal: int, tails: Index) -> Halves | None:
    """Return the half-edges to a node by what a search found; None if it was not reached."""
    path: list[int] = []
    while before.get(goal, -1) >= 0:
        path.append(before[goal])
        goal = int(tails[path[-1]])
    return tuple(reversed(path)) if goal in before and len(path) <= LONGEST_CYCLE - 2 else None
