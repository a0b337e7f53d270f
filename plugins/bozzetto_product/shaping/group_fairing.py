"""Surfaces faired together: the curves between them are let go, to lie on one fair surface.

The outline of a group is filled as one loop, smooth to what is around it. Curves within go to their
nearest places on that surface, all the way or a share of it, and joints go along, so surfaces
between them stay joined. Nothing is iterated, so nothing drifts; curves of the recipe stay.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto_product.fill.edge_pieces import opened, pieces_of
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.loop_fill import fill_loop
from bozzetto_product.fill.loop_sides import piece_count, sides_of_loop
from bozzetto_product.fill.normal_field import frame_parameters
from bozzetto_product.fill.normals import edge_normals
from bozzetto_product.network.net import Edge, Loop, Net, ToldNormals
from bozzetto_product.network.outlines import ends_of, outlines_of
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.displacement import displaced
from bozzetto_product.projection.spline_basis import bent
from bozzetto_product.shaping.nearest_places import nearest_on
from bozzetto_product.shaping.outline_normals import with_open_fields

PLACES: Final = 12
"""Places on each span of a curve that are brought to the surface."""

CLOSE: Final = 2e-5
"""Distance from the surface, as share of its size, that is worth no further knot of a curve."""


@dataclass(frozen=True, eq=False)
class FairedNet:
    """A network with curves let go.

    Parameters
    ----------
    net : Net
        The same edges and nodes, elsewhere.
    moved : frozenset of int
        Edges that changed.
    whole : bool
        False where surfaces of the group have no single outline, are folded as one, or no curve
        lies between them; these stay as they were.
    """

    net: Net
    moved: frozenset[int]
    whole: bool


def faired(
    net: Net, loops: Sequence[Loop], members: Collection[int], share: float, mirror: Reflection
) -> FairedNet:
    """Let the curves between some surfaces go.

    Parameters
    ----------
    net : Net
        Curves cut at their joints.
    loops : sequence of Loop
        Of all surfaces, counter-clockwise seen from outside.
    members : collection of int
        Which of them are faired together.
    share : float
        How far curves go: 0 keeps them, 1 lets them go all the way.
    mirror : Reflection
        In which twins are images of one another.
    """
    parts = hanging_parts(net, loops, sorted(members))
    moves: dict[int, Spline] = {}
    surfaces: dict[int, Fill] = {}
    nodes = net.nodes.copy()
    whole = True
    for part in parts:
        inner = inner_edges(net, loops, part)
        ring = _outline(net, loops, part, inner)
        fill = None if ring is None or not inner else _filled(net, loops, part, ring)
        if fill is None:
            whole = whole and len(part) == 1
            continue
        _let_go(net, fill, inner, share, nodes, moves)
        surfaces.update(dict.fromkeys(inner, fill))
    made = twins_mirrored(net, nodes, moves, mirror)
    edges = [carried_edge(edge, made.get(number), nodes) for number, edge in enumerate(net.edges)]
    for number, fill in surfaces.items() if share >= 1.0 else ():
        edges[number] = _on_surface(edges, number, fill, mirror)
    moved = frozenset(
        number
        for number, (one, two) in enumerate(zip(net.edges, edges, strict=True))
        if one is not two
    )
    return FairedNet(replace(net, nodes=nodes, edges=tuple(edges)), moved, whole and bool(moves))


# -- the group -------------------------------------------------------------------------------


def _uses(loops: Sequence[Loop], part: Collection[int]) -> dict[int, list[tuple[int, bool]]]:
    uses: dict[int, list[tuple[int, bool]]] = {}
    for number in part:
        for edge, forward in loops[number]:
            uses.setdefault(edge, []).append((number, forward))
    return uses


def hanging_parts(net: Net, loops: Sequence[Loop], members: Sequence[int]) -> list[list[int]]:
    """Return members that hang together over edges that are no creases."""
    from scipy.cluster.hierarchy import DisjointSet

    sets = DisjointSet(members)
    for edge, uses in _uses(loops, members).items():
        if len(uses) == 2 and not net.edges[edge].crease >= 1.0:
            sets.merge(uses[0][0], uses[1][0])
    return sorted(sorted(subset) for subset in sets.subsets())


def inner_edges(net: Net, loops: Sequence[Loop], part: Collection[int]) -> tuple[int, ...]:
    """Return the edges between two surfaces of a part, creases apart, that no other surface has."""
    own, every = _uses(loops, part), _uses(loops, range(len(loops)))
    return tuple(
        edge
        for edge, uses in sorted(own.items())
        if len(uses) == len(every[edge]) == 2
        and uses[0][1] != uses[1][1]
        and not net.edges[edge].crease >= 1.0
    )


def _outline(
    net: Net, loops: Sequence[Loop], part: Sequence[int], inner: Sequence[int]
) -> Loop | None:
    """Return the one loop round a part; None if there are none or several."""
    within = set(inner)
    halves = [half for number in part for half in loops[number] if half[0] not in within]
    if not halves:
        return None
    ring = [halves.pop(0)]
    while halves:
        at = ends_of(net, ring[-1])[1]
        following = [half for half in halves if ends_of(net, half)[0] == at]
        if len(following) != 1:
            return None
        halves.remove(following[0])
        ring.append(following[0])
    closed = ends_of(net, ring[-1])[1] == ends_of(net, ring[0])[0]
    return tuple(ring) if closed and len(outlines_of(net, tuple(ring))) == 1 else None


def _filled(net: Net, loops: Sequence[Loop], part: Sequence[int], ring: Loop) -> Fill | None:
    """Return the fill of an outline, smooth to the surfaces around it."""
    around = [loop for number, loop in enumerate(loops) if number not in set(part)]
    *_, normals = edge_normals(net, [*around, ring])
    met = {edge for loop in around for edge, _ in loop}
    normals = with_open_fields(net, ring, normals, met)
    count = piece_count(normals.corners)
    own = {edge for edge, _ in ring}
    pieces = [
        pieces_of(edge.spline, count) if number in own else ()
        for number, edge in enumerate(net.edges)
    ]
    fill = fill_loop(sides_of_loop(ring, normals, pieces), loop=ring)
    return None if fill.folded else fill


# -- its curves ------------------------------------------------------------------------------


def _let_go(
    net: Net,
    fill: Fill,
    inner: Sequence[int],
    share: float,
    nodes: Array,
    moves: dict[int, Spline],
) -> None:
    """Bring edges, and the nodes between them, a share of the way to a fill."""
    fixed = {node for half in fill.loop for node in ends_of(net, half)}
    free = sorted(
        {node for edge in inner for node in ends_of(net, (edge, True)) if node >= 0} - fixed
    )
    if free:
        there = nearest_on(fill, net.nodes[free])[0]
        nodes[free] = net.nodes[free] + share * (there - net.nodes[free])
    size = fill.size
    for number in inner:
        edge = net.edges[number]
        at = _stations(edge.spline)
        places = edge.spline.value(at)
        shifts = share * (nearest_on(fill, places)[0] - places)
        for node, index in ((edge.start, 0), (edge.end, -1)):
            if node >= 0:
                shifts[index] = nodes[node] - net.nodes[node]
        moves[number] = displaced(edge.spline, at, shifts, np.full(len(at), 2.0 * CLOSE * size))


def _on_surface(edges: Sequence[Edge], number: int, fill: Fill, mirror: Reflection) -> Edge:
    """Return an edge with the normals of the surface that it went to; twins have one another's."""
    edge = edges[number]
    told = edges[edge.twin].normals if 0 <= edge.twin < number else None
    if told is None:
        spline = opened(edge.spline)
        at = frame_parameters(spline)
        told = ToldNormals(at, nearest_on(fill, spline.value(at))[1])
    else:
        twin, own = opened(edges[edge.twin].spline), opened(edge.spline)
        normals = mirror.points(told.normals) - mirror.points(np.zeros((1, 3)))
        at = told.parameters - twin.range[0] + own.range[0]
        start, end = mirror.points(twin.control_points[[0, -1]]) - own.control_points[0]
        if np.linalg.norm(end) < np.linalg.norm(start):
            at, normals = (own.range[0] + own.range[1] - at)[::-1], normals[::-1]
        told = ToldNormals(at, normals)
    return replace(edge, normals=told)


def _stations(spline: Spline) -> Array:
    begin, end = spline.range
    spans = np.unique(np.clip(spline.knots, begin, end))
    share = np.arange(PLACES) / PLACES
    at = (spans[:-1, None] + np.diff(spans)[:, None] * share).ravel()
    return at if spline.closed else np.append(at, end)


def twins_mirrored(
    net: Net, nodes: Array, moves: dict[int, Spline], mirror: Reflection
) -> dict[int, Spline]:
    """Return the curves with twins as images of one another, and bring nodes to theirs."""
    for node, image in enumerate(net.images):
        if image == node:
            nodes[node] = mirror.onto(nodes[node][None])[0]
        elif 0 <= image < node:
            nodes[node] = mirror.points(nodes[image][None])[0]
    made = dict(moves)
    for number in sorted(moves):
        twin = net.edges[number].twin
        if twin == number:
            own = net.edges[number].spline
            if mirror.holds(own):
                flat = mirror.onto(made[number].control_points)
                made[number] = replace(made[number], control_points=flat)
            elif not own.closed:
                made[number] = mirror.symmetric(made[number])
        elif 0 <= twin < number and twin in moves:
            reflected = mirror.spline(made[twin])
            far = np.linalg.norm(
                mirror.points(net.edges[twin].spline.control_points[:1])
                - net.edges[number].spline.control_points[:1]
            )
            near = np.linalg.norm(
                mirror.points(net.edges[twin].spline.control_points[:1])
                - net.edges[number].spline.control_points[-1:]
            )
            made[number] = reflected if far <= near else reflected.reversed()
    return made


def carried_edge(edge: Edge, spline: Spline | None, nodes: Array) -> Edge:
    """Return an edge with its new curve, its ends in the very numbers of its nodes."""
    curve = edge.spline if spline is None else spline
    if not curve.closed:
        ends = nodes[[edge.start, edge.end]]
        if not np.array_equal(curve.control_points[[0, -1]], ends):
            curve = bent(curve, ends[0], ends[1])
    return edge if curve is edge.spline else replace(edge, spline=curve, normals=None)
