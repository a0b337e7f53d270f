"""Where further points are expected, how sure that is, and which mark to ask for next."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.view.calibration import most_helpful, predicted, resect, spread_most
from tests.core.view.marked_car import CENTRE, NAMES, PICTURE, POINTS, rms, shot


def marked(rng, view="three-quarter", count=14, noise=3.0):
    taken = shot(rng, view, count)
    at = taken.marked
    marks = taken.places[at] + rng.normal(0, noise, (len(at), 2))
    return taken, marks


def test_places_are_those_of_the_camera():
    taken, marks = marked(np.random.default_rng(0))
    found = resect(POINTS[taken.marked], marks, PICTURE)
    np.testing.assert_array_equal(predicted(found, POINTS).pixels, found.project(POINTS))


@pytest.mark.parametrize(("view", "count"), [("three-quarter", 10), ("side", 24), ("front", 14)])
def test_ellipses_hold_the_places_as_often_as_they_say(view, count):
    rng = np.random.default_rng(1)
    inside = []
    for _ in range(40):
        taken, marks = marked(rng, view, count)
        found = resect(POINTS[taken.marked], marks, PICTURE, kind="perspective")
        expected = predicted(found, POINTS[taken.hidden])
        axes = expected.ellipses(0.9)
        off = taken.places[taken.hidden] - expected.pixels
        along = np.einsum("mi,mki->mk", off, axes) / np.sum(axes**2, axis=2)
        inside.append(np.mean(np.sum(along**2, axis=1) <= 1.0))
    assert 0.78 <= np.mean(inside) <= 0.97


def test_covariances_are_those_of_many_hands():
    rng = np.random.default_rng(2)
    taken = shot(rng, count=20)
    at = taken.marked
    sigma = 0.002 * np.hypot(*PICTURE)
    places, said = [], []
    for _ in range(60):
        marks = taken.places[at] + rng.normal(0, sigma, (20, 2))
        found = resect(POINTS[at], marks, PICTURE, kind="perspective")
        expected = predicted(found, POINTS[taken.hidden])
        places.append(expected.pixels)
        said.append(np.trace(expected.covariances, axis1=1, axis2=2))
    real = np.sum(np.var(places, axis=0), axis=1)
    ratio = np.sqrt(np.mean(said, axis=0) / real)
    assert 0.7 < ratio.min()
    assert ratio.max() < 1.35


def test_more_marks_make_surer_places():
    rng = np.random.default_rng(3)
    taken, marks = marked(rng, count=27, noise=0.0)
    spread = []
    for count in (6, 9, 14, 27):
        found = resect(POINTS[taken.marked[:count]], marks[:count], PICTURE, kind="perspective")
        expected = predicted(found, POINTS)
        total = np.trace(expected.covariances, axis1=1, axis2=2).mean()
        spread.append(np.sqrt(total) / found.deviation)  # per pixel of the hand
    assert spread == sorted(spread, reverse=True)


def test_points_behind_the_eye_have_no_place():
    taken, marks = marked(np.random.default_rng(4))
    found = resect(POINTS[taken.marked], marks, PICTURE)
    eye, forward = np.asarray(found.camera.eye), found.camera.axes[2]
    expected = predicted(found, [eye - 100 * forward, eye, POINTS[0]])
    assert np.isnan(expected.pixels[:2]).all()
    assert np.isnan(expected.covariances[:2]).all()
    assert np.isnan(expected.ellipses()[:2]).all()
    assert np.isfinite(expected.ellipses()[2]).all()
    helps = most_helpful(found, [eye - 100 * forward, POINTS[0]])
    assert helps.best == 1
    assert helps.after[0] == np.inf
    assert most_helpful(found, [eye - 100 * forward]).best is None


def test_axes_of_ellipses():
    taken, marks = marked(np.random.default_rng(5), count=8)
    expected = predicted(resect(POINTS[taken.marked], marks, PICTURE), POINTS)
    half = expected.ellipses(0.5)
    long, short = np.linalg.norm(half, axis=2).T
    assert (long >= short).all()
    np.testing.assert_allclose(np.sum(half[:, 0] * half[:, 1], axis=1), 0.0, atol=1e-9)
    draws = np.random.default_rng(6).multivariate_normal(
        np.zeros(2), expected.covariances[0], 20000
    )
    along = draws @ half[0].T / np.sum(half[0] ** 2, axis=1)
    assert np.mean(np.sum(along**2, axis=1) <= 1.0) == pytest.approx(0.5, abs=0.02)
    for share in (0.0, 1.0, -1.0, np.nan):
        with pytest.raises(UserError):
            expected.ellipses(share)


def test_what_a_mark_would_help_is_what_it_helps():
    rng = np.random.default_rng(7)
    taken, marks = marked(rng, count=8)
    at = taken.marked
    found = resect(POINTS[at], marks, PICTURE, kind="perspective")
    helps = most_helpful(found, POINTS[taken.hidden])
    now = predicted(found, POINTS[taken.hidden]).covariances
    assert helps.before == pytest.approx(np.sqrt(np.trace(now, axis1=1, axis2=2).mean()))
    for number, point in enumerate(POINTS[taken.hidden]):
        # Marked where it is expected, it changes nothing but the certainty.
        more = resect(
            np.vstack((POINTS[at], point)),
            np.vstack((marks, found.project(point))),
            PICTURE,
            kind="perspective",
        )
        np.testing.assert_allclose(more.project(POINTS), found.project(POINTS), atol=0.05)
        then = predicted(more, POINTS[taken.hidden]).covariances
        then *= (found.deviation / more.deviation) ** 2
        real = np.sqrt(np.trace(then, axis1=1, axis2=2).mean())
        assert helps.after[number] == pytest.approx(real, rel=0.03)
    assert helps.best == np.argmin(helps.after)
    assert (helps.after < helps.before).all()


def test_the_mark_it_asks_for_is_better_than_any():
    rng = np.random.default_rng(8)
    asked, others = [], []
    for _ in range(25):
        taken = shot(rng)
        at = np.array([NAMES.index(name) for name in (*CENTRE, "R2.R")])
        rest = np.setdiff1d(np.arange(len(POINTS)), at)
        marks = taken.places + rng.normal(0, 3, taken.places.shape)
        found = resect(POINTS[at], marks[at], PICTURE)
        best = rest[most_helpful(found, POINTS[rest]).best]
        for kept, one in ((asked, best), (others, rng.choice(rest))):
            more = np.append(at, one)
            after = resect(POINTS[more], marks[more], PICTURE)
            kept.append(rms(after.project(POINTS[rest]) - taken.places[rest]))
    assert np.mean(asked) < 0.9 * np.mean(others)


def test_the_point_that_spreads_most():
    plane = np.array([(0, 0, 0), (100, 0, 0), (0, 0, 100), (100, 0, 100)], float)
    assert spread_most(plane, [(50, 1, 50), (50, -30, 50), (50, 20, 50)]) == 1
    line = np.array([(0, 0, 0), (50, 0, 0), (100, 0, 0)], float)
    assert spread_most(line, [(200, 0, 0), (50, 40, 0)]) == 1
    assert spread_most(plane, []) is None
    assert spread_most([], [(1, 2, 3)]) == 0
    assert spread_most([(1, 2, 3)], [(1, 2, 3), (4, 5, 6)]) == 1


def test_points_without_sense_have_no_place_and_are_not_asked_for():
    taken, marks = marked(np.random.default_rng(9))
    found = resect(POINTS[taken.marked], marks, PICTURE)
    odd = [(np.nan, 0, 0), (np.inf, 0, 0), (1e300, -1e300, 1e300), POINTS[3]]
    expected = predicted(found, odd)
    assert np.isnan(expected.pixels[:3]).all()
    assert np.isfinite(expected.pixels[3]).all()
    assert most_helpful(found, odd).best == 3
    assert spread_most(POINTS[:3], odd) == 3
    assert spread_most(POINTS[:3], odd[:3]) is None
    assert len(predicted(found, []).ellipses()) == 0
    assert most_helpful(found, []).best is None
