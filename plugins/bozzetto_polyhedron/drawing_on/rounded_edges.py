"""Edges that are rounded with a radius: flat strips in the body, and an exact cylinder beside it.

The cylinder touches both faces of the edge. In the body, strips with their corners on it stand for
it, so that bodies stay made of planes; when a body is handed over, strips that nothing else has cut
become the cylinder again. Where a plane ends it obliquely, its end is an ellipse: an affine image
of the arc, and so the same rational curve with other control points. Where it runs out over several
faces, each has its part, and they meet where the line of both planes meets the cylinder.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import acos, atan2, ceil, cos, pi, sin, sqrt, tan
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


BEYOND: Final = 0.25
"""How far the tool that rounds an end reaches beyond it, in radii."""

LEAST_TURN: Final = 1e-6
"""Angle, radians, below which two places of an arc are too close to be told apart."""


@dataclass(frozen=True, eq=False)
class EndPiece:
    """What one face ends of an arc.

    Parameters
    ----------
    face : int
        Number of the face.
    chain : tuple of int
        Vertices of its border along the arc.
    turns : (float, float)
        Where it begins and ends, radians from the beginning of the arc.
    """

    face: int
    chain: tuple[int, ...]
    turns: tuple[float, float]


@dataclass(frozen=True, eq=False)
class RoundedEdge:
    """An arc in a body that is whole: strips between faces that end them.

    Parameters
    ----------
    circle : Circle
        An arc, in the frame of the body.
    faces : tuple of int
        The strips, numbers of faces.
    ends : (tuple of EndPiece, tuple of EndPiece)
        At either end, in the order of turns; below along the axis first.
    spokes : (2, 3) float64
        Unit vectors from the axis to where the arc begins, and across that the way it turns.
    places : dict of int to (3,) float64
        Where the vertices at which one end face follows another one lie on the cylinder, mm.
    """

    circle: Circle
    faces: tuple[int, ...]
    ends: tuple[tuple[EndPiece, ...], tuple[EndPiece, ...]]
    spokes: Array
    places: dict[int, Array]

    @property
    def turns(self) -> list[float]:
        """Where the cylinder is cut into pieces of at most a quarter turn, radians, in order."""
        breaks = sorted({turn for end in self.ends for each in end for turn in each.turns})
        found = breaks[:1]
        for turn in breaks[1:]:
            count = ceil((turn - found[-1]) / (0.5 * pi) - ROUNDING)
            found += np.linspace(found[-1], turn, count + 1)[1:].tolist()
        return found


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


def rounded_end(
    body: PlanarBody, first: tuple[int, int], second: tuple[int, int]
) -> tuple[PlanarBody, Circle]:
    """Round the end of a plate by half a turn: the face between two edges becomes a cylinder.

    Parameters
    ----------
    body : PlanarBody
        A closed one.
    first, second : (int, int)
        Numbers of the vertices of two parallel edges of one face, square to both faces beside it.

    Returns
    -------
    body : PlanarBody
        With strips in the place of the cylinder.
    circle : Circle
        The arc that they stand for: half a turn.

    Raises
    ------
    UserError
        If there are no such edges.
    """
    one, two, start, end = edge_faces(body, first)
    between = {one, two} & set(edge_faces(body, second)[:2])
    if len(between) != 1:
        raise UserError("These edges do not bound one face. Choose two that do.")
    (last,) = between
    beside = two if last == one else one
    other = next(k for k in edge_faces(body, second)[:2] if k != last)
    inward, across = faces_at_edge(body, first)
    if last == one:
        inward, across = across, inward
    along = body.vertices[end] - body.vertices[start]
    along = along / np.linalg.norm(along)
    corner = body.vertices[start]
    gap = body.vertices[list(second)] - corner
    radius = 0.5 * float(gap[0] @ across)
    square = max(
        *np.abs(gap @ across - 2.0 * radius),
        *np.abs(gap @ inward),
        float(np.abs(body.normals[other] + body.normals[beside]).max()) * radius,
        abs(float(across @ inward)) * radius,
    )
    if not radius > 0.0 or square > ALONG * radius:
        raise UserError("This end is not square. Round its edges one by one.")
    center = corner + radius * (across + inward)
    circle = Circle(center, along, radius, -1, 0.0, sweep=pi)
    away = np.array((-across, -inward))
    arc, strips, inner = _strips(circle, away)
    convex = bool(across @ body.normals[beside] < 0)
    side = 1.0 if convex else -1.0
    beyond = corner - BEYOND * radius * inward
    line = np.concatenate((arc, [beyond + 2.0 * radius * across, beyond]))
    walls = np.array(
        (
            *strips,
            side * body.normals[other],
            side * body.normals[last],
            side * body.normals[beside],
        )
    )
    offsets = np.array(
        (
            *inner,
            side * body.offsets[other],
            side * body.offsets[last] + BEYOND * radius,
            side * body.offsets[beside],
        )
    )
    caps = [
        cap_at(body, vertex, (one, two), out) for vertex, out in ((start, -along), (end, along))
    ]
    tool = _prism_between(line, walls, offsets, caps, along)
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
    if len(group) != circle.sides or any(len(body.faces[k]) > 1 for k in group):
        return None
    lines = {line for k in group for line in _lines_along(body, circle.axis, k)}
    if len(lines) != circle.sides + 1 or len({v for line in lines for v in line}) != 2 * len(lines):
        return None
    ordered = sorted(lines, key=_angle_in(body, circle, [v for v, _ in lines]))
    chains = _chains(body, group, ordered)
    if chains is None:
        return None
    spokes = _spokes(body, circle, chains[0])
    places: dict[int, Array] = {}
    low, high = (_end_pieces(body, circle, chain, group, spokes, places) for chain in chains)
    if low is None or high is None:
        return None
    found = RoundedEdge(circle, tuple(group), (low, high), spokes, places)
    return found if min(np.diff(found.turns)) > LEAST_TURN else None


def exact_rims(
    body: PlanarBody, rounded: RoundedEdge
) -> tuple[list[tuple[EndPiece, list[Curve]]], list[tuple[EndPiece, list[Curve]]]]:
    """Return the curves at both ends of a round edge, of each piece in the order of its chain."""
    turns = np.array(rounded.turns)
    made = []
    for end in rounded.ends:
        rim = []
        for piece in end:
            inside = (turns > piece.turns[0] - LEAST_TURN) & (turns < piece.turns[1] + LEAST_TURN)
            rim.append((piece, _rim(body, rounded, piece, turns[inside])))
        made.append(rim)
    return made[0], made[1]


def exact_sides(
    body: PlanarBody, rounded: RoundedEdge, rims: tuple[Sequence[Curve], Sequence[Curve]]
) -> list[Brep]:
    """Return the exact cylinder between the curves of two rims, looking away from the material."""
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
    arc, strips, inner = _strips(circle, away)
    line = np.concatenate((body.vertices[start][None], arc))
    caps = [
        cap_at(body, vertex, (one, two), out) for vertex, out in ((start, -along), (end, along))
    ]
    filled = bool(away[1] @ body.normals[two] < 0)  # the edge is an inner one
    side = -1.0 if filled else 1.0
    walls = np.array((side * body.normals[one], *strips, side * body.normals[two]))
    offsets = np.array((side * body.offsets[one], *inner, side * body.offsets[two]))
    return _prism_between(line, walls, offsets, caps, along)


def _strips(circle: Circle, away: Array) -> tuple[Array, Array, Array]:
    """Return the corners of the strips of an arc, and their planes: they look at the axis.

    `away` are the directions from the axis to where the arc begins, and across that, (2, 3).
    """
    step = circle.sweep / circle.sides
    turns = step * np.arange(circle.sides + 1)
    arc = circle.center + circle.radius * np.column_stack((np.cos(turns), np.sin(turns))) @ away
    middles = turns[:-1] + 0.5 * step
    strips = -np.column_stack((np.cos(middles), np.sin(middles))) @ away
    return arc, strips, strips @ circle.center - circle.apothem


def _prism_between(
    line: Array,
    walls: Array,
    offsets: Array,
    caps: Sequence[tuple[Array, float]],
    along: Array,
) -> PlanarBody:
    """Return the prism over a ring of corners, with a wall from each to the next, and two caps."""
    rings = [
        line + np.multiply.outer((offset - line @ normal) / (along @ normal), along)
        for normal, offset in caps
    ]
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


def _chains(
    body: PlanarBody, group: Sequence[int], lines: Sequence[tuple[int, int]]
) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
    """Return the vertices at either end of strips, below along the axis first.

    Both are in the order of `lines`, the sides of strips along the axis, each from below; None
    where a strip of the group is not between two lines that follow one another.
    """
    chains = [lines[0][0]], [lines[0][1]]
    for one, other in pairwise(lines):
        between = [
            ring
            for k in group
            for ring in body.faces[k]
            if {*one, *other} <= set(ring) and len(set(ring)) == len(ring)
        ]
        if len(between) != 1:
            return None
        ring, count = between[0], len(between[0])
        for chain, start, stop, never in zip(chains, one, other, one[::-1], strict=True):
            at = ring.index(start)
            step = -1 if ring[(at + 1) % count] == never else 1
            while ring[at % count] != stop:
                at += step
                if ring[at % count] == never:
                    return None
                chain.append(ring[at % count])
    return tuple(chains[0]), tuple(chains[1])


def _end_pieces(
    body: PlanarBody,
    circle: Circle,
    chain: Sequence[int],
    group: Sequence[int],
    spokes: Array,
    places: dict[int, Array],
) -> tuple[EndPiece, ...] | None:
    """Return what other faces end of an arc; None where it is not theirs alone.

    The exact places of vertices between two of them are put into `places`.
    """
    others = {
        side: number
        for number, face in enumerate(body.faces)
        if number not in group
        for ring in face
        for side in sides_of(ring)
    }
    owners = [others.get((a, b), others.get((b, a))) for a, b in pairwise(chain)]
    starts = [k for k in range(len(owners)) if not k or owners[k] != owners[k - 1]]
    faces = [owners[k] for k in starts]
    if len(set(faces)) < len(faces):
        return None
    turns = [0.0]
    pieces = []
    for number, (face, start, stop) in enumerate(
        zip(faces, starts, [*starts[1:], len(owners)], strict=True)
    ):
        if face is None or abs(body.normals[face] @ circle.axis) < EDGE_ON:
            return None
        own = tuple(chain[start : stop + 1])
        if any(_others_at(body, vertex, group) != {face} for vertex in own[1:-1]):
            return None
        if number + 1 == len(faces):
            turns.append(circle.sweep)
        else:
            following = faces[number + 1]
            if following is None or _others_at(body, own[-1], group) != {face, following}:
                return None
            place = _on_cylinder(body, circle, (face, following), own[-1])
            if place is None:
                return None
            places[own[-1]] = place
            first, across = spokes @ (place - circle.center)
            turns.append(atan2(across, first))
        pieces.append(EndPiece(face, own, (turns[-2], turns[-1])))
    return tuple(pieces) if min(np.diff(turns)) > LEAST_TURN else None


def _others_at(body: PlanarBody, vertex: int, group: Sequence[int]) -> set[int]:
    """Return the faces at a vertex but those of a group."""
    return {
        number
        for number, face in enumerate(body.faces)
        if number not in group and any(vertex in ring for ring in face)
    }


def _on_cylinder(
    body: PlanarBody, circle: Circle, faces: tuple[int, int], vertex: int
) -> Array | None:
    """Return where the line of two faces meets a cylinder, beside a vertex of theirs.

    None where it does not, or where they do not tell.
    """
    line = np.cross(*body.normals[list(faces)])
    if np.linalg.norm(line) < ALONG:
        return None
    near = body.vertices[vertex]
    from_axis = near - circle.center
    from_axis = from_axis - (from_axis @ circle.axis) * circle.axis
    across = line - (line @ circle.axis) * circle.axis
    a, b = float(across @ across), float(across @ from_axis)
    square = b * b - a * (float(from_axis @ from_axis) - circle.radius**2)
    if a < ALONG**2 * float(line @ line) or square <= 0.0:
        return None
    steps = (-b - sqrt(square)) / a, (-b + sqrt(square)) / a
    return np.asarray(near + min(steps, key=abs) * line)


def _spokes(body: PlanarBody, circle: Circle, chain: Sequence[int]) -> Array:
    """Return unit vectors from the axis to where an arc begins, and across it, (2, 3)."""
    begin, middle = body.vertices[[chain[0], chain[len(chain) // 2]]] - circle.center
    first = begin - (begin @ circle.axis) * circle.axis
    first = first / np.linalg.norm(first)
    across = np.cross(circle.axis, first)
    return np.array((first, across if middle @ across > 0 else -across))


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


def _rim(body: PlanarBody, rounded: RoundedEdge, piece: EndPiece, turns: Array) -> list[Curve]:
    """Return the exact section of the cylinder with the plane of a face, cut at turns, radians."""
    circle, axis = rounded.circle, rounded.circle.axis
    normal, offset = body.normals[piece.face], float(body.offsets[piece.face])

    def on_plane(turn: float, reach: float) -> Array:
        spoke = np.array((cos(turn), sin(turn))) @ rounded.spokes
        place = circle.center + reach * circle.radius * spoke
        return np.asarray(place + (offset - place @ normal) / (axis @ normal) * axis)

    pieces = []
    for begin, end in pairwise(turns.tolist()):
        half = 0.5 * (end - begin)
        net = np.array(
            (on_plane(begin, 1.0), on_plane(begin + half, 1.0 / cos(half)), on_plane(end, 1.0))
        )
        knots = np.array((0.0, 0.0, 0.0, 1.0, 1.0, 1.0))
        pieces.append(Curve(2, knots, net, np.array((1.0, cos(half), 1.0))))
    return pieces
