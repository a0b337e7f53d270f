"""A touch on an edge, a rim or an arc gives it a dimension, which is then typed."""

from __future__ import annotations

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, override
from bozzetto_polyhedron.model.fittings import Place
from bozzetto_polyhedron.model.round_sizes import RimSize, RoundSize
from bozzetto_polyhedron.model.state import Body, Measure, PolyhedronState
from bozzetto_polyhedron.rounds.round_curves import name_of, number_at
from bozzetto_polyhedron.rounds.straightened import straightened
from bozzetto_polyhedron.solve.measured_edges import edge_at, faces_apart
from bozzetto_polyhedron.solve.picking import (
    Touched,
    TouchedRound,
    edge_at_place,
    round_line_at,
)
from bozzetto_polyhedron.tools.erase import ErasingTool
from bozzetto_polyhedron.tools.turn_solid import DRAW_FIRST


class DimensionTool(ErasingTool):
    """Lengths of edges, typed."""

    id = "dimension"
    title = "Dimension"
    icon = "icons/dimension.svg"
    group = "Sizes and angles"
    hint = "Touch an edge or a rim of a solid, then type its size under “Parameters”."
    gesture = "tap"

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Choose the dimension of an edge or a rim, or give it one."""
        place = np.array([tap.x, tap.y])
        edge = edge_at_place(state, tap.camera, place)
        round_line = round_line_at(state, tap.camera, place)
        if round_line is not None and (edge is None or round_line.distance < edge.distance):
            return round_measured(state, round_line)
        if edge is None:
            raise UserError("There is no edge here. Touch an edge or a rim of a solid.")
        return measured(state, edge)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint; where there is nothing to measure, that it is to be drawn."""
        if not state.of_kind(Body):
            return DRAW_FIRST
        if (state.chosen_of(Measure) or state.chosen_of(RoundSize)) is not None:
            return NextStep("Type its size under “Parameters”, or touch another edge.")
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


def round_measured(state: PolyhedronState, touched: TouchedRound) -> PolyhedronState:
    """Return the state with the size of the rim or arc that is touched, chosen.

    Raises
    ------
    UserError
        If nothing round is on the body there, or its size follows from edges.
    """
    body, curve = touched.body, touched.curve
    reading = straightened(body.strokes, body.evidence).reading
    if reading is None or touched.found.body is None:
        raise UserError("This drawing is no solid yet. Draw the edges that are missing first.")
    placed = touched.found.rounds.get(curve.number)
    if placed is None:
        raise UserError("Nothing round came of this line. Draw its ellipse again.")
    arc = curve.number - len(reading.rims)
    if arc >= 0 and len(reading.bends[arc].corners) > 1:
        raise UserError("A round end is as wide as its body. Type the length of an edge across it.")
    for known in state.round_sizes_of(body):
        if number_at(reading, np.array(known.place)) == curve.number:
            return state.with_node(known)
    size = RoundSize(
        id=state.unused_id(),
        name=state.unused_name("Diameter"),
        body=body.id,
        place=_place(name_of(curve, reading)),
        diameter=round(2.0 * placed.circle.radius, 6),
    )
    if arc >= 0:
        return state.with_node(size)
    return state.with_node(RimSize(**vars(size), depth=round(placed.depth, 6)))


def _place(row: np.ndarray) -> Place:
    return float(row[0]), float(row[1])
