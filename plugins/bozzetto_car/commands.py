"""Commands for a car: changes of the whole body, and its file as a template."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from bozzetto.errors import UserError
from bozzetto.plugin import Command, Context
from bozzetto_car.body.build import body_in_work, body_of, world_of
from bozzetto_car.marking.commands import marking_commands
from bozzetto_car.marking.edit_marks import unlocked_sketch, with_sides_exchanged
from bozzetto_car.state import CarState, Treatment
from bozzetto_car.template.writer import template_file


def all_commands() -> tuple[Command, ...]:
    """Return all commands but those for styling curves, in the order of the menu."""
    return (
        Command(
            "new-car", "New car",
            "Begin a car without a sketch; the panel shows the templates to choose from.",
            lambda state, context: state, enabled=lambda state: not is_shaped(state),
        ),
        *marking_commands(),
        Command(
            "exchange-sides", "Exchange left and right",
            "The marks of this sketch belong to the other side of the car.",
            _exchanged, enabled=_has_marks,
        ),
        Command(
            "anneal", "Smooth lines",
            "Bend lines as little as possible through their nodes.",
            _anneal, enabled=is_shaped,
        ),
        Command(
            "reduce", "Reduce tangents",
            "Shorten long tangents, so that no edge runs back on itself.",
            _reduce, enabled=is_shaped,
        ),
        Command(
            "pull-out", "Pull panels out",
            "Make side panels and the corners of nose and tail bulge by a default amount.",
            _pull_out, enabled=is_shaped,
        ),
        Command(
            "undo-edits", "Take back all edits",
            "Remove all edits by hand, and how lines join; the shape that the marks give stays.",
            _no_edits, enabled=lambda state: bool(state.edits or state.joints or state.flowing),
        ),
        Command(
            "save-template", "Save this car as a template",
            "Write a file with which further cars begin, and that marks files can name.",
            _template, enabled=is_shaped, writes=".json",
        ),
    )  # fmt: skip


def _has_marks(state: CarState) -> bool:
    return state.sketch is not None and bool(state.sketch.marks)


def _exchanged(state: CarState, context: Context) -> CarState:
    sketch = state.sketch
    if sketch is None or not sketch.marks:
        raise UserError("There are no marks to exchange. Choose a sketch that has some.")
    return state.with_node(with_sides_exchanged(unlocked_sketch(state)))


def _anneal(state: CarState, context: Context) -> CarState:
    return _treated(state, "anneal")


def _reduce(state: CarState, context: Context) -> CarState:
    return _treated(state, "reduce")


def _pull_out(state: CarState, context: Context) -> CarState:
    return _treated(state, "pull out")


def _treated(state: CarState, kind: Literal["anneal", "reduce", "pull out"]) -> CarState:
    edit = Treatment(dimensions=world_of(state, body_of(state)), kept=state.lock, kind=kind)
    return replace(state, edits=(*state.edits, edit))


def _no_edits(state: CarState, context: Context) -> CarState:
    return replace(state, edits=(), joints=(), flowing=())


def is_shaped(state: CarState) -> bool:
    """Whether a car is more than a bundled template."""
    return state.is_begun or bool(state.dimensions.given())


def car_as_template(state: CarState, name: str) -> bytes:
    """Return the file of a template that is a car as it is, with all edits and dimensions.

    Parameters
    ----------
    state : CarState
        The car.
    name : str
        Title of the template.

    Raises
    ------
    UserError
        If no body is shown yet, or no template can be like it.
    """
    network, source = body_in_work(state).network, state.template_source
    return template_file(source, network, name, state.without, _remedy(state))


def _template(state: CarState, context: Context) -> bytes:
    return car_as_template(state, context.file)


def _remedy(state: CarState) -> str:
    """Return what to do about a body that folds: there may be nothing to undo."""
    if state.edits:
        return "Undo the last edit there, or move its nodes apart."
    return "Drag the marks there apart, or its nodes."
