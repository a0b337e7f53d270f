"""Wheels stand along the centre plane; rings that are round across it stay there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.ink import Stroke
from bozzetto.view import Camera
from bozzetto_symmetry.interpretation.round_loop import off_circle
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.solve.curve_solver import trace_of
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry import scenes as s

COSINE, SINE = np.cos(m.ROUND), np.sin(m.ROUND)


def circle(radius: float, one: int, other: int, middle: tuple[float, ...]) -> s.Array:
    made = np.tile(np.array(middle, float), (len(m.ROUND), 1))
    made[:, one] += radius * COSINE
    made[:, other] += radius * SINE
    return made


def ink(curve: s.Array, view: Camera, random: np.random.Generator) -> Stroke:
    begun = np.roll(curve, int(random.integers(len(curve))), axis=0)
    x, y = s.drawn(begun, view, noise=1.0, random=random, closed=True).T
    return Stroke(x, y, view)


@pytest.mark.parametrize("seed", range(81, 87))
def test_a_wheel_in_the_plane_is_no_ring_across_it_and_the_ring_is_a_key_away(seed: int) -> None:
    random = np.random.default_rng(seed)
    wheel = circle(random.uniform(15, 35), 0, 2, (random.uniform(-50, 50), 0.0, 0.0))
    state = add_drawing(SymmetryState(), (ink(wheel, m.view_of(random), random),))
    (curve,) = state.curves
    trace = trace_of(curve, state)
    assert trace.reading == "plane"
    assert trace.curve is not None
    assert trace.curve.closed
    assert np.median(s.distances(trace.points, wheel, closed=True)) < 1.0
    assert trace.choices > 1
    assert trace_of(replace(curve, other=True), state).reading == "self"


@pytest.mark.parametrize("seed", range(81, 87))
@pytest.mark.parametrize("axes", [(0, 1), (1, 2)])
def test_a_round_ring_across_the_plane_stays_there(seed: int, axes: tuple[int, int]) -> None:
    random = np.random.default_rng(seed)
    ring = circle(random.uniform(15, 35), *axes, (random.uniform(-50, 50), 0.0, 10.0))
    state = add_drawing(SymmetryState(), (ink(ring, m.view_of(random), random),))
    assert trace_of(state.curves[0], state).reading == "self"


def test_wheels_on_both_sides_are_a_pair() -> None:
    random = np.random.default_rng(4)
    view = s.camera(35, 20, pixels=800.0)
    wheel = circle(20.0, 0, 2, (-40.0, 35.0, -15.0))
    both = ink(wheel, view, random), ink(wheel * (1, -1, 1), view, random)
    state = add_drawing(SymmetryState(), both)
    (curve,) = state.curves
    assert trace_of(curve, state).reading == "pair"


def test_a_circle_is_round_wherever_it_lies_and_an_ellipse_is_not() -> None:
    turned = (
        circle(7.0, 0, 1, (3, 4, 5)) @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    )
    assert off_circle(turned) < 1e-3
    # The radius of an ellipse varies by ± half of what its axes differ by.
    flat = circle(1.0, 0, 1, (0, 0, 0)) * (1.1, 0.9, 1.0)
    assert off_circle(flat) == pytest.approx(0.1 / np.sqrt(2.0), rel=0.05)
