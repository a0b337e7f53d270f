"""A touch on a body of another object frees the piece under the pen; another takes it back."""

from __future__ import annotations

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, override
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto_polyhedron.commands.pieces import has_followed, touched_piece
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.followed import divided_of
from bozzetto_polyhedron.tools.erase import ErasingTool


class FreePiece(ErasingTool):
    """Pieces of other objects as bodies of their own."""

    id = "free"
    title = "Free a piece"
    icon = "icons/free.svg"
    group = "Mechanism"
    hint = "Touch a limb, a door or a lid of another object: it moves by itself, once it is hinged."
    gesture = "tap"

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Free the piece under the pen, or put it back to the others."""
        if state.moved is not None:
            raise UserError("Pieces are freed at rest. Choose “Back to rest” first.")
        found = {}
        for part in state.shown(Followed):
            whole = divided_of(part, context.sources)
            if whole is not None:
                found[part.id] = whole
        layers = tuple(
            Layer(part_id, (Shaded(whole.mesh),), owner=part_id) for part_id, whole in found.items()
        )
        hits = cast_rays(Scene(layers), tap.camera.rays(np.array([[tap.x, tap.y]])))
        if not layers or not hits.hit[0]:
            raise UserError(f"There is nothing of another object here. {self.hint}")
        owner = hits.owners[0]
        name = found[owner].names[int(found[owner].piece[hits.faces[0]])]
        return touched_piece(state, context.sources, state.node(owner), name)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return the hint; where there is nothing to free, how it comes here."""
        if not has_followed(state):
            return NextStep(
                "Choose another object in the list, then “Use as input for” this one in the menu."
            )
        return NextStep(self.hint)
