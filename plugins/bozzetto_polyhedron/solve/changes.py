"""Changes of a body after it was reconstructed, made one after another."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, Literal

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke, Strokes, distances_to_polyline
from bozzetto.plugin import remembered
from bozzetto_polyhedron.drawing_on.added_strokes import with_strokes_added
from bozzetto_polyhedron.drawing_on.chamfer import chamfered
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.drawing_on.circles import Circle, circle_on_face, polygon_of
from bozzetto_polyhedron.drawing_on.copies import copied_along, mirrored, mirrored_points, moved
from bozzetto_polyhedron.drawing_on.joints import joined_by
from bozzetto_polyhedron.drawing_on.loop_on_face import LoopOnFace, loop_on_face
from bozzetto_polyhedron.drawing_on.named_edges import edge_named, plane_named
from bozzetto_polyhedron.drawing_on.push import pushed
from bozzetto_polyhedron.drawing_on.rounded_edges import rounded_edge
from bozzetto_polyhedron.drawing_on.stroke_ends import PlacedLines
from bozzetto_polyhedron.drawing_on.stroke_path import path_of
from bozzetto_polyhedron.model.changes import (
    Added,
    Chamfer,
    Change,
    Copies,
    Fillet,
    Join,
    Mirror,
    Point,
    Push,
)
from bozzetto_polyhedron.solid.boolean import combined
from bozzetto_polyhedron.solid.face_rings import tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody

REACH: Final = 9.0
"""Distance within which a side of a loop snaps to an edge, px."""

MEETS: Final = 12.0
"""Distance within which ends of lines meet corners, edges and one another, px."""

THROUGH: Final = float("-inf")
"""Depth of a cut through all of a body."""


def changed_body(
    drawn: Changed,
    changes: Sequence[Change],
    others: Mapping[str, Changed] | None = None,
    placement: Placement | None = None,
) -> Changed:
    """Return a body after all changes, in their order; in the frame of its drawing.

    Parameters
    ----------
    drawn : Changed
        As it was reconstructed, with what was drawn round.
    changes : sequence of Change
        In their order.
    others : mapping of str to Changed, optional
        Other bodies by their ids, in the same frame; what is joined to one that is not there
        waits for it.
    placement : Placement, optional
        From the frame of the drawing to that of the model.

    Returns
    -------
    Changed
        What could not be done is left out and told.
    """
    made = drawn
    for change in changes:
        try:
            made = after(made, change, others, placement)
        except UserError as problem:
            made = replace(made, told=(*made.told, f"{change.name} is left out. {problem}"))
    return made


def loop_of(body: PlanarBody, push: Push) -> LoopOnFace:
    """Return where a loop lies on a body as it is before that loop is pushed."""
    if push.outline == "circle":
        circle = circle_of(body, push)
        return LoopOnFace(circle.face, polygon_of(circle))
    return _loop(body, push.strokes)


def circle_of(body: PlanarBody, push: Push) -> Circle:
    """Return the circle that a loop is on a face.

    Raises
    ------
    UserError
        If it is no circle there.
    """
    found = _circle(body, push.strokes)
    if found is None:
        raise UserError("This is no circle on a face. Draw it again, or set it to “As drawn”.")
    return replace(found, radius=0.5 * push.diameter) if push.diameter > 0.0 else found


def outline_of(body: PlanarBody, strokes: Strokes) -> Literal["drawn", "circle"]:
    """Return whether strokes draw a circle on a face rather than a polygon.

    What is nearer to the ink is meant: a hexagon is nearly round, and a circle has no corners.
    """
    circle = _circle(body, strokes)
    if circle is None:
        return "drawn"
    try:
        loop = _loop(body, strokes)
    except UserError:
        return "circle"
    ink = strokes[0].camera.on_plane(_as_one(strokes), circle.center, circle.axis)
    across = tangents(circle.axis)
    ring = np.concatenate((loop.corners, loop.corners[:1])) @ across.T
    away = distances_to_polyline(ink @ across.T, ring)
    straight = float(np.sqrt((away**2).mean())) / circle.radius
    return "circle" if circle.deviation < straight else "drawn"


def lines_of(made: Changed, change: Added) -> PlacedLines:
    """Return where added lines are, on a body as it was before them."""
    return _added(made.body, made.points, made.lines, change.strokes)[0]


def path_in_space(body: PlanarBody, strokes: Strokes) -> Array:
    """Return the line in space that a stroke stands for along which copies are put, (n, 3) mm."""
    return path_of(body, strokes[0].points, strokes[0].camera, MEETS)


def after(
    made: Changed,
    change: Change,
    others: Mapping[str, Changed] | None = None,
    placement: Placement | None = None,
) -> Changed:
    """Return a body after one more change; see `changed_body`.

    Raises
    ------
    UserError
        If a loop does not lie on a face any more, an edge is gone, or nothing is left.
    """
    match change:
        case Push():
            return _with_push(made, change)
        case Added():
            return _with_added(made, change.strokes)
        case Chamfer():
            if change.width <= 0.0:
                return made
            body = _chamfered(made.body, change.begin, change.end, change.width)
            return replace(made, body=body)
        case Fillet():
            return made if change.radius <= 0.0 else _with_fillet(made, change)
        case Mirror():
            return _mirrored(made, change)
        case Copies():
            return _copied(made, change)
        case Join():
            return _joined(made, change, others or {}, placement or Placement())
    return made


def _with_push(made: Changed, push: Push) -> Changed:
    if push.depth == 0.0 and not push.through:
        return made
    depth = THROUGH if push.through else push.depth
    loop = loop_of(made.body, push)
    body = _pushed(made.body, loop.face, loop.corners, depth)
    circles = made.circles
    if push.outline == "circle":
        circles = _each_once((*circles, circle_of(made.body, push)))
    return replace(made, body=body, circles=circles)


def _with_fillet(made: Changed, change: Fillet) -> Changed:
    body, circle = _rounded(made.body, change.begin, change.end, change.radius)
    return replace(made, body=body, circles=_each_once((*made.circles, circle)))


def _with_added(made: Changed, strokes: Strokes) -> Changed:
    _, closed = _added(made.body, made.points, made.lines, strokes)
    return replace(
        made,
        body=closed.body,
        points=closed.points,
        lines=closed.lines,
        sheet=closed.sheet,
        told=(*made.told, *closed.told),
    )


def _mirrored(made: Changed, change: Mirror) -> Changed:
    normal, offset = plane_named(made.body, change.place, change.normal)
    image = made.mapped(
        lambda body: mirrored(body, normal, offset),
        lambda points: mirrored_points(points, normal, offset),
    )
    if change.keeps == "image":
        return image
    body = _united(made.body, image.body)
    return replace(made, body=body, circles=_each_once((*made.circles, *image.circles)))


def _copied(made: Changed, change: Copies) -> Changed:
    path = path_in_space(made.body, change.strokes)
    copies = copied_along(made.body, path, change.count)
    body = copies[0]
    circles = list(made.circles)
    for copy in copies[1:]:
        shift = copy.vertices[0] - copies[0].vertices[0]
        body = _united(body, copy)
        circles += [replace(each, center=each.center + shift) for each in made.circles]
    return replace(made, body=body, circles=tuple(circles))


def _joined(
    made: Changed, change: Join, others: Mapping[str, Changed], placement: Placement
) -> Changed:
    other = others.get(change.other)
    if other is None:
        return made
    back = placement.inverse()
    strokes = [stroke.moved(back) for stroke in change.strokes]
    pairs = [(stroke.points, stroke.camera) for stroke in strokes]
    found = joined_by(made.body, other.body, pairs, MEETS)
    if found.body is None:
        return replace(
            made,
            points=np.concatenate((made.points, found.lines.reshape(-1, 3))),
            lines=np.concatenate(
                (
                    made.lines,
                    len(made.points) + np.arange(2 * len(found.lines)).reshape(-1, 2),
                )
            ),
            told=(*made.told, found.told),
        )
    shifted = other.mapped(
        lambda body: moved(body, found.shift), lambda points: points + found.shift
    )
    return replace(
        made,
        body=found.body,
        circles=(*made.circles, *shifted.circles),
        joined=(*made.joined, change.other, *other.joined),
        told=(*made.told, *((found.told,) if found.told else ())),
    )


def _each_once(circles: Sequence[Circle]) -> tuple[Circle, ...]:
    """Return circles without those that are the same in space."""
    kept: list[Circle] = []
    for circle in circles:
        same = any(
            np.abs(circle.center - other.center).max() < 1e-9 * circle.radius
            and abs(abs(circle.axis @ other.axis) - 1.0) < 1e-12
            and abs(circle.radius - other.radius) < 1e-9 * circle.radius
            and abs(circle.sweep - other.sweep) < 1e-9
            for other in kept
        )
        if not same:
            kept.append(circle)
    return tuple(kept)


def _key(value: Any) -> Hashable:
    if isinstance(value, PlanarBody):
        return value.vertices.tobytes(), value.faces, value.normals.tobytes()
    if isinstance(value, np.ndarray):
        return value.tobytes()
    return value  # type: ignore[no-any-return]


def _by_content(*asked: Any) -> Hashable:
    return tuple(_key(value) for value in asked)


@remembered(limit=64, key=_by_content)
def _loop(body: PlanarBody, strokes: Strokes) -> LoopOnFace:
    camera = strokes[0].camera
    return loop_on_face(body, [stroke.points for stroke in strokes], camera, REACH)


@remembered(limit=64, key=_by_content)
def _circle(body: PlanarBody, strokes: Strokes) -> Circle | None:
    return circle_on_face(body, _as_one(strokes), strokes[0].camera)


@remembered(limit=64, key=_by_content)
def _pushed(body: PlanarBody, face: int, corners: Array, depth: float) -> PlanarBody:
    return pushed(body, face, corners, depth)


@remembered(limit=64, key=_by_content)
def _added(
    body: PlanarBody, points: Array, lines: Index, strokes: Strokes
) -> tuple[PlacedLines, Changed]:
    paths = [stroke.points for stroke in strokes]
    before = Changed(body, points=points, lines=lines)
    return with_strokes_added(before, paths, strokes[0].camera, MEETS)


@remembered(limit=64, key=_by_content)
def _chamfered(body: PlanarBody, begin: Point, end: Point, width: float) -> PlanarBody:
    return chamfered(body, edge_named(body, begin, end), width)


@remembered(limit=64, key=_by_content)
def _rounded(
    body: PlanarBody, begin: Point, end: Point, radius: float
) -> tuple[PlanarBody, Circle]:
    return rounded_edge(body, edge_named(body, begin, end), radius)


@remembered(limit=64, key=_by_content)
def _united(first: PlanarBody, second: PlanarBody) -> PlanarBody:
    return combined(first, second, "union")


def _as_one(strokes: Sequence[Stroke]) -> Array:
    """Return the points of strokes one after another, each begun at its nearer end."""
    chain = strokes[0].points
    for stroke in strokes[1:]:
        ends = np.linalg.norm(stroke.points[[0, -1]] - chain[-1], axis=1)
        chain = np.vstack((chain, stroke.points if ends[0] <= ends[1] else stroke.points[::-1]))
    return chain
