"""Commands for marking: skip a point, note that it is not visible, remove a mark."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, cast

from bozzetto.errors import UserError
from bozzetto.plugin import Command, Context
from bozzetto_car.marking.edit_marks import (
    sketch_in_work,
    with_all_asked,
    with_asked,
    with_skipped,
    without_last_mark,
)
from bozzetto_car.marking.next_mark import ALL_MARKED, HIDDEN, asked_of, in_work, neighbour_of
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.solver.template_ranking import likelier_template
from bozzetto_car.state import CarState
from bozzetto_car.template.loader import Bundled

NONE_LIKELIER: Final = (
    "No template fits the marks far better. Set more marks, or choose one by hand."
)

NOTHING_HIDDEN: Final = "No point of this sketch is noted as not visible. There is none to ask for."


def marking_commands() -> tuple[Command, ...]:
    """Return the commands, in the order of the menu."""
    return (
        Command(
            "skip", "Skip this point",
            "Ask for the next point; this one comes again when the others are marked.",
            lambda state, context: passed_over(state, 1), "S", _has_sketch,
        ),
        Command(
            "ask-before", "Go back to the point before",
            "Ask again for the point before this one, to set its mark again.",
            lambda state, context: passed_over(state, -1), "Shift+S", _has_sketch,
        ),
        Command(
            "not-visible", "This point is not visible",
            "Do not ask for this point any more in this sketch.", _not_visible, "N", _has_sketch,
        ),
        Command(
            "ask-again", "Ask again for points not visible",
            "Points that were noted as not visible in this sketch are asked for again.",
            _again, enabled=_has_hidden,
        ),
        Command(
            "remove-last-mark", "Remove last mark",
            "Take the newest mark of this sketch away and ask for its point again.",
            lambda state, context: without_last_mark(state), enabled=_has_mark,
        ),
        Command(
            "likeliest-template", "Use the template that fits best",
            "The car takes the template with which its marks are by far likeliest.",
            _likeliest, enabled=_has_mark,
        ),
    )  # fmt: skip


def asked_node(state: CarState) -> str:
    """Return the node that is asked for.

    Raises
    ------
    UserError
        If there is no sketch, it is hidden, or all is marked.
    """
    sketch_in_work(state)
    solved_ = solve_car(state)
    if in_work(state, solved_) is None:
        raise UserError(HIDDEN)
    asked = asked_of(state, solved_)
    if asked is None:
        raise UserError(ALL_MARKED)
    return asked.node


def passed_over(state: CarState, step: int) -> CarState:
    """Return the state that asks for the next node (step 1) or the one before (-1).

    Raises
    ------
    UserError
        As `asked_node` does; with all points marked, only forward.
    """
    sketch = sketch_in_work(state)
    solved_ = solve_car(state)
    placed, asked = in_work(state, solved_), asked_of(state, solved_)
    if placed is None:
        raise UserError(HIDDEN)
    if asked is None:
        if step > 0 or not sketch.marks:
            raise UserError(ALL_MARKED)
        return with_asked(state, sketch.marks[-1].node)
    return with_asked(state, neighbour_of(asked.node, step, placed, solved_))


def _not_visible(state: CarState, context: Context) -> CarState:
    return with_skipped(state, [asked_node(state)])


def _again(state: CarState, context: Context) -> CarState:
    if not _has_hidden(state):
        raise UserError(NOTHING_HIDDEN)
    return with_all_asked(state)


def _likeliest(state: CarState, context: Context) -> CarState:
    likelier = likelier_template(solve_car(state))
    if likelier is None:
        raise UserError(NONE_LIKELIER)
    return replace(state, template=cast(Bundled, likelier.id))


def _has_sketch(state: CarState) -> bool:
    return state.sketch is not None


def _has_hidden(state: CarState) -> bool:
    return state.sketch is not None and bool(state.sketch.skipped)


def _has_mark(state: CarState) -> bool:
    return state.sketch is not None and bool(state.sketch.marks)
