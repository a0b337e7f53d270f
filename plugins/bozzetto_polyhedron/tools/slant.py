"""A touch on a face has it keep the angle that was drawn; another touch makes it right again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, override
from bozzetto_polyhedron.drawing_on.body_hits import face_under
from bozzetto_polyhedron.model.state import PolyhedronState, Slant
from bozzetto_polyhedron.solve.picking import solids_in
from bozzetto_polyhedron.solve.pipeline import solved
from bozzetto_polyhedron.solve.slanted_faces import slanted_faces
from bozzetto_polyhedron.tools.erase import ErasingTool


class SlantTool(ErasingTool):
    """Right angles switched off and on, face by face."""

    id = "slant"
    title = "Keep slant"
    icon = "icons/slant.svg"
    group = "Sizes and angles"
    hint = "Touch a face: it keeps the slant that was drawn. Touch it again for right angles."
    gesture = "tap"

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Have the face that is touched keep its angle, or no longer."""
        for body in solids_in(state):
            found = solved(body, state)
            if found.base is None or found.answer is None:
                continue
            hit = face_under(found.base, tap.camera, np.array([tap.x, tap.y]))
            if hit is None:
                continue
            graph, answer = found.graph, found.answer
            known = [
                slant.id
                for slant in state.slants_of(body)
                if hit[1] in slanted_faces([slant], graph, answer)
            ]
            if known:
                return replace(state.without_nodes(*known), selected=body.id)
            corners = graph.places[list(answer.faces[hit[1]][0])]
            return state.with_node(
                Slant(
                    id=state.unused_id(),
                    name=state.unused_name("Slant"),
                    body=body.id,
                    corners=tuple((float(x), float(y)) for x, y in corners),
                )
            )
        raise UserError("There is no face here. Touch a face of a solid as it was drawn.")

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint; what there is to say before there is a solid, or any right angle."""
        if not solids_in(state):
            return NextStep("Turn a drawing into a solid first.", tool="turn")
        if not state.exact:
            return NextStep("Right angles are off for all faces. Switch them on in the form.")
        return NextStep(self.hint)
