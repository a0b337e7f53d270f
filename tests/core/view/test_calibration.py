"""Laws of cameras from marks: what must not change them, and what they are the best of."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry import Placement
from bozzetto.view.calibration import resect
from tests.core.view.marked_car import PICTURE, POINTS, rms, shot


def test_a_kind_that_is_asked_for_is_taken():
    taken = shot(np.random.default_rng(1))
    for kind in ("perspective", "orthographic"):
        found = resect(POINTS[taken.marked], taken.places[taken.marked], PICTURE, kind=kind)
        assert found.camera.kind == kind
        assert set(found.scores) == {kind}


def test_a_picture_that_is_not_cropped_has_no_shift():
    taken = shot(np.random.default_rng(6))
    found = resect(POINTS[taken.marked], taken.places[taken.marked] + (40, -20), PICTURE)
    assert found.shift == (0.0, 0.0)
    np.testing.assert_array_equal(found.project(POINTS), found.camera.project(POINTS)[0])


def test_the_camera_goes_along_with_the_world():
    rng = np.random.default_rng(7)
    taken = shot(rng)
    marks = taken.places[taken.marked] + rng.normal(0, 3, (27, 2))
    found = resect(POINTS[taken.marked], marks, PICTURE)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    moved = Placement(tuple(turn.ravel().tolist()), 2.5, (300.0, -1e4, 7e3))
    again = resect(moved.points(POINTS[taken.marked]), marks, PICTURE)
    np.testing.assert_allclose(
        again.project(moved.points(POINTS)), found.project(POINTS), atol=1e-3
    )
    np.testing.assert_allclose(again.camera.eye, found.camera.moved(moved).eye, atol=0.1)


def test_a_scan_at_another_resolution_and_other_orders_of_marks_are_the_same():
    rng = np.random.default_rng(8)
    taken = shot(rng, count=12)
    marks = taken.places[taken.marked] + rng.normal(0, 3, (12, 2))
    found = resect(POINTS[taken.marked], marks, PICTURE)
    finer = resect(POINTS[taken.marked], 4 * marks, (4800, 3200))
    np.testing.assert_allclose(finer.project(POINTS), 4 * found.project(POINTS), atol=4e-3)
    assert finer.deviation == pytest.approx(4 * found.deviation, rel=1e-5)
    order = rng.permutation(12)
    other = resect(POINTS[taken.marked][order], marks[order], PICTURE)
    np.testing.assert_allclose(other.project(POINTS), found.project(POINTS), atol=1e-3)
    np.testing.assert_allclose(other.residuals, found.residuals[order], atol=1e-3)


def test_residuals_are_mark_minus_place():
    rng = np.random.default_rng(9)
    taken = shot(rng)
    marks = taken.places[taken.marked] + rng.normal(0, 3, (27, 2))
    found = resect(POINTS[taken.marked], marks, PICTURE)
    np.testing.assert_allclose(
        found.residuals, marks - found.project(POINTS[taken.marked]), atol=1e-8
    )
    assert found.rms == pytest.approx(rms(found.residuals))
    assert 2.0 < found.deviation < 4.5


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_no_camera_nearby_and_none_that_another_solver_finds_has_a_lower_loss(kind):
    from scipy.optimize import minimize
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(10)
    taken = shot(rng, count=15, kind=kind)
    at = taken.marked
    marks = taken.places[at] + rng.normal(0, 3, (15, 2))
    found = resect(POINTS[at], marks, PICTURE, kind=kind)
    start = found.camera
    right, up, forward = start.axes
    knee = 0.003 * np.hypot(*PICTURE)  # from docs/car.md

    def loss(numbers):
        turn = Rotation.from_rotvec(numbers[:3]).as_matrix() @ np.stack((right, -up, forward))
        eye = np.asarray(start.eye) + 1e3 * numbers[3:6]
        if kind == "perspective":
            size = 0.5 * PICTURE[1] / np.tan(np.radians(start.fov_y) / 2) * np.exp(numbers[6])
            seen = (POINTS[at] - eye) @ turn.T
            places = seen[:, :2] / seen[:, 2:] * size
        else:
            size = PICTURE[1] / start.height * np.exp(numbers[6])
            places = (POINTS[at] - eye) @ turn[:2].T * size
        off = np.sum((places + 0.5 * np.array(PICTURE) - marks) ** 2, axis=1)
        return float(np.sum(2 * knee**2 * (np.sqrt(1 + off / knee**2) - 1)))

    here = loss(np.zeros(7))
    for scale in (1e-4, 1e-3, 1e-2):
        for _ in range(30):
            assert loss(scale * rng.normal(size=7)) >= here
    other = minimize(
        loss, 1e-3 * rng.normal(size=7), method="Nelder-Mead", options={"maxiter": 4000}
    )
    assert other.fun >= here * (1 - 1e-6)


def test_resuming_gives_what_searching_gives():
    rng = np.random.default_rng(11)
    for _ in range(10):
        taken = shot(rng, count=14)
        at = taken.marked
        marks = taken.places[at] + rng.normal(0, 3, (14, 2))
        before = resect(POINTS[at], marks, PICTURE)
        marks[3] += rng.normal(0, 10, 2)
        resumed = resect(POINTS[at], marks, PICTURE, before=before)
        searched = resect(POINTS[at], marks, PICTURE, kind=before.camera.kind)
        np.testing.assert_allclose(resumed.project(POINTS), searched.project(POINTS), atol=1e-2)
        assert resumed.camera.kind == before.camera.kind


def test_a_cropped_picture_is_resumed_and_may_be_called_whole_again():
    rng = np.random.default_rng(14)
    taken = shot(rng)
    marks = taken.places[taken.marked] + (150, -90) + rng.normal(0, 2, (27, 2))
    before = resect(POINTS[taken.marked], marks, PICTURE, cropped=True)
    marks[0] += 4.0
    for cropped in (True, False):
        resumed = resect(POINTS[taken.marked], marks, PICTURE, cropped=cropped, before=before)
        searched = resect(POINTS[taken.marked], marks, PICTURE, cropped=cropped, kind="perspective")
        np.testing.assert_allclose(resumed.shift, searched.shift, atol=0.1)
        np.testing.assert_allclose(resumed.project(POINTS), searched.project(POINTS), atol=0.05)
    assert resumed.shift == (0.0, 0.0)


def test_marks_that_were_taken_away_do_not_matter_to_what_was_set_aside():
    rng = np.random.default_rng(15)
    taken = shot(rng, count=8)
    marks = taken.places[taken.marked].copy()
    marks[7] += 150.0
    before = resect(POINTS[taken.marked], marks, PICTURE)
    assert before.disagreeing == (7,)
    fewer = resect(POINTS[taken.marked[:7]], marks[:7], PICTURE, before=before)
    assert fewer.disagreeing == ()
    assert rms(fewer.project(POINTS) - taken.places) < 1e-4
    moved = np.roll(np.arange(8), 1)
    other = resect(POINTS[taken.marked[moved]], marks[moved], PICTURE, before=before)
    assert other.disagreeing == (0,)


def test_resuming_from_a_camera_of_other_marks_searches():
    rng = np.random.default_rng(12)
    for _ in range(10):
        one, other = shot(rng), shot(rng)
        before = resect(POINTS[one.marked], one.places[one.marked], PICTURE)
        found = resect(POINTS[other.marked], other.places[other.marked], PICTURE, before=before)
        assert rms(found.project(POINTS) - other.places) < 1e-5
