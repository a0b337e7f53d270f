"""A stroke from a body outward puts copies of it along the stroke."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import Strokes
from bozzetto.plugin import Context, Ink, NextStep, override
from bozzetto_polyhedron.drawing_on.copies import MOST_COPIES
from bozzetto_polyhedron.model.changes import Copies
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.changes import path_in_space
from bozzetto_polyhedron.solve.picking import solids_in
from bozzetto_polyhedron.solve.pipeline import changed_until, with_change
from bozzetto_polyhedron.tools.change_tool import ChangeTool

APART: Final = 1.25
"""Distance of copies along the stroke, in extents of the body on its way, where none is typed."""

FIRST_MOST: Final = 12
"""Copies that a stroke makes at most before a number is typed."""


class CopiesTool(ChangeTool):
    """Copies along a stroke."""

    id = "copies"
    title = "Copies"
    icon = "icons/copies.svg"
    group = "Copies"
    hint = "Draw a line from a solid outward: copies of it stand along the line."
    makes = Copies
    then = NextStep("Type how many there are, or draw another line.")

    @override
    def draw(self, state: PolyhedronState, ink: Ink, context: Context) -> PolyhedronState:
        """Put copies of the solid on which the stroke begins along it."""
        problem: UserError | None = None
        for body in solids_in(state):
            stroke = ink.strokes[-1]
            if not body.placement.is_identity:
                stroke = stroke.moved(body.placement.inverse())
            strokes = Strokes([stroke])
            made = changed_until(body, state).body
            try:
                path = path_in_space(made, strokes)
            except UserError as found:
                problem = problem or found
                continue
            copies = Copies(
                id=state.unused_id(),
                name=state.unused_name("Copies"),
                body=body.id,
                strokes=strokes,
                count=_first_count(made.vertices, path),
            )
            return with_change(state, body, copies)
        raise problem or UserError("There is no solid to copy. Turn a drawing into one first.")


def _first_count(vertices: np.ndarray, path: np.ndarray) -> int:
    """Return how many copies stand along a line without touching, two at least."""
    length = float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
    way = path[-1] - path[0]
    across = vertices @ (way / max(float(np.linalg.norm(way)), 1e-300))
    step = APART * max(float(np.ptp(across)), length / MOST_COPIES)
    return int(np.clip(1 + length // step, 2, FIRST_MOST))
