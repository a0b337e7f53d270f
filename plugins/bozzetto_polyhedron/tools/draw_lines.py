"""Draw the edges of a solid; after every stroke the lines show how they were understood."""

from __future__ import annotations

from contextlib import suppress
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, Ink, NextStep, override
from bozzetto.scene import Scene
from bozzetto_polyhedron.commands.answers import chosen_body, has_body
from bozzetto_polyhedron.commands.pieces import has_followed, step_of_followed
from bozzetto_polyhedron.model.assign_stroke import with_strokes
from bozzetto_polyhedron.model.changes import Added, Join
from bozzetto_polyhedron.model.same_view import on_sheet, where_seen
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.kept_poses import at_rest_here
from bozzetto_polyhedron.solve.mending import MENDABLE
from bozzetto_polyhedron.solve.pipeline import Solved, graph_of_ink, never, solved
from bozzetto_polyhedron.solve.round_lines import is_column
from bozzetto_polyhedron.solve.spots import is_linkage, places_of_findings
from bozzetto_polyhedron.solve.standing import stood
from bozzetto_polyhedron.tools.added_lines import with_added
from bozzetto_polyhedron.tools.erase import ErasingTool
from bozzetto_polyhedron.tools.turn_solid import TurnSolid, sentence_of
from bozzetto_polyhedron.view.scene import scene_after

FEWEST: Final = 6
"""Lines of the smallest solid, a tetrahedron: with fewer there is nothing to say yet."""

FIRST: Final = "Draw every edge of a solid, one stroke each, and the hidden ones lightly."

LINKAGE: Final = "These bars move: pull a corner with “Move”, or press P to play."


class DrawLines(ErasingTool):
    """Edges one by one, in any order and direction, drawn over and over if one likes."""

    id = "draw"
    title = "Draw lines"
    icon = "icons/draw.svg"
    hint = FIRST

    @override
    def draw(self, state: PolyhedronState, ink: Ink, context: Context) -> PolyhedronState:
        """Add ink to the drawing or the solid that it belongs to, or begin a new drawing.

        What has moved is at rest from then on as it was drawn upon.
        """
        state = at_rest_here(state, context.sources)
        for stroke in ink.strokes:
            stroke = where_seen(stroke, state, context.seen)
            added = with_added(state, stroke)
            if added is None:
                added = with_strokes(state, [stroke])
                if context.alone:
                    added = stood(state, added, added.selected)
            state = added
        return state

    @override
    def preview(self, state: PolyhedronState, gesture: Gesture, context: Context) -> Scene:
        """Return what lines that meet a solid would make of it."""
        if not isinstance(gesture, Ink):
            return Scene()
        made = resting = at_rest_here(state, context.sources)
        for stroke in gesture.strokes:
            made = with_added(made, stroke) or made
        return Scene() if made is resting else scene_after(made, context.sources)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the first thing that looks wrong, and where; or that it can be turned."""
        if state.chosen_of(Added) is not None or state.chosen_of(Join) is not None:
            return NextStep(_after_added(state))
        body = _body_meant(state)
        linkages = [one for one in state.shown(Body) if is_linkage(one, state)]
        if linkages and (body is None or body in linkages):
            return NextStep(LINKAGE, tool="move")
        if body is None and has_followed(state) and not has_body(state):
            return step_of_followed(state)
        if body is None:
            return NextStep(FIRST)
        graph = graph_of_ink(body.strokes, body.evidence, never)
        if len(graph.lines) < FEWEST:
            return NextStep("Go on: every edge of the solid, the hidden ones lightly.")
        if graph.health:
            finding = graph.health[0]
            x, y, z = (float(v) for v in on_sheet(body, np.array([finding.place]))[0])
            if body.choice is not None:
                with suppress(UserError):
                    places = places_of_findings(body, solved(body, state), [finding])
                    x, y, z = places[0].tolist()
            by_touch = " “Mend” does it at a touch." if finding.what in MENDABLE else ""
            return NextStep(f"{finding.sentence}{by_touch}", place=(x, y, z))
        if body.choice is None:
            touched = "rim" if is_column(body) else "corner"
            return NextStep(f"The lines close. Touch a {touched} to turn it.", tool=TurnSolid.id)
        found: Solved | None = None
        with suppress(UserError):
            found = solved(body, state)
        return NextStep(sentence_of(found, state))


def _body_meant(state: PolyhedronState) -> Body | None:
    """Return the body that is chosen, or that what is chosen belongs to, or the only one."""
    with suppress(UserError):
        return chosen_body(state)
    return None


def _after_added(state: PolyhedronState) -> str:
    """Return what to do after lines were added to a solid."""
    body = state.node(state.body_of_chosen())
    changed = solved(body, state).changed
    if changed is not None and changed.told:
        return changed.told[-1]
    if changed is not None and len(changed.lines):
        return "Go on: lines that close become faces, and faces that close join the solid."
    return "Draw more lines on the solid, in any view, or turn it to see what became of them."
