"""The mesh of a union, worked out piece by piece: what did not change is not united again.

Of a body with limbs the limbs meet the body and not one another. So each is united with the body
by itself, and the union of all is put together from that: where a triangle of the body was cut
or covered by one limb it is taken from that limb's union, and no other touches it. It is closed
because each piece has the very border of the triangles that it stands for.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Faces, Flags, Index
from bozzetto.plugin import remembered
from bozzetto_silhouette.inflation.manifold_check import volume_of
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.isotropic_remeshing import border_edges
from bozzetto_silhouette.solids.body import meet
from bozzetto_silhouette.solids.lump import Held, Lump, united
from bozzetto_silhouette.solids.volume_check import is_volume_of_union

if TYPE_CHECKING:
    from manifold3d import Manifold

_KEY = np.array([0.7548776662466927, 0.5698402909980532, 0.3247179572447460])


class UnionMesh(NamedTuple):
    """A closed mesh that knows where its faces come from.

    Attributes
    ----------
    vertices : (v, 3) float64 array
    faces : (f, 3) int32 array
        Oriented outwards.
    numbers : (f,) int array
        Under which manifold3d keeps the mesh apart that each face comes from.
    """

    vertices: Array
    faces: Faces
    numbers: Index


Piece = tuple[Lump, ...]
"""Lumps that meet one another, and none of another piece."""


class _Change(NamedTuple):
    """Changes of a mesh, the base, by a union with other solids.

    Attributes
    ----------
    vertices : (v, 3) float64 array
        New ones; in faces they count from the base's last vertex on.
    faces : (f, 3) int array
        Of the other solids.
    numbers : (f,) int array
    border : (e, 2) int array
        The directed edges where they end.
    pieces : (p, 3) int array
        What is left of the base's faces that were cut.
    origins : (p,) int array
        The face of the base that each is a piece of.
    touched : (t,) int array
        The base's faces that were cut, or are covered.
    """

    vertices: Array
    faces: Index
    numbers: Index
    border: Index
    pieces: Index
    origins: Index
    touched: Index


def union_mesh(lumps: tuple[Lump, ...]) -> UnionMesh | None:
    """Return the mesh of a union of solids; None where there is no sound one."""
    base, pieces = _pieces(lumps)
    if len(pieces) > 1:
        mesh = _put_together(lumps[base], pieces)
        if mesh is not None:
            volumes = [float(lump.manifold.volume()) for lump in lumps]
            if is_volume_of_union(volume_of(mesh.vertices, mesh.faces), volumes):
                return mesh
    whole = united(lumps)
    return None if whole is None else mesh_of(whole)


def mesh_of(solid: Manifold) -> UnionMesh:
    """Return the mesh of a solid of manifold3d."""
    mesh = solid.to_mesh64()
    starts = np.array(mesh.run_index, dtype=np.intp) // 3
    lengths = starts[1:] - starts[:-1]
    return UnionMesh(
        np.array(mesh.vert_properties, np.float64)[:, :3],
        np.array(mesh.tri_verts).astype(np.int32),
        np.repeat(np.array(mesh.run_original_id, dtype=np.int64), lengths),
    )


def found(vertices: Array, before: Array) -> Index:
    """Find the index of each vertex (v, 3) among those before (n, 3), -1 for new ones."""
    keys = before @ _KEY
    order = np.argsort(keys, kind="stable")
    at = np.minimum(np.searchsorted(keys[order], vertices @ _KEY), len(before) - 1)
    index = order[at]
    return np.where((before[index] == vertices).all(axis=1), index, -1)


def _pieces(lumps: tuple[Lump, ...]) -> tuple[int, list[Piece]]:
    """Choose the lump that most others meet; return it, and the pieces that the others are."""
    boxes = np.stack([lump.box for lump in lumps])
    below = (boxes[:, None, 0] <= boxes[None, :, 1]).all(axis=2)
    meets: Flags = np.logical_and(below, below.T)
    many = meets.sum(axis=1)
    base = min(np.flatnonzero(many == many.max()).tolist(), key=lambda k: lumps[k].place)
    one, other = np.nonzero(meets)
    close = [
        (i, j)
        for i, j in zip(one.tolist(), other.tolist(), strict=True)
        if i < j and base not in (i, j) and not _are_apart(lumps[i], lumps[j])
    ]
    ends = np.array(close, np.intp).reshape(-1, 2)
    _, number = connected_pieces(ends[:, 0], ends[:, 1], len(lumps))
    pieces: dict[int, list[Lump]] = {}
    for k, lump in enumerate(lumps):
        if k != base:
            pieces.setdefault(int(number[k]), []).append(lump)
    return base, [tuple(piece) for piece in pieces.values()]


def _grouped(base: Lump, pieces: list[Piece]) -> list[list[Piece]]:
    """Put small pieces into groups: few, as each costs the base once more, and none large.

    Sizes are told by powers of two, so that a piece that changes a little seldom moves others into
    another group, which would have to be united anew.
    """
    sizes = [
        2.0 ** round(np.log2(sum(lump.manifold.num_tri() for lump in piece))) for piece in pieces
    ]
    enough = np.sqrt(sum(sizes) * base.manifold.num_tri())
    groups: list[list[Piece]] = []
    full = enough
    for piece, size in zip(pieces, sizes, strict=True):
        if full >= enough:
            groups.append([])
            full = 0.0
        groups[-1].append(piece)
        full += size
    return groups


@remembered(limit=1024, key=lambda one, other: (one.held, other.held))
def _are_apart(one: Lump, other: Lump) -> bool:
    """Whether two solids with boxes that meet surely do not: one has no face where they meet.

    A box that reaches beyond another is outside of that solid there, and so is all of it that no
    face of the solid passes through.
    """
    boxes = one.box, other.box
    if any((b[0] < a[0]).all() and (a[1] < b[1]).all() for a, b in (boxes, boxes[::-1])):
        return False
    low, high = np.maximum(*(box[0] for box in boxes)), np.minimum(*(box[1] for box in boxes))
    for lump in (one, other):
        surface = lump.shown()
        corners = surface.vertices[surface.faces]
        within = (corners.min(axis=1) <= high) & (corners.max(axis=1) >= low)
        if not within.all(axis=1).any():
            return True
    return False


def _put_together(base: Lump, pieces: list[Piece]) -> UnionMesh | None:
    """Put the changes by all pieces into a base; None where that is not closed."""
    mesh = _numbered(base.held)[1]
    count = len(mesh.vertices)
    groups = _grouped(base, pieces)
    changes = [_change(base, tuple(lump for piece in group for lump in piece)) for group in groups]
    known = [change for change in changes if change is not None]
    if len(known) < len(changes):
        return None
    touches = np.zeros((len(known), len(mesh.faces)), dtype=bool)
    for row, change in zip(touches, known, strict=True):
        row[change.touched] = True
    shared = touches.sum(axis=0) > 1
    points = np.concatenate([change.vertices for change in known])
    faces, numbers, borders, cut = [], [], [], []
    first = count
    for change in known:
        shift = first - count
        first += len(change.vertices)
        faces.append(_shifted(change.faces, count, shift))
        numbers.append(change.numbers)
        borders.append(_shifted(change.border, count, shift))
        own = ~shared[change.origins]
        cut.append((_shifted(change.pieces[own], count, shift), change.origins[own]))
    for change, mine in _shared_changes(base, groups, touches, shared):
        at = found(change.vertices, points) if len(points) else np.zeros(0, np.intp)
        rows = change.pieces[mine]
        new = rows >= count
        places = at[np.where(new, rows - count, 0)] if len(at) else rows
        if (places[new] < 0).any():
            return None
        cut.append((np.where(new, count + places, rows), change.origins[mine]))
    touched = touches.any(axis=0)
    left, origins = (np.concatenate(column) for column in zip(*cut, strict=True))
    if not _is_closed(np.concatenate(borders), left, mesh.faces[touched].astype(np.intp), first):
        return None
    every = np.concatenate([mesh.faces[~touched].astype(np.intp), left, *faces])
    used = np.zeros(first, dtype=bool)
    used[every] = True
    rank = np.cumsum(used, dtype=np.int32) - np.int32(1)
    return UnionMesh(
        np.concatenate([mesh.vertices, points])[used],
        rank[every],
        np.concatenate([mesh.numbers[~touched], mesh.numbers[origins], *numbers]),
    )


def _shared_changes(
    base: Lump, groups: list[list[Piece]], touches: Flags, shared: Flags
) -> Iterator[tuple[_Change, Flags]]:
    """Return for faces that several groups cut what all of these leave of them.

    Only the pieces near such faces are looked at. With each comes which of its pieces (p,)
    count.
    """
    mesh = _numbered(base.held)[1]
    at = np.flatnonzero(shared)
    if not len(at):
        return
    sets, number = np.unique(touches[:, at], axis=1, return_inverse=True)
    for k, members in enumerate(sets.T):
        faces = at[number.ravel() == k]
        corners = mesh.vertices[mesh.faces[faces]].reshape(-1, 3)
        box = np.stack([corners.min(axis=0), corners.max(axis=0)])
        near = tuple(
            lump
            for group in np.flatnonzero(members)
            for piece in groups[group]
            if any(meet(lump.box, box) for lump in piece)
            for lump in piece
        )
        change = _change(base, near)
        if change is not None:
            yield change, np.isin(change.origins, faces)


def _shifted(rows: Index, count: int, shift: int) -> Index:
    """Return indices of which those from a count on are moved on."""
    return np.where(rows >= count, rows + shift, rows)


def _is_closed(border: Index, left: Index, before: Index, count: int) -> bool:
    """Whether faces with a border and pieces are bounded as the faces were that they replace."""
    ends = [border]
    for rows in (left, before[:, ::-1]):
        ends.append(np.stack([rows.ravel(), np.roll(rows, -1, axis=1).ravel()], axis=1))
    a, b = np.concatenate(ends).T
    return bool(np.array_equal(np.sort(a * count + b), np.sort(b * count + a)))


@remembered(limit=64)
def _numbered(held: Held) -> tuple[Manifold, UnionMesh]:
    """Return a solid whose faces keep their numbers, and its mesh."""
    import manifold3d

    mesh = mesh_of(held.manifold)
    numbered = manifold3d.Mesh64(
        mesh.vertices,
        mesh.faces.astype(np.uint64),
        face_id=np.arange(len(mesh.faces), dtype=np.uint64),
    )
    return manifold3d.Manifold(numbered), mesh


@remembered(limit=256, key=lambda base, group: (base.held, tuple(lump.held for lump in group)))
def _change(base: Lump, group: tuple[Lump, ...]) -> _Change | None:
    """Return what uniting a base with a group changes; None where that is not sound."""
    solid, before = _numbered(base.held)
    whole = united(group, solid)
    if whole is None:
        return None
    own = int(solid.to_mesh64().run_original_id[0])
    after, count = mesh_of(whole), len(before.vertices)
    parents = found(after.vertices, before.vertices)
    new = parents < 0
    place = np.where(new, count + np.cumsum(new) - 1, parents)
    faces = _turned(place[after.faces])
    mine = after.numbers == own
    pieces, origins = faces[mine], np.array(whole.to_mesh64().face_id, dtype=np.intp)[mine]
    same = (pieces == _turned(before.faces.astype(np.intp))[origins]).all(axis=1)
    touched = np.ones(len(before.faces), dtype=bool)
    touched[origins[same]] = False
    faces = faces[~mine]
    return _Change(
        after.vertices[new],
        faces,
        after.numbers[~mine],
        border_edges(faces, count + len(after.vertices)),
        pieces[~same],
        origins[~same],
        np.flatnonzero(touched),
    )


def _turned(faces: Index) -> Index:
    """Return faces that begin with their least corner."""
    first = faces.argmin(axis=1)
    return np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)
