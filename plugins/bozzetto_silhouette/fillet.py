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

__all__ = ["Fillet", "filleted"]

Points = NDArray[np.float64]

_FINENESS = 0.22
"""Longest edge in the fillet as a share of the reach: a quarter circle gets about seven."""

_SLIVER = 0.45
"""Edges shorter than this share of the shorter of the longest edge and the mesh's own spacing
are collapsed."""

_STAGES = (0.4, 0.75, 1.0)
"""The reach grows by stages, so that no vertex has far to go at once."""

_SMOOTHINGS = 3
"""Rounds of relaxation after every stage."""

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

_REPAIRS = 6
"""Rounds of mending faces that were turned over."""

_LEFT = 0.02
"""What may be left of the blended value at a vertex, as a share of the reach."""

_OVERTURNED = -0.2
"""Cosine between a face and the gradient below which it counts as turned over."""


class Fillet(NamedTuple):
    """A mesh with its fillet.

    Attributes
    ----------
    vertices : (v, 3) float array
    faces : (f, 3) int array
    parents : (v,) int array
        The vertex of the sharp mesh that each stands for or came from.
    moved : (v,) bool array
        Those of the fillet.
    """

    vertices: Points
    faces: NDArray[np.intp]
    parents: NDArray[np.intp]
    moved: NDArray[np.bool_]


def filleted(
    vertices: Points, faces: NDArray[np.intp], solid: Composite, step: float
) -> Fillet | None:
    """The mesh of the sharp operation brought onto the blended solid.

    Parameters
    ----------
    vertices, faces : (v, 3) float array, (f, 3) int array
        Of the sharp operation.
    solid : Composite
        With a reach above 0.
    step : float
        Spacing of the finer of the two meshes.

    Returns
    -------
    Fillet or None
        None where the mesh could not be brought there soundly.
    """
    told = _told(solid, vertices)
    if not told.any():
        return Fillet(vertices, faces, np.arange(len(vertices)), told)
    may = told.copy()
    for _ in range(_RINGS):
        may[faces[may[faces].any(axis=1)]] = True
    around = may[faces].any(axis=1)
    numbers = np.unique(faces[around])
    local = np.zeros(len(vertices), dtype=np.intp)
    local[numbers] = np.arange(len(numbers))
    patch = Patch(
        vertices[numbers],
        local[faces[around]],
        np.zeros(len(numbers), dtype=bool),
        numbers,
        np.zeros((len(numbers), 3)),
    )
    patch = _rounded(patch, may, solid, step)
    if not _sound(solid, patch):
        return None
    # What was never free is still the vertex that it was; the others are new.
    fresh = np.flatnonzero(patch.free)
    number = patch.parents.copy()
    number[fresh] = len(vertices) + np.arange(len(fresh))
    return _compact(
        np.vstack([vertices, patch.vertices[fresh]]),
        np.concatenate([faces[~around], number[patch.faces]]),
        np.append(np.arange(len(vertices)), patch.parents[fresh]),
        len(vertices),
    )


def _rounded(patch: Patch, may: NDArray[np.bool_], solid: Composite, step: float) -> Patch:
    """The patch moved onto the blended solid, by stages.

    `may` tells of every vertex of the mesh whether it can be set free.
    """
    longest = _FINENESS * solid.reach
    shortest = _SLIVER * min(longest, step)
    for share in _STAGES:
        stage = replace(solid, reach=share * solid.reach)
        free = patch.free | (_told(stage, patch.vertices) & may[patch.parents])
        patch = split(replace(patch, free=free), longest)
        for _ in range(_SMOOTHINGS):
            patch = _projected(stage, patch)
            patch = flipped_edges(collapsed(patch, shortest), _FLIPS)
            patch = relaxed(patch)
        for _ in range(_NEWTON):
            patch = _projected(stage, patch)
    for _ in range(_REPAIRS):
        if patch.facing().min() > 0.0:
            break
        patch = _projected(solid, relaxed(flipped_edges(collapsed(patch, shortest), _FLIPS)))
    return patch


def _told(solid: Composite, points: Points) -> NDArray[np.bool_]:
    """Where the blend makes a difference."""
    sides = solid.sides(points)
    sharp = replace(solid, reach=0.0).blended(*sides).value
    told: NDArray[np.bool_] = np.abs(solid.blended(*sides).value - sharp) > _TELLING * solid.reach
    return told


def _projected(solid: Composite, patch: Patch) -> Patch:
    """Free vertices after a damped step of Newton's method; normals from the gradient."""
    value, gradient = solid.sample(patch.vertices)
    square = np.maximum((gradient**2).sum(axis=1), _FLATTEST**2)
    most = _STRIDE * solid.reach
    way = np.where(patch.free, np.clip(value, -most, most) / square, 0.0)
    return replace(
        patch, vertices=patch.vertices - way[:, None] * gradient, normals=-unit(gradient)
    )


def _sound(solid: Composite, patch: Patch) -> bool:
    """Whether all vertices arrived and no face was turned over."""
    if not np.isfinite(patch.vertices).all():
        return False
    left = np.abs(solid.value(patch.vertices[patch.free])).max(initial=0.0)
    inner = patch.free[patch.faces].all(axis=1)
    facing = patch.facing(patch.faces[inner]).min(initial=1.0)
    return bool(left <= _LEFT * solid.reach and facing >= _OVERTURNED)


def _compact(
    vertices: Points, faces: NDArray[np.intp], parents: NDArray[np.intp], first_new: int
) -> Fillet:
    """Without the vertices that no face uses any more."""
    used = np.zeros(len(vertices), dtype=bool)
    used[faces] = True
    number = np.cumsum(used) - 1
    moved = np.arange(len(vertices)) >= first_new
    return Fillet(vertices[used], number[faces], parents[used], moved[used])
