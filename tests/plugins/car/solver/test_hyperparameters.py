"""What marks say of the car and of each other."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.view.calibration import resect
from bozzetto_car.camera.marked_view import MarkedView, Reprojection
from bozzetto_car.solver.evidence import HANDS, SPREADS, STEADY, USUAL
from bozzetto_car.solver.hyperparameters import evidence_of, judge_marks
from bozzetto_car.solver.prior import Cost, Prior
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from tests.plugins.car.sketched import (
    FRONT_QUARTER,
    PICTURE,
    REAR_QUARTER,
    SIDE,
    View,
    sketched,
    styled,
)

Array = NDArray[np.float64]


def with_wrong(
    template: Template, view: MarkedView, moves: dict[int, tuple[float, float]]
) -> MarkedView:
    """The view with some of its marks, by their number, moved, and its camera found again."""
    marks = view.marks.copy()
    for number, move in moves.items():
        marks[number] += move
    camera = resect(template.positions[view.nodes], marks, PICTURE).camera
    return MarkedView(camera, view.nodes, marks)


def by_brute_force(template: Template, view: MarkedView, unit: float) -> float:
    """Logarithm of the density of the marks, camera integrated out, summed over the grid.

    The unit, px, is that of the hand: the diagonal of all marks, also where one is left out.
    """
    from scipy.linalg import null_space
    from scipy.special import logsumexp
    from scipy.stats import multivariate_normal

    cost = Cost.balanced()
    covariance = np.linalg.inv(Prior(template, cost).form(template.variables))
    sight, pose = Reprojection.of(template, view, held=False)
    seen = sight.residuals(pose, template.positions)
    assert seen is not None
    hand = cost.hand * unit / (sight.extent * sight.framing.diagonal)
    rows = sight.rows(seen, template.basis.reshape(-1, 3, len(covariance))) / hand
    by_car, by_camera = rows[:, : len(covariance)], rows[:, len(covariance) :]
    missed = seen.missed.ravel() / hand
    kept = null_space(by_camera.T).T
    size = 0.5 * np.linalg.slogdet(by_camera.T @ by_camera)[1]
    logs = [
        multivariate_normal(
            cov=s**2 * np.eye(len(kept)) + t**2 * kept @ by_car @ covariance @ by_car.T @ kept.T
        ).logpdf(kept @ missed)
        - 0.5 * (np.log(s) / np.log(STEADY)) ** 2
        - 0.5 * (np.log(t / USUAL[0]) / np.log(USUAL[1])) ** 2
        for t in SPREADS
        for s in HANDS
    ]
    return float(logsumexp(logs) - size)


def test_a_mark_is_judged_by_the_density_with_and_without_it() -> None:
    template = bundled("sedan")
    (view,) = sketched(template, styled(template, 1), (FRONT_QUARTER,), 1).views
    view = view.only(np.arange(len(view.nodes)) % 3 == 0)
    unit = float(np.linalg.norm(np.ptp(view.marks, axis=0)))
    found = evidence_of(template, view).improbable[0]
    whole = by_brute_force(template, view, unit)
    for number in range(len(view.nodes)):
        rest = view.only(np.arange(len(view.nodes)) != number)
        gain = by_brute_force(template, rest, unit) - whole
        assert found[number] == pytest.approx(gain, abs=1e-5)


@pytest.mark.parametrize("views", [(FRONT_QUARTER,), (FRONT_QUARTER, REAR_QUARTER)])
def test_the_spread_is_that_of_the_cars(template: Template, views: tuple[View, ...]) -> None:
    """Cars drawn from the prior itself, narrowed: the spread that is told is the one they have."""
    form = Prior(template, Cost.balanced()).form(template.variables)
    root = np.linalg.inv(np.linalg.cholesky(form)).T
    for share in (0.1, 0.3, 1.0):
        told = []
        for seed in range(12):
            draw = np.random.default_rng(seed).normal(size=len(root))
            car = template.whole(template.variables + share * root @ draw)
            told.append(
                judge_marks(template, sketched(template, car, views, seed, 2.0).views).spread
            )
        assert 0.6 < np.median(told) / share < 1.5


def test_the_template_itself_is_told(template: Template) -> None:
    for view in (FRONT_QUARTER, SIDE):
        for seed in range(6):
            sketch = sketched(template, template.positions, (view,), seed, 3.0)
            found = judge_marks(template, sketch.views)
            assert found.spread < 0.25
            assert all(flags.all() for flags in found.counted)


def test_several_wrong_marks_are_set_aside_and_no_others(template: Template) -> None:
    """Nearly always: two that go astray together may be what another car would have."""
    rng = np.random.default_rng(4)
    missed = lost = 0
    for seed in range(18):
        (view,) = sketched(template, styled(template, seed), (FRONT_QUARTER,), seed, 2.0).views
        which = rng.choice(len(view.nodes), 2, replace=False)
        around = rng.uniform(0.0, 2.0 * np.pi, 2)
        moves = {
            int(n): (120.0 * np.cos(a), 120.0 * np.sin(a))
            for n, a in zip(which, around, strict=True)
        }
        flags = judge_marks(template, [with_wrong(template, view, moves)]).counted[0]
        aside, wrong = set(np.flatnonzero(~flags).tolist()), set(which.tolist())
        missed += not wrong <= aside
        lost += not aside <= wrong
    assert missed <= 2
    assert lost <= 1


def test_of_six_marks_none_is_set_aside() -> None:
    template = bundled("sedan")
    for seed in range(6):
        (view,) = sketched(template, template.positions, (FRONT_QUARTER,), seed, 2.0).views
        some = np.arange(len(view.nodes)) % 4 == 0
        some &= np.cumsum(some) <= 6
        wrong = with_wrong(template, view.only(some), {0: (150.0, 0.0)})
        assert judge_marks(template, [wrong]).counted[0].all()


def test_no_mark_comes_and_goes_while_another_trembles() -> None:
    """Where a mark is just about wrong, it stays what it was before."""
    template = bundled("sedan")
    (view,) = sketched(template, styled(template, 3), (FRONT_QUARTER,), 3, 2.0).views

    def counts(off: float, before: bool) -> bool:
        wrong = with_wrong(template, view, {5: (off, 0.0)})
        flags = np.zeros(len(view.nodes), bool)
        flags[5] = not before
        return bool(judge_marks(template, [wrong], [flags]).counted[0][5])

    assert counts(0.0, True)
    assert not counts(150.0, True)
    low, high = 0.0, 150.0
    for _ in range(10):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if counts(middle, True) else (low, middle)
    for tremor in (-2.0, -1.0, 1.0, 2.0):
        assert not counts(high + tremor, False)


def test_of_chaos_three_quarters_are_kept() -> None:
    template = bundled("sedan")
    rng = np.random.default_rng(1)
    (view,) = sketched(template, template.positions, (FRONT_QUARTER,), 0, 2.0).views
    chaos = MarkedView(view.camera, view.nodes, rng.uniform(0.0, 800.0, view.marks.shape))
    flags = judge_marks(template, [chaos]).counted[0]
    assert (~flags).sum() <= 0.25 * len(flags)
