"""The V-spring over several surfaces at once, across the curves between them.

The surfaces of a group are one mesh while it works, so normals at a curve are those of both sides:
that takes angles out. Curves are held, or take a share of each displacement
(Kara & Shimada, book chapter, section 13.2.3.2).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Spline
from bozzetto_product.network.net import Edge, Loop, Net
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.displacement import displaced
from bozzetto_product.paper.paper_surface import PaperSurface
from bozzetto_product.paper.v_spring import relaxed
from bozzetto_product.shaping.group_fairing import (
    carried_edge,
    hanging_parts,
    inner_edges,
    twins_mirrored,
)

CLOSE: Final = 1e-4
"""Distance of a curve from the vertices that it gave way to, as share of its chain's length."""


@dataclass(frozen=True, eq=False)
class EvenedGroup:
    """Surfaces of a network after the V-spring went over some of them.

    Parameters
    ----------
    surfaces : tuple of PaperSurface or None
        All of the network.
    net : Net
        With the curves that gave way.
    moved : frozenset of int
        Edges that gave way.
    """

    surfaces: tuple[PaperSurface | None, ...]
    net: Net
    moved: frozenset[int]


def evened_group(
    net: Net,
    surfaces: Sequence[PaperSurface | None],
    members: Collection[int],
    weight: float,
    freedom: float,
    mirror: Reflection,
    *,
    checkpoint: Callable[[], None] = lambda: None,
) -> EvenedGroup:
    """Even surfaces across the curves between them; creases stay, and so does the outline.

    Parameters
    ----------
    net : Net
        Curves cut at their joints.
    surfaces : sequence of PaperSurface or None
        Of the network; neighbours have the same points on their common edges.
    members : collection of int
        Which of them.
    weight : float
        Share of the whole way that vertices go, 0 … 1.
    freedom : float
        Share of their displacement that vertices on the curves between them take, 0 … 1.
    mirror : Reflection
        In which twins are images of one another.
    checkpoint : callable
        Called now and then.
    """
    loops = [() if one is None else one.loop for one in surfaces]
    made = list(surfaces)
    inner: list[int] = []
    for part in hanging_parts(net, loops, sorted(members)):
        between = inner_edges(net, loops, part)
        inner += between
        own = {number: one for number in part if (one := made[number]) is not None}
        moved = _relaxed_part(own, between, weight, freedom, checkpoint)
        made = [moved.get(number, one) for number, one in enumerate(made)]
    if freedom <= 0.0:
        return EvenedGroup(tuple(made), net, frozenset())
    return _with_curves(net, surfaces, made, inner, loops, mirror)


def _relaxed_part(
    own: dict[int, PaperSurface],
    between: Collection[int],
    weight: float,
    freedom: float,
    checkpoint: Callable[[], None],
) -> dict[int, PaperSurface]:
    """Return the surfaces of one part, evened as one mesh."""
    places = np.concatenate([one.triangles.points for one in own.values()])
    begins = np.cumsum([0, *(len(one.triangles.points) for one in own.values())])
    _, first, same = np.unique(places, axis=0, return_index=True, return_inverse=True)
    same = same.ravel()
    free = np.ones(len(first))
    on_curve: list[Index] = []
    for one, begin in zip(own.values(), begins, strict=False):
        for half_edge, (edge, _) in enumerate(one.loop):
            numbers = same[begin + one.border_of(half_edge)]
            if edge in between:
                on_curve.append(numbers)
            else:
                free[numbers] = 0.0
    for numbers in on_curve:
        free[numbers] = np.minimum(free[numbers], freedom)
    faces = np.concatenate(
        [one.triangles.faces + begin for one, begin in zip(own.values(), begins, strict=False)]
    )
    start = places[first]
    found = relaxed(start, same[faces], free, checkpoint=checkpoint).points
    after = (start + weight * (found - start))[same]
    return {
        number: _with_points(one, after[begin : begin + len(one.triangles.points)])
        for (number, one), begin in zip(own.items(), begins, strict=False)
    }


def _with_points(surface: PaperSurface, points: Array) -> PaperSurface:
    return replace(surface, triangles=replace(surface.triangles, points=points))


def _with_curves(
    net: Net,
    before: Sequence[PaperSurface | None],
    after: Sequence[PaperSurface | None],
    inner: Collection[int],
    loops: Sequence[Loop],
    mirror: Reflection,
) -> EvenedGroup:
    """Return the network with curves where the points on them went."""
    nodes = net.nodes.copy()
    moves: dict[int, Spline] = {}
    for number, (one, other) in enumerate(zip(before, after, strict=True)):
        if one is None or other is None:
            continue
        for half_edge, (edge, _) in enumerate(loops[number]):
            if edge not in inner or edge in moves:
                continue
            numbers = one.border_of(half_edge)[: -1 if net.edges[edge].spline.closed else None]
            there, here = one.triangles.points[numbers], other.triangles.points[numbers]
            moves[edge] = _moved(net.edges[edge], there, here)
            for node, place in zip(
                (net.edges[edge].start, net.edges[edge].end), here[[0, -1]], strict=True
            ):
                if node >= 0:
                    nodes[node] = place
    made = twins_mirrored(net, nodes, moves, mirror)
    edges = tuple(
        carried_edge(edge, made.get(number), nodes) for number, edge in enumerate(net.edges)
    )
    moved = frozenset(
        number
        for number, (edge, now) in enumerate(zip(net.edges, edges, strict=True))
        if edge is not now
    )
    return EvenedGroup(tuple(after), replace(net, nodes=nodes, edges=edges), moved)


def _moved(edge: Edge, there: Array, here: Array) -> Spline:
    """Return the curve of an edge after places on it went elsewhere."""
    at = edge.spline.foot_points(there)
    if not edge.spline.closed:
        at[[0, -1]] = edge.spline.range
    order = np.argsort(at, kind="stable")
    length = float(np.linalg.norm(np.diff(there, axis=0), axis=1).sum())
    return displaced(
        edge.spline, at[order], (here - there)[order], np.full(len(at), 2.0 * CLOSE * length)
    )
