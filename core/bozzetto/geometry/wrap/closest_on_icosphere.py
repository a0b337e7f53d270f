"""Closest points on a wrapped icosphere to points near it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry.mesh_places import closest_on_triangles

if TYPE_CHECKING:
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


def closest_on_icosphere(sphere: Icosphere, vertices: Array, points: Array) -> MeshPoints:
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


def _dot(one: Array, other: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", one, other))
