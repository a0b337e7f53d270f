"""What was round in a drawing, on the exact body of its straight lines.

Rounded corners are cut first, then cylinders that stand out, the largest first, then holes: each
lies on the face on which its rim was drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.body_hits import face_under
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.drawing_on.circles import Circle, circle_in_plane, polygon_of
from bozzetto_polyhedron.drawing_on.push import prism_on, pushed
from bozzetto_polyhedron.drawing_on.rounded_edges import rounded_edge, rounded_end
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.rounds.ellipses import TURN, Ellipse
from bozzetto_polyhedron.rounds.round_things import (
    Barrel,
    Bend,
    PlacedRound,
    Reading,
    Rim,
    RoundSizes,
)
from bozzetto_polyhedron.rounds.straightened import Column, Straightened
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import within_face

LEFT_OUT: Final = ("An ellipse is left out.", "An arc is left out.", "Ellipses are left out.")
"""How what is told of something round begins that fits nowhere."""

SAMPLES: Final = 72
"""Points of an ellipse that are laid on a face."""

INSIDE, INSIDE_SEEN = 0.85, 0.7
"""Least share of a rim that lies within its face: a hand draws it over the border by a hair. The
second where the face is the one that is seen at its centre."""

FITS, FITS_SEEN = 0.12, 0.25
"""Largest deviation from a circle of a rim on its face, in radii; the second on the face that is
seen at its centre: small ellipses are drawn too wide or too narrow by a quarter."""

NEAR: Final = 0.2
"""Difference from the depth of the whole wall, in depths, up to which a hole is meant through."""

NOISE: Final = 0.03
"""The same in diagonals of the drawing."""

SQUARE: Final = 0.05
"""Largest difference of two sides of the box about a cylinder, in sides, and cosine between two."""

CORNER: Final = 0.06
"""Distance of a corner of the graph from where lines would meet, in diagonals."""


AS_DRAWN: Final = RoundSizes()
"""Of what nobody typed a size of."""


@dataclass(frozen=True, eq=False)
class Rounded:
    """The exact body of a drawing with what was round in it.

    Parameters
    ----------
    made : Changed
        What fits nowhere is left out and told.
    placed : mapping of int to PlacedRound
        What was put on it, by the numbers of `rounds.round_curves`.
    """

    made: Changed
    placed: Mapping[int, PlacedRound] = field(default_factory=dict)

    def after(self, number: int, placed: PlacedRound, body: PlanarBody) -> Rounded:
        """Return the same with something more that is round."""
        made = replace(self.made, body=body, circles=(*self.made.circles, placed.circle))
        return Rounded(made, {**self.placed, number: placed})

    def without(self, what: str, problem: UserError) -> Rounded:
        """Return the same, which tells why something is left out."""
        return replace(self, made=replace(self.made, told=(*self.made.told, f"{what} {problem}")))


def with_rounds(
    body: PlanarBody,
    graph: LineGraph,
    found: Straightened,
    camera: Camera,
    sizes: Mapping[int, RoundSizes],
) -> Rounded:
    """Put what was round in a drawing on its exact body.

    Parameters
    ----------
    body : PlanarBody
        Of the straightened drawing: its vertices are the corners of the graph.
    graph : LineGraph
        px.
    found : Straightened
        The drawing.
    camera : Camera
        Through which it was drawn.
    sizes : mapping of int to RoundSizes
        What was typed, by the numbers of `rounds.round_curves`.
    """
    reading = found.reading
    if reading is None:
        return Rounded(Changed(body))
    if not body.closed:
        told = (f"{LEFT_OUT[2]} They need a closed solid.",)
        return Rounded(Changed(body, told=told))
    made = _with_bends(Rounded(Changed(body)), graph, reading, sizes)
    done: set[int] = set()
    if found.column is not None:
        near, far = found.column.barrel.near, found.column.barrel.far
        made = _turned(made, graph, found.column, sizes.get(near, AS_DRAWN))
        done = {near, far}
    order = sorted(
        (k for k in range(len(reading.rims)) if k not in done),
        key=lambda k: -reading.rims[k].ellipse.radius,
    )
    barrels = {number: each for each in reading.barrels for number in (each.near, each.far)}
    for stands_out in (True, False):
        for number in order:
            barrel = barrels.get(number)
            if number in done or (barrel is not None and barrel.outside) != stands_out:
                continue
            done |= {number} if barrel is None else {barrel.near, barrel.far}
            name = number if barrel is None else barrel.near
            size = sizes.get(name, AS_DRAWN)
            try:
                if barrel is not None and stands_out:
                    placed, after = _boss(made.made.body, reading, barrel, camera, size)
                else:
                    rim = reading.rims[number]
                    placed, after = _hole(made.made.body, reading, rim, barrel, camera, size)
                made = made.after(name, placed, after)
            except UserError as problem:
                made = made.without(LEFT_OUT[0], problem)
    return made


def shows_column(vertices: Array, graph: LineGraph, column: Column) -> bool:
    """Return whether the box of an answer is one about a cylinder: square across, and upright.

    Parameters
    ----------
    vertices : (n, 3) float64
        One for each corner of the graph.
    graph : LineGraph
        Of the box.
    column : Column
        The cylinder.
    """
    corners = vertices[_vertices_at(graph, column.corners, np.inf)]
    one, other, along = corners[1] - corners[0], corners[3] - corners[0], corners[4] - corners[0]
    lengths = np.linalg.norm((one, other, along), axis=1)
    cosines = (
        one @ other / (lengths[0] * lengths[1]),
        one @ along / (lengths[0] * lengths[2]),
        other @ along / (lengths[1] * lengths[2]),
    )
    is_square = abs(lengths[0] - lengths[1]) < SQUARE * lengths[0]
    return bool(is_square and np.abs(cosines).max() < SQUARE)


def _turned(made: Rounded, graph: LineGraph, column: Column, size: RoundSizes) -> Rounded:
    """Return the cylinder within a box."""
    body = made.made.body
    near = set(_vertices_at(graph, column.corners[:4], np.inf))
    faces = [k for k, face in enumerate(body.faces) if set(face[0]) == near]
    if len(faces) != 1:
        raise UserError("The ellipses make no cylinder. Draw both of them, and both sides.")
    ring = body.vertices[list(body.faces[faces[0]][0])]
    normal, offset = body.normals[faces[0]], float(body.offsets[faces[0]])
    center = ring.mean(axis=0)
    radius = 0.5 * float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).mean())
    depth = size.depth or offset - float((body.vertices @ normal).min())
    circle = _sized(Circle(center, normal, radius, -1, 0.0), size)
    prism = prism_on(normal, offset, polygon_of(circle), -depth)
    prism = replace(prism, frame=body.frame, told=body.told)
    return made.after(column.barrel.near, PlacedRound(circle, depth), prism)


def _sized(circle: Circle, size: RoundSizes) -> Circle:
    """Return a circle with the diameter that was typed."""
    return replace(circle, radius=0.5 * size.diameter) if size.diameter > 0.0 else circle


def _with_bends(
    made: Rounded, graph: LineGraph, reading: Reading, sizes: Mapping[int, RoundSizes]
) -> Rounded:
    """Return a body with its corners rounded that were drawn round."""
    drawn = made.made.body
    named = [
        [_edge_at(drawn, graph, bend, k, reading.size) for k in range(len(bend.corners))]
        for bend in reading.bends
    ]
    for number, (bend, edges) in enumerate(
        zip(reading.bends, named, strict=True), len(reading.rims)
    ):
        size = sizes.get(number, AS_DRAWN)
        try:
            radius = 0.5 * size.diameter or _radius(drawn, graph, bend, edges)
            ends = [tuple(drawn.vertices[list(edge)]) for edge in edges if edge is not None]
            if len(ends) < len(edges):
                raise UserError("The lines at an arc meet in no edge.")
            numbers = [_edge_between(made.made.body, *pair) for pair in ends]
            if len(numbers) == 1:
                body, circle = rounded_edge(made.made.body, numbers[0], radius)
            else:
                body, circle = rounded_end(made.made.body, numbers[0], numbers[1])
            made = made.after(number, PlacedRound(circle), body)
        except UserError as problem:
            made = made.without(LEFT_OUT[1], problem)
    return made


def _vertices_at(graph: LineGraph, places: Array, reach: float) -> list[int]:
    away = np.linalg.norm(graph.places[:, None] - places, axis=2)
    return [int(k) for k in away.argmin(axis=0)] if away.min(axis=0).max() < reach else []


def _edge_at(
    body: PlanarBody, graph: LineGraph, bend: Bend, number: int, size: float
) -> tuple[int, int] | None:
    """Return the edge in the place of an arc: it joins the corners on both sides of the body."""
    corner = bend.corners[number]
    found = _vertices_at(graph, np.stack((corner, corner + bend.shift)), CORNER * size)
    if len(found) < 2:
        return None
    one, two = found
    edges = {tuple(edge) for edge in edges_of(body.faces).tolist()}
    return (one, two) if (min(one, two), max(one, two)) in edges else None


def _edge_between(body: PlanarBody, start: Array, end: Array) -> tuple[int, int]:
    """Return an edge by its ends, mm: numbers change with what was rounded before."""
    found = [int(np.linalg.norm(body.vertices - place, axis=1).argmin()) for place in (start, end)]
    return found[0], found[1]


def _radius(
    body: PlanarBody, graph: LineGraph, bend: Bend, edges: list[tuple[int, int] | None]
) -> float:
    """Return the radius of a rounded corner, mm: the mean of where its arcs begin, on all lines."""
    found = []
    edge = edges[0]
    if edge is None or len(bend.corners) > 1:
        return 0.0
    pairs = [tuple(line) for line in graph.lines.tolist()]
    for number, (_, at, corner) in enumerate(bend.ends):
        vertex = edge[0] if number < len(bend.ends) // 2 else edge[1]
        others = [a + b - vertex for a, b in pairs if vertex in (a, b)]
        others = [other for other in others if other not in edge]
        if not others:
            continue
        spans = graph.places[others] - graph.places[vertex]
        way = (at - corner) / max(float(np.linalg.norm(at - corner)), 1e-12)
        cosine = spans @ way / np.linalg.norm(spans, axis=1)
        best = int(cosine.argmax())
        span = float(np.linalg.norm(spans[best]))
        length = float(np.linalg.norm(body.vertices[others[best]] - body.vertices[vertex]))
        found.append(length * float(np.linalg.norm(at - corner)) / span)
    if not found:
        raise UserError("Nothing tells the radius of an arc.")
    return float(np.mean(found))


def _on_face(
    body: PlanarBody, ellipse: Ellipse, light: bool, camera: Camera, *, near: Array | None = None
) -> Circle:
    """Return the circle that a rim is on a face.

    Parameters
    ----------
    body : PlanarBody
        What it is drawn on.
    ellipse : Ellipse
        px.
    light : bool
        Whether it is drawn as what is hidden: it lies on a face that looks away then.
    camera : Camera
        The view.
    near : (2,) float64, optional
        A place of the face, px; the centre of the ellipse by default.

    Raises
    ------
    UserError
        If it is on none.
    """
    pixels = ellipse.at(np.linspace(0.0, TURN, SAMPLES, endpoint=False))
    place = ellipse.center if near is None else near
    sight = camera.rays(place[None]).directions[0]
    hit = None if light else face_under(body, camera, place)
    best: tuple[float, Circle] | None = None
    for face, (normal, offset) in enumerate(zip(body.normals, body.offsets, strict=True)):
        if (float(normal @ sight) < 0.0) == light:
            continue
        circle = circle_in_plane(pixels, camera, normal, float(offset), face)
        is_seen = hit is not None and hit[1] == face
        if circle is None or circle.deviation > (FITS_SEEN if is_seen else FITS):
            continue
        points = camera.on_plane(pixels, offset * normal, normal)
        if within_face(body, face, points).mean() < (INSIDE_SEEN if is_seen else INSIDE):
            continue
        hidden = 0.0 if light or is_seen else FITS_SEEN
        if best is None or circle.deviation + hidden < best[0]:
            best = circle.deviation + hidden, circle
    if best is None:
        raise UserError("It lies on no face. Draw it within a face, as a circle is seen there.")
    return best[1]


def _height(camera: Camera, circle: Circle, shift: Array) -> float:
    """Return how far along its axis a circle is moved by a shift on the sheet, mm."""
    ends = np.stack((circle.center, circle.center + circle.axis * circle.radius))
    begin, end = camera.project(ends)[0]
    image = (end - begin) / circle.radius
    square = float(image @ image)
    if square <= 0.0:
        raise UserError("Its axis points at the eye. Draw it from another side.")
    return float(shift @ image) / square


def _boss(
    body: PlanarBody, reading: Reading, barrel: Barrel, camera: Camera, size: RoundSizes
) -> tuple[PlacedRound, PlanarBody]:
    """Return a cylinder on one of the faces of a body, and the body with it."""
    near, far = reading.rims[barrel.near], reading.rims[barrel.far]
    problem: UserError | None = None
    for base, top in ((far, near), (near, far)):
        try:
            circle = _on_face(body, base.ellipse, False, camera)
        except UserError as found:
            problem = problem or found
            continue
        height = _height(camera, circle, top.ellipse.center - base.ellipse.center)
        if height <= 0.0:
            continue
        circle, height = _sized(circle, size), size.depth or height
        after = pushed(body, circle.face, polygon_of(circle), height)
        return PlacedRound(circle, height), after
    raise problem or UserError("Its far rim lies on no face.")


def _hole(
    body: PlanarBody,
    reading: Reading,
    rim: Rim,
    barrel: Barrel | None,
    camera: Camera,
    size: RoundSizes,
) -> tuple[PlacedRound, PlanarBody]:
    """Return a hole, as deep as its other rim is drawn or else through the wall, and the body."""
    circle = _on_face(body, rim.ellipse, rim.light, camera)
    wall, is_across = _wall_under(body, circle)
    depth, through = size.depth or wall, size.depth == 0.0
    if barrel is not None and size.depth == 0.0:
        near, far = reading.rims[barrel.near], reading.rims[barrel.far]
        other = far if rim is near else near
        depth = -_height(camera, circle, other.ellipse.center - rim.ellipse.center)
        if depth <= 0.0:
            raise UserError("Its other rim lies outside of the solid.")
        per_px = wall / max(_length(camera, circle, wall), 1e-9)
        through = depth > wall - max(NEAR * wall, NOISE * reading.size * per_px)
    reach = -depth if not through else (-wall if is_across else float("-inf"))
    circle = _sized(circle, size)
    after = pushed(body, circle.face, polygon_of(circle), reach)
    return PlacedRound(circle, 0.0 if through else depth), after


def _length(camera: Camera, circle: Circle, depth: float) -> float:
    """Return how long a line along the axis of a circle is on the sheet, px."""
    places = camera.project(np.stack((circle.center, circle.center - depth * circle.axis)))[0]
    return float(np.linalg.norm(places[1] - places[0]))


def _wall_under(body: PlanarBody, circle: Circle) -> tuple[float, bool]:
    """Return how thick a body is under a circle, mm, and whether its other face is parallel."""
    nearest: tuple[float, bool] | None = None
    for face, (normal, offset) in enumerate(zip(body.normals, body.offsets, strict=True)):
        slope = -float(normal @ circle.axis)
        if face == circle.face or slope < 1e-9:
            continue
        depth = (float(offset) - float(normal @ circle.center)) / slope
        point = circle.center - depth * circle.axis
        if depth > 1e-9 * circle.radius and within_face(body, face, point[None])[0]:
            if nearest is None or depth < nearest[0]:
                nearest = depth, slope > 1.0 - 1e-9
    if nearest is None:
        raise UserError("There is no wall under it.")
    return nearest
