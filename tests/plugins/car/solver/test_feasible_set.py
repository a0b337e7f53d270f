"""The set of allowed cars: the way into it, and steps that do not leave it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from bozzetto.errors import UserError
from bozzetto_car.dimensions import Dimensions, Locks
from bozzetto_car.solver.feasible_set import Feasible
from bozzetto_car.solver.prior import Cost, Prior
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness


def form_of(template: Template) -> np.ndarray:
    return Prior(template, Cost.balanced()).form(template.variables)


def test_an_allowed_car_is_taken_as_it_is(template: Template) -> None:
    made = Feasible.of(Soundness.of(template), None, template.variables, form_of(template))
    assert np.array_equal(made.start, template.variables)
    assert np.array_equal(made.span, np.eye(len(template.variables)))


@pytest.mark.parametrize("seed", range(5))
def test_the_way_back_ends_at_a_sound_car(template: Template, seed: int) -> None:
    soundness = Soundness.of(template)
    rng = np.random.default_rng(seed)
    broken = template.variables + rng.normal(0.0, 200.0, len(template.variables))
    assert soundness.slacks(broken).min() < -10.0
    made = Feasible.of(soundness, None, broken, form_of(template))
    assert soundness.slacks(made.start).min() >= -1e-9


def test_no_car_between_violates_less(template: Template) -> None:
    """One inequality alone: the nearest car is the projection, for which there is a formula."""
    soundness, form = Soundness.of(template), form_of(template)
    row, constant = soundness.matrix[0], soundness.constants[0]
    others = tuple(name for name in soundness.names if name != soundness.names[0])
    alone = Soundness.of(template, without=others)
    toward = np.linalg.solve(form, row)
    broken = template.variables - 2.0 * (row @ template.variables + constant) / (row @ row) * row
    made = Feasible.of(alone, None, broken, form)
    lacking = -(row @ broken + constant)
    assert made.start == pytest.approx(broken + lacking / (row @ toward) * toward, abs=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_steps_never_leave(template: Template, seed: int) -> None:
    soundness, form = Soundness.of(template), form_of(template)
    locks = Locks.of(template, Dimensions(wheelbase=2750.0, height=1500.0), template.variables)
    made = Feasible.of(soundness, locks, template.variables, form)
    rng = np.random.default_rng(seed)
    car, refused = made.start, 0
    inner = made.span.T @ form @ made.span
    for _ in range(40):
        slope = inner @ rng.normal(0.0, 1500.0, made.span.shape[1])
        step = made.step(car, inner * 10.0 ** rng.uniform(0.0, 3.0), slope)
        assert step is not None
        moved = made.moved(car, step)
        if moved is None:
            refused += 1
            continue
        car = moved
        assert soundness.slacks(car).min() >= -1e-9
        assert locks.rows @ car == pytest.approx(locks.values, abs=1e-8)
        assert (locks.bounds @ car).min() >= -1e-9
    assert refused < 40


def test_a_shorter_step_is_always_possible(template: Template) -> None:
    """What is refused for its length goes through when the form is stiffer."""
    soundness, form = Soundness.of(template), form_of(template)
    made = Feasible.of(soundness, None, template.variables, form)
    rng = np.random.default_rng(1)
    for _ in range(10):
        slope = form @ rng.normal(0.0, 5000.0, len(form))
        for stiffer in 8.0 ** np.arange(12):
            step = made.step(made.start, stiffer * form, slope)
            if step is not None and made.moved(made.start, step) is not None:
                break
        else:
            pytest.fail("no step at all")


def test_locked_dimensions_hold_from_the_start(template: Template) -> None:
    wanted = Dimensions(4600.0, 1820.0, 1490.0, 880.0, 2740.0)
    locks = Locks.of(template, wanted, template.variables)
    made = Feasible.of(Soundness.of(template), locks, template.variables, form_of(template))
    assert locks.rows @ made.start == pytest.approx(locks.values, abs=1e-8)
    assert np.abs(locks.rows @ made.span).max() < 1e-12
    assert made.span.shape[1] == len(template.variables) - 5
    assert made.span.T @ made.span == pytest.approx(np.eye(made.span.shape[1]), abs=1e-12)


@pytest.mark.parametrize(
    "wanted",
    [
        Dimensions(wheelbase=1200.0),
        Dimensions(length=3000.0, wheelbase=2900.0),
        Dimensions(width=1500.0, height=3000.0),
    ],
)
def test_dimensions_of_no_sound_car_name_what_they_break(
    template: Template, wanted: Dimensions
) -> None:
    soundness = Soundness.of(template)
    locks = Locks.of(template, wanted, template.variables)
    free = [(None, None)] * len(template.variables)
    possible = linprog(
        np.zeros(len(free)),
        -np.vstack((soundness.matrix, locks.bounds)),
        np.concatenate((soundness.constants, np.zeros(len(locks.bounds)))),
        locks.rows,
        locks.values,
        bounds=free,
    )
    assert possible.status == 2
    with pytest.raises(UserError, match="keeps “") as told:
        Feasible.of(soundness, locks, template.variables, form_of(template))
    named = [name for name in soundness.names if f"“{name}”" in str(told.value)]
    assert named


def test_what_is_switched_off_stands_in_no_ones_way(template: Template) -> None:
    """A very short car, as soon as nobody minds the wheelbase."""
    wanted = Dimensions(wheelbase=1450.0)
    locks = Locks.of(template, wanted, template.variables)
    name = "The wheelbase is 1.5 m at least"
    with pytest.raises(UserError, match=f"“{name}”"):
        Feasible.of(Soundness.of(template), locks, template.variables, form_of(template))
    without = Soundness.of(template, without=[name])
    made = Feasible.of(without, locks, template.variables, form_of(template))
    assert locks.rows @ made.start == pytest.approx(locks.values, abs=1e-8)
