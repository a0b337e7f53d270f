"""Triangles of faces whose inner sides are nobody else's.

A side inside one face may join the same two vertices as one inside another: across a pole, say,
or the diagonals of two faces with the same corners. Four triangles would meet there then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array, Index

if TYPE_CHECKING:
    from bozzetto.geometry.brep.surface import BSplineSurface


@dataclass(frozen=True, eq=False)
class FaceTriangles:
    """The triangles of one face.

    Attributes
    ----------
    parameters : (n, 2) float
        u and v of the corners.
    vertices : (n,) int
        Which vertex of the whole each corner is. On a seam and at a pole several are one.
    triangles : (t, 3) int
        Numbers of corners, counter-clockwise seen from outside.
    """

    parameters: Array
    vertices: Index
    triangles: Index


def with_single_sides(
    vertices: Array, faces: Sequence[FaceTriangles], surfaces: Sequence[BSplineSurface]
) -> tuple[Array, list[FaceTriangles]]:
    """Return vertices and triangles of faces in which no side is one of more than two triangles.

    Parameters
    ----------
    vertices : (n, 3) float
        Of all faces, mm.
    faces : sequence of FaceTriangles
        Closed against one another but for such sides.
    surfaces : sequence of BSplineSurface
        That of each face, on which sides are halved.

    Returns
    -------
    vertices : (m, 3) float
        Those given, and behind them the middles of sides that had to be halved.
    faces : list of FaceTriangles
        As they were, where nothing had to be done.
    """
    made = list(faces)
    crowded = _crowded_sides(made, len(vertices))
    if not crowded:
        return vertices, made
    added: list[Array] = []
    direct = set()
    for number, (face, surface) in enumerate(zip(faces, surfaces, strict=True)):
        for side in sorted(crowded & _inner_sides(face)):
            if side not in direct and not _is_border(side, faces):
                direct.add(side)  # one may stay as it is
                continue
            made[number], place = _halved(made[number], surface, side, len(vertices) + len(added))
            added.append(place)
    return np.concatenate((vertices, *added)), made


def _crowded_sides(faces: Sequence[FaceTriangles], count: int) -> set[tuple[int, int]]:
    """Return the sides, as pairs of vertices, of more than two triangles."""
    keys = np.concatenate([np.sort(_sides(face), axis=1) @ (count, 1) for face in faces])
    known, uses = np.unique(keys, return_counts=True)
    return {divmod(key, count) for key in known[uses > 2].tolist()}


def _sides(face: FaceTriangles) -> Index:
    """Return the sides of all triangles as pairs of vertices, (3 t, 2)."""
    rows = face.vertices[face.triangles]
    return np.concatenate([rows[:, [k, (k + 1) % 3]] for k in range(3)])


def _inner_sides(face: FaceTriangles) -> set[tuple[int, int]]:
    sides, uses = np.unique(np.sort(_sides(face), axis=1), axis=0, return_counts=True)
    return {(a, b) for a, b in sides[uses == 2].tolist()}


def _is_border(side: tuple[int, int], faces: Sequence[FaceTriangles]) -> bool:
    """Whether a side is on the border of some face."""
    return any(
        int((np.sort(_sides(face), axis=1) == side).all(axis=1).sum()) == 1 for face in faces
    )


def _halved(
    face: FaceTriangles, surface: BSplineSurface, side: tuple[int, int], number: int
) -> tuple[FaceTriangles, Array]:
    """Return a face with an inner side halved, and the place of its middle, (1, 3)."""
    rows = face.triangles.tolist()
    corners = face.parameters.tolist()
    kept, found = [], []
    for row in rows:
        own = [int(face.vertices[corner]) for corner in row]
        first = next((k for k in range(3) if {own[k], own[k - 2]} == set(side)), None)
        if first is None:
            kept.append(row)
        else:
            found.append((row[first], row[first - 2], row[first - 1]))
    for a, b, c in found:  # at a pole the corners of both triangles differ
        middle = len(corners)
        corners.append([0.5 * (x + y) for x, y in zip(corners[a], corners[b], strict=True)])
        kept += [[a, middle, c], [middle, b, c]]
    parameters = np.array(corners)
    place = surface.value(*parameters[[len(face.parameters)]].T)
    names = np.append(face.vertices, np.full(len(found), number))
    return FaceTriangles(parameters, names, np.array(kept, np.intp)), place
