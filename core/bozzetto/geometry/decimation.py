"""Decimation: fewer triangles that follow the same shape.

Edges are collapsed onto one of their ends in the order of the quadric error (Garland & Heckbert,
"Surface simplification using quadric error metrics", 1997), many that do not touch one another
at a time. Vertices that stay are those that were, so that colours and bones stay theirs. A
collapse keeps the topology (the link condition: Dey et al., "Topology preserving edge
contraction", 1999) and turns no triangle over.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Flags, Index

if TYPE_CHECKING:
    from collections.abc import Callable

    from bozzetto.geometry.mesh import Mesh

BORDER: Final = 30.0
"""How much more moving a border costs than moving as far off a surface."""

LEAST_COSINE: Final = 0.2
"""Of the angle by which a triangle may turn in one collapse."""

SHARE: Final = 0.15
"""Of the collapses that are possible, those that are considered in one round."""

FEW: Final = 8
"""So many are considered in any case."""

MOST_LOOKED_AT: Final = 3000
"""Up to so many, those that turn triangles over are sorted out before the choice, not after."""

OFTEN: Final = 0.5
"""Share of the chosen that turn triangles over from which the choice is made anew without them: on
rough scans next to nothing would be left of it."""

TINY: Final = 1e-300
"""Added to costs, whose logarithm is taken."""

ROUNDS: Final = 400
"""After so many rounds no more is to be hoped for."""


@dataclass(frozen=True, eq=False)
class Decimated:
    """A mesh made of some vertices of another one.

    Attributes
    ----------
    vertices : (m,) int
        Which vertices of the first mesh stay, growing.
    faces : (f, 3) int32
        Triangles over them, in the order of the groups.
    groups : (f,) int
        The group of each.
    """

    vertices: Index
    faces: NDArray[np.int32]
    groups: Index


def decimated(
    mesh: Mesh,
    triangles: int,
    groups: Index | None = None,
    checkpoint: Callable[[], None] = lambda: None,
) -> Decimated:
    """Return a mesh of at most so many triangles, or as few as its topology allows.

    Parameters
    ----------
    mesh : Mesh
        mm. Corners that it repeats at one place are kept apart.
    triangles : int
        The most there shall be.
    groups : (f,) int, optional
        A number for each triangle; the borders between groups are kept as well as edges are.
    checkpoint : callable
        Called between rounds; may raise to stop.
    """
    kind = np.zeros(len(mesh.faces), np.int64) if groups is None else np.asarray(groups, np.int64)
    faces = mesh.faces.astype(np.int64)
    points = mesh.vertices.astype(np.float64)
    quadrics = _quadrics(points, faces, kind)
    bounds_volume = _is_closed(faces) and _volume(points, faces) > 0.0
    share = SHARE
    for _ in range(ROUNDS):
        over = len(faces) - triangles
        if over <= 0:
            break
        checkpoint()
        moves = _round(points, faces, kind, quadrics, over, share)
        if not len(moves):
            if share == 1.0:
                break
            share = min(1.0, 3.0 * share)  # what costs least turns triangles over
            continue
        share = SHARE
        gone, kept = moves.T
        quadrics[kept] += quadrics[gone]
        target = np.arange(len(points))
        target[gone] = kept
        fewer = target[faces]
        a, b, c = fewer.T
        proper = (a != b) & (b != c) & (c != a)
        if bounds_volume and _volume(points, fewer[proper]) <= 0.0:
            break  # a few triangles of something jagged may lie inside out
        faces, kind = fewer[proper], kind[proper]
    order = np.argsort(kind, kind="stable")
    used, corners = np.unique(faces[order], return_inverse=True)
    return Decimated(used, corners.reshape(-1, 3).astype(np.int32), kind[order])


def _is_closed(faces: Index) -> bool:
    """Whether every side has its like in the other direction."""
    ends = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2)
    span = np.int64(faces.max(initial=0)) + 1
    there, back = (np.sort(a * span + b) for a, b in (ends.T, ends.T[::-1]))
    return bool(np.array_equal(there, back))


def _volume(points: Array, faces: Index) -> float:
    """Return the volume inside faces, negative where they look inwards."""
    a, b, c = (points[corner] for corner in faces.T)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def _edges(faces: Index) -> tuple[Index, Index, Index]:
    """Return edges (e, 2), how many faces each has, and the edge of every side (f, 3)."""
    sides = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2)
    low, high = sides.min(axis=1), sides.max(axis=1)
    span = np.int64(high.max()) + 1 if len(high) else np.int64(1)
    keys, of_side, count = np.unique(low * span + high, return_inverse=True, return_counts=True)
    return np.column_stack(np.divmod(keys, span)), count, of_side.reshape(-1, 3)


def _borders(faces: Index, kind: Index) -> tuple[Index, Index, Flags, Index]:
    """Return edges, how many faces each has, which are borders, and edges of sides."""
    edges, count, of_side = _edges(faces)
    most = np.full(len(edges), -1)
    least = np.full(len(edges), np.iinfo(np.int64).max)
    row = np.repeat(kind, 3)
    np.maximum.at(most, of_side.ravel(), row)
    np.minimum.at(least, of_side.ravel(), row)
    return edges, count, (count == 1) | (most != least), of_side


def _quadrics(points: Array, faces: Index, kind: Index) -> Array:
    """Return for each vertex the sum of the squared distances from its planes, (n, 4, 4)."""
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    normal = np.divide(across, area[:, None], out=np.zeros_like(across), where=area[:, None] > 0)
    total = np.zeros((len(points), 4, 4))
    _add(total, faces, normal, corners[:, 0], area)
    _, _, border, of_side = _borders(faces, kind)
    face, side = np.nonzero(border[of_side])
    first, second = points[faces[face, side]], points[faces[face, (side + 1) % 3]]
    along = second - first
    wall = np.cross(along, normal[face])
    length = np.linalg.norm(wall, axis=1, keepdims=True)
    wall = np.divide(wall, length, out=np.zeros_like(wall), where=length > 0)
    ends = np.column_stack((faces[face, side], faces[face, (side + 1) % 3]))
    _add(total, ends, wall, first, BORDER * (along * along).sum(axis=1))
    return total


def _add(total: Array, vertices: Index, normal: Array, place: Array, weight: Array) -> None:
    plane = np.column_stack((normal, -np.einsum("ij,ij->i", normal, place)))
    own = weight[:, None, None] * plane[:, :, None] * plane[:, None, :]
    for column in vertices.T:
        for i in range(4):
            for j in range(4):
                total[:, i, j] += np.bincount(column, own[:, i, j], len(total))


def _round(
    points: Array, faces: Index, kind: Index, quadrics: Array, over: int, share: float
) -> Index:
    """Return vertices that go and those onto which they go, (k, 2); none touch one another.

    Only a share of what may be collapsed is considered: what costs least.
    """
    edges, count, border, _ = _borders(faces, kind)
    on_border = np.zeros(len(points), bool)
    on_border[edges[border]] = True
    stuck = np.zeros(len(points), bool)
    stuck[edges[count > 2]] = True
    stuck[np.flatnonzero(np.bincount(edges[border].ravel(), minlength=len(points)) > 2)] = True
    pairs = np.concatenate((edges, edges[:, ::-1]))
    free = ~stuck[pairs[:, 0]] & (~on_border[pairs[:, 0]] | np.tile(border, 2))
    free &= _links(edges, count, border, len(points))[np.arange(len(pairs)) % len(edges)]
    pairs = pairs[free]
    if not len(pairs):
        return pairs
    place = np.column_stack((points[pairs[:, 1]], np.ones(len(pairs))))
    both = quadrics[pairs[:, 0]] + quadrics[pairs[:, 1]]
    reach = points[pairs[:, 0]] - points[pairs[:, 1]]
    scale = float(np.abs(quadrics[:, :3, :3]).max()) or 1.0
    # Short edges go first where the shape does not tell, as on a plane.
    cost = np.einsum("ni,nij,nj->n", place, both, place)
    cost = np.maximum(cost, 0.0) + 1e-9 * scale * (reach * reach).sum(axis=1) + TINY
    order = np.argsort(cost, kind="stable")[: max(int(share * len(pairs)), FEW)]
    if len(order) <= MOST_LOOKED_AT:
        order = order[~_turns(points, faces, pairs[order])]
    # In the order of costs alone next to nothing would come before all its neighbours.
    chance = np.random.default_rng(len(faces)).random(len(order))
    rank = np.argsort(np.lexsort((chance, np.floor(0.5 * np.log2(cost[order])))))
    first = _apart(pairs[order], rank, edges, len(points))
    turns = _turns(points, faces, pairs[order[first]])
    if np.count_nonzero(turns) > OFTEN * len(turns):
        able = ~_turns(points, faces, pairs[order])
        order, rank = order[able], np.argsort(np.argsort(rank[able]))
        first = _apart(pairs[order], rank, edges, len(points))
        turns = np.zeros(int(first.sum()), bool)
    chosen = pairs[order[first][~turns]]
    shared = 2  # a collapse takes two triangles, at a border one
    return chosen[: max(1, -(-over // shared))]


def _links(edges: Index, times: Index, border: Flags, count: int) -> Flags:
    """Whether collapsing an edge that so many faces have keeps the topology.

    Its ends have as many neighbours in common as the edge has faces, no two of them form a
    tetrahedron alone, and no two borders are joined through the inside.
    """
    from scipy.sparse import csr_array

    both = np.concatenate((edges, edges[:, ::-1]))
    near: Any = csr_array((np.ones(len(both), np.int32), (both[:, 0], both[:, 1])), (count, count))
    common = np.asarray((near[edges[:, 0]] * near[edges[:, 1]]).sum(axis=1)).ravel()
    valence = np.bincount(both[:, 0], minlength=count)
    on_border = np.zeros(count, bool)
    on_border[edges[border]] = True
    small = (valence[edges] <= 3).all(axis=1)
    joins = on_border[edges].all(axis=1) & ~border
    return np.asarray((common == times) & ~small & ~joins)


def _turns(points: Array, faces: Index, pairs: Index) -> Flags:
    """Whether a collapse turns a triangle over, or nearly."""
    corner = np.argsort(faces.ravel(), kind="stable")
    starts = np.searchsorted(faces.ravel()[corner], np.arange(len(points) + 1))
    sizes = (starts[1:] - starts[:-1])[pairs[:, 0]]
    pair = np.repeat(np.arange(len(pairs)), sizes)
    within = np.arange(len(pair)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    face, at = np.divmod(corner[starts[pairs[pair, 0]] + within], 3)
    stays = ~(faces[face] == pairs[pair, 1][:, None]).any(axis=1)
    pair, face, at = pair[stays], face[stays], at[stays]
    before = points[faces[face]]
    after = before.copy()
    after[np.arange(len(at)), at] = points[pairs[pair, 1]]
    old, new = (np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]) for c in (before, after))
    sizes_of = np.linalg.norm(old, axis=1) * np.linalg.norm(new, axis=1)
    longest = np.max([((after[:, i] - after[:, i - 1]) ** 2).sum(axis=1) for i in range(3)], axis=0)
    thin = np.linalg.norm(new, axis=1) <= 1e-4 * longest
    bad = (np.einsum("ij,ij->i", old, new) < LEAST_COSINE * sizes_of) | thin
    found = np.zeros(len(pairs), bool)
    found[pair[bad]] = True
    return found


def _apart(pairs: Index, rank: Index, edges: Index, count: int) -> Flags:
    """Return which collapses come first in their neighbourhood: they do not touch one another."""
    least = np.full(count, len(pairs))
    for column in pairs.T:
        np.minimum.at(least, column, rank)
    around = least.copy()
    for here, there in ((0, 1), (1, 0)):
        np.minimum.at(around, edges[:, here], least[edges[:, there]])
    return np.asarray((around[pairs] == rank[:, None]).all(axis=1))
