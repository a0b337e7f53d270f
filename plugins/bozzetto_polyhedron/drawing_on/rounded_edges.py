"""Edges that are rounded with a radius: flat strips in the body, and an exact cylinder beside it.

The cylinder touches both faces of the edge. In the body, strips with their corners on it stand for
it, so that bodies stay made of planes; when a body is handed over, strips that nothing else has cut
become the cylinder again. Where a plane ends it obliquely, its end is an ellipse: an affine image
of the arc, and so the same rational curve with other control points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import acos, ceil, cos, pi, sin, tan
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Brep, Curve, ruled_surface
from bozzetto_polyhedron.drawing_on.chamfer import cap_at, edge_faces, faces_at_edge, room_at_edge
from bozzetto_polyhedron.drawing_on.circles import ROUNDING, Circle
from bozzetto_polyhedron.solid.boolean import combined
from bozzetto_polyhedron.solid.face_rings import sides_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody

ALONG: Final = 1e-6
"""Sine of the angle to the axis below which a side of a strip runs along it."""

EDGE_ON: Final = 1e-3
"""Cosine of the angle between an end's normal and the axis below which it ends nothing."""


@dataclass(frozen=True, eq=False)
class RoundedEdge:
    """An arc in a body that is whole: strips between two planes.

    Parameters
    ----------
    circle : Circle
        An arc, in the frame of the body.
    faces : tuple of int
        The strips, numbers of faces.
    chains : (tuple of int, tuple of int)
        Vertices at either end, from one side of the arc to the other; below along the axis first.
    ends : (int, int)
        Faces that the arc ends in.
    """

    circle: Circle
    faces: tuple[int, ...]
    chains: tuple[tuple[int, ...], tuple[int, ...]]
    ends: tuple[int, int]


def rounded_edge(
    body: PlanarBody, edge: tuple[int, int], radius: float
) -> tuple[PlanarBody, Circle]:
    """Round an edge: an outer one is cut, an inner one filled.

    Parameters
    ----------
    body : PlanarBody
        A closed one.
    edge : (int, int)
        Numbers of its vertices.
    radius : float
        mm.

    Returns
    -------
    body : PlanarBody
        With strips in the place of the cylinder.
    circle : Circle
        The arc that they stand for.

    Raises
    ------
    UserError
        If there is no such edge, or the radius is none or too large.
    """
    if not (np.isfinite(radius) and radius > 0):
        raise UserError("A round edge needs a radius above zero. Type one.")
    _, two, start, end = edge_faces(body, edge)
    most = largest_radius(body, edge)
    if radius >= most:
        raise UserError(f"Its faces have no room for this radius: type less than {most:.4g} mm.")
    into_first, into_second = faces_at_edge(body, edge)
    half = half_angle(body, edge)
    along = body.vertices[end] - body.vertices[start]
    along = along / np.linalg.norm(along)
    toward = into_second - (into_second @ into_first) * into_first
    toward /= np.linalg.norm(toward)
    corner = body.vertices[start]
    center = corner + radius / tan(half) * into_first + radius * toward
    circle = Circle(center, along, radius, -1, 0.0, sweep=pi - 2.0 * half)
    away = np.array((-toward, -into_first))
    tool = _tool(body, edge, circle, away)
    convex = bool(into_first @ body.normals[two] < 0)
    return combined(body, tool, "difference" if convex else "union"), circle


def half_angle(body: PlanarBody, edge: tuple[int, int]) -> float:
    """Return half of the angle between the two faces at an edge, radians.

    Raises
    ------
    UserError
        If there is no such edge, or its faces are in one plane.
    """
    into_first, into_second = faces_at_edge(body, edge)
    half = 0.5 * acos(float(np.clip(into_first @ into_second, -1.0, 1.0)))
    if not 1e-6 < half < 0.5 * pi - 1e-6:
        raise UserError("These faces do not meet at an angle. Choose another edge.")
    return half


def largest_radius(body: PlanarBody, edge: tuple[int, int]) -> float:
    """Return the radius at which a round edge takes all of its narrower face, mm."""
    return room_at_edge(body, edge) * tan(half_angle(body, edge))


def rounded_edge_of(body: PlanarBody, circle: Circle, group: Sequence[int]) -> RoundedEdge | None:
    """Return the whole arc that strips stand for; None where something else cuts them.

    Parameters
    ----------
    body : PlanarBody
        With strips in the place of arcs.
    circle : Circle
        An arc, in the same frame.
    group : sequence of int
        Faces in the planes of its strips that hang together.
    """
    if len(group) != circle.sides or any(
        len(body.faces[k]) > 1 or len(body.faces[k][0]) != 4 for k in group
    ):
        return None
    lines = {line for k in group for line in _lines_along(body, circle.axis, k)}
    if len(lines) != circle.sides + 1 or len({v for line in lines for v in line}) != 2 * len(lines):
        return None
    ordered = sorted(lines, key=_angle_in(body, circle, [v for v, _ in lines]))
    chains = tuple(low for low, _ in ordered), tuple(high for _, high in ordered)
    ends = [_end_face(body, chain, group) for chain in chains]
    if ends[0] is None or ends[1] is None:
        return None
    if any(abs(body.normals[k] @ circle.axis) < EDGE_ON for k in ends):
        return None
    return RoundedEdge(circle, tuple(group), chains, (ends[0], ends[1]))


def exact_rims(body: PlanarBody, rounded: RoundedEdge) -> tuple[list[Curve], list[Curve]]:
    """Return the curves at both ends of a round edge, each in the order of its chain."""
    low, high = (
        _rim(body, rounded, chain, face)
        for chain, face in zip(rounded.chains, rounded.ends, strict=True)
    )
    return low, high


def exact_sides(
    body: PlanarBody, rounded: RoundedEdge, rims: tuple[list[Curve], list[Curve]]
) -> list[Brep]:
    """Return the exact cylinder between two rims, looking away from the material."""
    made = []
    outward = body.normals[rounded.faces[0]]
    corner = body.vertices[body.faces[rounded.faces[0]][0][0]]
    spoke = corner - rounded.circle.center
    spoke = spoke - (spoke @ rounded.circle.axis) * rounded.circle.axis
    is_outer = bool(spoke @ outward > 0)
    for first, second in zip(*rims, strict=True):
        piece = ruled_surface(first, second)
        surface = piece.faces[0].surface
        u, v = (np.array([np.mean(span)]) for span in surface.ranges)
        at, normal = surface.value(u, v).reshape(3), surface.normals(u, v).reshape(3)
        looks_out = bool((at - rounded.circle.center) @ normal > 0)
        made.append(piece if looks_out == is_outer else piece.turned_over())
    return made


def _tool(body: PlanarBody, edge: tuple[int, int], circle: Circle, away: Array) -> PlanarBody:
    """Return the prism between an edge and its arc.

    Its first two walls lie in the faces at the edge. `away` are the directions, in the plane across
    the edge, from the axis to where the arc begins, and across that toward the edge, (2, 3).
    """
    one, two, start, end = edge_faces(body, edge)
    along = circle.axis
    step = circle.sweep / circle.sides
    turns = step * np.arange(circle.sides + 1)
    arc = circle.center + circle.radius * np.column_stack((np.cos(turns), np.sin(turns))) @ away
    line = np.concatenate((body.vertices[start][None], arc))
    caps = [
        cap_at(body, vertex, (one, two), out) for vertex, out in ((start, -along), (end, along))
    ]
    rings = [
        line + np.multiply.outer((offset - line @ normal) / (along @ normal), along)
        for normal, offset in caps
    ]
    middles = turns[:-1] + 0.5 * step
    strips = -np.column_stack((np.cos(middles), np.sin(middles))) @ away
    inner = strips @ circle.center - circle.apothem
    filled = bool(away[1] @ body.normals[two] < 0)  # the edge is an inner one
    side = -1.0 if filled else 1.0
    walls = np.array((side * body.normals[one], *strips, side * body.normals[two]))
    offsets = np.array((side * body.offsets[one], *inner, side * body.offsets[two]))
    count = len(line)
    vertices = np.concatenate(rings)
    below, above = tuple(range(count)), tuple(range(count, 2 * count))
    sides = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count)]
    faces = [below[::-1], above, *sides]
    ring = vertices[list(sides[0])]
    if float(np.cross(ring[1] - ring[0], ring[2] - ring[0]) @ walls[0]) < 0:
        faces = [face[::-1] for face in faces]
    return PlanarBody(
        vertices,
        tuple((face,) for face in faces),
        np.array((caps[0][0], caps[1][0], *walls)),
        np.array((caps[0][1], caps[1][1], *offsets)),
        True,
    )


def _lines_along(body: PlanarBody, axis: Array, face: int) -> list[tuple[int, int]]:
    """Return the sides of a strip that run along the axis, each from below."""
    found = []
    for one, two in sides_of(body.faces[face][0]):
        span = body.vertices[two] - body.vertices[one]
        if float(np.linalg.norm(np.cross(axis, span))) < ALONG * float(np.linalg.norm(span)):
            found.append((one, two) if span @ axis > 0 else (two, one))
    return found


def _angle_in(
    body: PlanarBody, circle: Circle, corners: Sequence[int]
) -> Callable[[tuple[int, int]], float]:
    """Return a function from a line along the axis to its angle, from the middle of the arc."""
    spokes = body.vertices[list(corners)] - circle.center
    middle = spokes.mean(axis=0)
    middle = middle - (middle @ circle.axis) * circle.axis
    across = np.cross(circle.axis, middle)

    def angle(line: tuple[int, int]) -> float:
        spoke = body.vertices[line[0]] - circle.center
        return float(np.arctan2(spoke @ across, spoke @ middle))

    return angle


def _end_face(body: PlanarBody, chain: Sequence[int], group: Sequence[int]) -> int | None:
    """Return the one other face whose ring has all of a chain, side by side; None if none has."""
    inner = set(chain[1:-1])
    met = [
        (number, ring)
        for number, face in enumerate(body.faces)
        if number not in group
        for ring in face
        if not inner.isdisjoint(ring)
    ]
    if len(met) != 1:
        return None
    number, ring = met[0]
    return number if run_of(ring, chain) is not None else None


def run_of(ring: Sequence[int], chain: Sequence[int]) -> tuple[int, bool] | None:
    """Return where a ring runs through a chain, and whether forward; None if it does not."""
    count = len(ring)
    for forward in (True, False):
        wanted = tuple(chain) if forward else tuple(chain[::-1])
        if wanted[0] in ring:
            at = list(ring).index(wanted[0])
            if tuple(ring[(at + k) % count] for k in range(len(wanted))) == wanted:
                return at, forward
    return None


def _rim(body: PlanarBody, rounded: RoundedEdge, chain: Sequence[int], face: int) -> list[Curve]:
    """Return the exact section of the cylinder with the plane of a face, a quarter turn a piece."""
    circle, axis = rounded.circle, rounded.circle.axis
    normal, offset = body.normals[face], float(body.offsets[face])
    spoke = body.vertices[chain[0]] - circle.center
    first = spoke - (spoke @ axis) * axis
    first = first * (circle.radius / np.linalg.norm(first))
    across = np.cross(axis, first)
    last = body.vertices[chain[-1]] - circle.center
    across = across if last @ across > 0 else -across
    count = ceil(circle.sweep / (0.5 * pi) - ROUNDING)
    half = 0.5 * circle.sweep / count

    def on_plane(turn: float, reach: float) -> Array:
        place = circle.center + reach * (cos(turn) * first + sin(turn) * across)
        return np.asarray(place + (offset - place @ normal) / (axis @ normal) * axis)

    pieces = []
    for number in range(count):
        begin = 2.0 * half * number
        net = np.array(
            (
                on_plane(begin, 1.0),
                on_plane(begin + half, 1.0 / cos(half)),
                on_plane(begin + 2.0 * half, 1.0),
            )
        )
        knots = np.array((0.0, 0.0, 0.0, 1.0, 1.0, 1.0))
        pieces.append(Curve(2, knots, net, np.array((1.0, cos(half), 1.0))))
    return pieces
