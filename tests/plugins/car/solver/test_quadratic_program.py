"""The constrained minimum against its optimality conditions, enumeration and SciPy."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import linprog

from bozzetto_car.solver.quadratic_program import Contradiction, constrained_minimum


def problem(seed: int, size: int, rows: int) -> tuple[np.ndarray, ...]:
    """A random form, slope and inequalities that some vector keeps."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(size, size))
    matrix = rng.normal(size=(rows, size))
    least = matrix @ rng.normal(size=size) - rng.exponential(0.3, rows)
    return root @ root.T + 0.1 * np.eye(size), rng.normal(0.0, 3.0, size), matrix, least


@pytest.mark.parametrize("seed", range(20))
def test_it_is_the_best_of_all_sets_of_active_inequalities(seed: int) -> None:
    form, slope, rows, least = problem(seed, 3, 6)

    def cost(place: np.ndarray) -> float:
        return float(0.5 * place @ form @ place + slope @ place)

    best = np.inf
    for count in range(4):
        for held in map(list, combinations(range(6), count)):
            border = np.zeros((3 + count, 3 + count))
            border[:3, :3], border[:3, 3:], border[3:, :3] = form, -rows[held].T, rows[held]
            place = np.linalg.solve(border, np.concatenate((-slope, least[held])))[:3]
            if (rows @ place - least).min() >= -1e-9:
                best = min(best, cost(place))
    assert cost(constrained_minimum(form, slope, rows, least).place) == pytest.approx(best)


@pytest.mark.parametrize("seed", range(20))
def test_pull_and_push_balance(seed: int) -> None:
    """Karush, Kuhn and Tucker: the slope is a sum of active rows with weights not below 0."""
    form, slope, rows, least = problem(seed, 60, 120)
    found = constrained_minimum(form, slope, rows, least)
    slacks = rows @ found.place - least
    assert slacks.min() >= -1e-10
    pull = form @ found.place + slope
    active = np.flatnonzero(slacks < 1e-9)
    weights = np.linalg.lstsq(rows[active].T, pull, rcond=None)[0]
    assert np.abs(rows[active].T @ weights - pull).max() < 1e-6
    assert weights.min() > -1e-6


def test_nothing_in_the_way_is_the_free_minimum() -> None:
    form, slope, rows, _ = problem(1, 5, 4)
    found = constrained_minimum(form, slope, rows, np.full(4, -1e9))
    assert form @ found.place == pytest.approx(-slope)
    assert not len(found.active)
    none = constrained_minimum(form, slope, rows[:0], np.empty(0))
    assert np.array_equal(none.place, found.place)


def test_rows_told_twice_are_told_once() -> None:
    form, slope, rows, least = problem(2, 8, 12)
    once = constrained_minimum(form, slope, rows, least).place
    twice = constrained_minimum(
        form, slope, np.vstack((rows, rows, 2.0 * rows)), np.concatenate((least, least, 2 * least))
    ).place
    assert twice == pytest.approx(once, abs=1e-9)


@pytest.mark.parametrize("seed", range(30))
def test_contradictions_are_told_from_hard_cases(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows, least = rng.normal(size=(12, 4)), rng.normal(0.3, 1.0, 12)
    possible = linprog(np.zeros(4), -rows, -least, bounds=(None, None)).status == 0
    try:
        place = constrained_minimum(np.eye(4), np.zeros(4), rows, least).place
        assert possible
        assert (rows @ place - least).min() >= -1e-9
    except Contradiction as found:
        assert not possible
        some = found.rows
        among = linprog(np.zeros(4), -rows[some], -least[some], bounds=(None, None))
        assert among.status == 2  # these alone contradict each other


def test_a_row_that_says_nothing_is_kept_or_cannot_be() -> None:
    form, slope, rows, least = problem(3, 4, 5)
    silent = np.vstack((rows, 1e-17 * rows[:1]))
    found = constrained_minimum(form, slope, silent, np.append(least, -1.0))
    assert np.array_equal(found.place, constrained_minimum(form, slope, rows, least).place)
    with pytest.raises(Contradiction) as told:
        constrained_minimum(form, slope, silent, np.append(least, 1.0))
    assert told.value.rows.tolist() == [5]


def test_a_saddle_has_no_least_value() -> None:
    with pytest.raises(np.linalg.LinAlgError):
        constrained_minimum(np.diag([1.0, -1.0]), np.zeros(2), np.eye(2), np.zeros(2))
