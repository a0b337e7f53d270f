"""Loops turned alike, so that their surfaces show one side outward."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto_product.loops.sampling import SampledNet
from bozzetto_product.network.half_edges import half_edges
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.outlines import outlines_of, reversed_loop

FLAT_VOLUME: Final = 1e-3
"""Volume, per area to the power 1.5, below which loops count as flat: a cap as high as a hundredth
of its width has more."""

LEAN: Final = 0.2
"""Sine of the angle to what they were drawn on, beyond which flat loops have a side outward."""


@dataclass(frozen=True)
class OrientedLoops:
    """Loops that run through shared edges in opposite senses.

    Parameters
    ----------
    loops : tuple of Loop
        In the order given.
    parts : tuple of tuple of int
        Numbers of the loops of each part that hangs together by edges.
    closed : tuple of bool
        Whether each part is closed: two loops at each of its edges, in opposite senses.
    open_edges : tuple of int
        Edges with one loop only.
    crowded_edges : tuple of int
        Edges with more than two loops.
    one_sided : bool
        Some part cannot be turned alike, as a Möbius strip.
    """

    loops: tuple[Loop, ...]
    parts: tuple[tuple[int, ...], ...]
    closed: tuple[bool, ...]
    open_edges: tuple[int, ...]
    crowded_edges: tuple[int, ...]
    one_sided: bool


def orient_loops(
    net: Net, loops: Sequence[Loop], outward_at: Callable[[Array], Array] | None = None
) -> OrientedLoops:
    """Turn loops so that neighbours agree, and those of a part so that they face outward.

    Parameters
    ----------
    net : Net
        Where the loops are.
    loops : sequence of Loop
        In any sense.
    outward_at : callable, optional
        Gives the way outward (3,) of what points (n, 3) were drawn on; 0 where that is not known.

    Returns
    -------
    OrientedLoops
        Seen from outside a loop runs counter-clockwise, and round its holes clockwise. Outside is
        where the signed volume of a part's loops, each outline as a cone over its own centre, is
        positive: exactly so where the part is closed; of an open one, the side that it bulges to.
        A flat one faces away from what it was drawn on, or else up.
    """
    turned = [tuple(loop) for loop in loops]
    at_edge: dict[int, list[int]] = {}
    for number, loop in enumerate(turned):
        for edge, _ in loop:
            at_edge.setdefault(edge, []).append(number)
    parts: list[tuple[int, ...]] = []
    seen: set[int] = set()
    for number in range(len(turned)):
        if number not in seen:
            parts.append(tuple(sorted(_turn_alike(net, number, turned, at_edge))))
            seen.update(parts[-1])
    sampled = SampledNet.of(net)
    for part in parts:
        outlines = [each for number in part for each in outlines_of(net, turned[number])]
        if _faces_inward([_points(sampled, each) for each in outlines], outward_at):
            for number in part:
                turned[number] = reversed_loop(net, turned[number])
    disagreeing = {edge for edge, here in at_edge.items() if _disagree(edge, here, turned)}
    open_edges = tuple(sorted(edge for edge, here in at_edge.items() if len(here) == 1))
    crowded = tuple(sorted(edge for edge, here in at_edge.items() if len(here) > 2))
    unsound = disagreeing.union(open_edges, crowded)
    closed = tuple(
        not any(edge in unsound for number in part for edge, _ in turned[number]) for part in parts
    )
    return OrientedLoops(
        tuple(turned), tuple(parts), closed, open_edges, crowded, bool(disagreeing)
    )


def _turn_alike(
    net: Net, first: int, turned: list[Loop], at_edge: dict[int, list[int]]
) -> list[int]:
    """Turn the loops that hang together with one, breadth first, over edges of two loops."""
    part, seen = [first], {first}
    for number in part:
        for edge, forward in turned[number]:
            here = at_edge[edge]
            for other in here if len(here) == 2 else ():
                if other not in seen:
                    if (edge, forward) in turned[other]:
                        turned[other] = reversed_loop(net, turned[other])
                    seen.add(other)
                    part.append(other)
    return part


def _disagree(edge: int, here: Sequence[int], turned: Sequence[Loop]) -> bool:
    """Tell whether the two loops of an edge run through it in the same sense."""
    if len(here) != 2 or here[0] == here[1]:
        return False
    first, second = (
        next(forward for each, forward in turned[number] if each == edge) for number in here
    )
    return first == second


def _points(sampled: SampledNet, loop: Loop) -> Array:
    lines = [sampled.lines[half // 2][:: 1 - 2 * (half % 2)][:-1] for half in half_edges(loop)]
    return np.vstack(lines)


def _faces_inward(
    rings: Sequence[Array], outward_at: Callable[[Array], Array] | None = None
) -> bool:
    """Tell whether the signed volume of rings, each closed by a cone, is negative."""
    centre = np.vstack(rings).mean(axis=0)
    volume, area, size = 0.0, np.zeros(3), 0.0
    for ring in rings:
        points = ring - centre
        following = np.roll(points, -1, axis=0)
        areas = 0.5 * cross_product(points, following)
        volume += float((areas @ points.mean(axis=0)).sum())
        area += areas.sum(axis=0)
        size += float(np.linalg.norm(areas, axis=1).sum())
    if abs(volume) > FLAT_VOLUME * size**1.5:
        return volume < 0
    if outward_at is not None:
        outward = outward_at(np.vstack(rings))
        rise = float(area @ outward)
        if abs(rise) > LEAN * np.linalg.norm(area) * np.linalg.norm(outward):
            return rise < 0
    main = int(np.argmax(np.abs(area[::-1]) > 0.5 * np.abs(area).max()))
    return bool(area[::-1][main] < 0)
