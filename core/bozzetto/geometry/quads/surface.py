"""The surface that quads are laid over: dense triangles with normals, features and frames."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index

SHARP: Final = 0.75
"""Cosine of the angle between two triangles from which their edge is a crease: 41°."""

BENT: Final = -0.6
"""Cosine of the angle between two feature edges above which their vertex is a corner: 127°."""

FILTERED: Final = 4
"""Rounds in which normals are averaged with those beside that differ little, so that rough scans
and slivers have no creases."""

ALIKE: Final = 16
"""The power of the cosine between two normals by which they count for one another: at 20° more
than a third, at 45° nothing."""

EVENED: Final = 2
"""Rounds in which borders of groups are evened out: they run zigzag along the triangles."""

MOST_ROUNDS: Final = 16
"""Rounds of splitting: each halves the edges that are too long."""


@dataclass(frozen=True, eq=False)
class Edges:
    """Edges of triangles.

    Attributes
    ----------
    ends : (e, 2) int
        Vertices, the lower number first.
    faces : (e, 2) int
        Triangles on both sides; −1 where there is none.
    crowded : (e,) bool
        Whether more than two triangles meet.
    of_side : (f, 3) int
        The edge of each triangle from each corner to the next.
    """

    ends: Index
    faces: Index
    crowded: Flags
    of_side: Index


def edges_of(faces: Index) -> Edges:
    """Return the edges of triangles (f, 3)."""
    sides = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2).astype(np.int64)
    low, high = sides.min(axis=1), sides.max(axis=1)
    span = np.int64(high.max(initial=0)) + 1
    keys, first, which, count = np.unique(
        low * span + high, return_index=True, return_inverse=True, return_counts=True
    )
    beside = np.full((len(keys), 2), -1)
    face = np.repeat(np.arange(len(faces)), 3)
    beside[which, 1] = face
    beside[:, 0] = face[first]
    beside[count == 1, 1] = -1
    return Edges(np.column_stack(np.divmod(keys, span)), beside, count > 2, which.reshape(-1, 3))


def across(points: Array, faces: Index) -> Array:
    """Return normals of triangles, as long as twice their area, (f, 3)."""
    a, b, c = (points[corner] for corner in faces.T)
    return np.cross(b - a, c - a)


def units(vectors: Array) -> Array:
    """Return unit vectors (n, 3); 0 stays."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def refined(
    points: Array, faces: Index, longest: float, most: int
) -> tuple[Array, Index, Index] | None:
    """Split edges in their middle until none is longer; None where that takes too many triangles.

    Parameters
    ----------
    points : (n, 3) float
        Vertices.
    faces : (f, 3) int
        Triangles.
    longest : float
        In the unit of the points.
    most : int
        Triangles at most.

    Returns
    -------
    points : (m, 3) float
        Those given come first.
    faces : (g, 3) int
    origin : (g,) int
        The triangle given that each lies in.
    """
    origin = np.arange(len(faces))
    for _ in range(MOST_ROUNDS):
        edges = edges_of(faces)
        length = np.linalg.norm(points[edges.ends[:, 1]] - points[edges.ends[:, 0]], axis=1)
        long = length > longest
        if not long.any():
            break
        if len(faces) + 2 * int(long.sum()) > most:
            return None
        middle = np.full(len(edges.ends), -1)
        middle[long] = len(points) + np.arange(int(long.sum()))
        points = np.concatenate((points, points[edges.ends[long]].mean(axis=1)))
        faces, row = _split(points, faces, middle[edges.of_side])
        origin = origin[row]
    return points, faces, origin


def _split(points: Array, faces: Index, middle: Index) -> tuple[Index, Index]:
    """Return triangles split at middles (f, 3) of their sides, −1 for none; and whence they are."""
    count = (middle >= 0).sum(axis=1)
    kept, rows = [faces[count == 0]], [np.flatnonzero(count == 0)]
    for number in (1, 2, 3):
        which = np.flatnonzero(count == number)
        if not len(which):
            continue
        has = middle[which] >= 0
        # The first side is split where one is; the last is whole where two are.
        turn = has.argmax(axis=1) if number == 1 else (has.argmin(axis=1) + 1) % 3
        turned = (turn[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(faces[which], turned, axis=1).T
        p, q, r = np.take_along_axis(middle[which], turned, axis=1).T
        if number == 1:
            made = [(a, p, c), (p, b, c)]
        elif number == 3:
            made = [(a, p, r), (p, b, q), (r, q, c), (p, q, r)]
        else:
            made = [(p, b, q)]
            one = np.linalg.norm(points[a] - points[q], axis=1)
            other = np.linalg.norm(points[p] - points[c], axis=1)
            first = one <= other
            made += [
                (a, p, np.where(first, q, c)),
                (np.where(first, a, p), q, c),
            ]
        kept += [np.column_stack(row) for row in made]
        rows += [which] * len(made)
    return np.concatenate(kept), np.concatenate(rows)


@dataclass(frozen=True, eq=False)
class Features:
    """Edges that quads keep: borders, borders of groups, creases.

    Attributes
    ----------
    edges : (k, 2) int
        Vertices.
    line : (n,) bool
        Whether a vertex lies on such an edge.
    corner : (n,) bool
        Whether it is an end, a branching or a bend of them.
    along : (n, 3) float
        Unit direction of the edges at a vertex, of either sense; 0 off them and at corners.
    even : (n,) bool
        Whether a vertex lies within a border of two groups where the surface is smooth: its place
        on the surface counts, the zigzag of the triangles does not.
    """

    edges: Index
    line: Flags
    corner: Flags
    along: Array
    even: Flags


def features_of(
    points: Array, faces: Index, kind: Index, edges: Edges, least: float = 0.0
) -> Features:
    """Return the features of a surface.

    Parameters
    ----------
    points : (n, 3) float
        Vertices.
    faces : (f, 3) int
        Triangles.
    kind : (f,) int
        Group of each triangle.
    edges : Edges
        Of the triangles.
    least : float
        Creases that hang together and are shorter in all, in the unit of the points, are none:
        slivers have normals of any direction. Bends of borders of groups that lie nearer to one
        another are a zigzag.
    """
    one, other = edges.faces.T
    border = (other < 0) | edges.crowded
    firm = border | creases_of(points, faces, edges)
    firm[firm] = border[firm] | _long(points, edges.ends[firm], least)
    kept = firm | (kind[one] != kind[other])
    ends = edges.ends[kept]
    many = np.bincount(ends.ravel(), minlength=len(points))
    even = many == 2
    even[edges.ends[firm]] = False
    even[_alone(points, even & (_through(points, ends)[1] > BENT), least)] = False
    along, straight = _through(_evened(points, ends, even), ends)
    corner = (many > 0) & ((many != 2) | ((straight > BENT) & ~even))
    along[corner] = 0.0
    return Features(ends, many > 0, corner, units(along), even)


def creases_of(points: Array, faces: Index, edges: Edges) -> Flags:
    """Return which edges between two triangles are sharp, but for what is rough, (e,)."""
    normal = filtered_normals(across(points, faces), edges)
    one, other = edges.faces.T
    bend = np.einsum("ij,ij->i", normal[one], normal[other])
    flat = (normal[one] == 0).all(axis=1) | (normal[other] == 0).all(axis=1)
    return np.asarray((bend < SHARP) & ~flat & (other >= 0) & ~edges.crowded)


def filtered_normals(large: Array, edges: Edges) -> Array:
    """Return unit normals (f, 3) of triangles without what is rough.

    Each is averaged with its neighbours by their area, and the less the more they differ, as in
    Zheng, Fu, Au and Tai 2011, *Bilateral normal filtering for mesh denoising*, equation 4.
    """
    area = np.linalg.norm(large, axis=1)
    normal = units(large)
    pairs = edges.faces[(edges.faces[:, 1] >= 0) & ~edges.crowded]
    for _ in range(FILTERED):
        cosine = np.einsum("ij,ij->i", normal[pairs[:, 0]], normal[pairs[:, 1]])
        share = np.maximum(cosine, 0.0) ** ALIKE
        total = normal * area[:, None]
        for here, there in (pairs.T, pairs.T[::-1]):
            weight = share * area[there]
            for axis in range(3):
                total[:, axis] += np.bincount(here, weight * normal[there, axis], len(area))
        normal = units(total)
    return normal


def _long(points: Array, ends: Index, least: float) -> Flags:
    """Return which edges hang together with others so that all are as long, (k,)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    i, j = ends.T
    joined = coo_array((np.ones(len(ends)), (i, j)), (len(points), len(points)))
    piece = connected_components(joined, directed=False)[1][i]
    total = np.bincount(piece, np.linalg.norm(points[j] - points[i], axis=1))
    return np.asarray(total[piece] >= least)


def _alone(points: Array, chosen: Flags, apart: float) -> Index:
    """Return those of the chosen points near which no other is chosen."""
    from scipy.spatial import cKDTree

    rows = np.flatnonzero(chosen)
    if not len(rows):
        return rows
    away, _ = cKDTree(points[rows]).query(points[rows], k=2)
    return rows[np.asarray(away)[:, 1] > apart]


def _through(points: Array, ends: Index) -> tuple[Array, Array]:
    """Return the way of lines through their vertices, (n, 3), and how straight they are, (n,).

    That is the cosine between the first edge out of a vertex and another: −1 where they go on
    straight.
    """
    along, straight = np.zeros((len(points), 3)), np.zeros(len(points))
    direction = units(points[ends[:, 1]] - points[ends[:, 0]])
    # Of two edges out of a vertex the second is turned around: both go the same way through it.
    vertex = ends.ravel()
    out = np.stack((direction, -direction), axis=1).reshape(-1, 3)
    order = np.argsort(vertex, kind="stable")
    first = order[np.r_[True, np.diff(vertex[order]) > 0]] if len(order) else order
    along[vertex[first]] += out[first]
    rest = np.setdiff1d(order, first)
    straight[vertex[rest]] = np.einsum("ij,ij->i", out[rest], along[vertex[rest]])
    along[vertex[rest]] -= out[rest]
    return along, straight


def _evened(points: Array, ends: Index, even: Flags) -> Array:
    """Return points (n, 3) of which some have gone towards the middle of their two neighbours."""
    made = points.copy()
    one, other = np.concatenate((ends, ends[:, ::-1])).T
    one, other = one[even[one]], other[even[one]]
    for _ in range(EVENED):
        middle = np.column_stack([
            np.bincount(one, 0.5 * made[other, axis], len(points)) for axis in range(3)
        ])  # fmt: skip
        made[even] = 0.5 * (made[even] + middle[even])
    return made
