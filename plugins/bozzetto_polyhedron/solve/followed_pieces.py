"""What of a body of another object can move by itself: groups of faces, and what hangs apart."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Mesh, Solid, Surface
from bozzetto.plugin import cached_property

SPECK: Final = 0.03
"""Share of the largest piece of a group below which another one belongs to what is near."""

WALL: Final = 2.0
"""Thickness, mm, of what a piece is that would enclose less: a skin, such as a door."""


@dataclass(frozen=True, eq=False)
class Divided:
    """The triangles of a body and the pieces that they make.

    Parameters
    ----------
    mesh : Mesh
    names : tuple of str
        Of the pieces, no two alike.
    piece : (f,) intp
        Which piece each triangle belongs to.
    """

    mesh: Mesh
    names: tuple[str, ...]
    piece: Index

    @cached_property
    def largest(self) -> int:
        """Number of the piece of most volume; of an open body of most area."""
        sizes = [self.taken((k,)) for k in range(len(self.names))]
        closed = is_closed(self.mesh)
        found = [
            0.0 if mesh is None else _volume(mesh) if closed else float(_areas(mesh).sum())
            for mesh in sizes
        ]
        return int(np.argmax(found))

    def number_of(self, name: str) -> int | None:
        """Return the number of a piece; None where it is not there."""
        return self.names.index(name) if name in self.names else None

    def taken(self, numbers: Collection[int]) -> Mesh | None:
        """Return some pieces as one mesh; None where nothing is left of it.

        Where all of the body is closed, it is closed as well: each ring of the cut gets a fan of
        triangles about its middle, the same on both sides of the cut. One that encloses less than
        its skin would as a sheet stays open.
        """
        if len(numbers) == len(self.names):
            return self.mesh
        faces = self.mesh.faces[np.isin(self.piece, list(numbers))]
        if not len(faces):
            return None
        open_mesh = _compact(self.mesh.vertices, faces)
        if not is_closed(self.mesh):
            return open_mesh
        closed = _capped(open_mesh)
        areas, volume = _areas(open_mesh), _volume(closed)
        return closed if volume > WALL * float(areas.sum()) else open_mesh


def divided(parts: Sequence[Solid | Surface], name: str) -> Divided | None:
    """Return the pieces of a body; None where it has no triangles.

    Parameters
    ----------
    parts : sequence of Solid or Surface
        The body.
    name : str
        Of the body: what has no groups is called so.
    """
    vertices, faces, labels, names = [], [], [], list[str]()
    count = 0
    for part in parts:
        vertices.append(np.asarray(part.mesh.vertices))
        faces.append(np.asarray(part.mesh.faces, np.intp) + count)
        count += len(part.mesh.vertices)
        rows = [(group.name or name, group.count) for group in part.groups]
        for label, size in rows or [(name, len(part.mesh.faces))]:
            if label not in names:
                names.append(label)
            labels.append(np.full(size, names.index(label), np.intp))
    if not any(len(each) for each in faces):
        return None
    mesh = Mesh(np.concatenate(vertices), np.concatenate(faces).astype(np.int32))
    return _by_connection(mesh, np.concatenate(labels), names)


def is_closed(mesh: Mesh) -> bool:
    """Whether every side of a triangle is that of another one, too."""
    sides = _sides(np.asarray(mesh.faces, np.int64))
    numbers = sides.min(axis=1) * len(mesh.vertices) + sides.max(axis=1)
    return bool((np.unique(numbers, return_counts=True)[1] == 2).all())


def _by_connection(mesh: Mesh, labels: Index, names: Sequence[str]) -> Divided:
    """Tell apart what hangs apart in each group; specks go to the piece that is nearest."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    _, place = np.unique(mesh.vertices, axis=0, return_inverse=True)
    faces = np.asarray(place.ravel()[mesh.faces], np.int64)
    sides = np.sort(_sides(faces), axis=1)
    owner = np.tile(np.arange(len(faces)), 3)
    order = np.lexsort((labels[owner], sides[:, 1], sides[:, 0]))
    sides, owner = sides[order], owner[order]
    same = (sides[1:] == sides[:-1]).all(axis=1) & (labels[owner[1:]] == labels[owner[:-1]])
    pairs = owner[:-1][same], owner[1:][same]
    graph = coo_matrix((np.ones(len(pairs[0]), bool), pairs), shape=(len(faces), len(faces)))
    _, component = connected_components(graph, directed=False)
    areas = np.bincount(component, _areas(mesh))
    label_of = np.zeros(len(areas), np.intp)
    label_of[component] = labels
    first = np.full(len(areas), len(faces))
    np.minimum.at(first, component, np.arange(len(faces)))
    kept: list[int] = []
    called: list[str] = []
    for label, name in enumerate(names):
        mine = np.flatnonzero(label_of == label)
        if not len(mine):
            continue
        large = mine[areas[mine] >= SPECK * areas[mine].max()]
        large = large[np.argsort(first[large])]
        kept += large.tolist()
        called += [name] if len(large) == 1 else [f"{name} {k + 1}" for k in range(len(large))]
    number = np.full(len(areas), -1)
    number[kept] = np.arange(len(kept))
    piece = number[component]
    specks = piece < 0
    if specks.any():
        middles = np.asarray(mesh.vertices, float)[mesh.faces].mean(axis=1)
        _, nearest = cKDTree(middles[~specks]).query(middles[specks])
        piece[specks] = piece[~specks][nearest]
    return Divided(mesh, _apart(called), piece)


def _apart(names: Sequence[str]) -> tuple[str, ...]:
    """Return names of which no two are alike."""
    made: list[str] = []
    for name in names:
        number, other = 1, name
        while other in made:
            number += 1
            other = f"{name} {number}"
        made.append(other)
    return tuple(made)


def _compact(vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> Mesh:
    """Return triangles with those vertices alone that they use."""
    used, numbers = np.unique(faces, return_inverse=True)
    return Mesh(np.asarray(vertices)[used], numbers.reshape(-1, 3).astype(np.int32))


def _capped(mesh: Mesh) -> Mesh:
    """Return triangles with a fan about the middle of every ring of open sides."""
    sides = _sides(np.asarray(mesh.faces, np.int64))
    numbers = sides.min(axis=1) * len(mesh.vertices) + sides.max(axis=1)
    _, which, counts = np.unique(numbers, return_inverse=True, return_counts=True)
    following: dict[int, list[int]] = {}
    for begin, end in sides[counts[which.ravel()] == 1].tolist():
        following.setdefault(begin, []).append(end)
    vertices = [np.asarray(mesh.vertices, float)]
    faces = [np.asarray(mesh.faces, np.intp)]
    count = len(mesh.vertices)
    while following:
        ring = [next(iter(following))]
        while ring[-1] in following:
            ends = following[ring[-1]]
            ring.append(ends.pop())
            if not ends:
                del following[ring[-2]]
        begins, ends_of = np.array(ring[:-1]), np.array(ring[1:])
        vertices.append(vertices[0][begins].mean(axis=0)[None])
        faces.append(np.stack((ends_of, begins, np.full(len(begins), count)), axis=1))
        count += 1
    return Mesh(np.concatenate(vertices).astype(np.float32), np.concatenate(faces).astype(np.int32))


def _sides(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.concatenate((faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]))


def _corners(mesh: Mesh) -> tuple[Array, Array, Array]:
    places = np.asarray(mesh.vertices, float)[mesh.faces]
    return places[:, 0], places[:, 1], places[:, 2]


def _areas(mesh: Mesh) -> Array:
    first, second, third = _corners(mesh)
    return np.asarray(0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1))


def _volume(mesh: Mesh) -> float:
    first, second, third = _corners(mesh)
    middle = first.mean(axis=0)
    return float(
        np.einsum("ij,ij->", first - middle, np.cross(second - middle, third - middle)) / 6
    )
