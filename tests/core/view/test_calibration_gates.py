"""Cameras from marks: how near they have to come, over many random views of a car."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.view.calibration import resect
from tests.core.view.marked_car import PICTURE, POINTS, rms, shot, turned_by

TRIALS = 12
"""Views of each kind; with `pytest -m slow` many more."""


def trials(view, count, noise, *, kind="perspective", ask="auto", seed=0, views=TRIALS):
    """Misses of the hidden points, px, and turns of the camera, degrees."""
    rng = np.random.default_rng(seed)
    missed, turned = [], []
    for _ in range(views):
        taken = shot(rng, view, count, kind)
        at = taken.marked
        marks = taken.places[at] + rng.normal(0, noise, (len(at), 2))
        found = resect(POINTS[at], marks, PICTURE, kind=ask)
        missed.append(rms(found.project(POINTS[taken.hidden]) - taken.places[taken.hidden]))
        turned.append(turned_by(found.camera, taken.camera))
    return np.array(missed), np.array(turned)


@pytest.mark.parametrize("view", ["three-quarter", "side", "front"])
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_marks_without_noise_give_the_camera_back(view, kind):
    missed, turned = trials(view, 99, 0.0, kind=kind)
    assert missed.max() < 1e-6
    assert turned.max() < 1e-4


@pytest.mark.parametrize("count", [6, 8, 12])
def test_few_marks_without_noise_do_as_well(count):
    missed, _ = trials("three-quarter", count, 0.0)
    assert np.quantile(missed, 0.9) < 1e-6


def test_27_marks_of_a_hand():
    missed, turned = trials("three-quarter", 27, 3.0)
    assert np.median(missed) <= 3.0
    assert np.quantile(missed, 0.9) <= 6.0
    assert np.median(turned) <= 0.5
    assert np.quantile(turned, 0.9) <= 1.0


def test_8_marks_of_a_hand():
    missed, turned = trials("three-quarter", 8, 3.0)
    assert np.median(missed) <= 6.0
    assert np.median(turned) <= 1.0


def test_6_marks_of_a_hand_say_where_the_others_are():
    missed, _ = trials("three-quarter", 6, 3.0)
    assert np.median(missed) <= 9.0


@pytest.mark.parametrize("view", ["three-quarter", "side", "front"])
def test_orthographic_sketches(view):
    missed, turned = trials(view, 99, 2.0, kind="orthographic")
    assert np.median(missed) <= 5.0
    assert np.median(turned) <= 1.0


def test_the_kind_is_told_by_the_marks():
    rng = np.random.default_rng(3)
    right = {}
    for kind in ("perspective", "orthographic"):
        right[kind] = 0
        for _ in range(TRIALS):
            taken = shot(rng, count=20, kind=kind)
            marks = taken.places[taken.marked] + rng.normal(0, 2, (20, 2))
            found = resect(POINTS[taken.marked], marks, PICTURE)
            assert set(found.scores) == {"perspective", "orthographic"}
            assert found.scores[found.camera.kind] == min(found.scores.values())
            right[kind] += found.camera.kind == kind
    assert right["perspective"] == TRIALS
    assert right["orthographic"] >= 0.9 * TRIALS


def test_a_car_that_is_not_the_template_turns_the_camera_little():
    rng = np.random.default_rng(4)
    turned = []
    for _ in range(TRIALS):
        real = POINTS * rng.normal(1, 0.03, 3) + rng.normal(0, 40, POINTS.shape)
        taken = shot(rng, points=real)
        marks = taken.places[taken.marked] + rng.normal(0, 3, (27, 2))
        found = resect(POINTS[taken.marked], marks, PICTURE)
        turned.append(turned_by(found.camera, taken.camera))
        assert len(found.disagreeing) <= 2
    assert np.median(turned) <= 2.0


def test_a_cropped_picture_finds_its_principal_point():
    rng = np.random.default_rng(5)
    missed, off = [], []
    for _ in range(TRIALS):
        taken = shot(rng)
        shift = rng.uniform(-250, 250, 2)
        marks = taken.places[taken.marked] + shift
        exact = resect(POINTS[taken.marked], marks, PICTURE, cropped=True)
        off.append(np.linalg.norm(np.array(exact.shift) - shift))
        noisy = resect(
            POINTS[taken.marked], marks + rng.normal(0, 3, marks.shape), PICTURE, cropped=True
        )
        missed.append(rms(noisy.project(POINTS) - taken.places - shift))
        assert exact.camera.viewport == PICTURE
    assert np.median(off) < 30.0, "what is known of the middle draws it there a little"
    assert np.median(missed) <= 3.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("view", "count", "noise", "kind", "median", "most"),
    [
        ("three-quarter", 27, 3.0, "perspective", 3.0, 6.0),
        ("three-quarter", 8, 3.0, "perspective", 6.0, 12.0),
        ("front", 27, 3.0, "perspective", 3.0, 6.0),
        ("side", 27, 3.0, "perspective", 4.0, 9.0),
        ("side", 27, 2.0, "orthographic", 5.0, 9.0),
    ],
)
def test_hundreds_of_views(view, count, noise, kind, median, most):
    missed, turned = trials(view, count, noise, kind=kind, views=300, seed=20)
    assert np.median(missed) <= median
    assert np.quantile(missed, 0.9) <= most
    assert np.median(turned) <= 1.0
