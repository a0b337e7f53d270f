"""The lines in space that stand for what was done to a body: to show them, and to erase them."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_polyhedron.drawing_on.body_hits import met_by
from bozzetto_polyhedron.drawing_on.named_edges import edge_named
from bozzetto_polyhedron.model.changes import Added, Change, Copies, EdgeChange, Join, Push
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.changes import MEETS, lines_of, loop_of, path_in_space
from bozzetto_polyhedron.solve.pipeline import changed_until


def change_lines(body: Body, state: PolyhedronState, change: Change) -> list[Array]:
    """Return the lines of a change, each (n, 3) mm in the model's frame.

    Those of added lines and of joints are in the order of their strokes; what cannot be found any
    more has none.
    """
    try:
        found = _lines(body, state, change)
    except UserError:
        return []
    if isinstance(change, Join):
        return found
    return [body.placement.points(line) for line in found]


def _lines(body: Body, state: PolyhedronState, change: Change) -> list[Array]:
    if isinstance(change, Join):
        return _of_join(body, state, change)
    made = changed_until(body, state, change)
    match change:
        case Added():
            placed = lines_of(made, change)
            return list(placed.points[placed.lines])
        case Push():
            corners = loop_of(made.body, change).corners
            return [np.concatenate((corners, corners[:1]))]
        case EdgeChange():
            edge = edge_named(made.body, change.begin, change.end)
            return [made.body.vertices[list(edge)]]
        case Copies():
            return [path_in_space(made.body, change.strokes)]
    return []


def _of_join(body: Body, state: PolyhedronState, join: Join) -> list[Array]:
    """Return each stroke from where it meets the first body to where it meets the other."""
    other = state.node(join.other)
    bodies = [
        (changed_until(body, state, join).body, body.placement),
        (changed_until(other, state).body, other.placement),
    ]
    lines = []
    for stroke in join.strokes:
        for ends in (stroke.points[[0, -1]], stroke.points[[-1, 0]]):
            met = [
                met_by(made, stroke.camera.moved(placement.inverse()), place, MEETS)
                for (made, placement), place in zip(bodies, ends, strict=True)
            ]
            if met[0] is not None and met[1] is not None:
                points = np.stack((met[0].point, met[1].point))
                lines.append(
                    np.concatenate(
                        [
                            placement.points(point[None])
                            for (_, placement), point in zip(bodies, points, strict=True)
                        ]
                    )
                )
                break
        else:
            lines.append(np.zeros((0, 3)))
    return lines
