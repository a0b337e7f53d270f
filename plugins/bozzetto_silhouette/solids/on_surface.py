"""Vertices brought onto a blended surface by Newton's method, and their normals.

Many small places are asked at once, each of its own solid; every answer is remembered by itself.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.composite import localized, signature
from bozzetto_silhouette.implicit.implicit_solid import Implicit, Sample, sample_each
from bozzetto_silhouette.numerics.isotropic_remeshing import Patch, dot, unit
from bozzetto_silhouette.solids.batched_answers import each

NEWTON = 2
"""Steps of Newton's method where two seams meet."""

STRIDE = 0.4
"""Longest of these steps, as a share of the spacing."""

STILL = 1e-3
"""Length of a step, as a share of the spacing, after which the next would not be felt: steps
become as short as their squares."""

FLATTEST = 0.2
"""Gradients are taken for no shorter than this: between sides that face each other they vanish."""

OFF = 0.03
"""Value from which on a vertex is not on it, as a share of its spacing."""

ROOM = 3.0
"""Margin around a seam within which solids matter, in spacings."""

DIFFERENCE = 0.1
"""Width of the difference quotients for normals, as a share of the spacing."""

_TETRAHEDRON = np.array([[1, -1, -1], [-1, -1, 1], [-1, 1, -1], [1, 1, 1.0]]) / np.sqrt(3.0)


class Surfaces(NamedTuple):
    """The surfaces that the vertices of a patch belong on.

    Attributes
    ----------
    solids : list of Implicit
    owner : (n,) int array
        The number of its solid by the `parents` of a patch; it never falls.
    """

    solids: list[Implicit]
    owner: Index

    def sample(self, patch: Patch, at: Index) -> Sample:
        """Return values and gradients at some vertices of a patch, each of its own solid."""
        return sample_each(self.solids, patch.vertices[at], self._ends(patch.parents[at]))

    def normals(self, points: Array, spacing: Array, parents: Index) -> Array:
        """Return unit normals, outwards, by differences of the value at a tetrahedron's corners."""
        width = DIFFERENCE * spacing[:, None, None]
        corners = (points[:, None, :] + width * _TETRAHEDRON).reshape(-1, 3)
        values = sample_each(self.solids, corners, 4 * self._ends(parents)).value
        return unit(-values.reshape(-1, 4) @ _TETRAHEDRON)

    def _ends(self, parents: Index) -> Index:
        """Return where in a row of vertices those of each solid begin, and the end of the last."""
        return np.searchsorted(self.owner[parents], np.arange(len(self.solids) + 1))


def around(solid: Implicit, places: Array, spacing: Array) -> Implicit:
    """Reduce a solid to what matters around places (n, 3): that is faster to evaluate."""
    room = ROOM * float(spacing.max())
    box = np.stack([places.min(axis=0) - room, places.max(axis=0) + room])
    return localized(solid, box, room)


def rows_by_number(rows: Index, number: Index) -> list[Index]:
    """Return the rows of each number in turn, without those below 0."""
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.unique(number[number >= 0]))
    return np.split(rows[order], starts)[1:]


class Places(NamedTuple):
    """Places (n, 3) near a surface, how long edges are there (n,), and where normals are asked."""

    points: Array
    spacing: Array
    facing: Flags
    solid: Implicit


def _asked_at(some: Places) -> Hashable:
    *arrays, solid = some
    return *(array.tobytes() for array in arrays), signature(solid)


@remembered(limit=512, key=_asked_at)
def is_off(some: Places) -> Flags:
    """Mark the places that are not on their surface; remembered."""
    return all_off([some])[0]


def all_off(asked: list[Places]) -> list[Flags]:
    """Mark the places that are not on their surface."""
    ends = np.cumsum([0, *(len(some.points) for some in asked)])
    points = np.concatenate([some.points for some in asked])
    values = sample_each([some.solid for some in asked], points, ends).value
    return [
        np.abs(value) > OFF * some.spacing
        for value, some in zip(np.split(values, ends[1:-1]), asked, strict=True)
    ]


def settled(
    vertices: Array, number: Index, spacing: Array, facing: Flags, solid: Implicit
) -> tuple[Array, Array]:
    """Bring numbered vertices (v,) onto the surface; return all vertices, and normals.

    Each number is worked out by itself, and remembered; -1 is left as it is. Normals are those of
    numbered vertices that are `facing` (v,), which take twice the time; others are 0.
    """
    normals = np.zeros_like(vertices)
    vertices = vertices.copy()
    rows = [
        mine[np.lexsort(vertices[mine].T)]
        for mine in rows_by_number(np.arange(len(vertices)), number)
    ]  # fmt: skip
    asked = [
        Places(
            vertices[mine],
            spacing[mine],
            facing[mine],
            around(solid, vertices[mine], spacing[mine]),
        )
        for mine in rows
    ]
    answers = each(_on_surface, _all_on_surface, asked)
    for mine, found in zip(rows, answers, strict=True):
        vertices[mine], normals[mine] = found
    return vertices, normals


def _all_on_surface(asked: list[Places]) -> list[tuple[Array, Array]]:
    """Bring places onto surfaces; return them, and the normals that are asked."""
    ends = np.cumsum([0, *(len(some.points) for some in asked)])
    surfaces = Surfaces([some.solid for some in asked], np.repeat(
        np.arange(len(asked)), np.diff(ends)
    ))  # fmt: skip
    count = int(ends[-1])
    patch = Patch(
        np.concatenate([some.points for some in asked]), np.zeros((0, 3), np.intp),
        np.ones(count, dtype=bool), np.arange(count), np.zeros((count, 3)),
        np.concatenate([some.spacing for some in asked]),
    )  # fmt: skip
    for _ in range(NEWTON):
        before = patch.vertices
        patch = projected(surfaces, patch)
        step = patch.vertices - before
        patch = replace(patch, free=dot(step, step) > np.square(STILL * patch.spacing))
        if not patch.free.any():
            break
    normals = np.zeros((count, 3))
    facing = np.flatnonzero(np.concatenate([some.facing for some in asked]))
    if len(facing):
        normals[facing] = surfaces.normals(patch.vertices[facing], patch.spacing[facing], facing)
    at = ends[1:-1]
    return list(zip(np.split(patch.vertices, at), np.split(normals, at), strict=True))


@remembered(limit=512, key=_asked_at)
def _on_surface(some: Places) -> tuple[Array, Array]:
    return _all_on_surface([some])[0]


def projected(surfaces: Surfaces, patch: Patch) -> Patch:
    """Move free vertices by a damped Newton step; normals come from the gradient."""
    at = np.flatnonzero(patch.free)
    value, gradient, _ = surfaces.sample(patch, at)
    square = np.maximum(dot(gradient, gradient), FLATTEST**2)
    way = value / square
    far = np.abs(way) * np.sqrt(square)
    way *= np.minimum(1.0, STRIDE * patch.spacing[at] / np.maximum(far, 1e-300))
    vertices, normals = patch.vertices.copy(), patch.normals.copy()
    vertices[at] -= way[:, None] * gradient
    normals[at] = -unit(gradient)
    return replace(patch, vertices=vertices, normals=normals)
