"""Laws of moving about: what stays where it is, what comes out exactly."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.view.camera import Camera
from bozzetto.view.gl_matrices import gl_matrices, near_far
from bozzetto.view.navigation import (
    CLEARANCE,
    END_ON,
    fit,
    fit_points,
    interpolate,
    orbit,
    pan,
    turn,
    with_kind,
    zoom,
)
from bozzetto.view.standard_views import CUBE_DIRECTIONS, STANDARD_VIEWS, look_along, standard_view
from tests.core.view.cameras import cameras, point

degrees = st.floats(-400, 400)
share = st.tuples(st.floats(0, 1), st.floats(0, 1))


def close(camera, tolerance=1e-6):
    """Absolute tolerance in pixels."""
    return tolerance * max(camera.viewport) * (1 + np.abs(camera.target).max() / camera.distance)


# -- turning -----------------------------------------------------------------------------------


@given(cameras(), degrees, degrees, share, st.floats(0.2, 3), st.booleans())
def test_turning_keeps_the_pivot_in_its_place(camera, azimuth, elevation, at, depth, turntable):
    rays = camera.rays([np.array(at) * camera.viewport])
    pivot = (rays.origins + depth * camera.distance * rays.directions)[0]
    before, depth_before = camera.project(pivot)
    turned = turn(camera, azimuth, elevation, pivot, turntable=turntable)
    after, depth_after = turned.project(pivot)
    np.testing.assert_allclose(after, before, atol=close(camera))
    assert depth_after[0] == pytest.approx(depth_before[0], rel=1e-6)
    assert turned.distance == pytest.approx(camera.distance, rel=1e-6)
    assert turned.visible_height == pytest.approx(camera.visible_height, rel=1e-6)


@given(cameras(upright=True), st.lists(st.tuples(degrees, degrees), min_size=1, max_size=6))
def test_a_turntable_never_rolls_nor_hangs_upside_down(camera, moves):
    for azimuth, elevation in moves:
        camera = turn(camera, azimuth, elevation)
        right, up, _ = camera.axes
        assert abs(right[2]) < 1e-6, "the horizon stays level"
        assert up[2] > -1e-6, "up stays up"


def test_at_the_pole_the_turntable_stops_and_the_way_back_is_the_way_there():
    start = Camera(viewport=(800, 600))
    top = turn(start, 30, 500)
    np.testing.assert_allclose(top.axes[2], (0, 0, -1), atol=1e-12)
    beyond = turn(top, 0, 10)
    np.testing.assert_allclose(beyond.axes, top.axes, atol=1e-12)
    back = turn(top, -30, -90)
    np.testing.assert_allclose(back.axes, start.axes, atol=1e-12)
    np.testing.assert_allclose(back.eye, start.eye, atol=1e-9)


def test_near_the_pole_the_sheet_does_not_jump():
    camera = turn(Camera(), 20, 88)
    for _ in range(400):
        step = turn(camera, 0.0, 0.01)
        assert np.abs(step.axes - camera.axes).max() < 1e-3
        camera = step


def test_a_drag_to_the_right_brings_the_left_side_round():
    start = Camera(viewport=(800, 600))
    near = [(0.0, -50.0, 0.0)]
    for turntable in (True, False):
        assert orbit(start, 10, 0, turntable=turntable).project(near)[0][0, 0] > 400
        assert orbit(start, 0, 10, turntable=turntable).project(near)[0][0, 1] > 300


@given(cameras(), degrees, degrees)
def test_a_free_turn_undone_is_no_turn(camera, azimuth, elevation):
    there = turn(camera, azimuth, 0, turntable=False)
    back = turn(there, -azimuth, 0, turntable=False)
    np.testing.assert_allclose(back.axes, camera.axes, atol=1e-9)
    over = turn(turn(camera, 0, elevation, turntable=False), 0, -elevation, turntable=False)
    np.testing.assert_allclose(over.axes, camera.axes, atol=1e-9)


# -- moving ------------------------------------------------------------------------------------


@given(cameras(), share, st.floats(-200, 200), st.floats(-200, 200), st.floats(0.3, 4))
def test_panning_carries_a_point_with_the_pen(camera, at, dx, dy, depth):
    rays = camera.rays([np.array(at) * camera.viewport])
    held = (rays.origins + depth * camera.distance * rays.directions)[0]
    before, _ = camera.project(held)
    after, _ = pan(camera, dx, dy, held).project(held)
    np.testing.assert_allclose(after, before + np.array((dx, dy)), atol=close(camera))


@given(cameras(), share, st.floats(0.01, 100), st.booleans(), st.floats(0.3, 4))
def test_zooming_holds_the_place_under_the_pen(camera, at, factor, on_surface, depth):
    pixel = np.array(at) * camera.viewport
    if on_surface:
        rays = camera.rays([pixel])
        held = (rays.origins + depth * camera.distance * rays.directions)[0]
        zoomed = zoom(camera, factor, at=held)
    else:
        held = camera.on_plane([pixel], camera.target, camera.axes[2])[0]
        zoomed = zoom(camera, factor, tuple(pixel))
    after, _ = zoomed.project(held)
    np.testing.assert_allclose(after[0], pixel, atol=10 * max(1, factor) * close(camera))
    if zoomed.visible_height > 2e-5 and zoomed.visible_height < 5e7:
        assert zoomed.visible_height == pytest.approx(camera.visible_height / factor, rel=1e-5)


@given(cameras(), st.sampled_from([1e-3, 0.5, 2.0, 1e3]))
def test_zooming_for_ever_stops_at_the_limits(camera, factor):
    for _ in range(60):
        camera = zoom(camera, factor, (3.0, 4.0))
    assert 9e-6 < camera.visible_height < 1.1e8


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf])
def test_a_factor_that_is_none_changes_nothing(factor):
    assert zoom(Camera(), factor) == Camera()


# -- framing -----------------------------------------------------------------------------------


@given(cameras(), point, st.tuples(*[st.floats(0, 300)] * 3), st.floats(0, 0.4))
def test_fit_contains_the_box_and_touches_the_margin(camera, corner, size, margin):
    if max(size) < 1e-3:
        size = (1.0, *size[1:])
    box = np.stack((corner, np.add(corner, size)))
    fitted = fit(camera, box, margin)
    np.testing.assert_allclose(fitted.axes, camera.axes, atol=1e-6)
    np.testing.assert_allclose(fitted.target, box.mean(0), atol=1e-9)
    corners = list(product(*box.T))
    pixels, depth = fitted.project(corners)
    assert (depth > 0).all()
    # 1 on the margin, 0 in the middle
    reach = np.abs(pixels / fitted.viewport - 0.5).max() / (0.5 - margin)
    assert reach <= 1 + 1e-6
    across = (np.array(corners) - box[0]) @ camera.axes[:2].T
    close = camera.kind == "perspective" and depth.min() < 1.01 * CLEARANCE * np.ptp(depth) / 2.0
    if np.abs(across).max() > 0.02 * max(size) and not close:  # not seen end on
        assert reach >= 1 - 1e-6


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
def test_fit_at_any_scale(kind, scale):
    fitted = fit(Camera(kind), scale * np.array([(-1, -1, -1), (1, 1, 1.0)]))
    assert scale < fitted.visible_height < 10 * scale


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_fit_to_nothing_and_to_a_point(kind):
    nothing = fit(Camera(kind, target=(5, 5, 5)), np.full((2, 3), np.nan))
    assert nothing.target == (0, 0, 0)
    assert 100 < nothing.visible_height < 1000
    spot = fit(Camera(kind), [(7, 8, 9), (7, 8, 9)])
    assert spot.target == (7, 8, 9)
    assert spot.visible_height == pytest.approx(Camera(kind).visible_height)


clouds = st.lists(point, min_size=2, max_size=12)


@given(cameras(), clouds, st.floats(0, 0.4))
def test_points_are_framed_as_tightly_as_can_be(camera, points, margin):
    points = np.array(points)
    assume(np.ptp(points, axis=0).max() > 1e-3)
    fitted = fit_points(camera, points, margin)
    np.testing.assert_allclose(fitted.axes, camera.axes, atol=1e-6)
    pixels, depth = fitted.project(points)
    assert (depth > 0).all()
    # −1 and 1 on the margins, 0 in the middle
    reach = (pixels / fitted.viewport - 0.5) / (0.5 - margin)
    assert np.abs(reach).max() <= 1 + 1e-6
    touched = (reach.min(0) < -1 + 1e-4) & (reach.max(0) > 1 - 1e-4)
    flat = camera.kind == "orthographic"
    kept = (fitted.height, camera.height) if flat else (depth.min(), camera.distance)
    end_on = kept[0] == pytest.approx(kept[1])
    close = not flat and depth.min() < 1.01 * CLEARANCE * np.ptp(depth) / 2.0
    assert touched.any() or end_on or close, "unless the scale was kept, or the eye is at a point"


@given(cameras(), point, st.tuples(*[st.floats(1, 300)] * 3))
def test_points_are_never_smaller_than_in_the_fitted_box(camera, corner, size):
    corners = np.array(list(product(*zip(corner, np.add(corner, size), strict=True))))
    tight = fit_points(camera, corners)
    loose = fit(camera, (corner, np.add(corner, size)))
    if camera.kind == "orthographic":
        assert tight.height <= loose.height * (1 + 1e-9)
    else:
        back = camera.axes[2]
        assert np.dot(tight.eye, back) >= np.dot(loose.eye, back) - 1e-6 * tight.distance


@pytest.mark.parametrize("fov_y", [20.0, 90.0, 116.0, 150.0])
def test_a_cube_along_its_diagonal_is_framed_as_it_lies(fov_y):
    """However wide the view, and however far the eye was before: it is not seen end on."""
    corners = np.array(list(product((0.0, 100.0), repeat=3)))
    found = []
    for before in (1.0, 300.0, 1e5):
        eye = tuple(before * np.ones(3))
        camera = Camera("perspective", eye=eye, target=(0, 0, 0), fov_y=fov_y)
        found.append(fit_points(camera, corners).distance)
        assert fit(camera, (corners[0], corners[-1])).distance >= found[-1] * (1 - 1e-9)
    np.testing.assert_allclose(found, found[0], rtol=1e-6)
    assert found[0] < 100.0 * np.sqrt(3.0) / np.tan(np.radians(fov_y) / 2.0) + 90.0


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("thin", [1e-5, 2e-4, 3e-3, 0.1])
def test_box_and_points_agree_on_what_is_seen_end_on(kind, thin):
    camera = Camera(kind, eye=(0, -500, 0), target=(0, 0, 0))
    bounds = ((0, 0, 0), (100 * thin, 100, 100 * thin))
    corners = np.array(list(product(*zip(*bounds, strict=True))))
    loose, tight = fit(camera, bounds), fit_points(camera, corners)
    assert tight.visible_height == pytest.approx(loose.visible_height, rel=1e-6)
    kept = thin < END_ON
    assert (tight.visible_height >= camera.visible_height) == kept


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_a_sphere_fills_the_picture_where_its_box_does_not(kind):
    rng = np.random.default_rng(5)
    ball = rng.normal(size=(4000, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    camera = standard_view(Camera(kind, viewport=(400, 400)), "three-quarter")
    tight = fit_points(camera, ball, 0.0)
    loose = fit(camera, ((-1,) * 3, (1,) * 3), 0.0)
    assert tight.pixels_per_mm > 1.3 * loose.pixels_per_mm
    pixels, _ = tight.project(ball)
    np.testing.assert_allclose(pixels.mean(0), (200, 200), atol=8)


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_framing_no_points_and_a_single_one(kind):
    camera = Camera(kind, target=(5, 5, 5))
    for nothing in (np.zeros((0, 3)), np.full((4, 3), np.nan)):
        assert fit_points(camera, nothing) == fit(camera, np.full((2, 3), np.nan))
    spot = fit_points(camera, [(7, 8, 9), (np.inf, 0, 0)])
    np.testing.assert_allclose(spot.target, (7, 8, 9), atol=1e-9)
    assert spot.visible_height == pytest.approx(camera.visible_height)


@given(cameras())
def test_changing_the_kind_keeps_the_scale_at_the_target(camera):
    for kind in ("perspective", "orthographic"):
        other = with_kind(camera, kind)
        assert other.kind == kind
        assert other.pixels_per_mm == pytest.approx(camera.pixels_per_mm, rel=1e-6)
        np.testing.assert_allclose(other.axes, camera.axes, atol=1e-6)
        back = with_kind(other, camera.kind)
        assert back.pixels_per_mm == pytest.approx(camera.pixels_per_mm, rel=1e-6)


# -- named views -------------------------------------------------------------------------------

SIDES = {  # what lies to the right and what lies above, by hand
    "front": ((1, 0, 0), (0, 0, 1)),
    "back": ((-1, 0, 0), (0, 0, 1)),
    "right": ((0, 1, 0), (0, 0, 1)),
    "left": ((0, -1, 0), (0, 0, 1)),
    "top": ((1, 0, 0), (0, 1, 0)),
    "bottom": ((1, 0, 0), (0, -1, 0)),
}


@given(cameras())
def test_standard_views_lie_as_on_a_drawing(camera):
    for name, (right, up) in SIDES.items():
        view = standard_view(camera, name)
        np.testing.assert_allclose(view.axes[:2], (right, up), atol=1e-6)
        assert view.target == camera.target
        assert view.distance == pytest.approx(camera.distance)
        assert view.kind == camera.kind


def test_three_quarter_shows_front_right_and_top():
    forward = standard_view(Camera(), "three-quarter").axes[2]
    assert (forward * (-1, 1, -1) > 0.2).all()


def test_an_unknown_view_is_refused_by_name():
    with pytest.raises(UserError, match="three-quarter"):
        standard_view(Camera(), "sideways")


def test_all_directions_of_the_cube_are_upright():
    assert len(set(CUBE_DIRECTIONS)) == 26
    for direction in CUBE_DIRECTIONS:
        view = look_along(Camera(target=(1, 2, 3)), np.negative(direction))
        np.testing.assert_allclose(
            view.axes[2], np.negative(direction) / np.linalg.norm(direction), atol=1e-12
        )
        if direction[:2] != (0, 0):
            assert abs(view.axes[0][2]) < 1e-12
            assert view.axes[1][2] > 0


@given(st.floats(-180, 180))
def test_looking_down_turns_the_sheet_less_than_an_eighth(azimuth):
    before = turn(Camera(), azimuth, 80)
    view = look_along(before, (0, 0, -1))
    assert before.axes[0] @ view.axes[0] >= np.cos(np.pi / 4) - 1e-9
    assert sorted(np.abs(view.axes[1])) == [0, 0, 1]


@pytest.mark.parametrize("bad", [(0, 0, 0), (np.nan, 0, 1), (1, 0)])
def test_a_direction_that_is_none_is_refused(bad):
    with pytest.raises(UserError):
        look_along(Camera(), bad)


# -- on the way --------------------------------------------------------------------------------


@given(cameras(), cameras(), st.floats(0, 1))
def test_interpolation_is_exact_at_its_ends_and_sound_between(begin, end, t):
    assert interpolate(begin, end, 0) is begin
    assert interpolate(begin, end, 1) is end
    between = interpolate(begin, end, t)  # a Camera refuses what is not finite
    heights = sorted((begin.visible_height, end.visible_height))
    assert heights[0] * (1 - 1e-6) <= between.visible_height <= heights[1] * (1 + 1e-6)
    nearly = interpolate(begin, end, 1e-6)
    np.testing.assert_allclose(nearly.axes, begin.axes, atol=1e-4)
    arrived = interpolate(begin, end, 1 - 1e-6)
    np.testing.assert_allclose(arrived.axes, end.axes, atol=1e-4)
    assert arrived.visible_height == pytest.approx(end.visible_height, rel=1e-3)


def test_from_front_to_right_the_view_turns_evenly_about_the_vertical():
    front, right = standard_view(Camera(), "front"), standard_view(Camera(), "right")
    half = interpolate(front, right, 0.5)
    np.testing.assert_allclose(half.axes[2], (-np.sqrt(0.5), np.sqrt(0.5), 0), atol=1e-12)
    assert half.distance == pytest.approx(front.distance)


@given(st.sampled_from(sorted(STANDARD_VIEWS)), st.sampled_from(sorted(STANDARD_VIEWS)))
def test_between_any_two_named_views_there_is_no_jump(a, b):
    begin, end = (standard_view(Camera(), name) for name in (a, b))
    frames = [interpolate(begin, end, t).axes for t in np.linspace(0, 1, 101)]
    assert np.abs(np.diff(frames, axis=0)).max() < 0.06


def test_a_change_of_kind_is_gradual():
    begin = Camera(viewport=(800, 600))
    end = with_kind(begin, "orthographic")
    corner = [(60.0, 40.0, 50.0)]
    way = [interpolate(begin, end, t) for t in np.linspace(0, 1, 60)]
    track = np.array([camera.project(corner)[0][0] for camera in way])
    assert np.abs(np.diff(track, axis=0)).max() < 2.0


# -- for the graphics card ---------------------------------------------------------------------


@given(cameras(), st.lists(share, min_size=1, max_size=5), st.floats(0.1, 5))
@settings(max_examples=60)
def test_the_matrices_say_what_the_camera_says(camera, places, far):
    rays = camera.rays(np.array(places) * camera.viewport)
    world = rays.origins + far * camera.distance * rays.directions
    pixels, depth = camera.project(world)
    near, limit = 0.5 * depth.min(), 2.0 * depth.max()
    view, projection = gl_matrices(camera, near, limit)
    clip = np.column_stack((world, np.ones(len(world)))) @ view.T @ projection.T
    seen = clip[:, :3] / clip[:, 3:]
    width, height = camera.viewport
    found = np.column_stack(((seen[:, 0] + 1) * width / 2, (1 - seen[:, 1]) * height / 2))
    np.testing.assert_allclose(found, pixels, atol=close(camera))
    assert (np.abs(seen[:, 2]) <= 1 + 1e-9).all()
    for plane, value in ((near, -1), (limit, 1)):
        at = np.append(np.asarray(camera.eye) + plane * camera.axes[2], 1.0)
        there = projection @ view @ at
        assert there[2] / there[3] == pytest.approx(value, abs=1e-5)


@given(cameras(), point, st.tuples(*[st.floats(0, 300)] * 3))
def test_all_in_the_box_lies_between_near_and_far(camera, corner, size):
    box = np.stack((corner, np.add(corner, size)))
    near, far = near_far(camera, box)
    assert near < far
    _, depth = camera.project(list(product(*box.T)))
    if camera.kind == "perspective":
        assert near > 0
        depth = depth[depth > 1e-3 * far]
    assert (depth >= near).all()
    if (depth > 0).any():
        assert (depth <= far).all()


@given(cameras())
def test_near_and_far_without_a_box(camera):
    near, far = near_far(camera, np.full((2, 3), np.nan))
    assert near < camera.distance < far


def test_a_wider_opening_never_takes_the_eye_away_from_a_box_seen_along_its_diagonal():
    corners = np.array(list(product((0.0, 100.0), repeat=3)))
    before = Camera(eye=(-300, -300, 300), target=(0, 0, 0))
    for framed in (lambda c: fit_points(c, corners), lambda c: fit(c, corners[[0, -1]])):
        distances = [framed(replace(before, fov_y=fov)).distance for fov in range(20, 131, 2)]
        assert (np.diff(distances) <= 1e-9).all()
