"""Part of a body under a place of the sheet: a corner, an edge, or a face.

The first three cases of Masry et al. 2004, "Adding strokes", in their order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.view import Camera
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import within_face
from bozzetto_polyhedron.solid.visibility import EdgePieces, visible_pieces

Case = Literal["corner", "edge", "face", "free"]

UNSEEN: Final = 0.4
"""Share of the reach within which an edge is met that faces hide."""


@dataclass(frozen=True, eq=False)
class Met:
    """Part of a body under a place of the sheet.

    Parameters
    ----------
    point : (3,) float64
        mm.
    case : {"corner", "edge", "face"}
    number : int
        Of the vertex, of the edge in `face_rings.edges_of`, or of the face.
    faces : tuple of int
        The faces that the point lies in.
    """

    point: Array
    case: Case
    number: int
    faces: tuple[int, ...]


def met_by(body: PlanarBody, camera: Camera, place: ArrayLike, reach: float) -> Met | None:
    """Return the corner, else the edge, else the face of a body under a place of the sheet.

    Parameters
    ----------
    body : PlanarBody
        What is drawn on.
    camera : Camera
        Through which it is seen.
    place : (2,) array_like
        Canvas px.
    reach : float
        Distance within which corners and edges are met, px.
    """
    pieces = visible_pieces(body, camera)
    point, case, number = hit_by(
        body, body.vertices, camera, pieces, np.asarray(place, float), reach
    )
    if case == "free":
        return None
    if case == "face":
        return Met(point, case, number, (number,))
    ends = {number} if case == "corner" else set(edges_of(body.faces)[number].tolist())
    faces = [k for k, face in enumerate(body.faces) if any(ends <= set(ring) for ring in face)]
    return Met(point, case, number, tuple(faces))


def hit_by(
    body: PlanarBody,
    corners: Array,
    camera: Camera,
    pieces: EdgePieces,
    place: Array,
    reach: float,
) -> tuple[Array, Case, int]:
    """Return the point of the body under a place of the sheet, by the first three cases."""
    corner = _corner_at(body, corners, camera, pieces, place, reach)
    if corner is not None:
        return corners[corner], "corner", corner
    edge = _edge_at(pieces, camera, place, reach)
    if edge is not None:
        return edge[0], "edge", edge[1]
    hit = face_under(body, camera, place)
    if hit is not None:
        return hit[0], "face", hit[1]
    return np.full(3, np.nan), "free", -1


def _corner_at(
    body: PlanarBody,
    corners: Array,
    camera: Camera,
    pieces: EdgePieces,
    place: Array,
    reach: float,
) -> int | None:
    """Return the nearest corner within reach; one that is seen before one that is hidden."""
    pixels, _ = camera.project(corners)
    count = len(body.vertices)
    used = np.concatenate((np.unique(pieces.edges), np.arange(count, len(corners))))
    apart = np.linalg.norm(pixels[used] - place, axis=1)
    near = [(int(v), float(d)) for v, d in zip(used, apart, strict=True) if d < reach]
    if not near:
        return None
    seen = pieces.ends[~pieces.hidden].reshape(-1, 3)
    size = float(np.abs(body.vertices).max())
    return min(
        near,
        key=lambda item: (
            item[0] < count
            and not (np.abs(seen - corners[item[0]]).max(axis=1) < 1e-9 * size).any(),
            item[1],
        ),
    )[0]


def _edge_at(
    pieces: EdgePieces, camera: Camera, place: Array, reach: float
) -> tuple[Array, int] | None:
    """Return the point along the nearest edge within reach, seen edges first, and its number."""
    places, depth = camera.project(pieces.ends.reshape(-1, 3))
    places, depth = places.reshape(-1, 2, 2), depth.reshape(-1, 2)
    along = places[:, 1] - places[:, 0]
    length = np.maximum((along**2).sum(axis=1), 1e-300)
    share = np.clip(((place - places[:, 0]) * along).sum(axis=1) / length, 0.0, 1.0)
    apart = np.linalg.norm(places[:, 0] + share[:, None] * along - place, axis=1)
    near = np.flatnonzero(apart < np.where(pieces.hidden, UNSEEN * reach, reach))
    if not len(near):
        return None
    best = int(min(near, key=lambda k: (bool(pieces.hidden[k]), float(apart[k]))))
    at = float(share[best])
    if camera.kind == "perspective":
        at = at * depth[best, 0] / ((1 - at) * depth[best, 1] + at * depth[best, 0])
    start, end = pieces.ends[best]
    return start + at * (end - start), int(pieces.edge[best])


def face_under(body: PlanarBody, camera: Camera, place: ArrayLike) -> tuple[Array, int] | None:
    """Return where the ray through a place first meets a face, and which; None beside the body."""
    rays = camera.rays(np.reshape(np.asarray(place, float), (1, 2)))
    origin, sight = rays.origins[0], rays.directions[0]
    nearest: tuple[float, Array, int] | None = None
    for number, (normal, offset) in enumerate(zip(body.normals, body.offsets, strict=True)):
        slope = float(normal @ sight)
        if abs(slope) < 1e-9:
            continue
        along = float(offset - normal @ origin) / slope
        if camera.kind == "perspective" and along <= 0:
            continue
        if nearest is not None and along >= nearest[0]:
            continue
        point = origin + along * sight
        if within_face(body, number, point[None])[0]:
            nearest = along, point, number
    return None if nearest is None else nearest[1:]
