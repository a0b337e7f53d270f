"""Marks judged by the others: leave-one-out residuals, and wrong marks named."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from bozzetto.view.calibration import resect
from tests.core.view.marked_car import NAMES, PICTURE, POINTS, rms, shot, thrown


@pytest.mark.parametrize(("count", "near"), [(27, 0.1), (10, 0.5)])
def test_leaving_a_mark_out_is_solving_without_it(count, near):
    rng = np.random.default_rng(0)
    for _ in range(3):
        taken = shot(rng, count=count)
        at = taken.marked
        marks = taken.places[at] + rng.normal(0, 3, (count, 2))
        found = resect(POINTS[at], marks, PICTURE, kind="perspective")
        for one in range(0, count, 3):
            rest = np.delete(np.arange(count), one)
            other = resect(POINTS[at][rest], marks[rest], PICTURE, kind="perspective")
            expected = marks[one] - other.project(POINTS[at[one]])[0]
            np.testing.assert_allclose(found.leave_one_out[one], expected, atol=near)


def test_it_is_never_less_than_the_residual():
    rng = np.random.default_rng(1)
    taken = shot(rng, count=9)
    marks = taken.places[taken.marked] + rng.normal(0, 3, (9, 2))
    found = resect(POINTS[taken.marked], marks, PICTURE)
    without = np.linalg.norm(found.leave_one_out, axis=1)
    assert (without >= np.linalg.norm(found.residuals, axis=1) - 0.1).all()
    assert without.mean() > 1.5 * np.linalg.norm(found.residuals, axis=1).mean()


def disturbed(rng, view, count, noise, length):
    """A camera of marks of which one was moved, the one, and the picture."""
    taken = shot(rng, view, count)
    at = taken.marked
    marks = taken.places[at] + rng.normal(0, noise, (len(at), 2))
    wrong = int(rng.integers(len(at)))
    marks[wrong] += thrown(rng, length)
    return resect(POINTS[at], marks, PICTURE), wrong, taken


@pytest.mark.parametrize("view", ["three-quarter", "side", "front"])
@pytest.mark.parametrize("count", [10, 27])
def test_a_mark_moved_by_120_px_is_named_every_time(view, count):
    rng = np.random.default_rng(2)
    for _ in range(10):
        found, wrong, _ = disturbed(rng, view, count, 3.0, 120.0)
        assert found.disagreeing == (wrong,)
        off = np.linalg.norm(found.leave_one_out, axis=1)
        assert off[wrong] > 60.0
        assert np.argmax(off) == wrong


def test_it_does_not_move_the_camera():
    rng = np.random.default_rng(3)
    missed = []
    for _ in range(15):
        found, _, taken = disturbed(rng, "three-quarter", 27, 3.0, 120.0)
        missed.append(rms(found.project(POINTS[taken.hidden]) - taken.places[taken.hidden]))
    assert np.median(missed) <= 3.0
    assert max(missed) <= 6.0


def test_without_noise_it_does_not_move_the_camera_at_all():
    rng = np.random.default_rng(4)
    for length in (20.0, 38.0, 120.0, 2000.0):
        found, wrong, taken = disturbed(rng, "three-quarter", 12, 0.0, length)
        assert found.disagreeing == (wrong,)
        assert rms(found.project(POINTS) - taken.places) < 1e-5
        assert np.linalg.norm(found.leave_one_out[wrong]) == pytest.approx(length, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("view", ["three-quarter", "side", "front"])
@pytest.mark.parametrize(("count", "share"), [(27, 1.0), (15, 1.0), (10, 0.99), (8, 0.95)])
def test_hundreds_of_marks_moved_by_120_px(view, count, share):
    rng = np.random.default_rng(20)
    named = 0
    for _ in range(200):
        found, wrong, _ = disturbed(rng, view, count, 3.0, 120.0)
        named += wrong in found.disagreeing[:1]
    assert named >= share * 200


@pytest.mark.parametrize("noise", [0.0, 1.0, 3.0, 10.0])
def test_hands_are_not_accused(noise):
    rng = np.random.default_rng(5)
    for count in (7, 10, 27):
        for _ in range(5):
            taken = shot(rng, count=count)
            at = taken.marked
            marks = taken.places[at] + rng.normal(0, noise, (count, 2))
            assert resect(POINTS[at], marks, PICTURE).disagreeing == ()


def test_a_wrong_mark_is_named_also_where_the_car_is_not_the_template():
    rng = np.random.default_rng(10)
    for _ in range(8):
        real = POINTS * rng.normal(1, 0.03, 3) + rng.normal(0, 40, POINTS.shape)
        taken = shot(rng, points=real)
        at = taken.marked
        marks = taken.places[at] + rng.normal(0, 3, (27, 2))
        assert resect(POINTS[at], marks, PICTURE).disagreeing == ()
        wrong = int(rng.integers(27))
        marks[wrong] += thrown(rng, 120.0)
        assert resect(POINTS[at], marks, PICTURE).disagreeing == (wrong,)


def test_two_wrong_marks_are_both_named():
    rng = np.random.default_rng(6)
    for _ in range(8):
        taken = shot(rng)
        at = taken.marked
        marks = taken.places[at] + rng.normal(0, 3, (27, 2))
        wrong = rng.permutation(27)[:2]
        marks[wrong[0]] += thrown(rng, 120.0)
        marks[wrong[1]] += thrown(rng, 150.0)
        assert set(resect(POINTS[at], marks, PICTURE).disagreeing) == set(wrong.tolist())


def test_a_mark_on_the_wrong_side_of_the_car_is_named():
    taken = shot(np.random.default_rng(7))
    at = taken.marked
    names = [NAMES[number] for number in at]
    wrong = next(row for row, name in enumerate(names) if name.startswith("WF"))
    points = POINTS[at].copy()
    points[wrong] *= (1, -1, 1)
    found = resect(points, taken.places[at], PICTURE)
    assert found.disagreeing == (wrong,)
    assert rms(found.project(POINTS) - taken.places) < 1e-5


def test_dragging_a_mark_back_takes_it_in_again():
    rng = np.random.default_rng(8)
    taken = shot(rng, count=20)
    at = taken.marked
    marks = taken.places[at] + rng.normal(0, 2, (20, 2))
    right = marks[5].copy()
    way = thrown(rng, 120.0)
    found = None
    named = []
    for share in np.linspace(1.0, 0.0, 25):
        marks[5] = right + share * way
        found = resect(POINTS[at], marks, PICTURE, before=found)
        named.append(found.disagreeing == (5,))
        assert found.disagreeing in ((), (5,))
    assert named[0]
    assert not named[-1]
    assert sum(a != b for a, b in pairwise(named)) == 1, "it changes once"
    cold = resect(POINTS[at], marks, PICTURE, kind=found.camera.kind)
    np.testing.assert_allclose(found.project(POINTS), cold.project(POINTS), atol=1e-2)


def test_six_marks_are_all_kept():
    rng = np.random.default_rng(9)
    taken = shot(rng, count=6)
    marks = taken.places[taken.marked].copy()
    marks[2] += 200.0
    assert resect(POINTS[taken.marked], marks, PICTURE).disagreeing == ()
