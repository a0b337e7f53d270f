"""The direct linear transform: exact where the marks are, and taken apart rightly."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.view.calibration import direct_linear_transform
from tests.core.view.marked_car import CENTRE, NAMES, PICTURE, POINTS, rms, shot, turned_by


@pytest.mark.parametrize("count", [6, 12, 27])
def test_exact_marks_give_the_camera_back(count):
    rng = np.random.default_rng(0)
    for _ in range(20):
        taken = shot(rng, count=count)
        try:
            made = direct_linear_transform(POINTS[taken.marked], taken.places[taken.marked])
        except UserError:
            assert count == 6, "only few points may happen to lie badly"
            continue
        np.testing.assert_allclose(made.project(POINTS), taken.places, atol=1e-5)
        parts = made.parts
        focal = 0.5 * PICTURE[1] / np.tan(np.radians(taken.camera.fov_y) / 2)
        np.testing.assert_allclose(parts.focal, focal, rtol=1e-6)
        np.testing.assert_allclose(parts.principal, (600, 400), atol=1e-2)
        assert parts.skew == pytest.approx(np.pi / 2, abs=1e-6)
        np.testing.assert_allclose(parts.eye, taken.camera.eye, atol=0.1)
        right, up, forward = taken.camera.axes
        np.testing.assert_allclose(parts.turn, (right, -up, forward), atol=1e-6)
        np.testing.assert_allclose(parts.shift, -parts.turn @ parts.eye, atol=1e-6)


def test_any_matrix_is_taken_apart_as_an_rq_decomposition_has_it():
    from scipy.linalg import rq

    rng = np.random.default_rng(1)
    for _ in range(30):
        taken = shot(rng)
        right, up, forward = taken.camera.axes
        turn = np.stack((right, -up, forward))
        inner = np.array([[rng.uniform(800, 3000), rng.normal(0, 60), rng.normal(600, 80)],
                          [0, rng.uniform(800, 3000), rng.normal(400, 80)], [0, 0, 1]])  # fmt: skip
        seen = (POINTS - taken.camera.eye) @ turn.T @ inner.T
        made = direct_linear_transform(POINTS, seen[:, :2] / seen[:, 2:])
        triangle, _ = rq(made.matrix[:, :3])
        triangle *= np.sign(np.diag(triangle))
        triangle /= triangle[2, 2]
        parts = made.parts
        sine, cosine = np.sin(parts.skew), np.cos(parts.skew)
        ours = [[parts.focal[0], -parts.focal[0] * cosine / sine, parts.principal[0]],
                [0, parts.focal[1] / sine, parts.principal[1]], [0, 0, 1]]  # fmt: skip
        np.testing.assert_allclose(ours, triangle, rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(ours, inner, rtol=1e-5, atol=1e-2)
        np.testing.assert_allclose(parts.turn, turn, atol=1e-6)


def test_marks_lie_before_the_eye_also_where_the_origin_does_not():
    taken = shot(np.random.default_rng(2))
    behind = np.asarray(taken.camera.eye) - 3000 * taken.camera.axes[2]
    world = POINTS - behind  # the origin 3 m behind the eye
    made = direct_linear_transform(world, taken.places)
    np.testing.assert_allclose(made.project(world), taken.places, atol=1e-5)
    assert made.parts.shift[2] < 0.0, "t_z is the depth of the origin"
    depth = world @ made.matrix[2, :3] + made.matrix[2, 3]
    np.testing.assert_allclose(depth, taken.camera.project(POINTS)[1], rtol=1e-6)
    assert np.isnan(made.project([(0.0, 0.0, 0.0)])).all()


def test_units_of_points_and_marks_do_not_matter():
    rng = np.random.default_rng(3)
    taken = shot(rng)
    marks = taken.places + rng.normal(0, 3, taken.places.shape)
    made = direct_linear_transform(POINTS, marks)
    other = direct_linear_transform(1e-3 * POINTS + 7.0, 1e-3 * marks - 5.0)
    np.testing.assert_allclose(
        other.project(1e-3 * POINTS + 7.0), 1e-3 * made.project(POINTS) - 5.0, atol=1e-7
    )


def test_it_turns_the_camera_more_than_the_constrained_one_does():
    from bozzetto.view import Camera
    from bozzetto.view.calibration import resect

    rng = np.random.default_rng(4)
    direct, constrained = [], []
    for _ in range(15):
        taken = shot(rng, count=10)
        at = taken.marked
        marks = taken.places[at] + rng.normal(0, 3, (10, 2))
        found = resect(POINTS[at], marks, PICTURE)
        constrained.append(turned_by(found.camera, taken.camera))
        parts = direct_linear_transform(POINTS[at], marks).parts
        looks = Camera(eye=parts.eye, target=parts.eye + 1e3 * parts.turn[2], up=-parts.turn[1])
        direct.append(turned_by(looks, taken.camera))
    assert np.median(direct) > 2.0 * np.median(constrained)


def test_its_noise_is_what_the_notes_on_it_say():
    rng = np.random.default_rng(5)
    missed = []
    for _ in range(40):
        taken = shot(rng)
        marks = taken.places[taken.marked] + rng.normal(0, 3, (27, 2))
        made = direct_linear_transform(POINTS[taken.marked], marks)
        missed.append(rms(made.project(POINTS[taken.hidden]) - taken.places[taken.hidden]))
    assert np.median(missed) < 6.0


def test_points_of_a_plane_are_refused():
    taken = shot(np.random.default_rng(6))
    centre = [NAMES.index(name) for name in CENTRE]
    with pytest.raises(UserError, match="off that plane"):
        direct_linear_transform(POINTS[centre], taken.places[centre])


@pytest.mark.parametrize(
    ("points", "marks"),
    [
        (POINTS[:5], np.zeros((5, 2))),
        (POINTS[:8], np.zeros((7, 2))),
        (POINTS[:8], np.full((8, 2), np.nan)),
        (np.full((8, 3), np.inf), np.zeros((8, 2))),
        (np.zeros((8, 3)), np.zeros((8, 2))),
        (POINTS, np.zeros((39, 2))),
    ],
)
def test_what_says_nothing_is_refused(points, marks):
    with pytest.raises(UserError):
        direct_linear_transform(points, marks)
