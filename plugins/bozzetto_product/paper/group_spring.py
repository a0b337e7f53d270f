"""The V-spring over several surfaces at once, across the curves between them.

The surfaces of a group are one mesh while it works, so normals at a curve are those of both sides:
that takes angles out. Curves are held, or take a share of each displacement
(Kara & Shimada, book chapter, section 13.2.3.2).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Spline
from bozzetto_product.network.net import Edge, Net
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.displacement import displaced
from bozzetto_product.paper.neighbours import carried_inward
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
    return _with_curves(net, surfaces, made, inner, mirror)


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
    mirror: Reflection,
) -> EvenedGroup:
    """Return the network with curves near where the points on them went, and these on them.

    Single vertices move unevenly, as their neighbours are many or few; a curve does not.
    """
    nodes = net.nodes.copy()
    moves: dict[int, Spline] = {}
    for one, other in zip(before, after, strict=True):
        if one is None or other is None:
            continue
        for half_edge, (number, _) in enumerate(one.loop):
            if number not in inner or number in moves:
                continue
            edge, along = net.edges[number], one.border_of(half_edge)
            there, here = one.triangles.points[along], other.triangles.points[along]
            moves[number] = _moved(edge, there, here)
            for node, place in ((edge.start, here[0]), (edge.end, here[-1])):
                if node >= 0:
                    nodes[node] = place
    made = twins_mirrored(net, nodes, moves, mirror)
    edges = tuple(
        carried_edge(edge, made.get(number), nodes) for number, edge in enumerate(net.edges)
    )
    pairs = enumerate(zip(net.edges, edges, strict=True))
    moved = {number: now for number, (edge, now) in pairs if edge is not now}
    placed: dict[int, Array] = {}
    surfaces = tuple(None if one is None else _on_curves(one, moved, placed) for one in after)
    return EvenedGroup(surfaces, replace(net, nodes=nodes, edges=edges), frozenset(moved))


def _moved(edge: Edge, there: Array, here: Array) -> Spline:
    """Return the curve of an edge after places on it went elsewhere."""
    at = _parameters(edge.spline, there)
    order = np.argsort(at, kind="stable")
    length = float(np.linalg.norm(np.diff(there, axis=0), axis=1).sum())
    unit = np.full(len(at), 2.0 * CLOSE * length)
    return displaced(edge.spline, at[order], (here - there)[order], unit)


def _parameters(spline: Spline, places: Array) -> Array:
    """Return where places along the whole of a curve lie on it."""
    at = spline.foot_points(places)
    if not spline.closed:
        at[[0, -1]] = spline.range
    return at


def _on_curves(
    surface: PaperSurface, moved: Mapping[int, Edge], placed: dict[int, Array]
) -> PaperSurface:
    """Return a surface with its border on the curves that moved; the inside goes along."""
    triangles = surface.triangles
    shifts = np.zeros((triangles.border, 3))
    for half_edge, (number, _) in enumerate(surface.loop):
        if number not in moved:
            continue
        along, spline = surface.border_of(half_edge), moved[number].spline
        if number not in placed:  # the very same numbers for both surfaces
            rows = triangles.points[along]
            placed[number] = spline.value(_parameters(spline, rows))
            if not spline.closed:
                placed[number][[0, -1]] = spline.control_points[[0, -1]]
        shifts[along] = placed[number] - triangles.points[along]
    if not shifts.any():
        return surface
    points = triangles.points + carried_inward(triangles.faces, shifts, len(triangles.points))
    for half_edge, (number, _) in enumerate(surface.loop):
        if number in moved:
            points[surface.border_of(half_edge)] = placed[number]
    return _with_points(surface, points)
