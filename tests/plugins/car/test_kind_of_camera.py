"""A perspective that is plainly there is not solved as an orthographic picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_car.solver.initial_cameras import place_sketch
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.state import TRACE
from bozzetto_car.template.loader import bundled
from tests.plugins.car.held_out import held_out
from tests.plugins.car.marked_points import marked
from tests.plugins.car.sketched import FRONT_QUARTER, View
from tests.plugins.car.unseen import KINDS, WIDE, exaggerated, unseen


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("share", [0.0, 0.015])
def test_a_wide_angle_is_seen_from_seven_marks_on(name: str, share: float) -> None:
    """Of cars that no template is, also drawn by hand; marks come in the order of asking.

    The views are from the car's right.
    """
    kind = KINDS[name]
    template = bundled(kind.template)
    for seed in range(3):
        case = marked(template, unseen(kind, seed), (WIDE,), seed)
        if share:
            case = exaggerated(case, np.random.default_rng(seed), share)
        (sketch,) = case.state.sketches
        own = {mark.node: mark for mark in sketch.marks}
        order = [template.names[node] for node in template.asked("R")]
        asked = [own[node] for node in order if node in own]
        for count in (7, 10, 99):
            placed = place_sketch(template, replace(sketch, marks=tuple(asked[:count])))
            assert placed.resection is not None
            assert placed.resection.camera.kind == "perspective"


NEAR_SIDE: View = ((82.0, 98.0), (3.0, 10.0), (4.5, 7.0))


@pytest.mark.slow
def test_a_perspective_that_the_template_hides_is_found_with_the_car() -> None:
    """From the side, near: the template's own camera takes some of these for orthographic, and
    those that still are lose little as a rule, half at worst: as an orthographic drawing of another
    car of the family they are as likely."""
    found, lost = [], []
    for number, car in [*enumerate(held_out(930)), *enumerate(held_out(932))]:
        state = marked(car.template, car.positions, (NEAR_SIDE,), number).state
        first = place_sketch(car.template, state.sketches[0]).resection
        assert first is not None
        if first.camera.kind == "perspective":
            continue
        cars = [solve_car(replace(state, trace=trace)) for trace in (TRACE, 0.2, 1.0)]
        kinds = {one.placed["s0"].sketch_camera.camera.kind for one in cars}
        assert len(kinds) == 1, "the slider has no say"
        found.append(kinds.pop())
        told = solve_car(state.with_node(replace(state.sketches[0], kind="perspective")))
        lost.append(car.shape_error(cars[0].positions) / car.shape_error(told.positions))
    assert len(found) >= 8
    assert found.count("perspective") >= 0.5 * len(found)
    assert np.median(lost) <= 1.05
    assert max(lost) <= 1.6


def test_the_kind_that_is_told_is_kept() -> None:
    car = next(iter(held_out(930)))
    state = marked(car.template, car.positions, (NEAR_SIDE,), 0).state
    told = replace(state.sketches[0], kind="orthographic")
    found = solve_car(state.with_node(told)).placed["s0"]
    assert found.sketch_camera.camera.kind == "orthographic"


@pytest.mark.parametrize("name", KINDS)
def test_an_orthographic_picture_with_all_marks_is_solved_as_one(name: str) -> None:
    kind = KINDS[name]
    template = bundled(kind.template)
    found = []
    for seed in range(2):
        case = marked(template, unseen(kind, seed), (FRONT_QUARTER,), seed, kind="orthographic")
        found.append(solve_car(case.state).placed["s0"].sketch_camera.camera.kind)
    assert found == ["orthographic"] * 2
