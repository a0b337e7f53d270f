"""A touch on an edge bevels or rounds it; its dot makes that wider or narrower."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep, Tap, override
from bozzetto_polyhedron.drawing_on.body_hits import met_by
from bozzetto_polyhedron.drawing_on.chamfer import room_at_edge
from bozzetto_polyhedron.drawing_on.cylinders import round_edges
from bozzetto_polyhedron.drawing_on.named_edges import shares_of
from bozzetto_polyhedron.drawing_on.rounded_edges import largest_radius
from bozzetto_polyhedron.model.changes import Chamfer, EdgeChange, Fillet, Point
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solve.picking import REACH, solids_in
from bozzetto_polyhedron.solve.pipeline import changed_until, with_change
from bozzetto_polyhedron.tools.change_tool import ChangeTool

FIRST_SIZE: Final = 0.15
"""Size of a new chamfer or round edge, as share of what the narrower face at its edge allows."""


class EdgeTool(ChangeTool):
    """Changes the edge that is touched."""

    gesture = "tap"
    group = "Edges"
    hovers = True
    makes: ClassVar[type[EdgeChange]]

    @abstractmethod
    def most(self, body: PlanarBody, edge: tuple[int, int]) -> float:
        """Return the size at which the narrower face at an edge is gone, mm."""

    @override
    def tap(self, state: PolyhedronState, tap: Tap, context: Context) -> PolyhedronState:
        """Change the edge that is touched."""
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
                raise UserError("A round rim cannot be changed yet. Touch a straight edge.")
            if met.case != "edge":
                raise UserError("Touch an edge, away from its corners.")
            first, last = (int(v) for v in ends)
            begin, end = shares_of(made, made.vertices[[first, last]])
            change = self.makes(
                id=state.unused_id(),
                name=state.unused_name(self.title),
                body=body.id,
                begin=_point(begin),
                end=_point(end),
            )
            size = rounded(FIRST_SIZE * self.most(made, (first, last)))
            return with_change(state, body, change.sized(size))
        raise UserError("There is no edge here. Touch an edge of a solid.")


class ChamferTool(EdgeTool):
    """Bevels along edges."""

    id = "chamfer"
    title = "Chamfer"
    icon = "icons/chamfer.svg"
    hint = "Touch an edge of a solid to bevel it."
    makes = Chamfer
    then = NextStep(
        "Touch another edge, type its width, or drag its dot with “Push or pull”.", tool="push"
    )

    @override
    def most(self, body: PlanarBody, edge: tuple[int, int]) -> float:
        """Return how far the faces reach from the edge."""
        return room_at_edge(body, edge)


class RoundEdge(EdgeTool):
    """Edges rounded with a radius."""

    id = "round"
    title = "Round edge"
    icon = "icons/round.svg"
    hint = "Touch an edge of a solid to round it."
    makes = Fillet
    then = NextStep(
        "Touch another edge, type its radius, or drag its dot with “Push or pull”.", tool="push"
    )

    @override
    def most(self, body: PlanarBody, edge: tuple[int, int]) -> float:
        """Return the radius at which the arc takes all of a face."""
        return largest_radius(body, edge)


def rounded(value: float) -> float:
    """Return a length with four digits: what a person reads is what is cut."""
    return float(f"{value:.4g}")


def _point(row: np.ndarray) -> Point:
    x, y, z = (float(value) for value in row)
    return x, y, z
