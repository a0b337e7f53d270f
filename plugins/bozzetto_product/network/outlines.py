"""Outlines of a loop: the one round its surface, and those of holes in it.

A loop is a row of half-edges, head to tail. Where one does not begin in the node in which the one
before it ends, the next outline begins: the first is the one round the surface, all others are
holes, and these run the other way round, so that the surface is on the left of each. Outlines have
no node in common. A closed edge without a node is an outline by itself.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable

from bozzetto_product.network.net import HalfEdge, Loop, Net


def ends_of(net: Net, half_edge: HalfEdge) -> tuple[int, int]:
    """Return the nodes from which and to which a half-edge leads; -1 for a closed edge's."""
    edge, forward = net.edges[half_edge[0]], half_edge[1]
    return (edge.start, edge.end) if forward else (edge.end, edge.start)


def outlines_of(net: Net, loop: Loop) -> tuple[Loop, ...]:
    """Return the outlines of a loop, that of the surface first."""
    ends = [ends_of(net, half_edge) for half_edge in loop]
    starts = [
        number
        for number, (tail, _) in enumerate(ends)
        if not number or tail < 0 or tail != ends[number - 1][1]
    ]
    return tuple(loop[a:b] for a, b in itertools.pairwise([*starts, len(loop)]))


def rim_of(net: Net, loop: Loop) -> Loop:
    """Return the outline round the surface of a loop, without those of its holes."""
    return outlines_of(net, loop)[0]


def rim_edges(net: Net, loop: Loop) -> frozenset[int]:
    """Return the edges round the surface of a loop, which tell it from any other."""
    return frozenset(edge for edge, _ in rim_of(net, loop))


def joined_outlines(outlines: Iterable[Loop]) -> Loop:
    """Return the loop of some outlines."""
    return tuple(half_edge for outline in outlines for half_edge in outline)


def reversed_loop(net: Net, loop: Loop) -> Loop:
    """Return a loop the other way round: each of its outlines, in the same order."""
    return joined_outlines(map(reversed_outline, outlines_of(net, loop)))


def reversed_outline(outline: Loop) -> Loop:
    """Return one outline the other way round."""
    return tuple((edge, not forward) for edge, forward in reversed(outline))
