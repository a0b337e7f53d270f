"""A hand that bends a drawing: told from another car, said, and followed on request."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto_car.body.build import body_of
from bozzetto_car.camera.marked_view import Reprojection
from bozzetto_car.report import cautions_of
from bozzetto_car.solver.hand import bend_correlation, bent_by_hand
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.solver.prior import Cost
from bozzetto_car.template.loader import bundled
from tests.plugins.car.marked_points import Marked, marked
from tests.plugins.car.sketched import FRONT_QUARTER, apart, rms, sketched, styled
from tests.plugins.car.unseen import exaggerated

SEEDS = range(60, 66)


def bent(seed: int) -> Marked:
    template = bundled("minivan")
    case = marked(template, template.positions, (FRONT_QUARTER,), seed)
    return exaggerated(case, np.random.default_rng(seed))


def test_the_ways_of_a_bend_have_its_covariance() -> None:
    template = bundled("sedan")
    (view,) = sketched(template, styled(template, 1), (FRONT_QUARTER,), 1).views
    sight, _ = Reprojection.of(template, view, held=False)
    ways = bent_by_hand(sight, replace(Cost.balanced(), bend=0.01))
    assert np.abs(ways @ ways.T - 1e-4 * bend_correlation(sight)).max() < 2e-6
    assert bent_by_hand(sight, Cost.balanced()).shape == (len(view.nodes), 0)


def test_a_bent_drawing_of_the_template_stays_near_it() -> None:
    """Nothing of the drawing is exact but the car, which is followed only where one asks."""
    template = bundled("minivan")
    away: list[float] = []
    traced: list[float] = []
    for seed in SEEDS:
        state = bent(seed).state
        cars = [solve_car(replace(state, trace=trace)) for trace in (state.trace, 1.0)]
        for found, car in zip((away, traced), cars, strict=True):
            found.append(rms(apart(car.positions, template.positions)))
        assert cars[1].cost.bend == 0.0
    assert np.median(away) < 0.5 * np.median(traced)


def test_a_bend_is_said_and_none_where_there_is_none() -> None:
    template = bundled("minivan")
    said = 0
    for seed in SEEDS:
        plain = marked(template, template.positions, (FRONT_QUARTER,), seed).state
        assert solve_car(plain).cost.bend == 0.0
        body = body_of(bent(seed).state)
        words = any("bent by the hand" in one.message for one in cautions_of(body))
        assert words == (body.solved.cost.bend > 0.0)
        said += words
    assert said >= len(SEEDS) // 2
