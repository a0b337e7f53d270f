"""Outlines in a plane: faces of prisms, of any number of corners and any shape.

Where an edge that comes to a node in a plane goes on in that plane in one way only, there is
nothing to choose: stars and gears of a hundred corners are found as surely as squares.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto_product.loops.sampling import SampledNet

FLAT: Final = 1e-3
"""Distance from the plane within which an edge lies in it, as share of the size of the net."""

LEAST_SINE: Final = 0.15
"""Sine of the angle between two edges from which on they define a plane."""

FEWEST: Final = 5
"""Edges: what has fewer is found as any short cycle is."""

MOST: Final = 1000
"""Edges of an outline."""


def plane_outlines(sampled: SampledNet) -> list[tuple[int, ...]]:
    """Find the loops that lie in a plane, go on in it in one way only, and do not cross themselves.

    Parameters
    ----------
    sampled : SampledNet
        The net.

    Returns
    -------
    list of tuple of int
        Half-edges, head to tail, each loop once.
    """
    found: dict[frozenset[int], tuple[int, ...]] = {}
    tried: set[tuple[int, int]] = set()
    for halves in sampled.outgoing:
        if len(halves) < 2:
            continue
        ends = sampled.leaving[list(halves)]
        normals = cross_product(ends[:, None], ends)
        sines = np.linalg.norm(normals, axis=2)
        for one, two in np.argwhere(sines >= LEAST_SINE).tolist():
            first, second = halves[one], halves[two]
            if (second ^ 1, first) in tried:
                continue
            loop = _walked(sampled, second ^ 1, first, normals[one, two] / sines[one, two])
            if loop is None:
                continue
            backwards = tuple(half ^ 1 for half in reversed(loop))
            for way in (loop, backwards):
                tried.update(zip(way, (*way[1:], way[0]), strict=True))
            edges = frozenset(half // 2 for half in loop)
            if edges not in found and _is_simple(sampled, loop):
                found[edges] = loop
    return list(found.values())


def _walked(sampled: SampledNet, before: int, first: int, normal: Array) -> tuple[int, ...] | None:
    """Walk on in a plane from a corner until it comes back; None where it does not, or may turn."""
    place = sampled.lines[first // 2, 0 if first % 2 == 0 else -1]
    reach = FLAT * sampled.size

    def lies_in(half: int) -> bool:
        return bool(np.abs((sampled.lines[half // 2] - place) @ normal).max() <= reach)

    if not (lies_in(before) and lies_in(first)):
        return None
    loop = [first]
    while loop[-1] != before:
        node = int(sampled.heads[loop[-1]])
        ways = [half for half in sampled.outgoing[node] if half != loop[-1] ^ 1 and lies_in(half)]
        if len(ways) != 1 or len(loop) == MOST:
            return None
        loop.append(ways[0])
        if loop[-1] == first:
            return None
    return tuple(loop) if len(loop) >= FEWEST else None


def _is_simple(sampled: SampledNet, loop: tuple[int, ...]) -> bool:
    """Whether a loop in a plane passes no node twice, and does not cross itself."""
    import shapely

    if len({int(sampled.heads[half]) for half in loop}) < len(loop):
        return False
    rows = [sampled.lines[half // 2][:: 1 if half % 2 == 0 else -1][:-1] for half in loop]
    ring = np.concatenate(rows)
    ring = ring - ring.mean(axis=0)
    axes = np.linalg.svd(ring, full_matrices=False)[2][:2]
    return bool(shapely.Polygon(ring @ axes.T).is_valid)
