"""The edges of meshes that a line drawing shows: rims, creases, and outlines of a view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.exchange.cad.cad_curves import SHARES_OF_SPAN, checked_curves, points_on
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import Curve, Shapes, Solid

CREASE: Final = float(np.cos(np.radians(30.0)))
"""Cosine of the angle above which two faces meet in an edge and not in a bend."""

SMOOTH_CREASE: Final = float(np.cos(np.radians(60.0)))
"""The same where the mesh has normals of its own: it is smooth, if coarse in thin places."""

SAME_PLACE: Final = 1e-6
"""Corners nearer than this share of the size are one: patches that meet keep theirs apart."""


@dataclass(frozen=True, eq=False)
class Net:
    """Triangles of several parts, with the edges between them; what no view changes.

    Attributes
    ----------
    points : (v, 3) float
        mm.
    faces : (f, 3) int
    part : (f,) int
        To which part each triangle belongs.
    closed : (f,) bool
        Whether that part is a solid: its back is never seen.
    edges : (e, 2) int
        Pairs of points.
    sides : (e, 2) int
        The faces at each edge; −1 where there is none.
    sharp : (e,) bool
        Rims and creases: edges in every view.
    names : tuple of str
        Of the parts, and then of the wires.
    wires : (w, 2) int
        Pairs of points that are joined by drawn curves.
    wire : (w,) int
        The name of each.
    """

    points: Array
    faces: Index
    part: Index
    closed: Flags
    edges: Index
    sides: Index
    sharp: Flags
    names: tuple[str, ...]
    wires: Index
    wire: Index


def net_of(shapes: Shapes) -> Net:
    """Return the triangles of shapes as one net.

    Solids that pass through one another are united, so that lines are drawn where they meet.

    Parameters
    ----------
    shapes : Shapes
        Without exact surfaces; see `bozzetto.geometry.meshed`.
    """
    pieces = _united(shapes.solids) + [
        (part.mesh, np.full(len(part.mesh.faces), len(shapes.solids) + k))
        for k, part in enumerate(shapes.surfaces)
    ]
    places, faces, parts = [np.zeros((0, 3))], [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    for mesh, part in pieces:
        start = sum(map(len, places))
        places.append(mesh.vertices.astype(np.float64))
        faces.append(mesh.faces.astype(np.int64) + start)
        parts.append(np.asarray(part, np.int64))
    points, corners, part = np.concatenate(places), np.concatenate(faces), np.concatenate(parts)
    points, corners = _welded(points, corners, part)
    a, b, c = corners.T
    proper = (a != b) & (b != c) & (c != a)
    corners, part = corners[proper], part[proper]
    edges, sides, crowded = _edges(corners)
    normals = _normals(points, corners)
    smooth = np.array([one.mesh.normals is not None for one in shapes.meshes()], bool)
    limit = np.where(smooth[part], SMOOTH_CREASE, CREASE)[sides[:, 0]]
    rim = (sides < 0).any(axis=1)
    bend = np.einsum("ij,ij->i", normals[sides[:, 0]], normals[sides[:, 1]])
    names = tuple(one.name for one in (*shapes.meshes(), *shapes.curves))
    closed = part < len(shapes.solids)
    sharp = rim | crowded | (bend < limit)
    wired, wires, wire = _wires(shapes, len(points), len(names) - len(shapes.curves))
    points = np.concatenate((points, wired))
    return Net(points, corners, part, closed, edges, sides, sharp, names, wires, wire)


def _wires(shapes: Shapes, begin: int, name: int) -> tuple[Array, Index, Index]:
    """Return the points of drawn curves, pairs of them, and the number of each pair's name."""
    pieces = [checked_curves(Shapes(curves=(curve,))) for curve in shapes.curves]
    rows = [_polyline(piece) for own in pieces for piece in own]
    whose = np.repeat(np.arange(len(pieces)), [len(own) for own in pieces])
    starts = begin + np.cumsum([0, *map(len, rows)])
    pairs = [
        np.column_stack((np.arange(len(row) - 1), np.arange(1, len(row)))) + start
        for row, start in zip(rows, starts, strict=False)
    ]
    counts = [len(pair) for pair in pairs]
    return (
        np.concatenate([np.zeros((0, 3)), *rows]),
        np.concatenate([np.zeros((0, 2), np.int64), *pairs]),
        np.repeat(name + whose, counts),
    )


def _polyline(piece: Curve) -> Array:
    """Return points along a curve, in their order."""
    by_share = points_on(piece).reshape(len(SHARES_OF_SPAN), -1, 3)
    return by_share.swapaxes(0, 1).reshape(-1, 3)


def _united(solids: Sequence[Solid]) -> list[tuple[Mesh, Index]]:
    """Return the skins of solids, and for each triangle whose it is."""
    alone = [(one.mesh, np.full(len(one.mesh.faces), k)) for k, one in enumerate(solids)]
    if len(solids) < 2 or not _touch(solids):
        return alone
    import manifold3d

    made, owners = [], {}
    for number, solid in enumerate(solids):
        mesh = solid.mesh
        one = manifold3d.Manifold(
            manifold3d.Mesh(np.array(mesh.vertices, np.float32), np.array(mesh.faces, np.uint32))
        ).as_original()
        if one.status() != manifold3d.Error.NoError:
            return alone
        owners[one.original_id()] = number
        made.append(one)
    whole = manifold3d.Manifold.batch_boolean(made, manifold3d.OpType.Add).to_mesh()
    starts = np.asarray(whole.run_index, np.int64) // 3
    owner = [owners[int(number)] for number in whole.run_original_id]
    part = np.repeat(np.array(owner, np.int64), np.diff(starts))
    return [(Mesh(whole.vert_properties[:, :3], whole.tri_verts), part)]


def _touch(solids: Sequence[Solid]) -> bool:
    """Whether the boxes of two solids overlap."""
    low, high = np.stack([solid.mesh.bounds for solid in solids], axis=1)
    over = (low[:, None] <= high[None]).all(axis=2)
    over &= over.T
    return bool(over.sum() > len(solids))


def _welded(points: Array, faces: Index, part: Index) -> tuple[Array, Index]:
    """Make one point of all corners of a part that are at one place."""
    if not len(faces):
        return points, faces
    grain = SAME_PLACE * max(float(np.ptp(points, axis=0).max()), 1e-9)
    whose = np.zeros(len(points), np.int64)
    whose[faces.ravel()] = np.repeat(part, 3)
    cells = np.column_stack((np.rint(points / grain).astype(np.int64), whose))
    _, first, inverse = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    return points[first], inverse.ravel()[faces]


def _edges(faces: Index) -> tuple[Index, Index, Flags]:
    """Return edges, the two faces at each, and which have more than two."""
    pairs = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2)
    span = int(faces.max()) + 1 if len(faces) else 1
    keys = pairs.min(axis=1) * span + pairs.max(axis=1)
    known, first, inverse, count = np.unique(
        keys, return_index=True, return_inverse=True, return_counts=True
    )
    owner = np.repeat(np.arange(len(faces)), 3)
    sides = np.full((len(known), 2), -1)
    sides[:, 0] = owner[first]
    later = np.ones(len(keys), bool)
    later[first] = False
    sides[inverse.ravel()[later], 1] = owner[later]
    return np.column_stack(np.divmod(known, span)), sides, count > 2


def _normals(points: Array, faces: Index) -> Array:
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(np.divide(across, length, out=np.zeros_like(across), where=length > 0))
