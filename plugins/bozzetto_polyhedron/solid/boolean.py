"""Union, difference and intersection of bodies, with planes that stay exact.

The triangles are combined by manifold3d, which tells of every triangle of the result the face that
it was cut from. Faces are then put together by planes, and their corners computed anew as places
where planes meet, so that no digit is lost, however often bodies are combined.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
from scipy.spatial import cKDTree

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.solid.face_rings import (
    are_simple,
    area_vector,
    bounds_volume,
    edges_of,
    flat_rings,
    parted,
)
from bozzetto_polyhedron.solid.planar_body import PlanarBody, on_axis_planes
from bozzetto_polyhedron.solid.triangulation import triangles_of, volume_of

if TYPE_CHECKING:
    from manifold3d import Manifold

Operation = Literal["union", "difference", "intersection"]

SAME_PLANE: Final = 1e-9
"""Difference of normals, and of offsets as share of the size, below which planes are one."""

ATTEMPTS: Final = ((1e-6, True), (1e-6, False), (1e-7, False), (4e-6, True))
"""How far faces of the second body that lie in planes of the first are moved outward, as share of
the size, while triangles are combined: what touches then overlaps, whatever the rounding. And
whether manifold3d joins thin triangles: it may turn edges over there, and then it is tried
otherwise."""

SAME_PLACE: Final = 5e-6
"""Distance, as share of the size, within which two corners of triangles are one: above that
overlap, and below anything drawn."""

PARALLEL: Final = 1e-6
"""Sine between two edges of one corner below which they run along one another."""

SAME_VOLUME: Final = 1e-4
"""Largest difference of the volumes before and after corners were joined, as share of the cube of
the size."""

INDEPENDENT: Final = 1e-7
"""Least singular value of the normals that meet in a corner."""

EXACT: Final = 1e-11
"""Largest distance of a corner from its planes, as share of the size."""


@dataclass(frozen=True, eq=False)
class _Planes:
    """Planes of two bodies, each once, and which of them every face lies in, and which way."""

    normals: Array
    offsets: Array
    number: tuple[Index, Index]
    sign: tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Triangles of a result: corners, planes with the side they look to, and first faces."""

    vertices: Array
    triangles: Index
    plane: Index
    sign: Index
    origin: Index


def combined(first: PlanarBody, second: PlanarBody, operation: Operation) -> PlanarBody:
    """Combine two solids into one.

    Parameters
    ----------
    first, second : PlanarBody
        Closed, in the same frame.
    operation : {"union", "difference", "intersection"}
        A difference takes the second from the first.

    Returns
    -------
    PlanarBody
        Faces of the first come first, in their order. It may consist of several pieces.

    Raises
    ------
    UserError
        If one is a sheet, nothing is left, or the result is no solid.
    """
    if not (first.closed and second.closed):
        raise UserError("A sheet encloses no volume. Close it, or give it a thickness first.")
    every = np.concatenate((first.vertices, second.vertices))
    size = float(np.linalg.norm(np.ptp(every, axis=0)))
    planes = _planes(first, second, size)
    for overlap, simplified in ATTEMPTS:
        second_grown = _grown(second, planes, overlap * size)
        pieces, volume = _boolean(
            (first, second_grown), operation, planes, size, simplified=simplified
        )
        body = _of_pieces(first, pieces, planes)
        if is_sound(body, size) and abs(volume_of(body) - volume) <= SAME_VOLUME * size**3:
            return body
    raise UserError("These solids touch so closely that no solid comes of it. Move one a bit.")


def _of_pieces(first: PlanarBody, pieces: _Pieces, planes: _Planes) -> PlanarBody:
    """Return the body whose triangles are known, with corners where its planes meet."""
    faces, order = _faces(pieces)
    faces, labels = _without_straight_corners(faces, pieces.plane[order], pieces.sign[order])
    normals = planes.normals[labels[0]] * labels[1][:, None]
    offsets = planes.offsets[labels[0]] * labels[1]
    vertices = _met(pieces.vertices, faces, normals, offsets)
    body = PlanarBody(vertices, faces, normals, offsets, True, first.frame, first.told)
    return on_axis_planes(compact(body))


def compact(body: PlanarBody) -> PlanarBody:
    """Return a body without vertices that no face uses."""
    used = np.unique([v for face in body.faces for ring in face for v in ring])
    number = {int(old): new for new, old in enumerate(used)}
    faces = tuple(tuple(tuple(number[v] for v in ring) for ring in face) for face in body.faces)
    return replace(body, vertices=body.vertices[used], faces=faces)


def is_sound(body: PlanarBody, size: float) -> bool:
    """Whether faces bound a volume, corners are on their planes, and nothing touches itself."""
    if not bounds_volume(body.faces) or not np.isfinite(body.vertices).all():
        return False
    for face, normal, offset in zip(body.faces, body.normals, body.offsets, strict=True):
        corners = body.vertices[[v for ring in face for v in ring]]
        if np.abs(corners @ normal - offset).max() > EXACT * size:
            return False
        if any(len(ring) < 3 for ring in face):
            return False
        if not are_simple(flat_rings(body.vertices, face, normal)):
            return False
    return edges_apart(body)


def edges_apart(body: PlanarBody) -> bool:
    """Whether no two edges leave a corner in one direction: a wall there has no thickness."""
    edges = edges_of(body.faces)
    ends = np.concatenate((edges, edges[:, ::-1]))
    along = body.vertices[ends[:, 1]] - body.vertices[ends[:, 0]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    one, two = np.nonzero(np.triu(ends[:, None, 0] == ends[None, :, 0], 1))
    sines = np.linalg.norm(np.cross(along[one], along[two]), axis=1)
    ahead = (along[one] * along[two]).sum(axis=1) > 0.0
    return not bool((ahead & (sines <= PARALLEL)).any())


def _planes(first: PlanarBody, second: PlanarBody, size: float) -> _Planes:
    """Give numbers to the planes of both bodies, one number to those that agree."""
    normals: list[Array] = []
    offsets: list[float] = []
    numbers, signs = [], []
    for body in (first, second):
        number, sign = [], []
        for normal, offset in zip(body.normals, body.offsets, strict=True):
            known = _known_plane(normals, offsets, normal, float(offset), size)
            if known is None:
                known = len(normals), 1.0
                normals.append(normal)
                offsets.append(float(offset))
            number.append(known[0])
            sign.append(known[1])
        numbers.append(np.array(number, np.intp))
        signs.append(np.array(sign))
    return _Planes(
        np.array(normals), np.array(offsets), (numbers[0], numbers[1]), (signs[0], signs[1])
    )


def _known_plane(
    normals: list[Array], offsets: list[float], normal: Array, offset: float, size: float
) -> tuple[int, float] | None:
    """Return the number of a plane that is known already, and whether it looks the same way."""
    for number, (known, at) in enumerate(zip(normals, offsets, strict=True)):
        side = 1.0 if known @ normal > 0 else -1.0
        apart = float(np.abs(known - side * normal).max())
        if apart < SAME_PLANE and abs(at - side * offset) < SAME_PLANE * size:
            return number, side
    return None


def _grown(second: PlanarBody, planes: _Planes, way: float) -> PlanarBody:
    """Return the second body with the faces moved outward that lie in planes of the first."""
    shared = np.isin(planes.number[1], planes.number[0])
    if not shared.any():
        return second
    offsets = second.offsets + way * shared
    moved = _met(second.vertices, second.faces, second.normals, offsets)
    return replace(second, vertices=moved, offsets=offsets)


def _manifold(body: PlanarBody, number: int) -> Manifold:
    """Return a body for manifold3d; every triangle is marked with its face."""
    import manifold3d

    triangles, faces = triangles_of(body)
    return manifold3d.Manifold(
        manifold3d.Mesh64(
            vert_properties=np.array(body.vertices),
            tri_verts=triangles.astype(np.uint64),
            run_index=np.array((0, 3 * len(triangles)), np.uint64),
            run_original_id=np.array((number,), np.uint32),
            face_id=faces.astype(np.uint64),
        )
    )


def _boolean(
    bodies: tuple[PlanarBody, PlanarBody],
    operation: Operation,
    planes: _Planes,
    size: float,
    *,
    simplified: bool,
) -> tuple[_Pieces, float]:
    """Combine triangles and mark each with its plane; return them and the volume."""
    import manifold3d

    start = manifold3d.Manifold.reserve_ids(2)
    one, two = (_manifold(body, start + k) for k, body in enumerate(bodies))
    both = {"union": one + two, "difference": one - two, "intersection": one ^ two}
    result = both[operation]
    if simplified:
        result = result.simplify(SAME_PLACE * size)
    if result.status() != manifold3d.Error.NoError:
        raise UserError("One of these solids has crossing faces. Draw it again.")
    if result.is_empty():
        raise UserError("Nothing would be left. Draw a smaller loop, or push less far.")
    mesh = result.to_mesh64()
    triangles = np.asarray(mesh.tri_verts).astype(np.intp)
    bounds = np.asarray(mesh.run_index, np.intp) // 3
    body = np.repeat(np.asarray(mesh.run_original_id, np.intp) - start, np.diff(bounds))
    face = np.asarray(mesh.face_id, np.intp)
    plane, sign = np.zeros(len(face), np.intp), np.zeros(len(face), np.intp)
    for k in (0, 1):
        own = body == k
        flip = -1.0 if k == 1 and operation == "difference" else 1.0
        plane[own] = planes.number[k][face[own]]
        sign[own] = (flip * planes.sign[k][face[own]]).astype(np.intp)
    vertices = np.asarray(mesh.vert_properties)[:, :3]
    joined = np.arange(len(vertices))
    joined[np.asarray(mesh.merge_from_vert, np.intp)] = np.asarray(mesh.merge_to_vert, np.intp)
    origin = face + body * len(bodies[0].faces)
    pieces = _Pieces(vertices, joined[triangles], plane, sign, origin)
    return _welded(pieces, size), float(result.volume())


def _welded(pieces: _Pieces, size: float) -> _Pieces:
    """Join corners at one place; drop triangles without area and pairs back to back."""
    leader = np.arange(len(pieces.vertices))
    for one, two in sorted(cKDTree(pieces.vertices).query_pairs(SAME_PLACE * size)):
        leader[leader == leader[two]] = leader[one]
    triangles = leader[pieces.triangles]
    a, b, c = triangles.T
    kept = (a != b) & (b != c) & (c != a)
    seen: dict[tuple[int, ...], list[int]] = {}
    for number in np.flatnonzero(kept):
        seen.setdefault(tuple(sorted(triangles[number].tolist())), []).append(int(number))
    for same in seen.values():
        if len(same) == 2:
            kept[same] = False
    return _Pieces(
        pieces.vertices, triangles[kept], pieces.plane[kept], pieces.sign[kept],
        pieces.origin[kept],
    )  # fmt: skip


def _faces(pieces: _Pieces) -> tuple[tuple[Rings, ...], Index]:
    """Put triangles of one plane together to faces; return those and a triangle of each."""
    neighbours = _neighbours(pieces)
    group = np.full(len(pieces.triangles), -1)
    members: list[list[int]] = []
    for start in range(len(group)):
        if group[start] >= 0:
            continue
        group[start] = len(members)
        found, todo = [start], [start]
        while todo:
            for other in neighbours[todo.pop()]:
                if other >= 0 and group[other] < 0:
                    group[other] = group[start]
                    found.append(other)
                    todo.append(other)
        members.append(found)
    faces = [_rings(pieces, found, neighbours) for found in members]
    first = [min(found, key=lambda t: (pieces.origin[t], t)) for found in members]
    order = sorted(range(len(faces)), key=lambda k: (pieces.origin[first[k]], first[k]))
    return tuple(faces[k] for k in order), np.array([first[k] for k in order], np.intp)


def _neighbours(pieces: _Pieces) -> Index:
    """Return the triangles in the same plane over each side, −1 where the plane ends, (t, 3)."""
    sides = {
        (int(triangle[k]), int(triangle[(k + 1) % 3])): number
        for number, triangle in enumerate(pieces.triangles)
        for k in range(3)
    }
    found = np.full(pieces.triangles.shape, -1)
    for number, triangle in enumerate(pieces.triangles):
        for k in range(3):
            other = sides.get((int(triangle[(k + 1) % 3]), int(triangle[k])), -1)
            if (
                other >= 0
                and pieces.plane[other] == pieces.plane[number]
                and pieces.sign[other] == pieces.sign[number]
            ):
                found[number, k] = other
    return found


def _rings(pieces: _Pieces, members: list[int], neighbours: Index) -> Rings:
    """Return the rings round triangles that hang together, the outer one first.

    At a corner where the boundary touches itself the walk stays among triangles that share sides,
    and what runs through the corner twice becomes two rings.
    """
    todo = {(t, k) for t in sorted(members) for k in range(3) if neighbours[t, k] < 0}
    rings: list[Ring] = []
    while todo:
        start = min(todo)
        ring, at = [], start
        while at in todo:
            todo.discard(at)
            triangle, side = at
            ring.append(int(pieces.triangles[triangle, side]))
            side = (side + 1) % 3
            while neighbours[triangle, side] >= 0:
                corner = pieces.triangles[triangle, side]
                triangle = int(neighbours[triangle, side])
                side = int(np.flatnonzero(pieces.triangles[triangle] == corner)[0])
            at = (triangle, side)
        rings += parted(tuple(ring))
    sizes = [float(np.linalg.norm(area_vector(pieces.vertices[list(ring)]))) for ring in rings]
    outer = int(np.argmax(sizes))
    return (rings[outer], *(ring for k, ring in enumerate(rings) if k != outer))


def _without_straight_corners(
    faces: tuple[Rings, ...], plane: Index, sign: Index
) -> tuple[tuple[Rings, ...], tuple[Index, Index]]:
    """Leave out corners in which only two planes meet, and what is no face without them."""
    planes_at: dict[int, set[int]] = {}
    for face, number in zip(faces, plane.tolist(), strict=True):
        for vertex in (v for ring in face for v in ring):
            planes_at.setdefault(vertex, set()).add(number)
    cleaned = [
        tuple(
            ring
            for ring in (tuple(v for v in ring if len(planes_at[v]) > 2) for ring in face)
            if len(ring) > 2
        )
        for face in faces
    ]
    kept = [k for k, face in enumerate(cleaned) if face]
    return tuple(cleaned[k] for k in kept), (plane[kept], sign[kept])


def _met(vertices: Array, faces: tuple[Rings, ...], normals: Array, offsets: Array) -> Array:
    """Return corners moved to where all planes of their faces meet."""
    at: dict[int, list[int]] = {}
    for number, face in enumerate(faces):
        for vertex in dict.fromkeys(v for ring in face for v in ring):
            at.setdefault(vertex, []).append(number)
    moved = vertices.copy()
    for vertex, numbers in at.items():
        for _ in range(2):
            missing = offsets[numbers] - normals[numbers] @ moved[vertex]
            moved[vertex] += np.linalg.lstsq(normals[numbers], missing, rcond=INDEPENDENT)[0]
    return moved
