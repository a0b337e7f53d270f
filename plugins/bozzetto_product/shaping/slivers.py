"""Closed meshes without edges too short for files that know corners by their places.

Unions of many overlapping bodies leave edges far below single precision. They are contracted
where that keeps a closed surface (Dey, Edelsbrunner, Guha & Nekhayev 1999, *Topology preserving
edge contraction*: both ends have no more neighbours in common than the other corners of the two
triangles).
What must stay and still lies at one place is moved apart.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.sparse import csr_array

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Mesh

MOST_ROUNDS: Final = 60
"""Rounds of contracting edges; in each those that do not touch one another."""

TETRAHEDRON: Final = 6
"""Edges at both ends of an edge of a tetrahedron, which has none to lose."""

APART: Final = 2e-6
"""Length, as share of the size, by which corners that only touch are moved apart."""

MOST_APART: Final = 8
"""Rounds in which that is tried, each time by more."""


def contracted(vertices: Array, faces: Index, shortest: float) -> tuple[Array, Index, Index]:
    """Contract edges that are too short.

    Parameters
    ----------
    vertices : (n, 3) float
        mm.
    faces : (m, 3) int
        A closed surface: each side of a triangle is another's, the other way round.
    shortest : float
        mm; shorter edges go.

    Returns
    -------
    vertices : (k, 3) float
    faces : (l, 3) int
    kept : (l,) int
        Which of the given faces these are, in their order.
    """
    kept = np.arange(len(faces))
    order = np.random.default_rng(0)
    for _ in range(MOST_ROUNDS):
        gone = _apart_from_one_another(vertices, faces, shortest, order)
        if not len(gone):
            break
        target = np.arange(len(vertices))
        target[gone[:, 1]] = gone[:, 0]
        faces = target[faces]
        sound = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
        faces, kept = faces[sound], kept[sound]
    used, numbers = np.unique(faces, return_inverse=True)
    return vertices[used], numbers.reshape(-1, 3), kept


def _apart_from_one_another(
    vertices: Array, faces: Index, shortest: float, order: np.random.Generator
) -> Index:
    """Return edges that may be contracted at once, (k, 2): no two with neighbouring ends."""
    sides = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    edges = sides[sides[:, 0] < sides[:, 1]]
    short = edges[_lengths(vertices, edges) < shortest]
    if not len(short):
        return short
    count = len(vertices)
    valence = np.bincount(sides[:, 0], minlength=count)
    beside = csr_array((np.ones(len(sides), np.int32), tuple(sides.T)), shape=(count, count))
    common = (beside[short[:, 0]] * beside[short[:, 1]]).sum(axis=1)
    short = short[(common == 2) & (valence[short].sum(axis=1) > TETRAHEDRON)]
    turn = order.permutation(len(short))
    first = np.full(count, len(short))
    for end in short.T:
        np.minimum.at(first, end, turn)
    around = first.copy()
    np.minimum.at(around, sides[:, 0], first[sides[:, 1]])
    return np.asarray(short[(around[short] == turn[:, None]).all(axis=1)])


def _lengths(vertices: Array, edges: Index) -> Array:
    return np.asarray(np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1))


def moved_apart(vertices: Array, faces: Index, size: float) -> Mesh:
    """Return a mesh of which no two corners share a place in single precision.

    Corners at one place go into the body, each by another length, for where surfaces touch along a
    sliver their normals may be alike.

    Parameters
    ----------
    vertices : (n, 3) float
        mm.
    faces : (m, 3) int
        Closed.
    size : float
        mm, of the whole.
    """
    mesh = Mesh(vertices.astype(np.float32), faces.astype(np.int32))
    for number in range(1, MOST_APART):
        _, same, times = np.unique(mesh.vertices, axis=0, return_inverse=True, return_counts=True)
        touching = np.flatnonzero(times[same.ravel()] > 1)
        if not len(touching):
            break
        rank = _ranks(same.ravel()[touching])
        ways = mesh.vertex_normals()[touching].astype(float)
        ways[np.linalg.norm(ways, axis=1) < 0.5] = (0.0, 0.0, 1.0)
        places = mesh.vertices.astype(float)
        places[touching] -= number * APART * size * (1 + rank)[:, None] * ways
        mesh = Mesh(places.astype(np.float32), mesh.faces)
    return mesh


def _ranks(same: Index) -> Index:
    """Return the how-manieth of its equals each number is, from 0."""
    order = np.argsort(same, kind="stable")
    ordered = same[order]
    starts = np.flatnonzero(np.concatenate(([True], ordered[1:] != ordered[:-1])))
    counts = np.diff(np.concatenate((starts, [len(same)])))
    ranks = np.empty(len(same), np.intp)
    ranks[order] = np.arange(len(same)) - np.repeat(starts, counts)
    return ranks
