"""Corner normals and curvature of a mesh, for shading; no view changes them.

Both are kept as long as the mesh lives, so that turning the view costs nothing here.
"""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.corner_normals import CornerNormals

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Floats, Index
    from bozzetto.geometry.mesh import Mesh

CREASE = np.cos(np.radians(40.0))
"""Cosine of the angle above which neighbouring faces meet in an edge, not in a bend."""

MOST_PAIRS = 2_000_000
"""Pairs of faces compared around creased vertices; beyond, such corners are drawn flat."""


_normals: weakref.WeakKeyDictionary[Mesh, CornerNormals] = weakref.WeakKeyDictionary()
_curvatures: weakref.WeakKeyDictionary[Mesh, Floats] = weakref.WeakKeyDictionary()


def corner_normals(mesh: Mesh) -> CornerNormals:
    """Return the mesh's own normals, or smooth ones that break at creases."""
    known = _normals.get(mesh)
    if known is None:
        known = _normals[mesh] = _corner_normals(mesh)
    return known


def _corner_normals(mesh: Mesh) -> CornerNormals:
    smooth = mesh.vertex_normals()
    if mesh.normals is not None or not len(mesh.faces):
        return CornerNormals(smooth, mesh.faces)
    points = mesh.vertices[mesh.faces].astype(np.float64)
    area = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    length = np.linalg.norm(area, axis=1, keepdims=True)
    flat = np.divide(area, length, out=np.zeros_like(area), where=length > 0)
    departs = np.einsum("fcx,fx->fc", smooth[mesh.faces], flat) < CREASE
    creased = np.zeros(len(mesh.vertices), bool)
    creased[mesh.faces[departs & (length > 0)]] = True
    face, corner = np.nonzero(creased[mesh.faces])
    if not len(face):
        return CornerNormals(smooth, mesh.faces)
    own = _grouped_normals(mesh.faces[face, corner], face, flat, area)
    corners = mesh.faces.copy()
    corners[face, corner] = len(smooth) + np.arange(len(face))
    return CornerNormals(np.concatenate((smooth, own)), corners)


def _grouped_normals(vertex: NDArray[np.int32], face: Index, flat: Array, area: Array) -> Floats:
    """Return the mean of the faces that bend gently into each (vertex, face)."""
    order = np.argsort(vertex, kind="stable")
    _, first, count = np.unique(vertex[order], return_index=True, return_counts=True)
    if np.square(count).sum() > MOST_PAIRS:
        return flat[face].astype(np.float32)
    # All pairs (i, j) of corners at the same vertex.
    group = np.repeat(np.arange(len(count)), count)
    fan = count[group]
    i = np.repeat(np.arange(len(face)), fan)
    j = np.arange(len(i)) - np.repeat(np.cumsum(fan) - fan, fan) + np.repeat(first[group], fan)
    i, j = order[i], order[j]
    gentle = np.einsum("ij,ij->i", flat[face[i]], flat[face[j]]) >= CREASE
    i, j = i[gentle], j[gentle]
    total = np.stack([np.bincount(i, area[face[j], axis], len(face)) for axis in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    mean = np.divide(total, length, out=flat[face], where=length > 0)
    return np.asarray(mean, np.float32)


def mean_curvature(mesh: Mesh) -> Floats:
    """Return mean curvature at the vertices, 1/mm, positive where the surface bulges outwards.

    The mean over the edges of the normal curvature along each,
    (n_j − n_i)·(p_j − p_i) / |p_j − p_i|²: exact on spheres.
    """
    known = _curvatures.get(mesh)
    if known is None:
        known = _curvatures[mesh] = _mean_curvature(mesh)
    return known


def _mean_curvature(mesh: Mesh) -> Floats:
    count = len(mesh.vertices)
    normals = mesh.vertex_normals().astype(np.float64)
    points = mesh.vertices.astype(np.float64)
    begin = mesh.faces.ravel()
    end = np.roll(mesh.faces, -1, axis=1).ravel()
    along = points[end] - points[begin]
    square = np.einsum("ij,ij->i", along, along)
    bend = np.einsum("ij,ij->i", normals[end] - normals[begin], along)
    bend = np.divide(bend, square, out=np.zeros_like(bend), where=square > 0)
    total = np.bincount(begin, bend, count) + np.bincount(end, bend, count)
    edges = np.bincount(begin, minlength=count) + np.bincount(end, minlength=count)
    return np.asarray(total / np.maximum(edges, 1), np.float32)
