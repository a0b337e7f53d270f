"""Commands on bodies: a new one, on the ground, of sheet, with right angles."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context
from bozzetto_polyhedron.commands.answers import chosen_body
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.pipeline import solved
from bozzetto_polyhedron.solve.standing import standing_of, with_sheet_moved

SHEET: Final = 0.02
"""Thickness of a sheet in extents of the body, where none is given yet."""


def begin_body(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with nothing chosen: the next stroke away from all drawings begins anew."""
    return replace(state, selected="")


def right_angles(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with right angles made exact, or left as drawn."""
    return replace(state, exact=not state.exact)


def equal_lengths(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with lengths that are nearly equal made so, or left as drawn."""
    return replace(state, equal=not state.equal)


def unfolded(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state whose files get nets to cut and fold, or solids again."""
    return replace(state, files="solids" if state.files != "solids" else "nets")


def sheet(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with the chosen body of sheet metal, or solid again."""
    body = chosen_body(state)
    if body.wall > 0.0:
        return state.with_node(replace(body, wall=0.0))
    found = solved(body, state)
    if found.body is None:
        raise UserError(found.problem or "This drawing is no solid yet. Draw on.")
    extent = float(np.linalg.norm(np.ptp(found.body.vertices, axis=0)))
    return state.with_node(replace(body, wall=float(f"{SHEET * extent:.1g}")))


def on_the_ground(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with the chosen body standing on z = 0.

    Drawings of its sheet that are no solids yet come along.
    """
    body = chosen_body(state)
    found = solved(body, state)
    if found.body is None:
        raise UserError(found.problem or "This drawing is no solid yet. Draw on.")
    way = standing_of(body, found.body)
    if way is None:
        raise UserError("This body has no face to stand on. Turn it with the object's handles.")
    others = (each for each in state.of_kind(Body) if each.id != body.id)
    if any(each.choice is not None and each.placement == body.placement for each in others):
        return state.with_node(replace(body, placement=way.after(body.placement)))
    return with_sheet_moved(state, body, way)
