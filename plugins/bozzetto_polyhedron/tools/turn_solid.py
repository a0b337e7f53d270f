"""A touch on a corner turns a drawing into a solid; another touch shows the next answer."""

from __future__ import annotations

from contextlib import suppress
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, override
from bozzetto_polyhedron.commands.answers import first_answer, with_answer
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.reconstruction.ranking import SURE
from bozzetto_polyhedron.solve.picking import corner_at, round_line_at
from bozzetto_polyhedron.solve.pipeline import Solved, solved
from bozzetto_polyhedron.solve.spots import places_of_findings
from bozzetto_polyhedron.tools.erase import ErasingTool

LAID: Final = {"nets": "The net lies", "faces": "Every face lies flat"}
"""What is said of what files get, where that is not the solid."""

DRAW_FIRST: Final = NextStep("Draw every edge of a solid first.", tool="draw")
"""Where there is no drawing, of a tool that needs one."""


class TurnSolid(ErasingTool):
    """Drawings become solids at a touch."""

    id = "turn"
    title = "Turn solid"
    icon = "icons/turn.svg"
    hint = "Touch a corner or a rim to turn the drawing into a solid; again for the next answer."
    gesture = "tap"

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Turn the drawing whose corner is touched, or show its next answer."""
        place = np.array([tap.x, tap.y])
        touched = corner_at(state, tap.camera, place) or round_line_at(state, tap.camera, place)
        if touched is None:
            raise UserError("There is no corner here. Touch a corner or a rim of the drawing.")
        body = touched.body
        if body.choice is None:
            corner = touched.found.graph.places[touched.number]
            return first_answer(state, body, corner, alone=context.alone)
        if body.id != state.selected:
            number = max(touched.found.number, 0)
        else:
            number = touched.found.number + (-1 if tap.shift else 1)
        return with_answer(state, body, number, alone=context.alone)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint, or what came of the touch: what looks wrong first, and where."""
        if not state.of_kind(Body):
            return DRAW_FIRST
        body = state.chosen_of(Body)
        if body is None or body.choice is None:
            return NextStep(self.hint)
        found: Solved | None = None
        with suppress(UserError):
            found = solved(body, state)
        if found is not None and found.graph.health and not (found.body and found.body.closed):
            finding = found.graph.health[0]
            places = places_of_findings(body, found, [finding])
            x, y, z = places[0].tolist()
            return NextStep(finding.sentence, place=(x, y, z))
        return NextStep(sentence_of(found, state))


def sentence_of(found: Solved | None, state: PolyhedronState) -> str:
    """Return what to do with a solid that was turned."""
    if found is None or found.answer is None:
        return "These lines make no shape yet. Draw the edges that are missing."
    if found.problem:
        return found.problem
    if state.files != "solids":
        return f"{LAID[state.files]} beside it: Home shows all of it. SVG and DXF get it."
    count, sure = len(found.answers), found.answer.confidence
    if count > 1 and sure < SURE:
        return f"Is it this one? X shows the next of {count} answers."
    if count > 1:
        return f"Turn the view to see it. X shows another of {count} answers."
    return "Turn the view to see it."
