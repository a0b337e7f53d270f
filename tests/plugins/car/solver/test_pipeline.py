"""From marks to the car: what the issue asks for, whatever the marks are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.plugin.cache import forget_all
from bozzetto_car.solver import pipeline
from bozzetto_car.solver.pipeline import Solved, solve_car
from bozzetto_car.solver.prior import Cost
from bozzetto_car.state import CarState, Sketch
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from tests.plugins.car.marked_car import marked as marked_car
from tests.plugins.car.marked_points import Marked, aside, marked, with_marks
from tests.plugins.car.sketched import (
    FRONT,
    FRONT_QUARTER,
    REAR_QUARTER,
    SIDE,
    View,
    apart,
    rms,
    rubbery,
    styled,
)

CARS = {"styled": styled, "rubbery": rubbery}
SEEDS = range(8)


def of_the_template(
    template: Template, view: View, hand: float, count: int = 99, kind: str = "perspective"
) -> list[tuple[Marked, Solved]]:
    cases = [
        marked(template, template.positions, (view,), seed, hand, count, kind=kind)
        for seed in SEEDS
    ]
    return [(case, solve_car(case.state)) for case in cases]


# -- a car that is the template --------------------------------------------------------------------


def test_an_exact_template_is_found_again(template: Template) -> None:
    cases = of_the_template(template, FRONT_QUARTER, 3.0)
    assert np.median([case.hidden(car) for case, car in cases]) <= 3.0
    assert np.median([case.turned(car) for case, car in cases]) <= 1.0
    assert np.median([rms(apart(car.positions, template.positions)) for _, car in cases]) <= 10.0


def test_eight_marks_are_enough_to_find_it(template: Template) -> None:
    cases = of_the_template(template, FRONT_QUARTER, 3.0, 8)
    assert np.median([case.hidden(car) for case, car in cases]) <= 6.0


def test_an_orthographic_side_view_is_enough(template: Template) -> None:
    cases = of_the_template(template, SIDE, 2.0, kind="orthographic")
    assert np.median([case.hidden(car) for case, car in cases]) <= 5.0


@pytest.mark.parametrize("view", [FRONT_QUARTER, SIDE, FRONT])
def test_without_noise_nothing_is_lost(template: Template, view: View) -> None:
    for case, car in of_the_template(template, view, 0.0)[:2]:
        assert case.hidden(car) <= 1e-6
        assert np.abs(car.positions - template.positions).max() <= 1e-6


# -- other cars ------------------------------------------------------------------------------------


@pytest.mark.parametrize("cars", CARS)
def test_other_cars_are_come_nearer(template: Template, cars: str) -> None:
    views = {(FRONT_QUARTER,): 0.8, (FRONT_QUARTER, REAR_QUARTER): 0.4}
    for seen, most in views.items():
        share, away, marks = [], [], []
        for seed in SEEDS:
            true = CARS[cars](template, seed)
            case = marked(template, true, seen, seed)
            car = solve_car(case.state)
            assert not aside(car)
            away.append(rms(apart(car.positions, true)))
            share.append(away[-1] / rms(apart(template.positions, true)))
            missed = car.placed["s0"].missed
            assert missed is not None
            marks.append(rms(np.array(list(missed.values()))))
        assert np.median(share) <= most
        assert len(seen) == 2 or np.median(marks) <= 1.5
        assert len(seen) == 1 or np.median(away) <= 22.0


def test_the_slider_goes_from_the_template_to_the_marks() -> None:
    template = bundled("sedan")
    for true in (template.positions, styled(template, 2)):
        case = marked(template, true, (FRONT_QUARTER,), 2)
        cars = [solve_car(replace(case.state, trace=trace)) for trace in (0.0, 0.3, 0.6, 0.8, 1.0)]
        missed = [rms(car.joint.residuals[0]) for car in cars if car.joint is not None]
        assert (np.diff(missed) < 0.0).all()
        assert missed[-1] <= 1.0
        moved = [rms(apart(car.positions, template.positions)) for car in cars]
        assert moved[0] < moved[2] < moved[-1] + 1.0


# -- what stays as it is ---------------------------------------------------------------------------


def test_the_papers_cost_is_the_papers() -> None:
    template = bundled("sedan")
    case = marked(template, styled(template, 0), (FRONT_QUARTER,), 0)
    car = solve_car(replace(case.state, cost="paper"))
    assert car.cost == Cost.paper(template)
    found = car.placed["s0"].resection
    assert found is not None
    assert np.allclose(car.placed["s0"].sketch_camera.camera.eye, found.camera.eye)


def test_the_papers_camera_follows_a_drag() -> None:
    template = bundled("sedan")
    state = replace(marked(template, styled(template, 0), (FRONT_QUARTER,), 0).state, cost="paper")
    mark = state.sketches[0].marks[3]
    moved = with_marks(state, {mark.node: (mark.u + 8.0, mark.v)})
    after = solve_car(moved, before=state).placed["s0"]
    assert after.resection is not None
    assert np.allclose(after.sketch_camera.camera.eye, after.resection.camera.eye)
    assert np.allclose(
        after.sketch_camera.camera.eye,
        solve_car(moved).placed["s0"].sketch_camera.camera.eye,
        atol=5,
    )


def test_no_sketch_no_car_but_the_template() -> None:
    template = bundled("minivan")
    car = solve_car(CarState(template="minivan"))
    assert car.joint is None
    assert np.array_equal(car.positions, template.positions)


def test_a_sketch_with_too_few_marks_says_so_and_stops_no_other() -> None:
    template = bundled("sedan")
    state = marked(template, template.positions, (FRONT_QUARTER,), 0).state
    few = Sketch(id="few", marks=state.sketches[0].marks[:4])
    car = solve_car(replace(state, nodes=(*state.nodes, few)))
    assert car.solid == ("s0",)
    assert "6 different points" in car.placed["few"].problem
    alone = solve_car(state)
    assert np.array_equal(car.positions, alone.positions)


def test_too_many_sketches_are_refused() -> None:
    template = bundled("sedan")
    state = marked(template, template.positions, (FRONT_QUARTER,) * 9, 0, count=8).state
    with pytest.raises(UserError, match="8 sketches"):
        solve_car(state)


def test_marks_are_weighed_once_whatever_the_balance_and_the_dimensions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = marked_car(21)
    changes: tuple[dict[str, object], ...] = (
        {"trace": 0.2},
        {"trace": 0.9},
        {"wheelbase": 2790.0, "lock": True},
        {"wheelbase": 2850.0, "lock": True},
    )
    alone = []
    for change in changes:
        forget_all()
        alone.append(solve_car(replace(first, **change)))  # type: ignore[arg-type]
    forget_all()
    solve_car(first)
    for name in ("judge_marks", "place_sketch"):
        monkeypatch.setattr(pipeline, name, None)
    sketch = replace(first.sketches[0], name="Another name")
    for change, wanted in zip(changes, alone, strict=True):
        found = solve_car(replace(first.with_node(sketch), **change))  # type: ignore[arg-type]
        assert np.array_equal(found.positions, wanted.positions)
        assert found.placed["1"].sketch.name == "Another name"
