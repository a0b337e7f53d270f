"""The middle lines of ink as a graph: pixels thinned, joined to chains between nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index

SPUR: Final = 1.6
"""Longest branch that is a bulge of a line's border and no line, in half widths of the line that
it leaves."""

STEPS: Final = ((0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1))
"""Neighbours of a pixel, (row, column): those with a common side first."""


@dataclass(frozen=True, eq=False)
class LineChain:
    """A line between two nodes of the skeleton.

    Attributes
    ----------
    points : (n, 2) float
        Middles of its pixels in order, x and y; those of the nodes included. A closed chain
        begins and ends in one place.
    ends : (int, int)
        Its nodes; the same number twice for a closed chain.
    """

    points: Array
    ends: tuple[int, int]


@dataclass(frozen=True, eq=False)
class Skeleton:
    """The middle lines of ink.

    Attributes
    ----------
    chains : tuple of LineChain
    half_width : (h, w) float
        Distance of each pixel of ink from the paper, pixels.
    """

    chains: tuple[LineChain, ...]
    half_width: Array

    def width_at(self, points: Array) -> Array:
        """Return the width of the ink at places on middle lines, (n,), pixels."""
        rows = np.clip(points[:, 1].astype(int), 0, self.half_width.shape[0] - 1)
        columns = np.clip(points[:, 0].astype(int), 0, self.half_width.shape[1] - 1)
        return np.asarray(2.0 * self.half_width[rows, columns])


def skeleton_of(mask: Flags) -> Skeleton:
    """Thin ink to lines (Zhang and Suen 1984), and join their pixels to chains.

    Parameters
    ----------
    mask : (h, w) bool
        Where ink is. Holes that are smaller than the lines are wide are filled.
    """
    from scipy import ndimage
    from skimage.morphology import remove_small_holes, skeletonize

    half_width = ndimage.distance_transform_edt(mask)
    thin = skeletonize(mask)
    if thin.any():
        width = 2.0 * float(np.median(half_width[thin]))
        mask = remove_small_holes(mask, max_size=max(2, int(width * width)))
        half_width = ndimage.distance_transform_edt(mask)
        thin = skeletonize(mask)
    chains = _chains(thin)
    return Skeleton(tuple(_without_spurs(chains, half_width)), half_width)


def _neighbours(thin: Flags) -> tuple[Index, Index]:
    """Return the pixels (n, 2) of a skeleton, and the numbers of their neighbours (n, 8) or -1.

    Two pixels that touch at a corner are no neighbours where a third one touches both with a side:
    so a staircase is a chain and no row of junctions.
    """
    padded = np.pad(thin, 1)
    pixels = np.argwhere(padded)
    number = np.full(padded.shape, -1, np.intp)
    number[tuple(pixels.T)] = np.arange(len(pixels))
    near = np.stack([number[tuple((pixels + step).T)] for step in STEPS], axis=1)
    for column, (down, right) in enumerate(STEPS[4:], 4):
        beside = STEPS.index((down, 0)), STEPS.index((0, right))
        near[(near[:, beside[0]] >= 0) | (near[:, beside[1]] >= 0), column] = -1
    return pixels - 1, near


def _chains(thin: Flags) -> list[LineChain]:
    pixels, near = _neighbours(thin)
    if not len(pixels):
        return []
    places: Array = pixels[:, ::-1].astype(float) + 0.5
    degree = (near >= 0).sum(1)
    linked = [[int(other) for other in row if other >= 0] for row in near]
    is_node = degree != 2
    walked: set[tuple[int, int]] = set()
    done = np.zeros(len(pixels), bool)
    chains: list[LineChain] = []

    def walk(start: int, second: int) -> list[int]:
        path = [start, second]
        while not is_node[path[-1]] and path[-1] != start:
            first, last = linked[path[-1]]
            path.append(last if first == path[-2] else first)
        return path

    for node in np.flatnonzero(is_node):
        done[node] = True
        for second in linked[node]:
            if (int(node), second) in walked:
                continue
            path = walk(int(node), second)
            walked.add((path[-1], path[-2]))
            done[path] = True
            chains.append(LineChain(places[path], (path[0], path[-1])))
    for start in np.flatnonzero(~done):
        if not done[start]:
            path = walk(int(start), linked[start][0])
            done[path] = True
            chains.append(LineChain(places[path], (path[0], path[0])))
    return chains


def _without_spurs(chains: list[LineChain], half_width: Array) -> list[LineChain]:
    """Leave out short branches with a free end; lines that only they divided are joined again."""
    degree: dict[int, int] = {}
    for chain in chains:
        for end in chain.ends:
            degree[end] = degree.get(end, 0) + 1
    kept = []
    for chain in chains:
        free = [degree[end] == 1 for end in chain.ends]
        if sum(free) == 1:
            root = chain.points[0] if free[1] else chain.points[-1]
            reach = SPUR * half_width[int(root[1]), int(root[0])]
            if length(chain.points) <= reach + 1.0:
                continue
        kept.append(chain)
    return _merged(kept)


def _merged(chains: list[LineChain]) -> list[LineChain]:
    """Join the two chains at each node where no third one ends."""
    rows = dict(enumerate(chains))
    at: dict[int, list[int]] = {}
    for number, chain in rows.items():
        for end in chain.ends:
            at.setdefault(end, []).append(number)
    for node, numbers in at.items():
        if len(numbers) != 2 or numbers[0] == numbers[1]:
            continue
        first, second = rows[numbers[0]], rows.pop(numbers[1])
        one = first if first.ends[1] == node else _reversed(first)
        other = second if second.ends[0] == node else _reversed(second)
        rows[numbers[0]] = LineChain(
            np.vstack((one.points, other.points[1:])), (one.ends[0], other.ends[1])
        )
        beyond = at[other.ends[1]]
        beyond[beyond.index(numbers[1])] = numbers[0]
    return list(rows.values())


def _reversed(chain: LineChain) -> LineChain:
    return LineChain(chain.points[::-1], (chain.ends[1], chain.ends[0]))


def length(points: Array) -> float:
    """Return the length of a polyline."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
