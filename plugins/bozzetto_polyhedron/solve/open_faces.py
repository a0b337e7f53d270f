"""Faces that are left out: a box without a lid."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import distances_to_polyline
from bozzetto_polyhedron.drawing_on.named_edges import GONE, at_shares, shares_of
from bozzetto_polyhedron.model.changes import Point
from bozzetto_polyhedron.model.state import Body, Opening, PolyhedronState
from bozzetto_polyhedron.solid.boolean import compact
from bozzetto_polyhedron.solid.face_rings import flat_rings, inside_face
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import face_triangles, flat_points

TURNED: Final = 0.5
"""Cosine of the angle by which a face may have turned since it was named: 60°."""

UPRIGHT: Final = np.array((0.0, 0.0, 1.0))
"""Up in the frame of the model."""

SAME_TILT: Final = 1e-6
"""Difference of the upward parts of two normals below which the higher face is the top."""


def opened(
    body: PlanarBody, drawing: Body, state: PolyhedronState
) -> tuple[PlanarBody, tuple[str, ...]]:
    """Return a body without the faces that are open, and what a person must know.

    Parameters
    ----------
    body : PlanarBody
        With all that was drawn on it, in the frame of its drawing.
    drawing : Body
        That it comes from.
    state : PolyhedronState
        That it is part of.

    Raises
    ------
    UserError
        If no face is left.
    """
    told = []
    numbers = set() if drawing.lid == "closed" else {top_of(body, drawing)}
    for opening in state.openings_of(drawing):
        face = face_named(body, opening)
        if face is None:
            told.append(f"{opening.name} is left out. Its face is gone.")
        else:
            numbers.add(face)
    if not numbers:
        return body, tuple(told)
    kept = [k for k in range(len(body.faces)) if k not in numbers]
    if not kept:
        raise UserError("All faces are open. Close one of them with “Open face”.")
    faces = tuple(body.faces[k] for k in kept)
    left = replace(
        body, faces=faces, normals=body.normals[kept], offsets=body.offsets[kept], closed=False
    )
    return compact(left), tuple(told)


def open_by(body: PlanarBody, face: int, openings: Iterable[Opening]) -> tuple[Opening, ...]:
    """Return which openings leave out a face."""
    return tuple(each for each in openings if face_named(body, each) == face)


def is_open(body: PlanarBody, face: int, drawing: Body, state: PolyhedronState) -> bool:
    """Whether a face of a body, in the frame of its drawing, is left out."""
    if drawing.lid == "open" and face == top_of(body, drawing):
        return True
    return bool(open_by(body, face, state.openings_of(drawing)))


def top_of(body: PlanarBody, drawing: Body) -> int:
    """Return the face that looks up most, the highest of those that do."""
    up = drawing.placement.inverse().directions(UPRIGHT[None])[0]
    tilts = body.normals @ (up / np.linalg.norm(up))
    most = tilts >= tilts.max() - SAME_TILT
    return int(np.argmax(np.where(most, body.offsets, -np.inf)))


def face_named(body: PlanarBody, opening: Opening) -> int | None:
    """Return the face that an opening leaves out; None where it is gone."""
    place = at_shares(body, [opening.place])
    size = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    turned = body.normals @ np.asarray(opening.normal)
    away = [
        _distance(body, number, place) if turned[number] > TURNED else np.inf
        for number in range(len(body.faces))
    ]
    best = int(np.argmin(away)) if away else -1
    return best if best >= 0 and away[best] <= GONE * size else None


def name_of(body: PlanarBody, face: int) -> tuple[Point, Point]:
    """Return a place within a face, as shares of the box around its body, and its normal.

    The place is the middle of the largest triangle of the face.
    """
    triangles = face_triangles(body.vertices, body.faces[face], body.normals[face])
    corners = body.vertices[triangles]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    largest = int(np.argmax(np.linalg.norm(np.cross(first, second), axis=1)))
    return _point(shares_of(body, corners[largest].mean(axis=0))), _point(body.normals[face])


def _distance(body: PlanarBody, face: int, place: Array) -> float:
    """Return how far a place, (1, 3), is from a face, mm."""
    normal = body.normals[face]
    height = float(place[0] @ normal - body.offsets[face])
    flat = flat_points(body, face, place - height * normal)
    rings = flat_rings(body.vertices, body.faces[face], normal)
    if inside_face(rings, flat)[0]:
        return abs(height)
    beside = min(
        float(distances_to_polyline(flat, np.concatenate((ring, ring[:1])))[0]) for ring in rings
    )
    return float(np.hypot(height, beside))


def _point(row: Array) -> Point:
    x, y, z = (float(value) for value in np.reshape(row, 3))
    return x, y, z
