"""Nasty ink costs no more than it must: counted in work, or in processor time by its growth."""

from __future__ import annotations

import sys
import time

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.view import Camera
from bozzetto_symmetry.ink.sides import MOST_STROKES, sides_of
from bozzetto_symmetry.ink.stroke_grouping import bonds_between, group_strokes
from bozzetto_symmetry.ink.stroke_line import MOST_SAMPLES, smooth_line, thin_out
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations import assign_stroke
from bozzetto_symmetry.operations.assign_stroke import add_drawing

CAMERA = Camera().with_viewport(1000.0, 800.0)


def wave(shift: float = 0.0) -> np.ndarray:
    along = np.linspace(0.0, 1.0, 60)
    return np.c_[300.0 + 400.0 * along, 400.0 + shift + 80.0 * np.sin(6.0 * along)]


def stroke(points: np.ndarray) -> Stroke:
    return Stroke(points[:, 0], points[:, 1], camera=CAMERA)


def processor_time(work) -> float:
    begun = time.thread_time()
    work()
    return time.thread_time() - begun


def calls_of(work) -> int:
    """How many functions are called, in Python and below it."""
    count = [0]

    def heed(frame, event, argument):
        count[0] += event in ("call", "c_call")

    sys.setprofile(heed)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count[0]


@pytest.mark.parametrize("count", [10, 20, 40])
def test_strokes_are_compared_once_with_each_other(count):
    lines = [wave(0.01 * k) for k in range(count)]
    bonds = calls_of(lambda: bonds_between(lines))
    assert bonds < calls_of(lambda: group_strokes(lines)) < 1.5 * bonds


def test_uniting_groups_gives_what_uniting_them_one_by_one_gave():
    rng = np.random.default_rng(5)
    near = [wave(float(shift)) for shift in rng.normal(0.0, 2.0, 9)]
    far = [wave(150.0 + float(shift)) for shift in rng.normal(0.0, 2.0, 8)]
    mixed = [line for pair in zip(near, far, strict=False) for line in pair]
    assert group_strokes(mixed) == [list(range(0, 16, 2)), list(range(1, 16, 2))]


def test_too_many_strokes_are_refused_with_what_to_do():
    with pytest.raises(UserError, match="press Enter"):
        sides_of([stroke(wave(0.1 * k)) for k in range(MOST_STROKES + 1)])


def test_samples_closer_than_a_hand_draws_change_nothing():
    turn = np.linspace(0.0, 2.0 * np.pi, 40_000)
    dense = np.c_[500.0 + 200.0 * np.cos(turn), 400.0 + 150.0 * np.sin(turn)]
    few = thin_out(dense)
    assert len(few) <= MOST_SAMPLES + 2
    assert np.array_equal(few[[0, -1]], dense[[0, -1]])
    assert {tuple(row) for row in few.tolist()} <= {tuple(row) for row in dense.tolist()}
    one, other = smooth_line(dense), smooth_line(dense[::4])
    assert one.closed
    assert other.closed
    assert np.abs(one.pixels - other.pixels).max() < 0.05


def test_a_scribble_of_random_points_grows_no_faster_than_its_crossings():
    rng = np.random.default_rng(1)
    smooth_line(rng.uniform(100.0, 700.0, (100, 2)))  # imports
    spent = [
        processor_time(lambda n=n: smooth_line(rng.uniform(100.0, 700.0, (n, 2))))
        for n in (400, 800, 1600)
    ]
    # Crossings grow with the square; the slack is for a machine that others use as well.
    assert spent[2] < 16.0 * max(spent[0], 0.02) * 2.0
    assert spent[2] < 3.0


def test_ink_that_goes_over_one_curve_is_read_without_solving_it_each_time(monkeypatch):
    solved = []
    trace_of = assign_stroke.trace_of
    monkeypatch.setattr(
        assign_stroke, "trace_of", lambda *asked: solved.append(1) or trace_of(*asked)
    )
    found = []
    for count in (4, 40):
        solved.clear()
        state = add_drawing(SymmetryState(), [stroke(wave(0.05 * k)) for k in range(count)])
        found.append((len(state.curves), len(state.curves[0].strokes), len(solved)))
    assert found[0][:2] == (1, 4)
    assert found[1] == (1, 40, found[0][2])


def test_ink_beside_what_was_gone_over_is_a_curve_of_its_own():
    strokes = [stroke(wave(0.05 * k)) for k in range(3)] + [stroke(wave(200.0))]
    first = add_drawing(SymmetryState(), strokes).curves[0]
    assert all(abs(drawn.points[0, 1] - 400.0) < 1.0 for drawn in first.strokes[:3])


def test_drifting_strokes_are_not_gone_over(monkeypatch):
    """Each is along the one before: only solving tells whether it still is the same curve."""
    state = add_drawing(SymmetryState(), [stroke(wave(6.0 * k)) for k in range(12)])
    first = state.curves[0].strokes
    assert len(first) < 12 or len(state.curves) == 1
    solved = []
    trace_of = assign_stroke.trace_of
    monkeypatch.setattr(
        assign_stroke, "trace_of", lambda *asked: solved.append(1) or trace_of(*asked)
    )
    add_drawing(state.with_node(state.curves[0]), [stroke(wave(72.0))])
    assert solved
