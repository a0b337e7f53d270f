"""A chamfer along an edge: a bevel at an outer edge, a fillet strip in an inner one."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_polyhedron.solid.boolean import combined
from bozzetto_polyhedron.solid.face_rings import sides_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody


def chamfered(body: PlanarBody, edge: tuple[int, int], setback: float) -> PlanarBody:
    """Replace an edge by a plane that leaves both faces at the same distance from it.

    Parameters
    ----------
    body : PlanarBody
        A closed one.
    edge : (int, int)
        Numbers of its vertices.
    setback : float
        Distance of the new edges from the old one, along the faces, mm.

    Raises
    ------
    UserError
        If there is no such edge, or the setback is none or too large.
    """
    one, two, start, end = edge_faces(body, edge)
    if not (np.isfinite(setback) and setback > 0):
        raise UserError("A chamfer needs a width above zero. Type one.")
    along = body.vertices[end] - body.vertices[start]
    length = float(np.linalg.norm(along))
    along /= length
    first, second = body.normals[one], body.normals[two]
    into_first, into_second = faces_at_edge(body, edge)
    if np.linalg.norm(np.cross(first, second)) < 1e-9:
        raise UserError("These faces do not meet at an angle. Choose another edge.")
    convex = bool(into_first @ second < 0)
    if setback >= (room := room_at_edge(body, edge)):
        raise UserError(f"This chamfer is wider than its face: type less than {room:.4g} mm.")
    slope = into_first + into_second
    slope /= np.linalg.norm(slope)
    at = float(slope @ (body.vertices[start] + setback * into_first))
    caps = [
        cap_at(body, vertex, (one, two), out) for vertex, out in ((start, -along), (end, along))
    ]
    side = 1.0 if convex else -1.0
    normals = np.array((side * first, side * second, slope, caps[0][0], caps[1][0]))
    offsets = np.array(
        (side * body.offsets[one], side * body.offsets[two], at, caps[0][1], caps[1][1])
    )
    wedge = _wedge(normals, offsets)
    return combined(body, wedge, "difference" if convex else "union")


def faces_at_edge(body: PlanarBody, edge: tuple[int, int]) -> tuple[Array, Array]:
    """Return the unit vectors from an edge into its two faces, across the edge.

    Raises
    ------
    UserError
        If there is no such edge.
    """
    one, two, start, end = edge_faces(body, edge)
    along = body.vertices[end] - body.vertices[start]
    along = along / np.linalg.norm(along)
    return np.cross(body.normals[one], along), -np.cross(body.normals[two], along)


def room_at_edge(body: PlanarBody, edge: tuple[int, int]) -> float:
    """Return how far the faces at an edge reach from it, the narrower one, mm."""
    one, two, start, _ = edge_faces(body, edge)
    reached = []
    for face, inward in zip((one, two), faces_at_edge(body, edge), strict=True):
        corners = body.vertices[[v for ring in body.faces[face] for v in ring]]
        reached.append(float(((corners - body.vertices[start]) @ inward).max()))
    return min(reached)


def edge_faces(body: PlanarBody, edge: tuple[int, int]) -> tuple[int, int, int, int]:
    """Return the face that runs an edge from its first vertex, the other one, and the vertices."""
    runs = {
        side: number
        for number, face in enumerate(body.faces)
        for ring in face
        for side in sides_of(ring)
    }
    start, end = edge
    if not body.closed or (start, end) not in runs or (end, start) not in runs:
        raise UserError("There is no such edge of a solid. Choose one.")
    return runs[start, end], runs[end, start], start, end


def cap_at(
    body: PlanarBody, vertex: int, faces: tuple[int, int], out: Array
) -> tuple[Array, float]:
    """Return the plane that ends a bevel at a vertex, looking outward along the edge.

    It is that of the third face, or straight across the edge where there are more.
    """
    third = [
        k
        for k, face in enumerate(body.faces)
        if k not in faces and any(vertex in ring for ring in face)
    ]
    if len(third) == 1 and abs(body.normals[third[0]] @ out) > 0.1:
        side = float(np.sign(body.normals[third[0]] @ out))
        return side * body.normals[third[0]], side * float(body.offsets[third[0]])
    return out, float(out @ body.vertices[vertex])


def _wedge(normals: Array, offsets: Array) -> PlanarBody:
    """Return the prism between three long planes and two caps, from the planes alone."""

    def met(*planes: int) -> Array:
        return np.asarray(np.linalg.solve(normals[list(planes)], offsets[list(planes)]))

    vertices = np.array([met(*pair, cap) for cap in (3, 4) for pair in ((0, 1), (1, 2), (2, 0))])
    faces = [((0, 2, 1),), ((3, 4, 5),), ((0, 1, 4, 3),), ((1, 2, 5, 4),), ((2, 0, 3, 5),)]
    order = [3, 4, 1, 2, 0]
    body = PlanarBody(vertices, tuple(faces), normals[order], offsets[order], True)
    ring = vertices[[0, 2, 1]]
    outward = float(np.cross(ring[1] - ring[0], ring[2] - ring[0]) @ normals[3])
    if outward < 0:
        turned = tuple(tuple(r[::-1] for r in face) for face in faces)
        body = PlanarBody(vertices, turned, normals[order], offsets[order], True)
    return body
