"""Triangles of plane faces, and what can be counted and measured with them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.geometry import triangulate
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.solid.face_rings import (
    edges_of,
    flat_rings,
    hanging_rings,
    inside_face,
    signed_volume,
    tangents,
)
from bozzetto_polyhedron.solid.planar_body import PlanarBody

CONVEX: Final = 1e-6
"""Sine of the least turn at a corner of a face that is triangulated as a fan."""


def triangles_of(body: PlanarBody) -> tuple[Index, Index]:
    """Triangulate all faces over the vertices of a body.

    Parameters
    ----------
    body : PlanarBody
        Its rings may not cross.

    Returns
    -------
    triangles : (t, 3) intp
        Numbers of vertices, counter-clockwise seen from outside.
    faces : (t,) intp
        The face that each one lies in.

    Raises
    ------
    UserError
        If the rings of a face cross.
    """
    made, owners = [], []
    for number, (face, normal) in enumerate(zip(body.faces, body.normals, strict=True)):
        found = face_triangles(body.vertices, face, normal)
        made.append(found)
        owners.append(np.full(len(found), number, np.intp))
    if not made:
        return np.zeros((0, 3), np.intp), np.zeros(0, np.intp)
    return np.concatenate(made), np.concatenate(owners)


def face_triangles(vertices: Array, face: Rings, normal: Array) -> Index:
    """Triangulate one face, holes left out; numbers of vertices, (t, 3)."""
    numbers = np.array([v for ring in face for v in ring], np.intp)
    outer, *holes = flat_rings(vertices, face, normal)
    if not holes and _is_convex(outer):
        fan = np.arange(1, len(numbers) - 1)
        return np.stack((np.broadcast_to(numbers[0], len(fan)), numbers[fan], numbers[fan + 1]), 1)
    try:
        found = triangulate(outer, tuple(holes))
    except ValueError as problem:
        raise UserError(
            "Lines of a face cross one another. Choose another answer, or draw them again."
        ) from problem
    corners = found.points[found.triangles]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    clockwise = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] < 0
    triangles = np.where(clockwise[:, None], found.triangles[:, ::-1], found.triangles)
    return np.asarray(numbers[triangles])


def _is_convex(ring: Array) -> bool:
    """Whether a ring turns to the left at every corner, and once round in all."""
    sides = np.roll(ring, -1, axis=0) - ring
    ahead = np.roll(sides, -1, axis=0)
    turn = sides[:, 0] * ahead[:, 1] - sides[:, 1] * ahead[:, 0]
    if not (turn > CONVEX * np.linalg.norm(sides, axis=1) * np.linalg.norm(ahead, axis=1)).all():
        return False
    angles = np.arctan2(turn, (sides * ahead).sum(axis=1))
    return bool(angles.sum() < 3.0 * np.pi)


def volume_of(body: PlanarBody) -> float:
    """Return the volume of a closed body, mm³; 0 for a sheet."""
    return signed_volume(body.vertices, body.faces) if body.closed else 0.0


def genus_of(body: PlanarBody) -> int | None:
    """Return the number of through-holes of a closed body; None for a sheet.

    By the formula of Euler and Poincaré: V − E + F − (L − F) = 2 (S − G), where L counts rings,
    those that touch as one, and S the connected surfaces.
    """
    if not body.closed:
        return None
    edges = edges_of(body.faces)
    rings = sum(hanging_rings(face) for face in body.faces)
    count = len(np.unique(edges)) - len(edges) + 2 * len(body.faces) - rings
    return len(shells_of(body.faces)) - count // 2


def shells_of(faces: Sequence[Rings]) -> list[list[int]]:
    """Return the connected surfaces of faces, each as numbers of faces that share vertices."""
    leader = list(range(len(faces)))

    def find(number: int) -> int:
        while leader[number] != number:
            number = leader[number]
        return number

    first: dict[int, int] = {}
    for number, face in enumerate(faces):
        for vertex in (v for ring in face for v in ring):
            one, two = find(first.setdefault(vertex, number)), find(number)
            leader[max(one, two)] = min(one, two)
    groups: dict[int, list[int]] = {}
    for number in range(len(faces)):
        groups.setdefault(find(number), []).append(number)
    return list(groups.values())


def within_face(body: PlanarBody, number: int, points: Array) -> Flags:
    """Whether points in the plane of a face lie within it, (n,)."""
    rings = flat_rings(body.vertices, body.faces[number], body.normals[number])
    return inside_face(rings, flat_points(body, number, points))


def flat_points(body: PlanarBody, number: int, points: Array) -> Array:
    """Return points in the coordinates of a face's plane, as `flat_rings` has them, (n, 2)."""
    origin = body.vertices[body.faces[number][0][0]]
    return np.asarray((points - origin) @ tangents(body.normals[number]).T)
