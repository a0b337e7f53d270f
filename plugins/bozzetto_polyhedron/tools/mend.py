"""A touch on a mark that says what looks wrong about a drawing mends the ink there."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, override
from bozzetto_polyhedron.graph.line_graph import Finding, LineGraph
from bozzetto_polyhedron.model.same_view import on_sheet
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.mending import MENDABLE, mended
from bozzetto_polyhedron.solve.picking import REACH
from bozzetto_polyhedron.solve.pipeline import graph_of_ink, never
from bozzetto_polyhedron.tools.erase import ErasingTool

NOTHING: Final = "Nothing that a touch could mend is marked here. Touch one of the marks."


class Mend(ErasingTool):
    """What looks wrong is mended at a touch: gaps, ticks, corners that are close, loose ends."""

    id = "mend"
    title = "Mend"
    icon = "icons/mend.svg"
    hint = (
        "Touch a mark: it closes a gap, erases a tick, joins two corners, draws a line on or reads "
        "a curve as round."
    )
    gesture = "tap"
    group = "Corrections"

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Mend the ink at the mark that is touched."""
        best: tuple[float, Body, LineGraph, Finding] | None = None
        for body in state.shown(Body):
            graph = graph_of_ink(body.strokes, body.evidence, never)
            if not graph.health:
                continue
            marks = on_sheet(body, np.array([each.place for each in graph.health], float))
            away = np.linalg.norm(tap.camera.project(marks)[0] - (tap.x, tap.y), axis=1)
            for distance, finding in zip(away.tolist(), graph.health, strict=True):
                if distance < (REACH if best is None else best[0]):
                    best = distance, body, graph, finding
        if best is None:
            raise UserError(NOTHING)
        _, body, graph, finding = best
        return state.with_node(mended(body, graph, finding))

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return what a touch would mend next, and where; or that nothing is left."""
        left = [
            (body, each)
            for body in state.shown(Body)
            for each in graph_of_ink(body.strokes, body.evidence, never).health
        ]
        for body, finding in left:
            if finding.what in MENDABLE:
                x, y, z = (float(value) for value in on_sheet(body, np.array([finding.place]))[0])
                return NextStep(self.hint, place=(x, y, z))
        if left:
            return NextStep(left[0][1].sentence, tool="draw")
        return NextStep("Nothing is left to mend. Touch a corner to turn it.", tool="turn")
