"""Cameras: the sheet and the world agree in both directions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.view.camera import Camera
from tests.core.view.cameras import cameras, point

pixel = st.tuples(st.floats(0, 1), st.floats(0, 1))


@given(cameras(), pixel, st.floats(0.05, 20))
def test_projecting_a_point_of_a_ray_gives_its_pixel(camera, share, far):
    place = np.array(share) * camera.viewport
    rays = camera.rays([place])
    point = rays.origins + far * camera.distance * rays.directions
    pixels, depth = camera.project(point)
    np.testing.assert_allclose(pixels[0], place, atol=1e-6 * max(camera.viewport))
    forward = rays.directions[0] @ camera.axes[2]
    assert depth[0] == pytest.approx(far * camera.distance * forward, rel=1e-6)
    assert np.linalg.norm(rays.directions[0]) == pytest.approx(1.0)


@given(cameras())
def test_the_target_is_the_middle_of_the_canvas_and_axes_are_orthonormal(camera):
    pixels, depth = camera.project(camera.target)
    np.testing.assert_allclose(pixels[0], np.array(camera.viewport) / 2, atol=1e-4)
    assert depth[0] == pytest.approx(camera.distance)
    np.testing.assert_allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(camera.axes) == pytest.approx(-1.0), "right, up, forward"


@given(cameras(), pixel)
def test_a_pixel_is_laid_on_a_plane(camera, share):
    place = np.array(share) * camera.viewport
    normal = camera.axes[2] + 0.3 * camera.axes[0]
    point = camera.on_plane([place], camera.target, normal)
    if np.isfinite(point).all():
        assert abs((point[0] - camera.target) @ normal) < 1e-6 * camera.distance * 100
        np.testing.assert_allclose(camera.project(point)[0][0], place, atol=1e-3)


@given(cameras())
def test_the_scale_at_the_target(camera):
    right, up, _ = camera.axes
    step = camera.visible_height / 10
    pixels, _ = camera.project(np.asarray(camera.target) + np.array([step * right, step * up]))
    np.testing.assert_allclose(
        pixels - np.array(camera.viewport) / 2,
        np.array([[1, 0], [0, -1]]) * step * camera.pixels_per_mm,
        atol=1e-3 * camera.viewport[1] / 10,
    )


def test_the_front_view_has_x_to_the_right_and_z_up():
    camera = Camera(viewport=(100, 100))
    (middle, right, above), _ = camera.project([(0, 0, 0), (10, 0, 0), (0, 0, 10)])
    assert right[0] > middle[0]
    assert right[1] == middle[1]
    assert above[1] < middle[1]
    assert above[0] == middle[0]


def test_behind_the_eye_there_is_no_pixel_in_perspective():
    pixels, depth = Camera().project([(0, -501, 0), (0, -500, 0)])
    assert np.isnan(pixels).all()
    assert (depth <= 0).all()


@pytest.mark.parametrize(
    "broken",
    [
        {"eye": (0, 0, 0)},
        {"eye": (0, np.nan, 0)},
        {"eye": (0, 1)},
        {"eye": (1e308, -1e308, 1e308)},
        {"viewport": (0, 10)},
        {"viewport": (10,)},
        {"height": -1},
        {"fov_y": 180},
        {"fov_y": 0},
        {"kind": "fisheye"},
        {"up": (0, 0, np.inf)},
    ],
)
def test_a_camera_that_cannot_be_is_refused(broken):
    with pytest.raises(UserError):
        Camera(**broken)


@pytest.mark.parametrize("up", [(0, 0, 0), (0, 1, 0), (0, -3, 0), (1e-320, 0, 0), (0, 0, 1e300)])
def test_a_bad_up_still_gives_a_frame(up):
    axes = Camera(up=up).axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)


@st.composite
def placements(draw):
    """Any turn, mirrored or not, any scale, any offset."""
    near = np.reshape(draw(st.lists(st.floats(-1, 1), min_size=9, max_size=9)), (3, 3))
    turn, _ = np.linalg.qr(near + 3.0 * np.diag((1, -1, draw(st.sampled_from((1, -1))))))
    scale = 10.0 ** draw(st.floats(-2, 2))
    return Placement(tuple(turn.ravel().tolist()), scale, draw(point))


@given(cameras(), placements(), st.lists(pixel, min_size=1, max_size=5))
def test_a_camera_carried_along_sees_the_moved_world_as_it_saw_the_world(camera, placement, shares):
    places = np.array(shares) * camera.viewport
    rays = camera.rays(places)
    seen = rays.origins + camera.distance * rays.directions
    moved = camera.moved(placement)
    flipped = places.copy()
    if placement.mirrors:
        flipped[:, 0] = camera.viewport[0] - places[:, 0]
    pixels, depth = moved.project(placement.points(seen))
    np.testing.assert_allclose(pixels, flipped, atol=1e-5 * max(camera.viewport))
    np.testing.assert_allclose(depth, placement.scale * camera.project(seen)[1], rtol=1e-6)


@given(cameras(), placements())
def test_a_camera_carried_there_and_back_is_where_it_was(camera, placement):
    back = camera.moved(placement).moved(placement.inverse())
    np.testing.assert_allclose(back.axes, camera.axes, atol=1e-6)
    atol = 1e-6 * (camera.distance + np.abs(camera.target).max() + 1e3)
    np.testing.assert_allclose(back.eye, camera.eye, atol=atol)
    assert back.height == pytest.approx(camera.height)


def test_a_camera_beyond_all_bounds_is_refused():
    with pytest.raises(UserError):
        Camera().moved(Placement(scale=1e308))
