"""A sphere of triangles that knows the coarser one it was subdivided from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, frozen
from bozzetto.cached_properties import cached_property

VALENCE: Final = 6
"""Most triangles round a vertex: five round the twelve of the icosahedron, six round others."""

GOLDEN: Final = (1.0 + 5.0**0.5) / 2.0


@dataclass(frozen=True, eq=False)
class Icosphere:
    """An icosahedron, each triangle of which was split into four, several times.

    It is its own mirror image about each of the coordinate planes, bit for bit.

    Attributes
    ----------
    level : int
        How often it was subdivided.
    directions : (n, 3) float
        Unit vectors; ``n = 10 · 4^level + 2``. Those of the coarser sphere come first.
    faces : (20 · 4^level, 3) int
        Counter-clockwise seen from outside.
    parents : (m, 2) int
        The ends of the coarser sphere's edges, one for each vertex that came with this level.
    rings : (n, 6) int
        The triangles round each vertex; where there are five, the first is told twice.
    mirrored : (n,) int
        The vertex that is each one's image when y changes its sign.
    """

    level: int
    directions: Array
    faces: Index
    parents: Index
    rings: Index
    mirrored: Index

    @cached_property
    def edges(self) -> Index:
        """All edges, (m, 2): see `edges_of`."""
        return edges_of(self.faces)[0]

    @cached_property
    def neighbours(self) -> frozenset[tuple[int, int]]:
        """The edges as pairs, the lower vertex first."""
        return frozenset((a, b) for a, b in self.edges.tolist())

    def refined(self, vertices: Array) -> Array:
        """Return places of the coarser sphere's vertices, and the middles of its edges, (n, 3)."""
        return np.vstack((vertices, 0.5 * vertices[self.parents].sum(axis=1)))


@lru_cache(maxsize=8)
def icosphere(level: int) -> Icosphere:
    """Return the icosahedron subdivided `level` times, ``level >= 0``."""
    if level == 0:
        places, faces, parents = *_icosahedron(), np.zeros((0, 2), np.intp)
    else:
        places, faces, parents = _subdivided(icosphere(level - 1))
    return Icosphere(
        level,
        frozen(places, np.float64),
        frozen(faces, np.intp),
        frozen(parents, np.intp),
        frozen(_rings(faces, len(places)), np.intp),
        frozen(_mirrored(places), np.intp),
    )


def edges_of(faces: Index) -> tuple[Index, Index]:
    """Return the edges of a closed mesh.

    Returns
    -------
    edges : (m, 2) int
        The lower vertex first; each edge once.
    of_face : (f, 3) int
        The edges that lead from each corner of a face to the next.
    """
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = int(faces.max()) + 1
    keys, number = np.unique(
        np.minimum(start, end) * count + np.maximum(start, end), return_inverse=True
    )
    return np.stack((keys // count, keys % count), axis=1), number.reshape(-1, 3)


def _icosahedron() -> tuple[Array, Index]:
    """Return the corners of three golden rectangles, and the triangles of neighbours among them."""
    signs = np.array([[0.0, s, t * GOLDEN] for s in (-1, 1) for t in (-1, 1)])
    corners = np.vstack((signs, signs[:, [2, 0, 1]], signs[:, [1, 2, 0]]))
    close = np.linalg.norm(corners[:, None] - corners, axis=2) < 2.5
    first, second, third = np.nonzero(close[:, :, None] & close[:, None] & close)
    kept = (first < second) & (second < third)
    faces = np.stack((first[kept], second[kept], third[kept]), axis=1)
    a, b, c = np.moveaxis(corners[faces], 1, 0)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    faces[inward] = faces[inward][:, ::-1]
    return _unit(corners), np.asarray(faces, np.intp)


def _subdivided(coarse: Icosphere) -> tuple[Array, Index, Index]:
    of_face = edges_of(coarse.faces)[1]
    middle = of_face + len(coarse.directions)
    corner = coarse.faces
    pieces = [np.stack((corner[:, k], middle[:, k], middle[:, k - 1]), axis=1) for k in range(3)]
    places = np.vstack((coarse.directions, _unit(coarse.directions[coarse.edges].sum(axis=1))))
    return places, np.vstack((*pieces, middle)), coarse.edges


def _unit(places: Array) -> Array:
    """Return vectors of length one; squares are added so that signs do not matter."""
    return np.asarray(places / np.sqrt((places * places).sum(axis=1, keepdims=True)))


def _rings(faces: Index, count: int) -> Index:
    order = np.argsort(faces, axis=None, kind="stable")
    vertex = faces.ravel()[order]
    place = np.arange(len(vertex)) - np.searchsorted(vertex, np.arange(count))[vertex]
    rings = np.full((count, VALENCE), -1)
    rings[vertex, place] = order // 3
    return np.asarray(np.where(rings < 0, rings[:, :1], rings))


def _mirrored(places: Array) -> Index:
    """Return pairs of mirror images by their coordinates, bit for bit."""
    here = np.lexsort((places + 0.0).T)
    there = np.lexsort((places * (1.0, -1.0, 1.0) + 0.0).T)
    image = np.empty(len(places), np.intp)
    image[there] = here
    return image
