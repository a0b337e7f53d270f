"""The body while something is dragged: what was there before is remembered, and goes along."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.plugin import remembered
from bozzetto_car.body.body import FEW_REMEMBERED, REMEMBERED, Body
from bozzetto_car.body.build import body_of
from bozzetto_car.body.edit_row import Same
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.state import CarState


def body_at_rest_of(state: CarState) -> Body:
    """Return the body of a car that nobody drags; see `preview_of`, which goes on from there.

    Raises
    ------
    UserError
        As `body_of` does.
    """
    _dimensions_at_rest.put(state.dimensions, state)
    return body_of(state)


def preview_of(state: CarState) -> Body:
    """Return the body of a car quickly, while something is dragged.

    While a dimension is dragged that is kept, the body is stretched to it and not solved for it:
    the solve without dimensions stays the same and is remembered, and stretching takes a
    hundredth of the time of another solve. While the shape is dragged, edits are not repeated:
    their effect is carried over from the first car that was seen with them; see
    `unstretched_body_of`.

    Raises
    ------
    UserError
        As `body_of` does.
    """
    is_stretched = state.dimensions != _dimensions_at_rest(state)
    shown = replace(state, lock=False) if is_stretched and state.lock else state
    if not state.edits:
        return body_of(shown)
    first = _first_seen(shown)
    body = body_of(shown, None if first is shown else first)
    return _as_dragged(body) if is_stretched else body


@remembered(limit=REMEMBERED)
def _as_dragged(body: Body) -> Body:
    return replace(body, is_dragged=True)


@remembered(limit=FEW_REMEMBERED, key=lambda state: Same(state.nodes))
def _dimensions_at_rest(state: CarState) -> Dimensions:
    """Return the dimensions that a car with these very sketches had when nobody dragged it."""
    return state.dimensions


@remembered(
    limit=FEW_REMEMBERED,
    key=lambda state: (
        Same(state.edits),
        state.smooth,
        state.default_shape,
        state.annealed,
        state.lock,
        state.joints,
        state.flowing,
    ),
)
def _first_seen(state: CarState) -> CarState:
    """Return the first car that was seen with the edits and the manner of deforming of a car."""
    return state
