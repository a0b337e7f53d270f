"""The fillet: around the crease of a sharp mesh the surface of the blended solid.

The sharp mesh has the topology and all detail. Only where the blend tells are its triangles
made anew, fine enough for the fillet, and moved onto the zero set of the blended solid.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.composite import Composite
from bozzetto_silhouette.remeshing import (
    Patch,
    collapsed,
    flipped_edges,
    relaxed,
    split,
    unit,
)

__all__ = ["Fillet", "filleted", "scaled"]

Points = NDArray[np.float64]
Indices = NDArray[np.intp]

RETREATS = (1.0, 0.4)
"""Shares of the blend that are tried in turn."""

_FINENESS = 0.22
"""Longest edge in the fillet as a share of the reach: a quarter circle gets about seven."""

_FINEST = 0.4
"""The same as a share of the mesh's spacing, at least: smaller fillets are not seen."""

_SLIVER = 0.45
"""Edges shorter than this share of the shorter of the longest edge and the mesh's own spacing
are collapsed."""

_STAGES = (0.4, 0.75, 1.0)
"""The reach grows by stages, so that no vertex has far to go at once."""

_SMOOTHINGS = 2
"""Rounds of relaxation after every stage."""

_COLLAPSES = 3
"""Rounds of collapsing edges before every relaxation."""

_FLIPS = 2
"""Rounds of flipping edges before every relaxation."""

_TELLING = 1e-3
"""What the blend adds, as a share of the reach, from which on vertices are set free."""

_NEWTON = 3
"""Steps of Newton's method at the end of every stage."""

_STRIDE = 0.25
"""Longest of these steps, as a share of the reach."""

_FLATTEST = 0.2
"""Gradients are taken for no shorter than this: between sides that face each other they vanish."""

_RINGS = 2
"""Rings of vertices around those that the blend tells on which may be moved, too."""

_HOPELESS = 0.05
"""Share of faces turned over from which on nothing more is tried."""

_REPAIRS = 6
"""Rounds of mending faces that were turned over."""

_LEFT = 0.02
"""What may be left of the blended value at a vertex, as a share of the reach."""

_OVERTURNED = -0.2
"""Cosine between a face and the gradient below which it counts as turned over."""


class Fillet(NamedTuple):
    """A mesh with its fillets.

    Attributes
    ----------
    vertices : (v, 3) float array
    faces : (f, 3) int array
    parents : (v,) int array
        The vertex of the sharp mesh that each stands for or came from.
    shares : (v,) float array
        Of the blend that was asked for, in the fillets; 0 where the mesh is as it was.
    """

    vertices: Points
    faces: Indices
    parents: Indices
    shares: Points


def filleted(vertices: Points, faces: Indices, solid: Composite, step: float) -> Fillet:
    """The mesh of the sharp operation brought onto the blended solid.

    Every crease is done by itself. One whose fillet finds no place, as where it would be
    larger than what it joins, is tried with less, and at last stays sharp.

    Parameters
    ----------
    vertices, faces : (v, 3) float array, (f, 3) int array
        Of the sharp operation.
    solid : Composite
        With a blend above 0.
    step : float
        Spacing of the finer of the two meshes.
    """
    crease = _creases(solid, vertices, faces)
    of_face = crease[faces].max(axis=1)
    todo = np.unique(of_face[of_face >= 0])
    meshes = [(vertices, faces, np.arange(len(vertices)), np.zeros(len(vertices)))]
    for share in RETREATS:
        if not len(todo):
            break
        patch = _rounded(
            _patch(vertices, faces[np.isin(of_face, todo)]), crease >= 0, scaled(solid, share), step
        )
        own = crease[patch.parents]
        failed = np.intersect1d(todo, _failed(scaled(solid, share), patch, own))
        done = np.setdiff1d(todo, failed)
        # What was never free is still the vertex that it was; the others are new.
        fresh = np.flatnonzero(patch.free)
        number = patch.parents.copy()
        number[fresh] = sum(len(mesh[0]) for mesh in meshes) + np.arange(len(fresh))
        rows = np.isin(own[patch.faces].max(axis=1), done)
        meshes.append((
            patch.vertices[fresh], number[patch.faces[rows]], patch.parents[fresh],
            np.full(len(fresh), share),
        ))  # fmt: skip
        todo = failed
    kept = (of_face < 0) | np.isin(of_face, todo)
    meshes[0] = (vertices, faces[kept], meshes[0][2], meshes[0][3])
    return _compact(*(np.concatenate(column) for column in zip(*meshes, strict=True)))


def scaled(solid: Composite, share: float) -> Composite:
    """The same with a share of its blend."""
    return replace(solid, blend=share * solid.blend, reach=share * solid.reach)


def _creases(solid: Composite, vertices: Points, faces: Indices) -> Indices:
    """For every vertex that the blend may move the number of its crease, else -1."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    may = _told(solid, vertices)
    for _ in range(_RINGS):
        may[faces[may[faces].any(axis=1)]] = True
    a, b = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    inner = may[a] & may[b]
    links = coo_array(
        (np.ones(inner.sum(), np.int32), (a[inner], b[inner])), shape=(len(vertices),) * 2
    )
    _, number = connected_components(links, directed=False)
    return np.where(may, number, -1)


def _patch(vertices: Points, faces: Indices) -> Patch:
    """Some faces of a mesh by themselves, with no vertex free yet."""
    numbers, inverse = np.unique(faces, return_inverse=True)
    return Patch(
        vertices[numbers],
        inverse.reshape(-1, 3),
        np.zeros(len(numbers), dtype=bool),
        numbers,
        np.zeros((len(numbers), 3)),
    )


def _rounded(patch: Patch, may: NDArray[np.bool_], solid: Composite, step: float) -> Patch:
    """The patch moved onto the blended solid, by stages.

    `may` tells of every vertex of the mesh whether it can be set free.
    """
    for share in _STAGES:
        stage = scaled(solid, share)
        free = patch.free | (_told(stage, patch.vertices) & may[patch.parents])
        patch = replace(patch, free=free)
        patch = split(patch, _spacing(solid, patch, step))
        for _ in range(_SMOOTHINGS):
            patch = _bettered(stage, patch, step)
        for _ in range(_NEWTON):
            patch = _projected(stage, patch)
        if np.mean(patch.facing() < _OVERTURNED) > _HOPELESS:
            return patch
    for _ in range(_REPAIRS):
        if patch.facing().min(initial=1.0) > 0.0:
            break
        patch = _projected(solid, _bettered(solid, patch, step))
    return patch


def _spacing(solid: Composite, patch: Patch, step: float) -> Points:
    """Longest edge that is wanted at each vertex."""
    reach = solid.local_reach(*solid.sides(patch.vertices))
    return np.maximum(_FINENESS * reach, _FINEST * step)


def _bettered(solid: Composite, patch: Patch, step: float) -> Patch:
    """Projected, without slivers, and relaxed."""
    patch = _projected(solid, patch)
    shortest = _SLIVER * np.minimum(_spacing(solid, patch, step), step)
    return relaxed(flipped_edges(collapsed(patch, shortest, _COLLAPSES), _FLIPS))


def _told(solid: Composite, points: Points) -> NDArray[np.bool_]:
    """Where the blend makes a difference."""
    sides = solid.sides(points)
    sharp = replace(solid, blend=0.0, reach=0.0).blended(*sides).value
    told: NDArray[np.bool_] = np.abs(
        solid.blended(*sides).value - sharp
    ) > _TELLING * solid.local_reach(*sides)
    return told


def _projected(solid: Composite, patch: Patch) -> Patch:
    """Free vertices after a damped step of Newton's method; normals from the gradient."""
    sides = solid.sides(patch.vertices)
    value, gradient, _ = solid.blended(*sides)
    square = np.maximum((gradient**2).sum(axis=1), _FLATTEST**2)
    most = _STRIDE * solid.local_reach(*sides)
    way = np.where(patch.free, np.clip(value, -most, most) / square, 0.0)
    return replace(
        patch, vertices=patch.vertices - way[:, None] * gradient, normals=-unit(gradient)
    )


def _failed(solid: Composite, patch: Patch, own: Indices) -> Indices:
    """Creases with vertices that did not arrive, or with faces that are turned over."""
    sides = solid.sides(patch.vertices)
    reach = np.maximum(solid.local_reach(*sides), _FINEST * _LEFT * solid.reach)
    lost = patch.free & ~(np.abs(solid.blended(*sides).value) <= _LEFT * reach)
    inner = patch.faces[patch.free[patch.faces].all(axis=1)]
    over = inner[~(patch.facing(inner) >= _OVERTURNED)]
    return np.unique(np.append(own[lost], own[over.ravel()]))


def _compact(vertices: Points, faces: Indices, parents: Indices, shares: Points) -> Fillet:
    """Without the vertices that no face uses any more."""
    used = np.zeros(len(vertices), dtype=bool)
    used[faces] = True
    number = np.cumsum(used) - 1
    return Fillet(vertices[used], number[faces], parents[used], shares[used])
