"""A touch on an edge gives it a dimension, which is then typed."""

from __future__ import annotations

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, override
from bozzetto_polyhedron.model.fittings import Place
from bozzetto_polyhedron.model.state import Body, Measure, PolyhedronState
from bozzetto_polyhedron.solve.measured_edges import edge_at, faces_apart
from bozzetto_polyhedron.solve.picking import Touched, edge_at_place
from bozzetto_polyhedron.tools.erase import ErasingTool


class DimensionTool(ErasingTool):
    """Lengths of edges, typed."""

    id = "dimension"
    title = "Dimension"
    icon = "icons/dimension.svg"
    group = "Sizes and angles"
    hint = "Touch an edge of a solid, then type its length under “Parameters”."
    gesture = "tap"

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Choose the dimension of an edge, or give it one."""
        touched = edge_at_place(state, tap.camera, np.array([tap.x, tap.y]))
        if touched is None:
            raise UserError("There is no edge here. Touch an edge of a solid.")
        return measured(state, touched)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint; where there is nothing to measure, that it is to be drawn."""
        if not state.of_kind(Body):
            return NextStep("Draw every edge of a solid first.", tool="draw")
        if state.chosen_of(Measure) is not None:
            return NextStep("Type its length under “Parameters”, or touch another edge.")
        return NextStep(self.hint)


def measured(state: PolyhedronState, touched: Touched) -> PolyhedronState:
    """Return the state with a dimension at the edge that is touched, chosen.

    Raises
    ------
    UserError
        If the edge is not between two parallel faces.
    """
    found, body = touched.found, touched.body
    if found.answer is None or found.base is None:
        raise UserError("This drawing is no solid yet. Draw the edges that are missing first.")
    first, second = (int(corner) for corner in found.graph.lines[touched.number])
    for measure in state.measures_of(body):
        known = edge_at(found.graph, measure.begin, measure.end)
        if known is not None and set(known) == {first, second}:
            return state.with_node(measure)
    faces = faces_apart(found.answer, (first, second))
    if faces is None:
        raise UserError("This edge is not between two parallel faces. Touch another edge.")
    offsets, normals = found.base.offsets[list(faces)], found.base.normals[list(faces)]
    apart = abs(float(offsets[0] - offsets[1] * np.sign(normals[0] @ normals[1])))
    return state.with_node(
        Measure(
            id=state.unused_id(),
            name=state.unused_name("Length"),
            body=body.id,
            begin=_place(found.graph.places[first]),
            end=_place(found.graph.places[second]),
            length=max(round(apart / body.placement.scale, 6), 1e-3),
        )
    )


def _place(row: np.ndarray) -> Place:
    return float(row[0]), float(row[1])
