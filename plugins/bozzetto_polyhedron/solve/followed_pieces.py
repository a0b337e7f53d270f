"""Pieces of another object that can move by themselves: groups of faces, and what hangs apart."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto.geometry import FaceGroup, Mesh, Solid, Surface
from bozzetto.plugin import cached_property

SPECK: Final = 0.03
"""Share of the largest piece of a group below which another one belongs to what is near."""

WALL: Final = 2.0
"""Thickness, mm, of what a piece is that would enclose less: a skin, such as a door."""


class Taken(NamedTuple):
    """Pieces of a body as one.

    Attributes
    ----------
    mesh : Mesh
    groups : tuple of FaceGroup
        All triangles, in their order.
    """

    mesh: Mesh
    groups: tuple[FaceGroup, ...]


@dataclass(frozen=True, eq=False)
class Divided:
    """The triangles of a body and the pieces that they make.

    Parameters
    ----------
    mesh : Mesh
        With normals, and with colours where a part has some.
    names : tuple of str
        Of the pieces, no two alike.
    piece : (f,) intp
        Which piece each triangle belongs to.
    groups : tuple of FaceGroup
        All triangles, in their order, with the colours and finishes that they came with.
    """

    mesh: Mesh
    names: tuple[str, ...]
    piece: Index
    groups: tuple[FaceGroup, ...]

    @cached_property
    def largest(self) -> int:
        """Number of the piece of most volume; of an open body of most area."""
        taken = [self.taken((k,)) for k in range(len(self.names))]
        closed = is_closed(self.mesh)
        found = [
            0.0 if one is None else _volume(one.mesh) if closed else float(_areas(one.mesh).sum())
            for one in taken
        ]
        return int(np.argmax(found))

    def number_of(self, name: str) -> int | None:
        """Return the number of a piece; None where it is not there."""
        return self.names.index(name) if name in self.names else None

    def taken(self, numbers: Collection[int]) -> Taken | None:
        """Return some pieces as one; None where nothing is left of it.

        Where all of the body is closed, it is closed as well: each ring of the cut gets a fan of
        triangles about its middle, the same on both sides of the cut. One that encloses less than
        its skin would as a sheet stays open.
        """
        if len(numbers) == len(self.names):
            return Taken(self.mesh, self.groups)
        kept = np.isin(self.piece, list(numbers))
        if not kept.any():
            return None
        begins = np.cumsum([0, *(group.count for group in self.groups)])
        counts = [int(kept[a:b].sum()) for a, b in itertools.pairwise(begins.tolist())]
        groups = tuple(
            replace(group, count=count)
            for group, count in zip(self.groups, counts, strict=True)
            if count
        )
        open_mesh = _compact(self.mesh, self.mesh.faces[kept])
        if not is_closed(self.mesh):
            return Taken(open_mesh, groups)
        closed = _capped(open_mesh)
        areas, volume = _areas(open_mesh), _volume(closed)
        if volume <= WALL * float(areas.sum()):
            return Taken(open_mesh, groups)
        last = groups[-1]
        caps = len(closed.faces) - len(open_mesh.faces)
        return Taken(closed, (*groups[:-1], replace(last, count=last.count + caps)))


def divided(parts: Sequence[Solid | Surface], name: str) -> Divided | None:
    """Return the pieces of a body; None where it has no triangles.

    Parameters
    ----------
    parts : sequence of Solid or Surface
        The body.
    name : str
        Of the body: what has no groups is called so.
    """
    labels, names, groups = [], list[str](), list[FaceGroup]()
    for part in parts:
        whole = FaceGroup(name, len(part.mesh.faces))
        for group in part.groups or (whole,):
            label = group.name or name
            if label not in names:
                names.append(label)
            labels.append(np.full(group.count, names.index(label), np.intp))
            groups.append(replace(group, name=label, color=group.color or part.color))
    if not any(group.count for group in groups):
        return None
    mesh = _joined([part.mesh for part in parts])
    return _by_connection(mesh, np.concatenate(labels), names, tuple(groups))


def _joined(meshes: Sequence[Mesh]) -> Mesh:
    """Return meshes as one, with their normals; with colours where one of them has some."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)]).tolist()
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    painted = any(mesh.colors is not None for mesh in meshes)
    colors = [_colors(mesh) for mesh in meshes] if painted else []
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(faces).astype(np.int32),
        np.concatenate([mesh.vertex_normals() for mesh in meshes]),
        np.concatenate([rgba for rgba, _ in colors]) if painted else None,
        np.concatenate([cover for _, cover in colors]) if painted else None,
    )


def _colors(mesh: Mesh) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return RGBA of the vertices, (v, 4), and how much of it is their own, (v,)."""
    count = len(mesh.vertices)
    if mesh.colors is None:
        return np.zeros((count, 4), np.uint8), np.zeros(count, np.uint8)
    return mesh.colors, np.full(count, 255, np.uint8) if mesh.cover is None else mesh.cover


def is_closed(mesh: Mesh) -> bool:
    """Whether every side of a triangle is that of another one, too."""
    sides = _sides(np.asarray(mesh.faces, np.int64))
    numbers = sides.min(axis=1) * len(mesh.vertices) + sides.max(axis=1)
    return bool((np.unique(numbers, return_counts=True)[1] == 2).all())


def _by_connection(
    mesh: Mesh, labels: Index, names: Sequence[str], groups: tuple[FaceGroup, ...]
) -> Divided:
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
    return Divided(mesh, _apart(called), piece, groups)


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


def _compact(mesh: Mesh, faces: NDArray[np.int32]) -> Mesh:
    """Return triangles with those vertices alone that they use."""
    used, numbers = np.unique(faces, return_inverse=True)
    return Mesh(
        mesh.vertices[used],
        numbers.reshape(-1, 3).astype(np.int32),
        None if mesh.normals is None else mesh.normals[used],
        None if mesh.colors is None else mesh.colors[used],
        None if mesh.cover is None else mesh.cover[used],
    )


def _capped(mesh: Mesh) -> Mesh:
    """Return triangles with a fan about the middle of every ring of open sides."""
    sides = _sides(np.asarray(mesh.faces, np.int64))
    numbers = sides.min(axis=1) * len(mesh.vertices) + sides.max(axis=1)
    _, which, counts = np.unique(numbers, return_inverse=True, return_counts=True)
    following: dict[int, list[int]] = {}
    for begin, end in sides[counts[which.ravel()] == 1].tolist():
        following.setdefault(begin, []).append(end)
    rings: list[Index] = []
    while following:
        ring = [next(iter(following))]
        while ring[-1] in following:
            ends = following[ring[-1]]
            ring.append(ends.pop())
            if not ends:
                del following[ring[-2]]
        rings.append(np.array(ring[:-1]))
    if not rings:
        return mesh
    places = np.asarray(mesh.vertices, float)
    middles = np.array([places[ring].mean(axis=0) for ring in rings])
    fans = [
        np.stack((np.roll(ring, -1), ring, np.full(len(ring), len(places) + number)), axis=1)
        for number, ring in enumerate(rings)
    ]
    firsts = [ring[0] for ring in rings]
    return Mesh(
        np.concatenate([places, middles]).astype(np.float32),
        np.concatenate([mesh.faces, *fans]).astype(np.int32),
        None if mesh.normals is None else np.concatenate([mesh.normals, _outwards(places, rings)]),
        None if mesh.colors is None else np.concatenate([mesh.colors, mesh.colors[firsts]]),
        None if mesh.cover is None else np.concatenate([mesh.cover, mesh.cover[firsts]]),
    )


def _outwards(places: Array, rings: Sequence[Index]) -> NDArray[np.float32]:
    """Return the unit normal of the fan in each ring, which goes round as the skin's border."""
    areas = []
    for ring in rings:
        rim = places[ring] - places[ring].mean(axis=0)
        areas.append(np.cross(np.roll(rim, -1, axis=0), rim).sum(axis=0))
    found = np.array(areas)
    return np.asarray(
        found / np.maximum(np.linalg.norm(found, axis=1), 1e-300)[:, None], np.float32
    )


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
