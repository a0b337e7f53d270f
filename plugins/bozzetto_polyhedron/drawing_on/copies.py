"""Bodies mirrored, repeated along a stroke, and joined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import resample
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.solid.boolean import combined
from bozzetto_polyhedron.solid.face_rings import area_vectors, bounds_volume, signed_volume
from bozzetto_polyhedron.solid.face_rings import turned_over as faces_turned_over
from bozzetto_polyhedron.solid.planar_body import PlanarBody

MOST_COPIES: Final = 200
"""Copies along one stroke."""

PLANE: Final = 1e-9
"""Distance of a fourth corner from a plane, as share of the size, below which it lies in it."""


def mirrored(body: PlanarBody, normal: ArrayLike, offset: float) -> PlanarBody:
    """Return the mirror image of a body in the plane ``normal @ p == offset``.

    Parameters
    ----------
    body : PlanarBody
        A solid or a sheet.
    normal : (3,) array_like
        Of any length but 0.
    offset : float
        In the unit of the normal times mm.
    """
    reflect, shift = _reflection(normal, offset)
    normals = body.normals @ reflect
    return replace(
        body,
        vertices=body.vertices @ reflect + shift,
        faces=faces_turned_over(body.faces),
        normals=normals,
        offsets=body.offsets + normals @ shift,
    )


def mirrored_points(points: Array, normal: ArrayLike, offset: float) -> Array:
    """Return the mirror images of points (n, 3) in a plane; see `mirrored`."""
    reflect, shift = _reflection(normal, offset)
    return np.asarray(points @ reflect + shift)


def _reflection(normal: ArrayLike, offset: float) -> tuple[Array, Array]:
    """Return the matrix and the shift of a mirror image."""
    across = np.asarray(normal, float)
    length = float(np.linalg.norm(across))
    if not (np.isfinite(across).all() and length > 0 and np.isfinite(offset)):
        raise UserError("A mirror needs a plane. Choose a face or an axis.")
    across, height = across / length, offset / length
    return np.eye(3) - 2.0 * np.outer(across, across), 2.0 * height * across


def moved(body: PlanarBody, shift: ArrayLike) -> PlanarBody:
    """Return a body moved by a vector, mm."""
    by = np.asarray(shift, float)
    return replace(body, vertices=body.vertices + by, offsets=body.offsets + body.normals @ by)


def copied_along(body: PlanarBody, path: ArrayLike, count: int) -> tuple[PlanarBody, ...]:
    """Return copies at even steps along a line in space, the body itself first.

    Parameters
    ----------
    body : PlanarBody
        Stands at the beginning of the line.
    path : (n, 3) array_like
        mm.
    count : int
        How many there are in all.
    """
    points = np.asarray(path, float).reshape(-1, 3)
    if len(points) < 2 or not np.isfinite(points).all():
        raise UserError("Copies need a line to stand along. Draw one.")
    if not 1 <= count <= MOST_COPIES:
        raise UserError(f"There can be 1 to {MOST_COPIES} copies. Type another number.")
    places = np.asarray(resample(points, count=max(count, 2)))[:count]
    return tuple(moved(body, place - places[0]) for place in places)


def joined(
    first: PlanarBody, second: PlanarBody, links: Sequence[tuple[int, int]] = ()
) -> PlanarBody:
    """Join two solids: where they overlap or touch, or by strokes drawn from one to the other.

    Parameters
    ----------
    first, second : PlanarBody
        Closed.
    links : sequence of (int, int)
        For every stroke the vertex of the first and that of the second; at least three, which
        run between all corners of a face of each.

    Raises
    ------
    UserError
        If the strokes do not join two faces.
    """
    if not links:
        return combined(first, second, "union")
    bridge = _bridge(first, second, links)
    return combined(combined(first, bridge, "union"), second, "union")


def _bridge(first: PlanarBody, second: PlanarBody, links: Sequence[tuple[int, int]]) -> PlanarBody:
    """Return the solid between two faces whose corners are linked."""
    partner = dict(links)
    ring = _face_of(first, set(partner))
    if len(set(partner.values())) != len(ring) or len(partner) != len(links):
        raise UserError("Each corner needs a line of its own to the other solid.")
    _face_of(second, set(partner.values()))
    count = len(ring)
    vertices = np.concatenate(
        (first.vertices[list(ring)], second.vertices[[partner[v] for v in ring]])
    )
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    faces: list[Rings] = [
        (tuple(range(count))[::-1],),
        (tuple(range(count, 2 * count)),),
    ]
    for k in range(count):
        quad = (k, (k + 1) % count, (k + 1) % count + count, k + count)
        faces += _plane_pieces(vertices, quad, size)
    if signed_volume(vertices, faces) < 0:
        faces = list(faces_turned_over(faces))
    areas = area_vectors(vertices, faces)
    lengths = np.linalg.norm(areas, axis=1)
    if not bounds_volume(faces) or (lengths < PLANE * size * size).any():
        raise UserError("These lines enclose no solid. Draw them from corner to corner.")
    normals = areas / lengths[:, None]
    offsets = np.array(
        [normal @ vertices[face[0][0]] for face, normal in zip(faces, normals, strict=True)]
    )
    return PlanarBody(vertices, tuple(faces), normals, offsets, True)


def _face_of(body: PlanarBody, corners: set[int]) -> tuple[int, ...]:
    """Return the ring of the face that has just these corners."""
    for face in body.faces:
        if len(face) == 1 and set(face[0]) == corners:
            return face[0]
    raise UserError(
        "Draw a line from every corner of a face to a corner of the other solid's face."
    )


def _plane_pieces(vertices: Array, quad: tuple[int, ...], size: float) -> list[Rings]:
    """Return a quadrilateral as one face where it is plane, else as two triangles, bulging out."""
    a, b, c, d = vertices[list(quad)]
    normal = np.cross(b - a, c - a)
    if abs(float((d - a) @ normal)) <= PLANE * size * float(np.linalg.norm(normal)):
        return [(quad,)]
    middle = vertices.mean(axis=0)
    if np.linalg.norm((a + c) / 2 - middle) < np.linalg.norm((b + d) / 2 - middle):
        quad = (*quad[1:], quad[0])
    return [((quad[0], quad[1], quad[2]),), ((quad[0], quad[2], quad[3]),)]
