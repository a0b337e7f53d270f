"""The loop that a touch means."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, cross_product
from bozzetto_product.loops.finding import FoundLoops
from bozzetto_product.loops.sampling import SampledNet
from bozzetto_product.network.half_edges import half_edges
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.outlines import outlines_of, rim_edges

BEHIND: Final = 4.0
"""What a loop costs for lying one diagonal of the net behind the first that a ray meets: a better
loop right behind a poor one is meant, one at the back of the body is not."""


def loops_at(
    net: Net, found: FoundLoops, origin: ArrayLike, direction: ArrayLike
) -> tuple[Loop, ...]:
    """Return the loops that a touch may mean, the likeliest first.

    Parameters
    ----------
    net : Net
        Where the loops were found.
    found : FoundLoops
        Fixed loops and candidates are looked at.
    origin, direction : (3,) array_like
        The ray from the eye through the touch, mm.

    Returns
    -------
    tuple of Loop
        All whose inside, as the cone over their centre, the ray meets, and of which it meets no
        hole: by cost and depth. The next touch at the same place may take the next one. Empty
        beside all loops.
    """
    start, ahead = np.asarray(origin, float), np.asarray(direction, float)
    length = float(np.linalg.norm(ahead))
    if not (np.isfinite(start).all() and 0.0 < length < np.inf):
        return ()
    costs = dict(zip(found.loops, found.costs, strict=True))
    known = {rim_edges(net, loop) for loop in found.loops}
    for loop, cost in zip(found.candidates, found.candidate_costs, strict=True):
        if frozenset(edge for edge, _ in loop) not in known:
            costs[loop] = cost
    sampled = SampledNet.of(net)
    hits: dict[frozenset[int], tuple[float, float, Loop]] = {}
    for loop, cost in costs.items():
        depth, *holes = (
            _depth(_ring(sampled, outline), start, ahead / length)
            for outline in outlines_of(net, loop)
        )
        if depth is not None and not any(hole is not None for hole in holes):
            hits.setdefault(frozenset(edge for edge, _ in loop), (depth, cost, loop))
    if not hits:
        return ()
    first = min(depth for depth, _, _ in hits.values())
    behind = BEHIND / max(sampled.size, 1e-300)
    ranked = sorted(hits.values(), key=lambda hit: hit[1] + behind * (hit[0] - first))
    return tuple(loop for _, _, loop in ranked)


def _ring(sampled: SampledNet, loop: Loop) -> Array:
    lines = [sampled.lines[half // 2][:: 1 - 2 * (half % 2)][:-1] for half in half_edges(loop)]
    return np.vstack(lines)


def _depth(ring: Array, origin: Array, direction: Array) -> float | None:
    """Return how far along a ray it first meets the cone over a ring's centre; None if it does not.

    Möller & Trumbore 1997, for all triangles at once.
    """
    apex = ring.mean(axis=0)
    first, second = ring - apex, np.roll(ring, -1, axis=0) - apex
    across = cross_product(direction, second)
    volume = (first * across).sum(axis=1)
    scale = np.where(np.abs(volume) > 0, volume, np.inf)
    to_origin = origin - apex
    u = across @ to_origin / scale
    other = cross_product(to_origin, first)
    v = other @ direction / scale
    depth = (second * other).sum(axis=1) / scale
    met = (np.abs(volume) > 0) & (u >= 0) & (v >= 0) & (u + v <= 1) & (depth > 0)
    return float(depth[met].min()) if met.any() else None
