"""Exact cylinders in the place of the flat sides of circles on faces and of round edges.

A circle is pushed as a polygon of the same area, so that planes are all that bodies are made of.
When a body is handed over, walls that nothing else has cut become cylinders again, with circles
round their ends, for STEP.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Brep, Color, Curve, plane_face, sewn, surface_of_revolution
from bozzetto_polyhedron.drawing_on.circles import SIDES, Circle
from bozzetto_polyhedron.drawing_on.rounded_edges import (
    RoundedEdge,
    exact_rims,
    exact_sides,
    rounded_edge_of,
    run_of,
)
from bozzetto_polyhedron.solid.face_rings import corners_of, sides_of, tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody

IN_PLANE: Final = 1e-9
"""Distance from a plane, as share of the radius, within which an edge lies in it."""

SAME: Final = 1e-8
"""Difference of normals, and of distances as share of the size, within which a plane is a side of
a polygon."""


LINE_KNOTS: Final = np.array((0.0, 0.0, 1.0, 1.0))
"""Of a straight line."""


@dataclass(frozen=True, eq=False)
class Wall:
    """A cylinder in a body, between two planes across its axis.

    Parameters
    ----------
    circle : Circle
        In the frame of the body.
    faces : tuple of int
        Sides of the polygon that it stands for, numbers of faces.
    heights : (float, float)
        Of its ends above the centre of the circle, mm.
    hollow : bool
        Whether it is a hole; otherwise a boss.
    rims : (frozenset of int, frozenset of int)
        Vertices at either end.
    """

    circle: Circle
    faces: tuple[int, ...]
    heights: tuple[float, float]
    hollow: bool
    rims: tuple[frozenset[int], frozenset[int]]


def walls_of(
    body: PlanarBody, circles: Sequence[Circle]
) -> tuple[tuple[Wall | RoundedEdge, ...], int]:
    """Find what is left of the cylinders of circles.

    Parameters
    ----------
    body : PlanarBody
        With flat sides in the place of circles.
    circles : sequence of Circle
        In the same frame.

    Returns
    -------
    walls : tuple of Wall or RoundedEdge
        Whole ones, in the order of their circles.
    cut : int
        How many others have only a part of their sides left, or sides that something else cuts.
    """
    walls: list[Wall | RoundedEdge] = []
    cut, taken = 0, set[int]()
    for circle in circles:
        sides = [face for face in _sides_of(body, circle) if face not in taken]
        for group in _groups(body, sides):
            taken.update(group)
            found = (rounded_edge_of if circle.is_arc else _free_wall)(body, circle, group)
            if found is None:
                cut += 1
            else:
                walls.append(found)
    return tuple(walls), cut


def smooth_edges(body: PlanarBody, circles: Sequence[Circle]) -> frozenset[tuple[int, int]]:
    """Return the edges between the sides of cylinders, whole or cut: nobody drew them."""
    return frozenset(
        side for sides in _side_counts(body, circles) for side, count in sides.items() if count > 1
    )


def round_edges(body: PlanarBody, circles: Sequence[Circle]) -> frozenset[tuple[int, int]]:
    """Return all edges at the sides of cylinders: those between them, and their rims."""
    return frozenset(side for sides in _side_counts(body, circles) for side in sides)


def _side_counts(body: PlanarBody, circles: Sequence[Circle]) -> list[Counter[tuple[int, int]]]:
    """Return for each cylinder how many of its sides there are at each edge."""
    return [
        Counter(
            (min(side), max(side))
            for number in group
            for ring in body.faces[number]
            for side in sides_of(ring)
        )
        for circle in circles
        for group in _groups(body, _sides_of(body, circle))
        if len(group) > 2 or circle.is_arc
    ]


def brep_with_cylinders(
    body: PlanarBody, circles: Sequence[Circle], name: str = "body", color: Color | None = None
) -> Brep:
    """Return the exact faces of a body: planes, and cylinders where circles were pushed.

    Parameters
    ----------
    body : PlanarBody
        A solid or a sheet.
    circles : sequence of Circle
        In the same frame; see `walls_of`.
    name : str
        What it is called.
    color : (r, g, b), optional
        sRGB.
    """
    walls, _ = walls_of(body, circles)
    gone = {face for wall in walls for face in wall.faces}
    rims: dict[frozenset[int], list[Curve]] = {}
    arcs: list[tuple[tuple[int, ...], list[Curve]]] = []
    places = body.vertices.copy()
    pieces: list[Brep] = []
    for wall in walls:
        if isinstance(wall, RoundedEdge):
            ends = exact_rims(body, wall)
            low, high = ([curve for _, curves in rim for curve in curves] for rim in ends)
            pieces += exact_sides(body, wall, (low, high))
            arcs += [(piece.chain, curves) for rim in ends for piece, curves in rim]
            places[list(wall.places)] = np.reshape(list(wall.places.values()), (-1, 3))
            continue
        side = _side(wall)
        pieces.append(side)
        for rim, height in zip(wall.rims, wall.heights, strict=True):
            rims[rim] = _rim(side, wall.circle, height)
    planes = [
        plane_face(
            [rims.get(frozenset(ring)) or _outline(places, ring, arcs) for ring in face],
            normal=normal,
            name=name,
        )
        for number, (face, normal) in enumerate(zip(body.faces, body.normals, strict=True))
        if number not in gone
    ]
    return sewn([*planes, *pieces], name, color)


def _outline(
    places: Array, ring: Sequence[int], arcs: Sequence[tuple[tuple[int, ...], list[Curve]]]
) -> Array | list[Curve]:
    """Return a ring of places, (n, 3), as its corners, or as curves where it runs through arcs."""
    runs: dict[int, tuple[int, list[Curve]]] = {}
    for chain, curves in arcs:
        found = run_of(ring, chain)
        if found is not None:
            at, forward = found
            back = [curve.reversed() for curve in curves[::-1]]
            runs[at] = len(chain) - 1, curves if forward else back
    if not runs:
        return np.asarray(places[list(ring)])
    first = at = min(runs)
    outline: list[Curve] = []
    while at < first + len(ring):
        here = at % len(ring)
        if here in runs:
            steps, curves = runs[here]
            outline += curves
        else:
            steps = 1
            ends = places[[ring[here], ring[(here + 1) % len(ring)]]]
            outline.append(Curve(1, LINE_KNOTS, ends))
        at += steps
    return outline


def _sides_of(body: PlanarBody, circle: Circle) -> list[int]:
    """Return the faces in the planes of the sides of a circle's polygon."""
    size = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    across = np.abs(body.normals @ circle.axis) < SAME
    away = np.abs(body.offsets - body.normals @ circle.center)
    return np.flatnonzero(across & (np.abs(away - circle.apothem) < SAME * size)).tolist()


def _groups(body: PlanarBody, sides: Sequence[int]) -> list[list[int]]:
    """Return sides that hang together over edges along the axis."""
    owner: dict[tuple[int, int], list[int]] = {}
    for face in sides:
        for ring in body.faces[face]:
            for one, two in sides_of(ring):
                owner.setdefault((min(one, two), max(one, two)), []).append(face)
    todo, groups = set(sides), []
    while todo:
        start = min(todo)
        todo.discard(start)
        group, reached = [start], [start]
        while reached:
            face = reached.pop()
            for ring in body.faces[face]:
                for one, two in sides_of(ring):
                    for other in owner[min(one, two), max(one, two)]:
                        if other in todo:
                            todo.discard(other)
                            group.append(other)
                            reached.append(other)
        groups.append(group)
    return groups


def _wall(body: PlanarBody, circle: Circle, group: Sequence[int]) -> Wall | None:
    """Return the whole cylinder that sides stand for; None where they are cut."""
    if len(group) != SIDES or any(len(body.faces[k]) > 1 for k in group):
        return None
    corners = sorted({v for k in group for v in corners_of(body.faces[k])})
    if len(corners) != 2 * SIDES or any(len(body.faces[k][0]) != 4 for k in group):
        return None
    heights = (body.vertices[corners] - circle.center) @ circle.axis
    low, high = float(heights.min()), float(heights.max())
    near = heights < 0.5 * (low + high)
    slack = IN_PLANE * max(circle.radius, high - low)
    if near.sum() != SIDES or np.ptp(heights[near]) > slack or np.ptp(heights[~near]) > slack:
        return None
    outward = body.offsets[group[0]] - body.normals[group[0]] @ circle.center > 0
    chosen = np.array(corners)
    rims = frozenset(chosen[near].tolist()), frozenset(chosen[~near].tolist())
    return Wall(circle, tuple(group), (low, high), not outward, rims)


def _free_wall(body: PlanarBody, circle: Circle, group: Sequence[int]) -> Wall | None:
    """Return the whole cylinder that sides stand for, if nothing else meets its rims."""
    wall = _wall(body, circle, group)
    return wall if wall is not None and _is_free(body, wall) else None


def _is_free(body: PlanarBody, wall: Wall) -> bool:
    """Whether the other faces at either end of a cylinder have it as one whole ring."""
    rings = [
        ring for number, face in enumerate(body.faces) if number not in wall.faces for ring in face
    ]
    for rim in wall.rims:
        met = [ring for ring in rings if not rim.isdisjoint(ring)]
        if len(met) != 1 or frozenset(met[0]) != rim or len(met[0]) != len(rim):
            return False
    return True


def _side(wall: Wall) -> Brep:
    """Return the exact cylinder, looking away from the material."""
    circle, (low, high) = wall.circle, wall.heights
    aside = circle.center + circle.radius * tangents(circle.axis)[0]
    line = Curve(
        1,
        LINE_KNOTS,
        np.stack((aside + low * circle.axis, aside + high * circle.axis)),
    )
    made = surface_of_revolution(line, circle.center, circle.axis)
    surface = made.faces[0].surface
    u, v = (np.array([np.mean(span)]) for span in surface.ranges)
    at, normal = surface.value(u, v).reshape(3), surface.normals(u, v).reshape(3)
    outward = bool((at - circle.center) @ normal > 0)
    return made if outward != wall.hollow else made.turned_over()


def _rim(side: Brep, circle: Circle, height: float) -> list[Curve]:
    """Return the arcs of a wall at a height above its circle, one after another."""
    level = float(circle.axis @ circle.center) + height
    limit = IN_PLANE * (circle.radius + abs(level))
    arcs = [
        edge
        for edge in side.edges
        if float(np.abs(edge.control_points @ circle.axis - level).max()) < limit
    ]
    chain = [arcs.pop(0)]
    while arcs:
        end = chain[-1].control_points[-1]
        number = min(range(len(arcs)), key=lambda k: _gap(arcs[k], end))
        arc = arcs.pop(number)
        ends = np.linalg.norm(arc.control_points[[0, -1]] - end, axis=1)
        chain.append(arc if ends[0] <= ends[1] else arc.reversed())
    return chain


def _gap(arc: Curve, end: Array) -> float:
    return float(np.linalg.norm(arc.control_points[[0, -1]] - end, axis=1).min())
