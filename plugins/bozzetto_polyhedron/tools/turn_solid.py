"""A touch on a corner turns a drawing into a solid; another touch shows the next answer."""

from __future__ import annotations

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, override
from bozzetto_polyhedron.commands.answers import with_answer
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.picking import corner_at
from bozzetto_polyhedron.tools.erase import ErasingTool


class TurnSolid(ErasingTool):
    """Drawings become solids at a touch."""

    id = "turn"
    title = "Turn solid"
    icon = "icons/turn.svg"
    hint = "Touch a corner of the drawing to turn it into a solid; again for the next answer."
    gesture = "tap"

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Turn the drawing whose corner is touched, or show its next answer."""
        touched = corner_at(state, tap.camera, np.array([tap.x, tap.y]))
        if touched is None:
            raise UserError("There is no corner here. Touch a corner of the drawing.")
        body = touched.body
        if body.choice is None or body.id != state.selected:
            return with_answer(state, body, max(touched.found.number, 0))
        step = -1 if tap.shift else 1
        return with_answer(state, body, touched.found.number + step)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint, or that there is nothing to turn yet."""
        if not state.of_kind(Body):
            return NextStep("Draw every edge of a solid first.", tool="draw")
        return NextStep(self.hint)
