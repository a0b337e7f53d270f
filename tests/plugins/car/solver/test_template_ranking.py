"""Which template is proposed: the right one where it is plain, none where it is not."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bozzetto.errors import UserError
from bozzetto_car.body.build import body_of
from bozzetto_car.commands import all_commands
from bozzetto_car.marking.next_mark import next_mark_in_words
from bozzetto_car.report import cautions_of
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.solver.template_ranking import likelier_template
from bozzetto_car.state import CarState
from bozzetto_car.template.loader import PAPER_TEMPLATES, bundled
from tests.plugins.car.held_out import held_out
from tests.plugins.car.marked_points import marked
from tests.plugins.car.sketched import FRONT_QUARTER, SIDE, View, rubbery, styled

SEEDS = range(40, 44)


def sketch_of(name: str, seed: int, view: View = FRONT_QUARTER) -> CarState:
    """A sketch of a styled or a rubbery car of a template."""
    template = bundled(name)
    car = (styled, rubbery)[seed % 2](template, seed)
    return marked(template, car, (view,), seed).state


def as_marked_with(state: CarState, name: str) -> CarState:
    """The sketch as marked by somebody who chose another template."""
    template = bundled(name)
    sketch = state.sketches[0]
    marks = tuple(mark for mark in sketch.marks if mark.node in template.node)
    return replace(state.with_node(replace(sketch, marks=marks)), template=name)


@pytest.mark.parametrize("name", PAPER_TEMPLATES)
@pytest.mark.parametrize("view", [FRONT_QUARTER, SIDE])
def test_the_right_template_is_left_alone(name: str, view: View) -> None:
    for seed in SEEDS:
        assert likelier_template(solve_car(sketch_of(name, seed, view))) is None


@pytest.mark.parametrize("name", PAPER_TEMPLATES)
def test_a_wrong_template_is_named(name: str) -> None:
    """Never another wrong one, and mostly at all."""
    named = []
    for seed in SEEDS:
        for wrong in PAPER_TEMPLATES:
            if wrong != name:
                found = likelier_template(solve_car(as_marked_with(sketch_of(name, seed), wrong)))
                assert found is None or found.id == name
                named.append(found is not None)
    assert sum(named) >= 0.6 * len(named)


def test_between_two_templates_none_is_proposed() -> None:
    """Cars 30 to 70 per cent of the way to another template belong with either."""
    proposed = [
        likelier_template(solve_car(marked(car.template, car.positions, (FRONT_QUARTER,), 5).state))
        for car in held_out(5)
    ]
    assert sum(one is not None for one in proposed) <= 1


def test_it_is_said_and_done() -> None:
    """In the next step, among the cautions, and by a command, which then has nothing to do."""
    state = as_marked_with(sketch_of("minivan", 41), "sedan")
    assert "looks like a minivan" in next_mark_in_words(state, solve_car(state))
    assert any("looks like a minivan" in one.message for one in cautions_of(body_of(state)))
    command = next(one for one in all_commands() if one.id == "likeliest-template")
    changed = command.run(state, None)  # type: ignore[arg-type]
    assert changed.template == "minivan"
    assert "looks like" not in next_mark_in_words(changed, solve_car(changed))
    with pytest.raises(UserError, match="No template fits"):
        command.run(changed, None)  # type: ignore[arg-type]


def test_too_few_common_marks_tell_nothing() -> None:
    state = sketch_of("hatchback", 42)
    sketch = state.sketches[0]
    few = state.with_node(replace(sketch, marks=sketch.marks[:5]))
    assert likelier_template(solve_car(few)) is None
    assert likelier_template(solve_car(CarState())) is None
