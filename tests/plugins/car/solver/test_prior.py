"""The cost of a deformation: what is cheap, what is dear, and the paper's own."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_car.solver.prior import Cost, Prior, extent, robust_weights
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Template


@pytest.fixture(params=TEMPLATES)
def template(request: pytest.FixtureRequest) -> Template:
    return bundled(request.param)


def plain(**changes: float) -> Cost:
    """Squares alone, without coupling and proportions."""
    cost = dataclasses.replace(Cost.balanced(), coupling=np.inf, proportion=0.0)
    return dataclasses.replace(cost, **changes)


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


def test_coupling_costs_what_edges_are_stretched_and_bent(template: Template) -> None:
    """The wheels are tied to two nodes each, which no edge of the template tells."""
    rng = np.random.default_rng(2)
    variables = template.variables + rng.normal(0.0, 50.0, len(template.variables))
    variables = template.reduced(
        np.where(
            np.isin(np.arange(len(template.names)), template.wheels)[:, None],
            template.positions,
            template.whole(variables),
        )
    )
    moved = template.whole(variables) - template.positions
    torn = sum(np.sum((moved[a] - moved[b]) ** 2) for a, b in template.edges)
    ties = 0.0
    for wheel, around in (("WF", ("B1", "B2")), ("WR", ("B4", "B5"))):
        for side in ("R", "L"):
            own = moved[template.node[f"{wheel}.{side}"]]
            ties += sum(
                np.sum((own - moved[template.node[f"{name}.{side}"]]) ** 2) for name in around
            )
    coupled = Prior(template, plain(coupling=25.0)).value(variables)
    alone = Prior(template, plain()).value(variables)
    assert coupled - alone == pytest.approx((torn + ties) / 25.0**2)


def test_a_car_that_moves_as_a_whole_is_not_torn(template: Template) -> None:
    along = template.reduced(template.positions + np.array([70.0, 0.0, 30.0]))
    coupled, alone = (Prior(template, cost).value(along) for cost in (plain(coupling=1.0), plain()))
    assert coupled == pytest.approx(alone)


def test_proportions_add_a_variance_and_no_more(template: Template) -> None:
    """The form is the inverse of a covariance: without them, plus that of three factors."""
    rigid = np.linalg.inv(Prior(template, plain()).form(template.variables))
    loose = np.linalg.inv(Prior(template, plain(proportion=0.05)).form(template.variables))
    added = np.zeros_like(rigid)
    middle = np.array([template.positions[:, 0].mean(), 0.0, 0.0])
    for axis in range(3):
        factor = np.ones(3)
        factor[axis] = 1.05
        stretched = middle + (template.positions - middle) * factor
        step = template.reduced(stretched) - template.variables
        added += np.outer(step, step)
    assert loose - rigid == pytest.approx(added, abs=1e-6 * np.abs(added).max())


def test_longer_as_a_whole_is_cheaper_than_in_one_place(template: Template) -> None:
    prior = Prior(template, Cost.balanced())
    longer = template.reduced(template.positions * [1.05, 1.0, 1.0])
    step = np.linalg.norm(longer - template.variables)
    lump = template.variables.copy()
    lump[3] += step
    assert prior.value(longer) < 0.1 * prior.value(lump)


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
