"""Closest places on a mesh to points in space, of any mesh and however far away."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry.bvh import FAN, LEAF, PAIRS_AT_ONCE, BoundingTree, tree_of

if TYPE_CHECKING:
    from bozzetto.geometry.mesh import Mesh

ALIKE: Final = 0.5
"""Cosine of the angle between two normals from which they count as facing the same way: 60°.
A plate and its back differ by 180°, two sides of a box by 90°."""

SAMPLED: Final = 2000
"""Faces, spread over the mesh, of which the nearest gives a first bound."""

GOLDEN: Final = 0.6180339887498949
"""Steps of this share of all go everywhere: equal steps may keep to a few parts of a mesh whose
faces were made in a regular order."""

MANY: Final = 256
"""From one point for so many vertices on, the nearest of all vertices gives the first bound."""

SLACK: Final = 1e-12
"""Share by which rounding may make a box farther than what lies in it."""


@dataclass(frozen=True, eq=False)
class MeshPlaces:
    """Places on a mesh.

    Attributes
    ----------
    faces : (n,) int
        Face that each lies on.
    weights : (n, 3) float
        Barycentric coordinates within it: not negative, of sum one.
    distances : (n,) float
        From the points that they are closest to, mm.
    """

    faces: Index
    weights: Array
    distances: Array

    def points(self, mesh: Mesh) -> Array:
        """Return the places in space, (n, 3), mm."""
        return mesh_points(mesh, self.faces, self.weights)


def mesh_points(mesh: Mesh, faces: ArrayLike, weights: ArrayLike) -> Array:
    """Return points of a mesh by face and barycentric coordinates.

    Parameters
    ----------
    mesh : Mesh
        The mesh as it is now.
    faces : (n,) array_like of int
        Faces of the mesh.
    weights : (n, 3) array_like
        Barycentric coordinates within them.

    Returns
    -------
    (n, 3) float
        mm.
    """
    corners = mesh.vertices[mesh.faces[np.asarray(faces, np.intp)]].astype(np.float64)
    return np.asarray(np.einsum("nc,ncx->nx", np.asarray(weights, float), corners), np.float64)


def face_normals(mesh: Mesh, faces: ArrayLike) -> Array:
    """Return the unit normals of faces (n,), shape (n, 3); 0 for a face without area."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[np.asarray(faces, np.intp)]], 1, 0).astype(float)
    across = np.cross(b - a, c - a)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(across / np.where(length > 0.0, length, 1.0), np.float64)


def alike(one: Array, other: Array) -> Flags:
    """Return whether normals (n, 3) of any length look the same way; one of length 0 looks all."""
    return np.asarray(_dot(one, other) >= ALIKE * _lengths(one) * _lengths(other))


def closest_on_mesh(
    mesh: Mesh, points: ArrayLike, normals: ArrayLike | None = None, within: float = np.inf
) -> MeshPlaces:
    """Find the closest place on a mesh to each point.

    Parameters
    ----------
    mesh : Mesh
        With at least one face.
    points : (n, 3) array_like
        Places, mm.
    normals : (n, 3) array_like, optional
        Unit vectors: only faces whose normals are `ALIKE` count, so that a place on a thin plate
        does not go over to its back. For a vector of length 0, and where a mesh has no such face,
        all count.
    within : float
        Distance up to which such a face is looked for, mm: where none is so near, all count.

    Returns
    -------
    MeshPlaces

    Raises
    ------
    ValueError
        If the mesh has no face.

    Notes
    -----
    The tree of boxes that rays are cast with (see `bvh`) is walked from the root down. A box that
    is farther than a triangle that is known is passed over, and one whose triangles all face
    another way.
    """
    if not len(mesh.faces):
        raise ValueError("an empty mesh has no closest place")
    place = np.asarray(points, float).reshape(-1, 3)
    best = _closest(mesh, place, None)
    if normals is not None:
        wanted = np.asarray(normals, float).reshape(-1, 3)
        other = np.flatnonzero(~alike(face_normals(mesh, best.faces), wanted))
        better = _closest(mesh, place[other], wanted[other], within)
        found = (better.faces >= 0) & (better.distances <= within)
        best.faces[other[found]] = better.faces[found]
        best.weights[other[found]] = better.weights[found]
        best.distances[other[found]] = better.distances[found]
    return best


def _bounds(mesh: Mesh, points: Array, normals: Array | None) -> Array:
    """Return distances (n,) that some face which counts is not beyond; inf where none is known.

    That of the nearest vertex for many points, else that of the nearest middle among `SAMPLED`
    faces.
    """
    if normals is None and MANY * len(points) > len(mesh.vertices):
        from scipy.spatial import cKDTree

        corners = np.unique(mesh.faces)
        return np.asarray(cKDTree(mesh.vertices[corners].astype(np.float64)).query(points)[0])
    count = len(mesh.faces)
    faces = np.arange(count)
    if count > SAMPLED:
        faces = (np.arange(SAMPLED) * GOLDEN % 1.0 * count).astype(np.intp)
    looks = face_normals(mesh, faces)
    middles = mesh.vertices[mesh.faces[faces]].mean(axis=1, dtype=np.float64)
    bound = np.empty(len(points))
    rows = max(1, PAIRS_AT_ONCE // len(faces))
    for first in range(0, len(points), rows):
        part = slice(first, first + rows)
        away = np.linalg.norm(points[part, None] - middles, axis=2)
        if normals is not None:
            away[normals[part] @ looks.T < ALIKE * _lengths(normals[part])[:, None]] = np.inf
        bound[part] = away.min(axis=1)
    return bound


def _boxes_of_normals(mesh: Mesh, tree: BoundingTree) -> list[tuple[Array, Array]]:
    """Return the boxes about the normals of the faces in each box of the tree, per level."""
    low = high = face_normals(mesh, tree.order)
    levels = []
    for group in (LEAF, *(FAN for _ in tree.levels[1:])):
        firsts = np.arange(0, len(low), group)
        low, high = np.minimum.reduceat(low, firsts), np.maximum.reduceat(high, firsts)
        levels.append((low, high))
    return levels[::-1]


def _closest(
    mesh: Mesh, points: Array, normals: Array | None, within: float = np.inf
) -> MeshPlaces:
    """Walk the tree from its root for the closest place on a face that counts; −1 if none does."""
    count, tree = len(points), tree_of(mesh)
    best = MeshPlaces(np.full(count, -1, np.intp), np.zeros((count, 3)), np.full(count, np.inf))
    reach = np.minimum(_bounds(mesh, points, normals) * (1.0 + SLACK), within)
    looks = None if normals is None else _boxes_of_normals(mesh, tree)
    pending = [(0, np.arange(count, dtype=np.intp), np.zeros(count, np.intp))]
    while pending:
        level, which, box = pending.pop()
        if len(which) > PAIRS_AT_ONCE:
            for begin in range(0, len(which), PAIRS_AT_ONCE):
                part = slice(begin, begin + PAIRS_AT_ONCE)
                pending.append((level, which[part], box[part]))
            continue
        low, high = (side[box] for side in tree.levels[level])
        here = points[which]
        near = np.maximum(np.maximum(low - here, here - high), 0.0)
        kept = np.linalg.norm(near, axis=1) <= reach[which]
        if normals is not None and looks is not None:
            low, high = (side[box] for side in looks[level])
            wanted = normals[which]
            most = np.maximum(wanted * low, wanted * high).sum(axis=1)
            kept &= most >= ALIKE * _lengths(wanted)
        which, box = which[kept], box[kept]
        last = level + 1 == len(tree.levels)
        size, end = (LEAF, len(tree.order)) if last else (FAN, len(tree.levels[level + 1][0]))
        children = (box[:, None] * size + np.arange(size)).ravel()
        which = np.repeat(which, size)
        inside = children < end
        which, children = which[inside], children[inside]
        if not last:
            pending.append((level + 1, which, children))
            continue
        for begin in range(0, len(which), PAIRS_AT_ONCE):
            part = slice(begin, begin + PAIRS_AT_ONCE)
            _try_triangles(tree, points, normals, which[part], children[part], best)
        np.minimum(reach, best.distances * (1.0 + SLACK), out=reach)
    return best


def _try_triangles(
    tree: BoundingTree,
    points: Array,
    normals: Array | None,
    which: Index,
    triangle: Index,
    best: MeshPlaces,
) -> None:
    """Measure pairs of point and triangle; write closer ones into `best`."""
    corner, edge1, edge2 = (part[triangle] for part in (tree.corner, tree.edge1, tree.edge2))
    triangles = np.stack((corner, corner + edge1, corner + edge2), axis=1)
    here = points[which]
    weights = closest_on_triangles(here, triangles)
    away = np.linalg.norm(np.einsum("nc,ncx->nx", weights, triangles) - here, axis=1)
    good = away < best.distances[which]
    if normals is not None:
        good &= alike(np.cross(edge1, edge2), normals[which])
    which, triangle, away, weights = which[good], triangle[good], away[good], weights[good]
    # Farthest first, so that the closest is written last; ties go to the lower face.
    final = np.lexsort((-tree.order[triangle], -away))
    best.faces[which[final]] = tree.order[triangle[final]]
    best.weights[which[final]] = weights[final]
    best.distances[which[final]] = away[final]


def closest_on_triangles(points: Array, triangles: Array) -> Array:
    """Return barycentric coordinates of the places of triangles that are nearest to points.

    Ericson, *Real-time collision detection* (2005), section 5.1.5: the region of the triangle's
    plane over which the point lies tells whether a corner, a side or the inside is nearest.

    Parameters
    ----------
    points : (…, 3) float
        Places, mm.
    triangles : (…, 3, 3) float
        Corners; leading axes as those of the points, by broadcasting.

    Returns
    -------
    (…, 3) float
        Not negative, of sum one. On a triangle without area a corner, or a place on a side.
    """
    a, b, c = (triangles[..., corner, :] for corner in range(3))
    ab, ac = b - a, c - a
    ab_a, ac_a = _dot(ab, points - a), _dot(ac, points - a)
    ab_b, ac_b = _dot(ab, points - b), _dot(ac, points - b)
    ab_c, ac_c = _dot(ab, points - c), _dot(ac, points - c)
    of_c = ab_a * ac_b - ab_b * ac_a
    of_b = ab_c * ac_a - ab_a * ac_c
    of_a = ab_b * ac_c - ab_c * ac_b
    total = of_a + of_b + of_c
    total = np.where(total > 0, total, 1.0)
    none = np.zeros_like(total)
    weights = np.stack((of_a, of_b, of_c), axis=-1) / total[..., None]

    over_bc = (of_a <= 0) & (ac_b - ab_b >= 0) & (ab_c - ac_c >= 0)
    share = _share(ac_b - ab_b, ab_c - ac_c)
    weights = np.where(over_bc[..., None], np.stack((none, 1 - share, share), -1), weights)
    over_ac = (of_b <= 0) & (ac_a >= 0) & (ac_c <= 0)
    share = _share(ac_a, -ac_c)
    weights = np.where(over_ac[..., None], np.stack((1 - share, none, share), -1), weights)
    over_ab = (of_c <= 0) & (ab_a >= 0) & (ab_b <= 0)
    share = _share(ab_a, -ab_b)
    weights = np.where(over_ab[..., None], np.stack((1 - share, share, none), -1), weights)
    beyond = (
        (ab_a <= 0) & (ac_a <= 0),
        (ab_b >= 0) & (ac_b <= ab_b),
        (ac_c >= 0) & (ab_c <= ac_c),
    )
    for corner, nearest in enumerate(beyond):
        weights = np.where(nearest[..., None], np.eye(3)[corner], weights)
    return np.asarray(weights)


def _dot(one: Array, other: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", one, other))


def _lengths(vectors: Array) -> Array:
    return np.asarray(np.linalg.norm(vectors, axis=-1))


def _share(forth: Array, back: Array) -> Array:
    total = forth + back
    return np.asarray(np.clip(forth / np.where(total > 0, total, 1.0), 0.0, 1.0))
