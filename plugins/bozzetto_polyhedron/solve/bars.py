"""Drawings whose lines can only be meant as the bars of a linkage."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.view import Camera
from bozzetto_polyhedron.model.fittings import Place
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.picking import corner_at
from bozzetto_polyhedron.solve.pipeline import graph_of_ink, never

OF_BARS: Final = ("loose end", "corner of two lines", "open faces")
"""What is no fault of bars that lie flat: their lines may end anywhere, and two make a joint."""


def is_of_bars(body: Body) -> bool:
    """Return whether a drawing that nobody turned has lines that end alone: no solid has any."""
    if body.choice is not None or body.moves != "whole" or not len(body.strokes):
        return False
    health = graph_of_ink(body.strokes, body.evidence, never).health
    return any(finding.what == "loose end" for finding in health)


def with_bars_at(state: PolyhedronState, camera: Camera, *places: Place) -> PolyhedronState:
    """Return the state in which drawings of bars with a corner at one of some places move flat.

    Parameters
    ----------
    state : PolyhedronState
        Returned as it is where no such drawing has a corner there.
    camera : Camera
        The view.
    places : (x, y)
        px.
    """
    chosen = state.selected
    for place in places:
        if not any(map(is_of_bars, state.shown(Body))):
            return state
        touched = corner_at(state, camera, np.array(place))
        if touched is not None and is_of_bars(touched.body):
            state = state.with_node(replace(touched.body, moves="flat"))
    return replace(state, selected=chosen)
