"""A closed loop on a face, pushed in, pulled out or through.

The result is a pure function of the loop and the depth, so that a drag shows it live.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_polyhedron.solid.boolean import combined
from bozzetto_polyhedron.solid.face_rings import are_simple, area_vector, tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody

LEAST_DEPTH: Final = 1e-4
"""Depth, as share of the size of the body, below which nothing is pushed."""

BEYOND: Final = 1.1
"""How far a tunnel is cut, in sizes of the body: beyond its other side, wherever that is."""


def pushed(body: PlanarBody, face: int, loop: ArrayLike, depth: float) -> PlanarBody:
    """Push a loop into a face, or pull it out.

    Parameters
    ----------
    body : PlanarBody
        A closed one.
    face : int
        The face that the loop lies on.
    loop : (n, 3) array_like
        Corners, mm; laid into the plane of the face.
    depth : float
        mm; positive pulls out, negative pushes in, and minus infinity cuts through.

    Returns
    -------
    PlanarBody
        The same body where the depth is nearly none.

    Raises
    ------
    UserError
        If the loop crosses itself or encloses no area, the body is a sheet, or nothing is left.
    """
    size = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    if np.isnan(depth) or depth == np.inf:
        raise UserError("A push needs a depth. Drag the loop in or out.")
    if abs(depth) < LEAST_DEPTH * size:
        return body
    reach = max(depth, -BEYOND * size)
    normal, offset = body.normals[face], float(body.offsets[face])
    tool = prism_on(normal, offset, loop, reach)
    return combined(body, tool, "union" if reach > 0 else "difference")


def prism_on(normal: Array, offset: float, loop: ArrayLike, depth: float) -> PlanarBody:
    """Return the straight prism over a loop in a plane.

    Parameters
    ----------
    normal : (3,) float
        Unit normal of the plane.
    offset : float
        Of the plane, mm.
    loop : (n, 3) array_like
        Corners, mm; either way round.
    depth : float
        mm along the normal; may be negative.

    Raises
    ------
    UserError
        If the loop crosses itself or encloses no area.
    """
    corners = np.asarray(loop, float).reshape(-1, 3)
    if len(corners) < 3 or not np.isfinite(corners).all():
        raise UserError("A loop needs at least three corners. Draw its lines until they close.")
    corners = corners + np.multiply.outer(offset - corners @ normal, normal)
    flat = (corners - corners[0]) @ tangents(normal).T
    if not are_simple([flat]):
        raise UserError("The loop crosses itself. Draw it again.")
    if (area_vector(corners) @ normal > 0) != (depth > 0):
        corners = corners[::-1]
    count = len(corners)
    side = normal * depth
    vertices = np.concatenate((corners, corners + side))
    ahead = np.roll(corners, -1, axis=0) - corners
    out = np.cross(ahead, normal if depth > 0 else -normal)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    end = float(np.sign(depth))
    base = tuple(range(count))
    walls = [((k, (k + 1) % count, (k + 1) % count + count, k + count),) for k in range(count)]
    return PlanarBody(
        vertices,
        ((base[::-1],), (tuple(k + count for k in base),), *walls),
        np.vstack((-end * normal, end * normal, out)),
        np.concatenate(
            ((-end * offset, end * (offset + depth)), np.einsum("nk,nk->n", out, corners))
        ),
        True,
    )


def dragged_depth(
    camera: Camera, normal: ArrayLike, start: ArrayLike, pixel: tuple[float, float]
) -> float:
    """Return how far a point was dragged along a normal, mm.

    Parameters
    ----------
    camera : Camera
        Through which the drag is seen.
    normal : (3,) array_like
        Unit vector.
    start : (3,) array_like
        Where the drag began, mm.
    pixel : (x, y)
        Where the pen is, canvas px.

    Returns
    -------
    float
        Along the line through `start`, to where it comes nearest to the ray under the pen; 0
        where the line is seen end-on.
    """
    along, begin = np.asarray(normal, float), np.asarray(start, float)
    rays = camera.rays(np.array([pixel], float))
    origin, sight = rays.origins[0], rays.directions[0]
    lean = float(along @ sight)
    across = 1.0 - lean * lean
    if across < 1e-6:
        return 0.0
    offset = origin - begin
    return float((offset @ along - lean * (offset @ sight)) / across)
