"""Marks without sense: a finite camera, or a sentence that says what to do."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.view.calibration import most_helpful, predicted, resect
from tests.core.view.marked_car import CENTRE, NAMES, NODES, PICTURE, POINTS, rms, shot
from tests.sizes import sized


def sound(found, points):
    """All numbers are numbers, but for the points of marks that were set aside."""
    kept = np.setdiff1d(np.arange(len(points)), found.disagreeing)
    assert np.isfinite(found.project(points[kept])).all()
    assert np.isfinite(found.residuals[kept]).all()
    assert not np.isnan(found.leave_one_out).any()
    assert np.isfinite(found.covariance).all()
    assert np.isfinite((*found.shift, found.deviation, found.rms, *found.scores.values())).all()
    assert found.deviation > 0.0
    expected = predicted(found, POINTS)
    seen = np.isfinite(expected.pixels).all(axis=1)
    assert np.isfinite(expected.covariances[seen]).all()
    assert not np.isnan(most_helpful(found, POINTS).after).any()
    return True


@pytest.mark.parametrize("count", [0, 1, 5])
def test_too_few_marks_say_how_many_and_which(count):
    taken = shot(np.random.default_rng(0))
    further = {name: NODES[name] for name in ("C0", "R2.R")}
    with pytest.raises(UserError, match=r"6 different points, and there are \d.*for example"):
        resect(POINTS[:count], taken.places[:count], PICTURE, further=further)


def test_marks_of_the_same_points_count_once():
    taken = shot(np.random.default_rng(0))
    twice = np.array([0, 1, 10, 20, 30, 0, 1, 10])
    with pytest.raises(UserError, match="there are 5"):
        resect(POINTS[twice], taken.places[twice], PICTURE)


def test_marks_in_the_plane_of_symmetry_ask_for_one_off_it():
    taken = shot(np.random.default_rng(1))
    at = [NAMES.index(name) for name in CENTRE]
    further = {"C4": NODES["C4"], "WF.R": NODES["WF.R"]}
    with pytest.raises(UserError, match=r"close to one plane.*, for example WF\.R\."):
        resect(POINTS[at], taken.places[at], PICTURE, further=further)
    more = [*at, NAMES.index("WF.R")]
    found = resect(POINTS[more], taken.places[more], PICTURE)
    assert rms(found.project(POINTS) - taken.places) < 1e-5


def test_marks_on_a_line_ask_for_one_off_it():
    points = np.linspace((0, 0, 0), (1000, 200, 300), 8)
    marks = np.linspace((100, 100), (900, 300), 8)
    with pytest.raises(UserError, match=r"close to one line.*\(?off it too\.$"):
        resect(points, marks, PICTURE)
    with pytest.raises(UserError, match="close to one line"):
        resect(np.vstack((points, points)), np.vstack((marks, marks)), PICTURE)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"marks": (3, np.nan)}, "not at a finite place"),
        ({"marks": (3, np.inf)}, "not at a finite place"),
        ({"marks": (3, 1e6)}, "far beside the picture"),
        ({"points": (3, np.nan)}, "beyond all bounds"),
        ({"points": (3, 1e12)}, "beyond all bounds"),
        ({"picture": (0.0, 800.0)}, "width and a height"),
        ({"picture": (np.nan, 800.0)}, "width and a height"),
        ({"picture": (1e9, 800.0)}, "width and a height"),
        ({"together": True}, "on top of one another"),
        ({"fewer": True}, "one mark"),
    ],
)
def test_nonsense_is_refused_in_words(change, words):
    taken = shot(np.random.default_rng(2))
    points, marks, picture = POINTS.copy(), taken.places.copy(), change.get("picture", PICTURE)
    if "marks" in change:
        row, value = change["marks"]
        marks[row] = value
    if "points" in change:
        row, value = change["points"]
        points[row] = value
    if "together" in change:
        marks = 0.01 * marks
    if "fewer" in change:
        marks = marks[1:]
    with pytest.raises(UserError, match=words):
        resect(points, marks, picture)


def test_the_mark_far_off_is_shown():
    taken = shot(np.random.default_rng(3))
    marks = taken.places.copy()
    marks[4] = (-1e5, 300)
    with pytest.raises(UserError) as caught:
        resect(POINTS, marks, PICTURE)
    assert caught.value.places == ((-1e5, 300.0),)


def test_marks_beside_the_picture_are_marks():
    taken = shot(np.random.default_rng(4))
    # The same sketch, of which only the middle was scanned: less picture, the same middle.
    found = resect(POINTS, taken.places - (400, 250), (400.0, 300.0))
    assert rms(found.project(POINTS) - taken.places + (400, 250)) < 1e-5
    assert np.abs(taken.places - (600, 400)).max() > 200


def test_left_and_right_exchanged_fit_badly_and_the_mirrored_points_well():
    rng = np.random.default_rng(5)
    for view in ("three-quarter", "side", "front"):
        taken = shot(rng, view)
        at = taken.marked
        marks = taken.places[at] + rng.normal(0, 3, (len(at), 2))
        wrong = resect(POINTS[at] * (1, -1, 1), marks, PICTURE)
        right = resect(POINTS[at], marks, PICTURE)
        assert sound(wrong, POINTS[at])
        assert min(wrong.scores.values()) > min(right.scores.values()) + 10.0
        assert wrong.deviation > 2.0 * right.deviation


def test_a_picture_with_two_marks_at_one_place_and_exchanged_marks():
    rng = np.random.default_rng(6)
    taken = shot(rng)
    at = taken.marked
    marks = taken.places[at].copy()
    marks[[3, 17]] = marks[[17, 3]]
    found = resect(POINTS[at], marks, PICTURE)
    assert sound(found, POINTS[at])
    assert rms(found.project(POINTS) - taken.places) < 3.0
    marks[8] = marks[9]
    assert sound(resect(POINTS[at], marks, PICTURE), POINTS[at])


def test_a_point_behind_the_eye_that_is_marked_all_the_same():
    rng = np.random.default_rng(7)
    taken = shot(rng)
    at = taken.marked
    behind = np.asarray(taken.camera.eye) - 2000.0 * taken.camera.axes[2] + (0, 0, 300)
    points = np.vstack((POINTS[at], behind))
    marks = np.vstack((taken.places[at], (500.0, 300.0)))
    found = resect(points, marks, PICTURE)
    kept = np.setdiff1d(np.arange(len(points)), found.disagreeing)
    assert np.isfinite(found.residuals[kept]).all()
    assert not np.isnan(found.leave_one_out).any()


def garbage(rng):
    """Points and marks of one of eight kinds of nonsense."""
    count = int(rng.integers(4, 28))
    points = POINTS[rng.permutation(len(POINTS))[:count]]
    width, height = PICTURE
    marks = rng.uniform((0, 0), PICTURE, (count, 2))
    kind = int(rng.integers(8))
    if kind == 1:
        marks = rng.uniform(-3 * width, 4 * width, (count, 2))
    elif kind == 2:
        marks = marks[0] + rng.normal(0, 10.0 ** rng.uniform(-3, 2), (count, 2))
    elif kind == 3:
        marks = np.round(marks / 400.0) * 400.0
    elif kind == 4:
        marks[:, 1] = 0.4 * height + rng.normal(0, 1e-3, count)
    elif kind == 5:
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        points = points * (1, 10.0 ** rng.uniform(-6, 0), 1) @ turn
    elif kind == 6:
        points = points[rng.integers(0, count, count)]
    elif kind == 7:
        points = points * 10.0 ** rng.uniform(-4, 4) + 10.0 ** rng.uniform(0, 5)
    return points, marks


def try_garbage(seeds):
    """How many of the sets gave a camera."""
    cameras, before = 0, None
    sentences = []
    for seed in seeds:
        rng = np.random.default_rng((99, seed))
        points, marks = garbage(rng)
        kind = str(rng.choice(("auto", "perspective", "orthographic")))
        cropped = bool(rng.integers(2))
        try:
            found = resect(points, marks, PICTURE, kind=kind, cropped=cropped, before=before)
        except UserError as problem:
            sentences.append(problem.message)
            continue
        cameras += sound(found, points)
        before = found if rng.integers(2) else None
    assert all(sentence.endswith(".") for sentence in sentences)
    return cameras


def test_garbage_gives_a_camera_or_a_sentence():
    assert try_garbage(range(40)) > 20


@pytest.mark.slow
@pytest.mark.parametrize("batch", range(sized(1, 20)))
def test_ten_thousand_sets_of_garbage(batch):
    first = 1000 + 500 * batch
    assert try_garbage(range(first, first + 500)) > 250
