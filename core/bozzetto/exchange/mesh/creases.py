"""Meshes whose vertices are divided along creases, for programs that shade by vertex normals."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto.geometry.mesh import Mesh

SHARP: Final = np.cos(np.radians(40.0))
"""Cosine of the angle between triangles from which their common edge is a crease."""


def divided(mesh: Mesh) -> tuple[Index, Index]:
    """Return vertices such that each belongs to triangles that meet smoothly around it.

    Parameters
    ----------
    mesh : Mesh
        Edges of two triangles, run in opposite senses, may be smooth; all others are creases.

    Returns
    -------
    vertex : (n,) int
        For each vertex, that of the mesh, in its order; just these where no crease is between two
        triangles.
    faces : (f, 3) int
        The triangles with these vertices.
    """
    faces = mesh.faces.astype(np.intp)
    corners = np.arange(faces.size).reshape(-1, 3)
    starts, ends = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = len(mesh.vertices)
    there, back = starts * count + ends, ends * count + starts
    order = np.argsort(there, kind="stable")
    at = np.clip(np.searchsorted(there[order], back), 0, max(len(order) - 1, 0))
    other = order[at] if len(order) else order
    _, inverse, times = np.unique(np.minimum(there, back), return_inverse=True, return_counts=True)
    paired = (times[inverse] == 2) & (there[other] == back)
    normals = _face_normals(mesh, faces)
    own = np.flatnonzero(paired)
    facing = np.einsum("ij,ij->i", normals[own // 3], normals[other[own] // 3])
    flat = np.asarray(~normals.any(axis=1))
    smooth = (facing > SHARP) | flat[own // 3] | flat[other[own] // 3]
    if smooth.all():
        return np.arange(count), faces
    following = np.roll(corners, -1, axis=1).ravel()
    one, two = own[smooth], other[own[smooth]]
    return _connected(starts, np.vstack((
        np.column_stack((one, following[two])), np.column_stack((following[one], two))
    )))  # fmt: skip


def divided_by(faces: Index, normals: NDArray[np.int32]) -> tuple[Index, Index, Index]:
    """Return vertices such that each has one normal, in the order of those of the mesh.

    Parameters
    ----------
    faces, normals : (f, 3) int
        Vertex and number of the normal of each corner.

    Returns
    -------
    vertex : (n,) int
        For each vertex, that of the mesh; those without a triangle are left out.
    faces : (f, 3) int
        The triangles with these vertices.
    normals : (n,) int
        Number of the normal of each vertex.
    """
    count = int(normals.max(initial=0)) + 1
    pairs = faces.astype(np.int64).ravel() * count + normals.ravel()
    found, corners = np.unique(pairs, return_inverse=True)
    vertex, which = np.divmod(found, count)
    return vertex, corners.reshape(-1, 3), which


def _face_normals(mesh: Mesh, faces: Index) -> Array:
    a, b, c = np.moveaxis(mesh.vertices[faces].astype(float), 1, 0)
    across = np.cross(b - a, c - a)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(np.divide(across, length, out=np.zeros_like(across), where=length > 0.0))


def _connected(starts: Index, pairs: Index) -> tuple[Index, Index]:
    """Return vertices and faces when pairs of corners are one vertex each."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(starts),) * 2)
    _, labels = connected_components(links, directed=False)
    _, first, faces = np.unique(labels, return_index=True, return_inverse=True)
    order = np.argsort(starts[first], kind="stable")
    rank = np.empty(len(order), np.intp)
    rank[order] = np.arange(len(order))
    return starts[first][order], rank[faces].reshape(-1, 3)
