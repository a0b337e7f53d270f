"""Turning about the eye: a picture and what is laid over it stay together."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.view import Camera
from bozzetto.view.eye_fixed_motion import FOV_LIMITS
from bozzetto.view.navigation import pan, zoom

SKETCH = Camera(
    eye=(-3200.0, -5100.0, 1500.0), target=(2300.0, 0.0, 700.0), fov_y=28.0, viewport=(1280, 800)
)
ROLLED = Camera(eye=(10.0, -900.0, 40.0), up=(0.3, 0.1, 1.0), fov_y=45.0)
DOWN = Camera(eye=(0.0, 0.0, 800.0), fov_y=40.0)

drags = st.tuples(st.floats(-220, 220), st.floats(-220, 220))
cameras = st.sampled_from([SKETCH, ROLLED])


def mapped(before, after, places):
    """The homography between two pictures, by Direct Linear Transformation, applied to places.

    It is found from four rays only; that others follow it is what makes it one.
    """
    width, height = before.viewport
    corners = np.array([(0, 0), (width, 0), (width, height), (0, height)], float)
    origins, directions = before.rays(corners)
    seen, _ = after.project(origins + 100.0 * directions)
    rows = []
    for (x, y), (u, v) in zip(corners, seen, strict=True):
        rows += [(x, y, 1, 0, 0, 0, -u * x, -u * y, -u), (0, 0, 0, x, y, 1, -v * x, -v * y, -v)]
    matrix = np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)
    image = np.column_stack((places, np.ones(len(places)))) @ matrix.T
    return image[:, :2] / image[:, 2:]


@given(cameras, drags, st.floats(0.3, 4.0))
def test_pictures_of_near_and_far_things_move_alike(camera, drag, factor):
    """Points on one ray, at any depth, stay on one pixel; pixels follow one homography."""
    moved = zoom(pan(camera, *drag, eye_fixed=True), factor, (300.0, 200.0), eye_fixed=True)
    assert moved.eye == camera.eye
    places = np.random.default_rng(1).uniform((0, 0), camera.viewport, (20, 2))
    origins, directions = camera.rays(places)
    near, _ = moved.project(origins + 30.0 * directions)
    far, _ = moved.project(origins + 30_000.0 * directions)
    seen = np.isfinite(near).all(1)
    assert seen.any()
    np.testing.assert_allclose(near[seen], far[seen], atol=1e-6)
    wanted = mapped(camera, moved, places)
    np.testing.assert_allclose(near[seen], wanted[seen], rtol=1e-6, atol=1e-5)


@given(cameras, drags, st.tuples(st.floats(200, 900), st.floats(200, 600)), st.floats(50, 9000))
def test_what_is_under_the_pen_follows_it_and_comes_back(camera, drag, place, distance):
    origins, directions = camera.rays([place])
    at = origins[0] + distance * directions[0]
    moved = pan(camera, *drag, at, eye_fixed=True)
    (seen,), _ = moved.project(at)
    np.testing.assert_allclose(seen, np.add(place, drag), atol=1e-7)
    back = pan(moved, -drag[0], -drag[1], at, eye_fixed=True)
    assert np.abs(back.axes - camera.axes).max() < 1e-9
    np.testing.assert_allclose(back.target, camera.target, atol=1e-9 * camera.distance)


def test_no_roll_is_gathered_on_a_way_round():
    """The order of drags makes no difference: which way it looks is all there is to a view."""
    camera = SKETCH
    for dx, dy in ((90, 0), (0, 70), (-90, 0), (0, -70)) * 50:
        camera = pan(camera, dx, dy, eye_fixed=True)
        assert abs(camera.axes[0][2]) < 1e-12  # level: z is up


@pytest.mark.parametrize("camera", [SKETCH, ROLLED])
@pytest.mark.parametrize("factor", [0.5, 1.7, 6.0])
def test_zooming_keeps_the_place_and_scales_about_it(camera, factor):
    pixel = (420.0, 310.0)
    origins, directions = camera.rays([pixel])
    closer = zoom(camera, factor, pixel, eye_fixed=True)
    (seen,), _ = closer.project(origins + 777.0 * directions)
    np.testing.assert_allclose(seen, pixel, atol=1e-7)
    slope = np.tan(np.radians(camera.fov_y / 2)) / np.tan(np.radians(closer.fov_y / 2))
    assert slope == pytest.approx(factor)


def test_the_opening_angle_keeps_within_its_limits():
    camera = SKETCH
    for factor in (10.0,) * 6 + (0.1,) * 12:
        camera = zoom(camera, factor, (100.0, 100.0), eye_fixed=True)
        assert FOV_LIMITS[0] - 1e-12 <= camera.fov_y <= FOV_LIMITS[1] + 1e-12
    narrow = Camera(fov_y=0.2)
    assert zoom(narrow, 3.0, eye_fixed=True).fov_y == pytest.approx(0.2)
    assert zoom(narrow, 0.1, eye_fixed=True).fov_y > 1.0


@pytest.mark.parametrize("camera", [SKETCH, ROLLED, DOWN, Camera(up=(0.0, 1.0, 0.0))])
@pytest.mark.parametrize("drag", [(0.0, 1e5), (1e5, -1e5), (3.0, 1e-300), (-1e7, 2e6)])
def test_odd_drags_give_a_view(camera, drag):
    for at in (None, camera.eye, np.subtract(camera.eye, camera.axes[2]), (1e9, 1e9, -1e9)):
        moved = pan(camera, *drag, at, eye_fixed=True)
        assert moved.eye == camera.eye
        assert np.isfinite(moved.axes).all()
        assert moved.distance == pytest.approx(camera.distance)
        zoomed = zoom(camera, 2.0, at=at, eye_fixed=True)
        assert np.isfinite(zoomed.axes).all()


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
def test_factors_that_mean_nothing_change_nothing(bad):
    assert zoom(SKETCH, bad, eye_fixed=True) == SKETCH


def test_looking_straight_down_can_be_moved():
    moved = pan(DOWN, 120.0, 80.0, eye_fixed=True)
    (seen,), _ = moved.project(DOWN.target)
    np.testing.assert_allclose(seen, (720.0, 530.0), atol=1e-6)
    back = pan(moved, -120.0, -80.0, DOWN.target, eye_fixed=True)
    assert np.abs(back.axes - DOWN.axes).max() < 1e-9


def test_orthographic_views_move_as_ever():
    flat = Camera("orthographic", eye=(0.0, -800.0, 0.0), height=300.0)
    assert pan(flat, 30.0, 20.0, eye_fixed=True) == pan(flat, 30.0, 20.0)
    assert zoom(flat, 2.0, (300.0, 200.0), eye_fixed=True) == zoom(flat, 2.0, (300.0, 200.0))
