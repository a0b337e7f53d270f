"""Loops found by themselves, around what a person confirmed and rejected."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Index
from bozzetto.plugin import remembered
from bozzetto_product.loops.candidates import Halves, candidate_loops, edges_of, mirror_image
from bozzetto_product.loops.choice import MOST_LOOPS, SIDE_GAIN, choose_loops
from bozzetto_product.loops.closing import flat_lids, unfinished_rims
from bozzetto_product.loops.costs import loop_costs
from bozzetto_product.loops.holes import EXACT, with_holes
from bozzetto_product.loops.plane_outlines import plane_outlines
from bozzetto_product.loops.sampling import SampledNet
from bozzetto_product.network.half_edges import half_edges, loop_of_half_edges
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.outlines import outlines_of, rim_of


@dataclass(frozen=True, eq=False)
class FoundLoops:
    """Loops of a net, and what else could be.

    Parameters
    ----------
    loops : tuple of Loop
        Those that were fixed come first, as they were given; then those found, with their holes.
    costs : (n,) float
        What speaks against each loop less what speaks for it: below 0 for one that was found.
    likely_open : tuple of bool
        Whether it may well be an opening that the person left, as it runs without a corner along
        the rims of others: told, so that it can be shown.
    candidates : tuple of Loop
        All loops that may be meant, those rejected and holes included, the best first; without
        their own holes.
    candidate_costs : (k,) float
    """

    loops: tuple[Loop, ...]
    costs: tuple[float, ...]
    likely_open: tuple[bool, ...]
    candidates: tuple[Loop, ...]
    candidate_costs: tuple[float, ...]


def _key(
    net: Net,
    *,
    fixed: Sequence[Loop] = (),
    rejected: Sequence[Loop] = (),
    flat: float = EXACT,
    checkpoint: Callable[[], None] = lambda: None,
) -> tuple[object, ...]:
    return net, tuple(fixed), tuple(rejected), flat


@remembered(limit=16, key=_key)
def find_loops(
    net: Net,
    *,
    fixed: Sequence[Loop] = (),
    rejected: Sequence[Loop] = (),
    flat: float = EXACT,
    checkpoint: Callable[[], None] = lambda: None,
) -> FoundLoops:
    """Find the loops of a net that are meant to be surfaces.

    Parameters
    ----------
    net : Net
        Open or closed, of any number of pieces.
    fixed : sequence of Loop
        These are in, whatever speaks against them, and stay as they are.
    rejected : sequence of Loop
        These, and their mirror images, are not found again.
    flat : float
        Distance from a plane, as share of its size, up to which a loop with holes lies in it.
    checkpoint : callable
        Called between steps; may raise to stop.

    Returns
    -------
    FoundLoops
        With a loop its mirror image is there. None closes a flat sheet, or what is half drawn. No
        edge has more than two loops, unless those that are fixed give it more.
    """
    sampled = SampledNet.of(net)
    checkpoint()
    outlines = {edges_of(loop): loop for loop in plane_outlines(sampled)}
    loops = candidate_loops(sampled)
    known = {edges_of(loop) for loop in loops}
    loops += tuple(loop for edges, loop in outlines.items() if edges not in known)
    checkpoint()
    rated = loop_costs(sampled, loops, outlines.keys())
    costs = rated.costs - SIDE_GAIN * rated.sides
    checkpoint()
    fixed_halves = [half_edges(loop) for loop in fixed]
    taken = _usage(len(net.edges), fixed_halves)
    barred = _barred(sampled, fixed_halves, [half_edges(loop) for loop in rejected])
    free = [number for number, loop in enumerate(loops) if edges_of(loop) not in barred]
    pairs = _mirror_pairs(sampled, loops, free)
    chosen = np.flatnonzero(choose_loops(loops, -costs, np.maximum(0, MOST_LOOPS - taken), pairs))
    chosen = chosen[np.argsort(costs[chosen], kind="stable")]
    every = [*fixed, *(loop_of_half_edges(loops[number]) for number in chosen)]
    parts = (net, sampled, every, len(fixed))
    closing = flat_lids(*parts) | unfinished_rims(*parts)
    chosen = chosen[~closing[len(fixed) :]]
    order = np.argsort(costs, kind="stable")
    of_fixed = loop_costs(sampled, [half_edges(rim_of(net, loop)) for loop in fixed])
    shared = taken + _usage(len(net.edges), [loops[number] for number in chosen]) > 1
    found, chosen = _with_holes(sampled, fixed, loops, (chosen, order), flat)
    likely_open = [
        bool(rated.corners[number] == 0 and shared[[half // 2 for half in loops[number]]].all())
        for number in chosen
    ]
    return FoundLoops(
        (*fixed, *found),
        (*(of_fixed.costs - SIDE_GAIN * of_fixed.sides).tolist(), *costs[chosen].tolist()),
        (*(False for _ in fixed), *likely_open),
        tuple(loop_of_half_edges(loops[number]) for number in order),
        tuple(costs[order].tolist()),
    )


def _with_holes(
    sampled: SampledNet,
    fixed: Sequence[Loop],
    loops: Sequence[Halves],
    numbers: tuple[Index, Index],
    flat: float,
) -> tuple[list[Loop], Index]:
    """Return the chosen loops with their holes, without those that are holes; and their numbers.

    Of the two rows of numbers given one is of those chosen, and one of all, the best first.
    """
    chosen, order = numbers
    own = set(chosen.tolist())
    others = [loop_of_half_edges(loops[k]) for k in order.tolist() if k not in own]
    every = [*fixed, *(loop_of_half_edges(loops[number]) for number in chosen)]
    found = with_holes(sampled, every, len(fixed), others, flat)[len(fixed) :]
    kept = np.array([loop is not None for loop in found], bool)
    return [loop for loop in found if loop is not None], chosen[kept]


def _barred(
    sampled: SampledNet, fixed: Sequence[Halves], rejected: Sequence[Halves]
) -> set[frozenset[int]]:
    """Return the edges of loops that are not chosen: they are in already, or are to stay out.

    Each outline of them counts: a hole is no surface.
    """
    barred = {edges_of(outline) for loop in fixed for outline in _outlines(sampled, loop)}
    for loop in rejected:
        for outline in _outlines(sampled, loop):
            barred |= {edges_of(outline), edges_of(mirror_image(sampled, outline) or outline)}
    return barred


def _outlines(sampled: SampledNet, halves: Halves) -> list[Halves]:
    loop = loop_of_half_edges(halves)
    return [half_edges(outline) for outline in outlines_of(sampled.net, loop)]


def _usage(edges: int, loops: Sequence[Halves]) -> Index:
    """Return how many of the loops each edge has."""
    halves = [half // 2 for loop in loops for half in loop]
    return np.bincount(np.array(halves, dtype=int), minlength=edges)


def _mirror_pairs(
    sampled: SampledNet, loops: Sequence[Halves], free: Sequence[int]
) -> list[tuple[int, ...]]:
    """Return the loops that may be chosen, each with its mirror image."""
    number_of = {edges_of(loops[number]): number for number in free}
    pairs: set[tuple[int, ...]] = set()
    for number in free:
        image = mirror_image(sampled, loops[number])
        other = number_of.get(edges_of(image), number) if image is not None else number
        pairs.add(tuple(sorted({number, other})))
    return sorted(pairs)
