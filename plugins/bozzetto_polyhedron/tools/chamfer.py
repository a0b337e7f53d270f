"""A touch on an edge bevels it; its dot makes the bevel wider or narrower."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, override
from bozzetto_polyhedron.drawing_on.body_hits import met_by
from bozzetto_polyhedron.drawing_on.chamfer import room_at_edge
from bozzetto_polyhedron.drawing_on.cylinders import round_edges
from bozzetto_polyhedron.drawing_on.named_edges import shares_of
from bozzetto_polyhedron.model.changes import Chamfer, Point
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solve.picking import REACH, solids_in
from bozzetto_polyhedron.solve.pipeline import changed_until, with_change
from bozzetto_polyhedron.tools.change_tool import ChangeTool

FIRST_WIDTH: Final = 0.15
"""Width of a new chamfer, as share of the narrower face at its edge."""


class ChamferTool(ChangeTool):
    """Bevels along edges."""

    id = "chamfer"
    title = "Chamfer"
    icon = "icons/chamfer.svg"
    group = "Edges"
    hint = "Touch an edge of a solid to bevel it."
    gesture = "tap"
    hovers = True
    makes = Chamfer
    then = NextStep("Drag its dot or type its width, or touch another edge.", tool="push")

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Bevel the edge that is touched."""
        for body in solids_in(state):
            camera = tap.camera.moved(body.placement.inverse())
            changed = changed_until(body, state)
            made = changed.body
            met = met_by(made, camera, np.array([tap.x, tap.y]), REACH / 2.0)
            if met is None:
                continue
            edges = edges_of(made.faces)
            ends = edges[met.number].tolist() if met.case == "edge" else [met.number]
            rims = {v for edge in round_edges(made, changed.circles) for v in edge}
            if met.case != "face" and rims.issuperset(ends):
                raise UserError("The rim of a circle has no chamfer yet. Touch a straight edge.")
            if met.case != "edge":
                raise UserError("Touch an edge, away from its corners.")
            first, last = (int(v) for v in ends)
            begin, end = shares_of(made, made.vertices[[first, last]])
            width = rounded(FIRST_WIDTH * room_at_edge(made, (first, last)))
            chamfer = Chamfer(
                id=state.unused_id(),
                name=state.unused_name("Chamfer"),
                body=body.id,
                begin=_point(begin),
                end=_point(end),
                width=width,
            )
            return with_change(state, body, chamfer)
        raise UserError("There is no edge here. Touch an edge of a solid.")


def rounded(value: float) -> float:
    """Return a length with four digits: what a person reads is what is cut."""
    return float(f"{value:.4g}")


def _point(row: np.ndarray) -> Point:
    x, y, z = (float(value) for value in row)
    return x, y, z
