"""The triangles around seams made even: collapsed, flipped, relaxed, and put on the surface."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.composite import signature
from bozzetto_silhouette.implicit.implicit_solid import Implicit
from bozzetto_silhouette.numerics.isotropic_remeshing import (
    Patch,
    border_edges,
    collapsed,
    flipped_edges,
    relaxed,
    unit,
)
from bozzetto_silhouette.solids.on_surface import Surfaces, projected

SLIVER = 0.5
"""Edges shorter than this share of the spacing are collapsed."""

COLLAPSES = 3
"""Rounds of collapsing edges at first."""

FLIPS = 2
"""Rounds of flipping edges before every relaxation."""

MENDED = 2
"""Rings of vertices around such faces that are moved."""

ROUNDS = 6
"""Rounds of mending faces that were turned over, at most."""

OVERTURNED = -0.2
"""Cosine between a face and the gradient below which it counts as turned over."""


class Sewn(NamedTuple):
    """A mesh whose seams were made even.

    Attributes
    ----------
    vertices, normals : (v, 3) float array
    faces : (f, 3) int array
    parents : (v,) int array
        The vertex before that each stands for.
    moved : (v,) bool array
        Those in seams: only they have normals; the others are as they were.
    """

    vertices: Array
    faces: Index
    parents: Index
    moved: Flags
    normals: Array


class Zone(NamedTuple):
    """The mesh around one seam, by itself.

    Attributes
    ----------
    vertices, faces : (v, 3) float array, (f, 3) int array
    free : (v,) bool array
        Those that may be moved.
    spacing : (v,) float array
    solid : Implicit
        Whose surface it is.
    evenings : int
        Rounds of evening it out.
    """

    vertices: Array
    faces: Index
    free: Flags
    spacing: Array
    solid: Implicit
    evenings: int


def _depends_on(zone: Zone) -> Hashable:
    *arrays, solid, evenings = zone
    return *(array.tobytes() for array in arrays), signature(solid), evenings


@remembered(limit=512, key=_depends_on)
def even(zone: Zone) -> Sewn:
    """Even out the mesh around one seam; remembered."""
    return evened([zone])[0]


def evened(zones: list[Zone]) -> list[Sewn]:
    """Even out the meshes around some seams, all in as many rounds.

    Where that turns faces over one stays as it was.
    """
    counts = [len(zone.vertices) for zone in zones]
    starts = np.cumsum([0, *counts])
    surfaces = Surfaces([zone.solid for zone in zones], np.repeat(np.arange(len(zones)), counts))
    free = np.concatenate([zone.free for zone in zones])
    before = Patch(
        np.concatenate([zone.vertices for zone in zones]),
        np.concatenate([zone.faces + start for zone, start in zip(zones, starts, strict=False)]),
        free,
        np.arange(starts[-1]),
        np.zeros((starts[-1], 3)),
        np.concatenate([zone.spacing for zone in zones]),
    )
    slope = surfaces.sample(before, before.parents).gradient
    before = replace(before, normals=-unit(slope))
    patch = _improved(surfaces, before, COLLAPSES)
    for _ in range(zones[0].evenings):
        patch = _improved(surfaces, patch, 1)
    for _ in range(ROUNDS):
        over = patch.faces[patch.facing() <= OVERTURNED]
        if not len(over):
            break
        patch = replace(patch, free=free[patch.parents] & _near(patch, over))
        among = surfaces._replace(owner=surfaces.owner[patch.parents])
        patch = patch.with_loosened(_improved(among, patch.loosened(), 1))
    patch = replace(patch, free=free[patch.parents])
    kept = [
        _better(*pair) for pair in zip(
            _apart(before, surfaces.owner), _apart(patch, surfaces.owner), strict=True
        )
    ]  # fmt: skip
    free = np.concatenate([one.free for one in kept])
    normals = np.zeros((len(free), 3))
    normals[free] = surfaces.normals(
        np.concatenate([one.vertices for one in kept])[free],
        np.concatenate([one.spacing for one in kept])[free],
        np.concatenate([one.parents + k for one, k in zip(kept, starts, strict=False)])[free],
    )
    own = np.split(normals, np.cumsum([len(one.vertices) for one in kept])[:-1])
    return [
        Sewn(one.vertices, one.faces, one.parents, one.free, normal)
        for one, normal in zip(kept, own, strict=True)
    ]


def _apart(patch: Patch, owner: Index) -> list[Patch]:
    """Take a patch apart by what its vertices belong to; parents count within each."""
    count = int(owner[-1]) + 1
    own = owner[patch.parents]
    ends = np.searchsorted(own, np.arange(count + 1))
    first = np.searchsorted(owner, np.arange(count))
    of_face = own[patch.faces[:, 0]]
    faces = np.split(
        patch.faces[np.argsort(of_face, kind="stable")],
        np.cumsum(np.bincount(of_face, minlength=count))[:-1],
    )
    return [
        Patch(
            patch.vertices[a:b], faces[k] - a, patch.free[a:b], patch.parents[a:b] - first[k],
            patch.normals[a:b], patch.spacing[a:b],
        )
        for k, (a, b) in enumerate(pairwise(ends.tolist()))
    ]  # fmt: skip


def _better(before: Patch, patch: Patch) -> Patch:
    """Return a seam that was made even; as it was, where that was worse."""
    worse = (patch.facing() <= OVERTURNED).sum() > (before.facing() <= OVERTURNED).sum()
    if worse or not _fits(before, patch) or not np.isfinite(patch.vertices).all():
        return before
    return patch


def _fits(before: Patch, patch: Patch) -> bool:
    """Whether a patch has the border that it had, so that the mesh around it stays closed."""
    before_ends, ends = (
        np.sort(_border_keys(some, len(before.parents))) for some in (before, patch)
    )
    return np.array_equal(before_ends, ends)


def _border_keys(patch: Patch, count: int) -> Index:
    a, b = border_edges(patch.faces, len(patch.vertices)).T
    keys: Index = patch.parents[a] * count + patch.parents[b]
    return keys


def _near(patch: Patch, faces: Index) -> Flags:
    """Mark the vertices of some faces, and those around them."""
    near = np.zeros(len(patch.vertices), dtype=bool)
    near[faces] = True
    for _ in range(MENDED):
        near[patch.faces[near[patch.faces].any(axis=1)]] = True
    return near


def _improved(surfaces: Surfaces, patch: Patch, collapses: int) -> Patch:
    """Collapse slivers, flip and relax, and project."""
    patch = relaxed(flipped_edges(collapsed(patch, SLIVER, collapses), FLIPS))
    return projected(surfaces, patch)
