"""A far side that was drawn in part: it pairs with the stretch that it matches, and no other."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_symmetry.interpretation.partial_pairing import partial_pairings
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.view.hints import GO_ON, next_step
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry import scenes as s

SIDE = s.PAIRS["S-wave"]
VIEW = s.camera(35, 20, pixels=800.0)


@pytest.mark.parametrize(("begin", "end"), [(0, 180), (60, 240), (150, 300)])
@pytest.mark.parametrize("sense", [1, -1])
def test_the_stretch_is_found(begin: int, end: int, sense: int) -> None:
    near, far = s.drawn(SIDE, VIEW), s.drawn((SIDE * MIRROR)[begin:end], VIEW, sense=sense)
    found = partial_pairings(Stereo(VIEW), near, far)[0]
    along = np.linalg.norm(np.diff(near, axis=0), axis=1).cumsum() / s.length_of(near)
    ends = np.array((0.0, *along))[[begin, end - 1]]
    np.testing.assert_allclose(found.stations[[0, -1]], ends, atol=0.02)
    assert found.reversed == (sense < 0)
    assert found.part[1] == 1.0
    assert found.part[0] == pytest.approx(ends[1] - ends[0], abs=0.02)
    points = Stereo(VIEW).intersected(found.near, found.far)
    assert np.median(s.distances(points, SIDE)) < 0.1


def test_either_side_may_be_the_one_in_part() -> None:
    near, far = s.drawn(SIDE[:180], VIEW), s.drawn(SIDE * MIRROR, VIEW)
    one = partial_pairings(Stereo(VIEW), near, far)[0]
    other = partial_pairings(Stereo(VIEW), far, near)[0]
    assert one.part == pytest.approx(other.part[::-1])
    np.testing.assert_allclose(one.far_stations[[0, -1]], other.stations[[0, -1]], atol=0.02)


def test_a_straight_line_is_no_stretch_of_another() -> None:
    ends = np.array(((-60.0, 30.0, 0.0), (60.0, 30.0, 0.0)))
    line = np.linspace(*ends, 100)
    near, far = s.drawn(line, VIEW), s.drawn((line * MIRROR)[:50], VIEW)
    assert partial_pairings(Stereo(VIEW), near, far) == ()


@pytest.mark.parametrize("line", [np.zeros((5, 2)), np.array(((0.0, 0.0), (1e-9, 0.0)))])
def test_dots_match_nothing(line: np.ndarray) -> None:
    assert partial_pairings(Stereo(VIEW), line, s.drawn(SIDE, VIEW)) == ()


@pytest.mark.parametrize("seed", range(300, 306))
def test_the_rest_waits_until_it_is_drawn(seed: int) -> None:
    random = np.random.default_rng(seed)
    far = SIDE * MIRROR
    strokes = [m.stroke(part, VIEW, 0.5, random) for part in (SIDE, far[:150], far[150:])]
    state = add_drawing(SymmetryState(), strokes[:2])
    (curve,) = state.curves
    trace = trace_of(curve, state)
    assert trace.reading == "pair"
    assert trace.rest == pytest.approx(0.5, abs=0.15)
    assert any(text.endswith("they wait for it.") for text in trace.warnings)
    assert next_step(state).endswith(GO_ON)
    whole = add_drawing(state, strokes[2:])
    (curve,) = whole.curves
    trace = trace_of(curve, whole)
    assert trace.rest == 0.0
    assert np.median(s.distances(SIDE, trace.points)) < 1.5


@pytest.mark.parametrize("seed", range(300, 310))
def test_sides_of_different_curves_stay_apart(seed: int) -> None:
    drawn = m.strangers(1.0, np.random.default_rng(seed))
    assert len(add_drawing(SymmetryState(), drawn.strokes).curves) == 2
