"""A perspective that is plainly there is not solved as an orthographic picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_car.solver.initial_cameras import place_sketch
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.template.loader import bundled
from tests.plugins.car.marked_points import marked
from tests.plugins.car.sketched import FRONT_QUARTER
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


@pytest.mark.parametrize("name", KINDS)
def test_an_orthographic_picture_with_all_marks_is_solved_as_one(name: str) -> None:
    kind = KINDS[name]
    template = bundled(kind.template)
    found = []
    for seed in range(2):
        case = marked(template, unseen(kind, seed), (FRONT_QUARTER,), seed, kind="orthographic")
        found.append(solve_car(case.state).placed["s0"].sketch_camera.camera.kind)
    assert found == ["orthographic"] * 2
