"""The cost of a deformation: what is cheap, what is dear, and the paper's own."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_car.solver.prior import Cost, Prior, extent, robust_weights, size_measure
from bozzetto_car.solver.proportions import (
    WAYS,
    believable_size,
    kin_directions,
    outer_dimensions,
    size_covariance,
    size_of_known,
)
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Template


def plain(**changes: float) -> Cost:
    """Squares of nodes by themselves, alone."""
    cost = dataclasses.replace(Cost.balanced(), smooth=0.0, proportion=0.0, kinship=0.0)
    return dataclasses.replace(cost, **changes)


def covariance(template: Template, **changes: float) -> Array:
    return np.linalg.inv(Prior(template, plain(**changes)).form(template.variables))


def test_the_template_costs_nothing_and_everything_else_something(template: Template) -> None:
    rng = np.random.default_rng(0)
    for cost in (Cost.balanced(), Cost.paper(template)):
        prior = Prior(template, cost)
        assert prior.value(template.variables) == 0.0
        for _ in range(20):
            moved = template.variables + rng.normal(0.0, 30.0, len(template.variables))
            assert prior.value(moved) > 0.0
            assert np.linalg.eigvalsh(prior.form(moved)).min() > 0.0


def test_deviation_is_the_sum_over_all_nodes(template: Template) -> None:
    rng = np.random.default_rng(1)
    variables = template.variables + rng.normal(0.0, 50.0, len(template.variables))
    moved = np.linalg.norm(template.whole(variables) - template.positions, axis=1)
    found = Prior(template, plain(deviation=40.0)).value(variables)
    assert found == pytest.approx(np.sum((moved / 40.0) ** 2))


def test_what_neighbours_do_together_costs_less(template: Template) -> None:
    """Two nodes that go the same way are cheaper than two that part; far ones do not care."""
    prior = Prior(template, plain(smooth=60.0))
    for names, least in ((("C3", "C4"), 1.2), (("C1", "C7"), 0.95)):
        cost = []
        for sign in (1.0, -1.0):
            moved = template.positions.copy()
            moved[template.node[names[0]], 2] += 30.0
            moved[template.node[names[1]], 2] += sign * 30.0
            cost.append(prior.value(template.reduced(moved)))
        assert cost[1] >= least * cost[0]


def test_outer_dimensions_add_their_covariance_and_no_more(template: Template) -> None:
    """Monte Carlo with the dimensions themselves: what is read off the cars is what was put in."""
    added = covariance(template, proportion=1.0) - covariance(template)
    assert np.linalg.matrix_rank(added, tol=1e-6 * np.abs(added).max()) == 5
    step = 1e-4
    was = outer_dimensions(template, template.positions)
    rows = []
    for column in np.eye(len(added)):
        moved = template.whole(template.variables + step * column)
        rows.append((outer_dimensions(template, moved) - was) / step / was)
    told = np.array(rows).T
    assert told @ added @ told.T == pytest.approx(size_covariance(), rel=1e-3, abs=1e-6)


def test_the_way_to_another_template_is_cheap(template: Template) -> None:
    ways = kin_directions(template)
    assert ways.shape[1] == len(TEMPLATES) - 1
    loose, stiff = (Prior(template, plain(kinship=share)) for share in (0.2, 0.0))
    for way in ways.T:
        along = template.variables + 0.2 * way
        assert loose.value(along) <= 1.0
        assert stiff.value(along) > 5.0 * loose.value(along)


def test_more_templates_make_no_wider_prior(template: Template) -> None:
    """All ways vary together as two whole ones, which end at other cars of the same size."""
    count = len(TEMPLATES) - 1
    whole = kin_directions(template) / np.sqrt(WAYS / count)
    own = outer_dimensions(template, template.positions)
    for way in whole.T:
        places = template.whole(template.variables + way)
        # A node that the other has not goes with its neighbour, and may come to stand out.
        assert np.abs(outer_dimensions(template, places) / own - 1.0).max() < 0.1
        assert np.abs(way).max() > 50.0
    spread = covariance(template, kinship=1.0) - covariance(template, kinship=0.0)
    mean = np.mean([way @ way for way in whole.T])
    assert np.trace(spread) == pytest.approx(WAYS * mean, rel=1e-6)


@pytest.mark.parametrize("factor", [0.7, 1.0, 1.4])
def test_size_costs_nothing_where_something_else_tells_it(factor: float) -> None:
    """A prior of another size is the same prior, in other units."""
    template = bundled("sedan")
    rng = np.random.default_rng(4)
    offset = rng.normal(0.0, 30.0, len(template.variables))
    offset -= (size_measure(template) @ offset) * template.variables
    one = Prior(template, Cost.balanced(), 1.0)
    other = Prior(template, Cost.balanced(), factor)
    assert other.value(factor * template.variables) == pytest.approx(0.0, abs=1e-9)
    assert other.value(factor * (template.variables + offset)) == pytest.approx(
        one.value(template.variables + offset), rel=1e-6
    )
    free = Prior(template, Cost.balanced(), 1.0, held=False)
    assert free.value(factor * template.variables) == pytest.approx((factor - 1.0) ** 2)


def test_the_believable_size_is_that_of_cars_that_were_built(template: Template) -> None:
    """Whatever size a car was solved at, the same comes out; and a car that is larger as all cars
    are is left alone."""
    places = template.positions
    for factor in (0.5, 1.0, 1.7):
        assert factor * believable_size(template, factor * places) == pytest.approx(1.0)
    wider = believable_size(template, places * [1.0, 1.05, 1.0])
    assert 0.94 < wider < 1.0
    assert size_of_known({"front_overhang": 1.2}) is None
    assert size_of_known({"length": 1.2}) == pytest.approx(1.2)
    both = size_of_known({"length": 1.2, "width": 1.1})
    assert both is not None
    assert 1.1 <= both <= 1.2


def test_the_papers_cost_is_a_sum_of_norms(template: Template) -> None:
    """H / 2 = 0.5 Σ |r| / D2 + 0.5 Σ |d| / D3, and the solver's cost is twice that."""
    rng = np.random.default_rng(3)
    cost = Cost.paper(template)
    variables = template.variables + rng.normal(0.0, 300.0, len(template.variables))
    moved = np.linalg.norm(template.whole(variables) - template.positions, axis=1)
    deviations = 0.5 * np.sum(moved) / extent(template)
    assert 0.5 * Prior(template, cost).value(variables) == pytest.approx(deviations, rel=0.03)
    missed = rng.normal(0.0, 0.05, (25, 2))  # in diagonals of the marks
    weighted = robust_weights(((missed / cost.hand) ** 2).sum(axis=1), cost.stray)[1]
    norms = 0.5 * np.sum(np.linalg.norm(missed, axis=1))
    assert 0.5 * weighted == pytest.approx(norms, rel=0.03)


def test_weights_are_the_slope_of_the_robust_cost() -> None:
    squares = np.array([0.0, 0.3, 4.0, 900.0])
    weights, total = robust_weights(squares, 3.0)
    assert total == pytest.approx(sum(robust_weights(squares[[i]], 3.0)[1] for i in range(4)))
    for number, square in enumerate(squares[1:], 1):
        higher = robust_weights(np.array([square * 1.001]), 3.0)[1]
        lower = robust_weights(np.array([square * 0.999]), 3.0)[1]
        assert weights[number] == pytest.approx((higher - lower) / (0.002 * square), rel=1e-4)
    assert np.array_equal(robust_weights(squares, np.inf)[0], np.ones(4))


def test_tracing_tightens_the_hand_and_nothing_else() -> None:
    hands = [Cost.balanced(trace).hand for trace in np.linspace(0.0, 1.0, 11)]
    assert (np.diff(hands) < 0.0).all()
    loose, tight = Cost.balanced(0.0), Cost.balanced(1.0)
    assert dataclasses.replace(loose, hand=0.0, stray=0.0) == dataclasses.replace(
        tight, hand=0.0, stray=0.0
    )


@pytest.mark.parametrize("trace", [-0.01, 1.01, np.nan, np.inf])
def test_a_balance_beyond_its_ends_is_refused(trace: float) -> None:
    with pytest.raises(UserError, match="stay plausible"):
        Cost.balanced(trace)
