"""Loops on faces and changed edges: outlines, and the dots that they are dragged by."""

from __future__ import annotations

from math import sin
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.scene import Handle, Item, Lines
from bozzetto_polyhedron.drawing_on.chamfer import faces_at_edge
from bozzetto_polyhedron.drawing_on.named_edges import edge_named
from bozzetto_polyhedron.drawing_on.rounded_edges import half_angle
from bozzetto_polyhedron.model.changes import EdgeChange, Fillet, Push
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.changes import loop_of
from bozzetto_polyhedron.solve.pipeline import changed_until

HANDLE: Final = "push:"
"""Before the id of a loop: the id of its dot."""

WIDTH_HANDLE: Final = "width:"
"""Before the id of a chamfer or a round edge: the id of its dot."""


def loop_in_model(state: PolyhedronState, body: Body, push: Push) -> tuple[Array, Array]:
    """Return the corners (n, 3) of a loop on its face, mm, and the outward normal of the face.

    Raises
    ------
    UserError
        If it lies on no face any more.
    """
    loop = loop_of(changed_until(body, state, push).body, push)
    corners = body.placement.points(loop.corners)
    normal = np.cross(corners - corners[0], np.roll(corners, -1, axis=0) - corners[0]).sum(axis=0)
    return corners, np.asarray(normal / np.linalg.norm(normal))


def edge_in_model(
    state: PolyhedronState, body: Body, change: EdgeChange
) -> tuple[Array, Array, float]:
    """Return the middle of a changed edge, mm, and the way on which its dot runs.

    Returns
    -------
    start : (3,) float64
    along : (3,) float64
        Unit vector from the old edge to the middle of the bevel or of the arc.
    per_size : float
        Way of the dot for one mm of width or radius.

    Raises
    ------
    UserError
        If the edge is gone.
    """
    made = changed_until(body, state, change).body
    edge = edge_named(made, change.begin, change.end)
    into_first, into_second = faces_at_edge(made, edge)
    into = 0.5 * (into_first + into_second)
    length = float(np.linalg.norm(into))
    middle = made.vertices[list(edge)].mean(axis=0)
    direction = body.placement.directions(into[None] / length)[0]
    per_size = 1.0 / sin(half_angle(made, edge)) - 1.0 if isinstance(change, Fillet) else length
    return body.placement.points(middle[None])[0], direction, per_size


def loop_items(state: PolyhedronState, body: Body) -> list[Item]:
    """Return the outlines and dots of all loops on a body, and the dots of its edges."""
    items: list[Item] = []
    for change in state.changes_of(body):
        try:
            if isinstance(change, Push):
                items += _of_loop(state, body, change)
            elif isinstance(change, EdgeChange):
                items.append(_of_edge(state, body, change))
        except UserError:
            continue
    return items


def _of_loop(state: PolyhedronState, body: Body, push: Push) -> list[Item]:
    corners, normal = loop_in_model(state, body, push)
    items: list[Item] = []
    if push.depth == 0.0 and not push.through:
        ring = np.concatenate((corners, corners[:1])).astype(np.float32)
        items.append(Lines(ring, color="accent", width=1.6))
    depth = 0.0 if push.through else push.depth * body.placement.scale
    x, y, z = (float(value) for value in corners.mean(axis=0) + depth * normal)
    return [*items, Handle(HANDLE + push.id, (x, y, z), tip="Push in or pull out")]


def _of_edge(state: PolyhedronState, body: Body, change: EdgeChange) -> Item:
    start, along, per_size = edge_in_model(state, body, change)
    way = change.size * per_size * body.placement.scale
    x, y, z = (float(value) for value in start + way * along)
    return Handle(WIDTH_HANDLE + change.id, (x, y, z), tip="Make it wider or narrower")
