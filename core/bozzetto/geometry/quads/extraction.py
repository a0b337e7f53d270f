"""Quads out of a lattice on a surface, by collapses that keep the surface closed.

Vertices of one node are joined, as in Jakob et al. 2015 (section 4), but only where the mesh stays
one: what remains are triangles between nodes, of the same genus. Pairs of them are quads.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.geometry.quads.surface import edges_of
from bozzetto.geometry.quads.triangle_graph import TriangleGraph

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bozzetto.arrays import Array, Flags, Index
    from bozzetto.geometry.quads.mirrors import Plane
    from bozzetto.geometry.quads.position_field import Lattice
    from bozzetto.geometry.quads.surface import Edges, Features

SHORT: Final = 0.55
"""Edges shorter than so many sides are collapsed."""

LONG: Final = 1.75
"""Edges longer than so many sides are split: a diagonal is 1.41 long."""

WIDE: Final = math.pi + 0.05
"""Edges whose opposite angles are together wider are flipped: a little more than Delaunay's."""

ROUNDS: Final = 4
"""Rounds of collapsing, splitting and flipping."""

LEAST_QUALITY: Final = 0.25
"""Of a quad; 1 for a rectangle, 0 where an angle is 0° or 180°."""

Vector = tuple[float, ...]


def nodes(
    points: Array, faces: Index, kind: Index, edges: Edges, features: Features, found: Lattice,
    side: float,
) -> TriangleGraph:  # fmt: skip
    """Return triangles between the nodes of a lattice."""
    graph = TriangleGraph(points, faces, kind, features.edges, features.corner)
    step_free = (found.step == 0).all(axis=1)
    one, other = edges.ends.T
    length = np.linalg.norm(points[other] - points[one], axis=1)
    which = np.flatnonzero(step_free)
    order = which[np.lexsort((length[which], np.round(found.error[which], 6)))]
    leader = list(range(len(points)))
    members: list[list[int]] = [[k] for k in leader]

    def leads(vertex: int) -> int:
        while leader[vertex] != vertex:
            leader[vertex] = leader[leader[vertex]]
            vertex = leader[vertex]
        return vertex

    pending = edges.ends[order].tolist()
    while pending:
        left = []
        done = 0
        for a, b in pending:
            u, v = leads(a), leads(b)
            if u == v:
                continue
            if graph.corner[u] or (graph.features[u] and not graph.features[v]):
                u, v = v, u
            elif (
                len(members[u]) > len(members[v])
                and bool(graph.features[u]) == bool(graph.features[v])
                and not graph.corner[v]
            ):
                u, v = v, u
            if v not in graph.near[u]:
                left.append((a, b))
            elif graph.may_collapse(u, v):
                graph.collapse(u, v)
                leader[u] = v
                members[v] += members[u]
                done += 1
            else:
                left.append((a, b))
        if not done:
            break
        pending = left
    node = points - side * (found.shift[:, :1] * found.first + found.shift[:, 1:] * found.second)
    for vertex in range(len(points)):
        if leader[vertex] != vertex or graph.corner[vertex]:
            continue
        own = members[vertex]
        if features.line[vertex]:
            own = [k for k in own if features.line[k]]
        graph.places[vertex] = tuple(node[own].mean(axis=0).tolist())
    return graph


def tidied(graph: TriangleGraph, side: float, planes: Sequence[Plane], reach: float) -> None:
    """Collapse short edges, split long ones, and flip those that a shorter one could replace.

    Parameters
    ----------
    graph : TriangleGraph
        Changed in place.
    side : float
        Of a square.
    planes : sequence of Plane
        Mirrors: only edges of the border may have both ends there.
    reach : float
        Distance up to which a vertex lies on them.
    """
    for _ in range(ROUNDS):
        changed = _collapse_short(graph, SHORT * side)
        changed += _split_long(graph, LONG * side)
        changed += _flip(graph)
        if not changed:
            break
    for plane in planes:
        for a, b in edges_of(graph.rows()[0]).ends.tolist():
            if b not in graph.features[a] and graph.features[a] and graph.features[b]:
                ends = np.array((graph.places[a], graph.places[b]))
                if (np.abs(plane.distances(ends)) <= reach).all():
                    graph.split(a, b, _middle(graph.places[a], graph.places[b]))


def _lengths(graph: TriangleGraph) -> tuple[Index, Array]:
    """Return all edges (e, 2) of triangles under change, and how long they are."""
    ends, place = edges_of(graph.rows()[0]).ends, np.array(graph.places)
    return ends, np.linalg.norm(place[ends[:, 0]] - place[ends[:, 1]], axis=1)


def _collapse_short(graph: TriangleGraph, least: float) -> int:
    done = 0
    ends, length = _lengths(graph)
    order = np.argsort(length, kind="stable")
    for a, b in ends[order[length[order] < least]].tolist():
        if b not in graph.near[a] or math.dist(graph.places[a], graph.places[b]) >= least:
            continue
        if graph.corner[a] or (graph.features[a] and not graph.features[b]):
            a, b = b, a
        if not graph.may_collapse(a, b):
            continue
        free = not graph.corner[b] and bool(graph.features[a]) == bool(graph.features[b])
        graph.collapse(a, b)
        if free:
            graph.places[b] = _middle(graph.places[a], graph.places[b])
        done += 1
    return done


def _middle(one: Vector, other: Vector) -> Vector:
    return tuple(0.5 * (p + q) for p, q in zip(one, other, strict=True))


def _split_long(graph: TriangleGraph, most: float) -> int:
    ends, length = _lengths(graph)
    order = np.argsort(-length, kind="stable")
    long = ends[order[length[order] > most]].tolist()
    for a, b in long:
        if b in graph.near[a]:
            graph.split(a, b, _middle(graph.places[a], graph.places[b]))
    return len(long)


def _flip(graph: TriangleGraph) -> int:
    done = 0
    pending = _wide(graph)
    for _ in range(3):
        again = set()
        for a, b in pending:
            if b not in graph.near[a]:
                continue
            found = graph.may_flip(a, b)
            if found is None:
                continue
            _one, _other, c, d = found
            p, q, r, s = (graph.places[v] for v in (a, b, c, d))
            if _angle(r, p, q) + _angle(s, p, q) <= WIDE:
                continue
            if _bend(p, q, r, s) < 0.3 and _bend(r, s, p, q) < _bend(p, q, r, s):
                continue
            graph.flip(a, b, found)
            done += 1
            for v, w in ((a, c), (a, d), (b, c), (b, d)):
                again.add((min(v, w), max(v, w)))
        pending = sorted(again)
        if not pending:
            break
    return done


def _wide(graph: TriangleGraph) -> list[tuple[int, int]]:
    """Return edges whose two opposite angles are together wider than `WIDE`."""
    faces, _kind = graph.rows()
    edges, place = edges_of(faces), np.array(graph.places)
    beside = edges.faces[(edges.faces[:, 1] >= 0) & ~edges.crowded]
    ends = edges.ends[(edges.faces[:, 1] >= 0) & ~edges.crowded]
    total = np.zeros(len(ends))
    for side in beside.T:
        apex = place[faces[side].sum(axis=1) - ends.sum(axis=1)]
        one, other = place[ends[:, 0]] - apex, place[ends[:, 1]] - apex
        size = np.linalg.norm(np.cross(one, other), axis=1)
        total += np.arctan2(size, np.einsum("ij,ij->i", one, other))
    return [(a, b) for a, b in ends[total > WIDE].tolist()]


def _sub(one: Vector, other: Vector) -> Vector:
    return (one[0] - other[0], one[1] - other[1], one[2] - other[2])


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _angle(apex: Vector, one: Vector, other: Vector) -> float:
    """Return the angle at an apex, radians."""
    a, b = _sub(one, apex), _sub(other, apex)
    across = _cross(a, b)
    return math.atan2(math.sqrt(_dot(across, across)), _dot(a, b))


def _bend(p: Vector, q: Vector, r: Vector, s: Vector) -> float:
    """Return the cosine between the triangles on both sides of an edge from p to q."""
    along = _sub(q, p)
    one, other = _cross(along, _sub(r, p)), _cross(_sub(s, p), along)
    size = math.sqrt(_dot(one, one) * _dot(other, other))
    return _dot(one, other) / size if size > 0.0 else -1.0


def rings_of(faces: Index, pairs: Index) -> Index:
    """Return the corners of quads, (q, 4), made of pairs of triangles (q, 2) with one edge.

    That edge goes from the first corner to the third.
    """
    one, other = faces[pairs[:, 0]], faces[pairs[:, 1]]
    lone = ~(one[:, :, None] == other[:, None, :]).any(axis=2)
    start = lone.argmax(axis=1)
    rest = ~(other[:, :, None] == one[:, None, :]).any(axis=2)
    far = np.take_along_axis(other, rest.argmax(axis=1)[:, None], axis=1)[:, 0]
    turned = np.take_along_axis(one, (start[:, None] + np.arange(3)) % 3, axis=1)
    return np.column_stack((turned[:, 1], far, turned[:, 2], turned[:, 0]))


def qualities(points: Array, rings: Index) -> Array:
    """Return how near to rectangles quads are, (q,): one less the worst angle's share of 90°.

    Remacle et al. 2012, *Blossom-Quad*, equation 3. Below 0 where they are not convex.
    """
    corners = points[rings]
    ahead = np.roll(corners, -1, axis=1) - corners
    behind = np.roll(corners, 1, axis=1) - corners
    across = np.cross(ahead, behind)
    middle = across.sum(axis=1, keepdims=True)
    sense = np.sign((across * middle).sum(axis=2))
    angle = np.arctan2(np.linalg.norm(across, axis=2), (ahead * behind).sum(axis=2))
    angle = np.where(sense > 0, angle, 2 * np.pi - angle)
    return np.asarray(1.0 - np.abs(angle - 0.5 * np.pi).max(axis=1) / (0.5 * np.pi))


def paired(
    points: Array, faces: Index, kind: Index, edges: Edges, features: Index, corner: Flags
) -> Index:
    """Return pairs of triangles that are quads, (q, 2).

    The squarest are joined first; triangles that are left over where two lie on both sides of a
    quad.

    Parameters
    ----------
    points, faces, kind, edges
        Of the triangles.
    features : (k, 2) int
        Edges that stay.
    corner : (n,) bool
        Vertices that may be left with two edges.
    """
    span = np.int64(len(points))
    low, high = features.min(axis=1, initial=span), features.max(axis=1, initial=0)
    fixed = np.isin(edges.ends[:, 0] * span + edges.ends[:, 1], low * span + high)
    one, other = edges.faces.T
    able = (other >= 0) & ~edges.crowded & ~fixed
    able[able] = kind[one[able]] == kind[other[able]]
    pairs = np.sort(edges.faces[able], axis=1)
    quality = qualities(points, rings_of(faces, pairs))
    good = quality >= LEAST_QUALITY
    pairs, quality = pairs[good], quality[good]
    order = np.lexsort((pairs[:, 1], pairs[:, 0], -np.round(quality, 9)))
    mate: dict[int, int] = {}
    for a, b in pairs[order].tolist():
        if a not in mate and b not in mate:
            mate[a], mate[b] = b, a
    near: dict[int, list[int]] = {}
    for a, b in pairs[order].tolist():
        near.setdefault(a, []).append(b)
        near.setdefault(b, []).append(a)
    for lone in range(len(faces)):
        if lone in mate:
            continue
        for a in near.get(lone, ()):
            b = mate[a]
            far = next((c for c in near[b] if c not in mate and c != lone), None)
            if far is not None:
                mate[lone], mate[a], mate[b], mate[far] = a, lone, far, b
                break
    made = np.array(sorted((a, b) for a, b in mate.items() if a < b), np.intp).reshape(-1, 2)
    return _without_doublets(points, faces, made, edges, corner)


def _without_doublets(
    points: Array, faces: Index, pairs: Index, edges: Edges, corner: Flags
) -> Index:
    """Take apart quads that leave a vertex between two edges alone: the least square ones first."""
    rings = rings_of(faces, pairs)
    order = np.argsort(qualities(points, rings), kind="stable")
    valence = np.bincount(edges.ends.ravel(), minlength=len(points))
    valence -= np.bincount(rings[:, ::2].ravel(), minlength=len(points))
    left = valence.tolist()
    stays = corner.tolist()
    kept = np.ones(len(pairs), bool)
    for number in order.tolist():
        a, c = int(rings[number, 0]), int(rings[number, 2])
        if any(left[v] < 3 and not stays[v] for v in (a, c)):
            kept[number] = False
            left[a] += 1
            left[c] += 1
    return pairs[kept]
