"""Cameras and shape together: what the issue asks for."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_car.camera.marked_view import MarkedView
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.solver.bundle_adjustment import JointSolution, solve
from bozzetto_car.solver.prior import Cost
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness
from tests.plugins.car.sketched import (
    FRONT,
    FRONT_QUARTER,
    PICTURE,
    REAR_QUARTER,
    SIDE,
    Sketched,
    View,
    apart,
    rms,
    rubbery,
    sketched,
    styled,
)
from tests.plugins.car.solved import assert_allowed, joint_of

CARS = {"styled": styled, "rubbery": rubbery}
SEEDS = range(6)


@cache
def cases(name: str, cars: str, views: tuple[View, ...]) -> list[tuple[Sketched, JointSolution]]:
    template = bundled(name)
    found = []
    for seed in SEEDS:
        sketch = sketched(template, CARS[cars](template, seed), views, seed)
        found.append((sketch, joint_of(template, sketch)))
    return found


def ratios(name: str, cars: str, views: tuple[View, ...]) -> tuple[float, float]:
    """Medians: error of the nodes against that of the template, and the error, mm."""
    template = bundled(name)
    before, after = [], []
    for sketch, joint in cases(name, cars, views):
        before.append(rms(apart(template.positions, sketch.car)))
        after.append(rms(apart(template.whole(joint.variables), sketch.car)))
    return float(np.median(np.divide(after, before))), float(np.median(after))


@pytest.mark.parametrize("cars", CARS)
def test_one_view_takes_the_template_toward_the_car(template: Template, cars: str) -> None:
    ratio, _ = ratios(template.id, cars, (FRONT_QUARTER,))
    assert ratio <= 0.8


@pytest.mark.parametrize("cars", CARS)
def test_two_three_quarter_views_fix_the_shape(template: Template, cars: str) -> None:
    ratio, error = ratios(template.id, cars, (FRONT_QUARTER, REAR_QUARTER))
    assert error <= 22.0
    assert ratio <= 0.4


@pytest.mark.parametrize("cars", CARS)
def test_marks_are_met(template: Template, cars: str) -> None:
    for _, joint in cases(template.id, cars, (FRONT_QUARTER,)):
        assert rms(joint.residuals[0]) <= 1.5


@pytest.mark.parametrize("cars", CARS)
def test_hidden_nodes_come_nearer_in_the_sketch(template: Template, cars: str) -> None:
    before, after = [], []
    for sketch, joint in cases(template.id, cars, (FRONT_QUARTER,)):
        (given,), (solved,), (places,) = sketch.views, joint.views, sketch.places
        hidden = np.setdiff1d(np.arange(len(places)), given.nodes)
        for view, car, found in (
            (given, template.positions, before),
            (solved, template.whole(joint.variables), after),
        ):
            off = view.camera.project(car[hidden])[0] - places[hidden]
            found.append(rms(np.linalg.norm(off, axis=1)))
    assert np.median(after) < 0.9 * np.median(before)


def test_every_car_is_sound_and_symmetric(template: Template) -> None:
    for cars in CARS:
        for views in ((FRONT_QUARTER,), (FRONT_QUARTER, REAR_QUARTER)):
            for _, joint in cases(template.id, cars, views):
                assert_allowed(template, joint, Soundness.of(template))


def test_every_further_view_helps() -> None:
    views = (FRONT_QUARTER, REAR_QUARTER, SIDE, FRONT)
    errors = [ratios("sedan", "styled", views[:count])[1] for count in (1, 2, 4)]
    assert errors[1] < 0.7 * errors[0]
    assert errors[2] < errors[1]


def test_what_cannot_be_solved_is_told() -> None:
    template = bundled("sedan")
    sketch = sketched(template, template.positions, (FRONT_QUARTER,), 0)
    cost, sound = Cost.balanced(), Soundness.of(template)
    with pytest.raises(UserError, match="One to 8 sketches"):
        solve(template, [], cost, sound)
    with pytest.raises(UserError, match="One to 8 sketches"):
        solve(template, sketch.views * 9, cost, sound)
    with pytest.raises(UserError, match="No car has these dimensions"):
        solve(template, sketch.views, cost, sound, locked=Dimensions(wheelbase=1200.0))
    with pytest.raises(UserError, match="wheelbase of -3 mm"):
        solve(template, sketch.views, cost, sound, locked=Dimensions(wheelbase=-3.0))
    inside = Camera("perspective", (1500.0, 0.0, 700.0), (4000.0, 0.0, 700.0), viewport=PICTURE)
    view = MarkedView(inside, sketch.views[0].nodes, sketch.views[0].marks)
    with pytest.raises(UserError, match="within the car"):
        solve(template, [view], cost, sound)
    with pytest.raises(ValueError, match="finite car"):
        solve(template, sketch.views, cost, sound, start=np.full(63, np.nan))
