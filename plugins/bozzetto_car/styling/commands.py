"""Commands for the chosen styling curve."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from bozzetto.errors import UserError
from bozzetto.plugin import Command, Context
from bozzetto_car.body.build import body_of
from bozzetto_car.state import CarState, StylingCurve
from bozzetto_car.styling.curve import mirror_curve, stem_of
from bozzetto_car.styling.oversketch import smooth_curve

SHARE: Final = 0.02
"""Share by which one command smooths a curve; see `smooth_curve`."""


def styling_commands() -> tuple[Command, ...]:
    """Return the commands, in the order of the menu."""
    return (
        Command(
            id="smooth-styling",
            title="Smooth styling curve",
            help="Take small bends out of the chosen styling curve; its ends stay.",
            run=_smoothed,
            enabled=_has_curve,
        ),
        Command(
            id="mirror-styling",
            title="Mirror styling curve",
            help="Make the mirror image of the chosen styling curve a curve of its own.",
            run=_mirrored,
            enabled=_has_curve,
        ),
    )


def _has_curve(state: CarState) -> bool:
    return any(curve.id == state.selected for curve in state.styling)


def _chosen(state: CarState) -> StylingCurve:
    for curve in state.styling:
        if curve.id == state.selected:
            return curve
    raise UserError("No styling curve is chosen. Choose one in the list.")


def _smoothed(state: CarState, context: Context) -> CarState:
    return state.with_node(smooth_curve(_chosen(state), body_of(state), SHARE))


def _mirrored(state: CarState, context: Context) -> CarState:
    """Return the state with two curves, each on one side only, that can be changed separately."""
    curve = _chosen(state)
    name = state.unused_name(stem_of(curve.name))
    image = replace(mirror_curve(curve), id=state.unused_id(), name=name, both=False)
    return state.with_node(replace(curve, both=False)).with_node(image)
