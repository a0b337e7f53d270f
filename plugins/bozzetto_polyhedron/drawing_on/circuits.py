"""Lines that were added to a body and close: their faces, and the solids that these bound.

Faces are chosen among the planar circuits of the added lines and of the edges between them, as
those of a drawing are (Masry et al. 2004, "Adding strokes" and "Face identification"). Corners
stay in the planes of the body that they were drawn on, to the last digit.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.orientation import oriented
from bozzetto_polyhedron.reconstruction.planar_faces import planar_faces
from bozzetto_polyhedron.solid.boolean import combined, compact
from bozzetto_polyhedron.solid.face_rings import (
    area_vectors,
    bounds_volume,
    edges_of,
    sides_of,
    tangents,
)
from bozzetto_polyhedron.solid.pieces import pieces_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody, on_axis_planes
from bozzetto_polyhedron.solid.plane_fit import (
    ACCEPTED,
    PlaneFit,
    Relations,
    fitted_planes,
    incidences,
)
from bozzetto_polyhedron.solid.regularities import Regularities
from bozzetto_polyhedron.solid.triangulation import volume_of

TOLERANCES: Final = (0.02, 0.05)
"""Distances from a plane, as share of the size of the lines, that are tried one after another."""

SAME: Final = 1e-7
"""Distance, as share of the size, within which points are one, or lie on an edge or in a plane."""

ALONG: Final = np.radians(12.0)
"""Angle within which a face takes the direction of a face of the body."""

GAINED: Final = 0.01
"""Share of a solid that must stick out of the body for it to be joined to it; what lies inside is
cut out."""

LEAST_AREA: Final = 1e-4
"""Area of a face, as share of the square of the size, below which it is none."""


def with_lines(before: Changed, points: Array, lines: Index) -> Changed:
    """Return a body with lines added to it.

    Where they bound a volume it is joined to the body, or cut out of it where it lies inside.
    Where they bound faces only, these are a sheet beside it.

    Parameters
    ----------
    before : Changed
        With the lines that were added earlier and are left.
    points : (k, 3) float
        Ends of new lines, mm.
    lines : (m, 2) int
        Their numbers.
    """
    points = np.concatenate((before.points, points))
    lines = np.concatenate((before.lines, np.asarray(lines) + len(before.points)))
    points, lines = _merged(points, lines, _size(before.body))
    left = replace(before, points=points, lines=lines, sheet=None)
    every = _with_edges(before.body, points, lines)
    if len(every) < 3:
        return left
    low, size = points.min(axis=0), float(np.linalg.norm(np.ptp(points, axis=0)))
    sheet: PlanarBody | None = None
    for tolerance in TOLERANCES:
        faces = planar_faces((points - low) / size, every, tolerance)
        faces = _with_added_sides(faces, lines)
        if not faces:
            continue
        made = _on_planes(before.body, points, oriented(points, faces))
        if made is None:
            continue
        if made.closed:
            return _united(left, made, faces)
        sheet = sheet or made
    return replace(left, sheet=None if sheet is None else compact(sheet))


def _size(body: PlanarBody) -> float:
    return float(np.linalg.norm(np.ptp(body.vertices, axis=0)))


def _merged(points: Array, lines: Index, size: float) -> tuple[Array, Index]:
    """Return points with those at one place made one, and lines each once."""
    leader = np.arange(len(points))
    for number in range(len(points)):
        near = np.flatnonzero(
            np.linalg.norm(points[:number] - points[number], axis=1) < SAME * size
        )
        if len(near):
            leader[number] = leader[near[0]]
    kept, numbers = np.unique(leader, return_inverse=True)
    lines = np.unique(np.sort(numbers[lines], axis=1), axis=0)
    return points[kept], lines[lines[:, 0] != lines[:, 1]]


def _with_edges(body: PlanarBody, points: Array, lines: Index) -> Index:
    """Return lines with the pieces of the body's edges that run from one point to the next."""
    slack = SAME * _size(body)
    pieces = []
    for edge in edges_of(body.faces):
        start, end = body.vertices[edge]
        along = end - start
        length = float(np.linalg.norm(along))
        at = (points - start) @ along / length
        apart = np.linalg.norm(points - start - np.outer(at / length, along), axis=1)
        on = np.flatnonzero((apart < slack) & (at > -slack) & (at < length + slack))
        order = on[np.argsort(at[on])]
        pieces += [(min(a, b), max(a, b)) for a, b in pairwise(order)]
    return np.unique(np.concatenate((lines, np.array(pieces, np.intp).reshape(-1, 2))), axis=0)


def _with_added_sides(faces: tuple[Rings, ...], lines: Index) -> tuple[Rings, ...]:
    """Return the faces that have an added line."""
    added = {(int(a), int(b)) for a, b in lines}
    return tuple(
        face
        for face in faces
        if any((min(s), max(s)) in added for ring in face for s in sides_of(ring))
    )


def _on_planes(body: PlanarBody, points: Array, faces: tuple[Rings, ...]) -> PlanarBody | None:
    """Return faces in exact planes, with corners in the planes of the body that they lie in.

    Planes of the body are held; faces that look nearly as one of them do so exactly. None where
    no planes go through the corners.
    """
    middle, size = points.mean(axis=0), float(np.linalg.norm(np.ptp(points, axis=0)))
    local = (points - middle) / size
    held_at = (body.offsets - body.normals @ middle) / size
    touching = np.abs(local @ body.normals.T - held_at) < SAME * max(1.0, _size(body) / size)
    areas = area_vectors(local, faces)
    lengths = np.linalg.norm(areas, axis=1)
    if (lengths < LEAST_AREA).any():
        return None
    drawn = areas / lengths[:, None]
    for snaps in (True, False):
        fit = _fit(local, faces, drawn, body.normals, (held_at, touching), snaps)
        turned = (area_vectors(fit.vertices, faces) * drawn).sum(axis=1)
        if fit.violation <= ACCEPTED and (turned > 0).all():
            break
    else:
        return None
    count = len(faces)
    normals = fit.normals[:count]
    made = PlanarBody(
        fit.vertices * size + middle,
        faces,
        normals,
        fit.offsets[:count] * size + normals @ middle,
        bounds_volume(faces),
        body.frame,
    )
    return on_axis_planes(_exactly_on(made, body))


def _fit(
    local: Array,
    faces: tuple[Rings, ...],
    drawn: Array,
    held: Array,
    heights: tuple[Array, Flags],
    snaps: bool,
) -> PlaneFit:
    """Fit planes to corners, with those planes of the body held that corners lie in."""
    held_at, touching = heights
    count = len(faces)
    cosines = drawn @ held.T
    nearest = np.abs(cosines).argmax(axis=1)
    cosine = cosines[np.arange(count), nearest]
    inside = np.array([touching[[v for ring in face for v in ring]].all(axis=0) for face in faces])
    nearest = np.where(inside.any(axis=1), inside.argmax(axis=1), nearest)
    cosine = cosines[np.arange(count), nearest]
    snapped = inside.any(axis=1) | (snaps & (np.abs(cosine) > np.cos(ALONG)))
    used = np.unique([v for face in faces for ring in face for v in ring])
    met = np.flatnonzero(touching[used].any(axis=0))
    every = np.concatenate((drawn, held[met]))
    every[:count][snapped] = (np.sign(cosine)[:, None] * held[nearest])[snapped]
    freedom = np.zeros(len(every), np.intp)
    freedom[:count][~snapped] = 2
    turns = np.zeros((len(every), 2, 3))
    for face in np.flatnonzero(~snapped):
        turns[face] = tangents(every[face])
    regular = Regularities(every, turns, freedom, np.arange(len(every)), np.ones(len(every)), None)
    rows = np.zeros((len(met), len(every)))
    rows[np.arange(len(met)), count + np.arange(len(met))] = 1.0
    corners, planes = np.nonzero(touching[np.ix_(used, met)])
    pairs = np.stack((count + planes, used[corners]), axis=1)
    return fitted_planes(
        local,
        np.concatenate((incidences(faces), pairs)),
        regular,
        Relations(rows, held_at[met]),
    )


def _exactly_on(made: PlanarBody, body: PlanarBody) -> PlanarBody:
    """Return faces with the very numbers of the body's planes that they lie in."""
    normals, offsets = made.normals.copy(), made.offsets.copy()
    slack = SAME * _size(body)
    for face in range(len(made.faces)):
        sign = np.sign(made.normals[face] @ body.normals.T)
        apart = np.abs(made.normals[face] - sign[:, None] * body.normals).max(axis=1)
        away = np.abs(made.offsets[face] - sign * body.offsets)
        same = np.flatnonzero((apart < SAME) & (away < slack))
        if len(same):
            normals[face] = sign[same[0]] * body.normals[same[0]]
            offsets[face] = sign[same[0]] * body.offsets[same[0]]
    return replace(made, normals=normals, offsets=offsets)


def _united(left: Changed, made: PlanarBody, faces: tuple[Rings, ...]) -> Changed:
    """Return the body with solids joined to it or cut out; their lines are used up."""
    used = {(min(s), max(s)) for face in faces for ring in face for s in sides_of(ring)}
    rest = np.array(
        [line for line in left.lines.tolist() if tuple(line) not in used], np.intp
    ).reshape(-1, 2)
    body, told = left.body, left.told
    for piece in pieces_of(made):
        try:
            body = _with_solid(body, piece)
        except UserError as problem:
            told = (*told, str(problem))
            return replace(left, sheet=compact(made), told=told)
    return replace(left, body=body, lines=rest, sheet=None, told=told)


def _with_solid(body: PlanarBody, piece: PlanarBody) -> PlanarBody:
    if not body.closed:
        return _beside(body, piece)
    whole = combined(body, piece, "union")
    if volume_of(whole) - volume_of(body) > GAINED * volume_of(piece):
        return whole
    return combined(body, piece, "difference")


def _beside(body: PlanarBody, piece: PlanarBody) -> PlanarBody:
    """Refuse to join a solid to a sheet."""
    raise UserError(
        "Lines were added to a sheet: close it first, so that what is drawn on it can be joined."
    )
