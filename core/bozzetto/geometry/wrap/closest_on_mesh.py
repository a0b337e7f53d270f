"""Closest points on a mesh to points near it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry.wrap.icosphere import Icosphere


@dataclass(frozen=True, eq=False)
class MeshPoints:
    """Places of a mesh.

    Attributes
    ----------
    corners : (n, 3) int
        The vertices of the triangle that each lies on.
    weights : (n, 3) float
        Barycentric coordinates within it.
    distances : (n,) float
        From the points that they are nearest to.
    """

    corners: Index
    weights: Array
    distances: Array

    @property
    def vertices(self) -> Index:
        """The corner that each is nearest to, by its coordinates, (n,)."""
        row = np.arange(len(self.corners))
        return np.asarray(self.corners[row, np.argmax(self.weights, axis=1)])

    def taken(self, kept: Flags) -> MeshPoints:
        """Return some of the rows."""
        return MeshPoints(self.corners[kept], self.weights[kept], self.distances[kept])

    def outside(self, vertices: Array, points: Array) -> Flags:
        """Whether the points that they are nearest to lie before their triangles, (n,)."""
        a, b, c = np.moveaxis(vertices[self.corners], 1, 0)
        return np.asarray(_dot(np.cross(b - a, c - a), points - a) > 0)


def closest_on_mesh(sphere: Icosphere, vertices: Array, points: Array) -> MeshPoints:
    """Find the nearest place on the triangles round the vertex that is nearest to each point.

    On a mesh of even triangles that is the nearest place of all.

    Parameters
    ----------
    sphere : Icosphere
        How the vertices hang together.
    vertices : (v, 3) float
        Places of the vertices, mm.
    points : (n, 3) float
        Places near the mesh, mm.
    """
    from scipy.spatial import cKDTree

    faces = sphere.rings[cKDTree(vertices).query(points)[1]]
    corners = sphere.faces[faces]
    weights = closest_on_triangles(points[:, None], vertices[corners])
    offset = np.einsum("nkc,nkcx->nkx", weights, vertices[corners]) - points[:, None]
    square = np.einsum("nkx,nkx->nk", offset, offset)
    row, best = np.arange(len(points)), np.argmin(square, axis=1)
    return MeshPoints(corners[row, best], weights[row, best], np.sqrt(square[row, best]))


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


def _share(forth: Array, back: Array) -> Array:
    total = forth + back
    return np.asarray(np.clip(forth / np.where(total > 0, total, 1.0), 0.0, 1.0))
