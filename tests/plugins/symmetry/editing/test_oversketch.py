"""Curves that are drawn over follow the strokes, and keep all the rest."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, fit_spline
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.view import Camera
from bozzetto_symmetry.editing.oversketch import oversketch
from bozzetto_symmetry.fitting.half_curve import halves_of
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from tests.plugins.symmetry.edited_curves import ACROSS, ALL, FLAT, PAIR, RAIL, check
from tests.plugins.symmetry.scenes import camera, real_curves, tremor

VIEWS = [
    (azimuth, elevation, kind)
    for azimuth, elevation in [(30, 20), (80, 10), (120, 40), (-60, 25), (200, -30), (45, 80)]
    for kind in ("perspective", "orthographic")
]


def stereo_of(azimuth, elevation, kind="perspective", pixels=700.0) -> Stereo:
    return Stereo(camera(azimuth, elevation, kind, pixels=pixels))


def stroke(places, view: Stereo, pressure=0.5) -> Stroke:
    press = np.full(len(places), pressure)
    return Stroke(places[:, 0], places[:, 1], view.camera, pressure=press)


def seen(spline, view: Stereo, begin=0.0, end=1.0, count=400):
    low, high = spline.range
    at = np.linspace(low + begin * (high - low), low + end * (high - low), count)
    return view.project(spline.value(at))


def hump(places, height):
    """Places moved aside on the sheet, not at their ends."""
    shift = height * np.sin(np.linspace(0, np.pi, len(places))) ** 2
    return places + shift[:, None] * (0.0, 1.0)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("view", VIEWS)
def test_a_curve_that_is_retraced_is_the_same_object(name, view):
    curve, stereo = ALL[name], stereo_of(*view)
    assert oversketch(curve, stereo, [stroke(seen(curve.spline, stereo), stereo)]) is curve
    part = seen(curve.spline, stereo, 0.55, 0.9)[::-1]
    assert oversketch(curve, stereo, [stroke(part, stereo)]) is curve


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("view", VIEWS[::3])
def test_the_picture_follows_the_stroke_and_the_rest_stays(name, view):
    curve, stereo = ALL[name], stereo_of(*view, pixels=1400.0)
    goal = hump(seen(curve.spline, stereo, 0.6, 0.85), 14.0)
    made = oversketch(curve, stereo, [stroke(goal, stereo)])
    check(made)
    assert made.reading == curve.reading
    path = seen(made.spline, stereo, count=3000)
    off = distances_to_polyline(goal[20:-20], path)
    # The contour resists being bent; what is fitted to it adds a third of a pixel.
    assert np.median(off) < 1.0
    assert off.max() < 3.5
    at = np.linspace(*curve.spline.range, 500)
    still = np.linalg.norm(made.spline.value(at) - curve.spline.value(at), axis=1) < 1e-9
    share = (at - at[0]) / (at[-1] - at[0])
    assert still[(share > 0.05) & (share < 0.15)].all() or name in ("loop", "ring", "across")
    assert still.mean() > (0.1 if curve.reading == "self" else 0.2)


@pytest.mark.parametrize("view", VIEWS[::2])
def test_drawing_over_the_mirror_image_is_drawing_over_the_curve_mirrored(view):
    stereo = stereo_of(*view)
    image = PAIR.spline.mirrored((0, 1, 0))
    goal = hump(seen(image, stereo, 0.3, 0.6), 12.0)
    made = oversketch(PAIR, stereo, [stroke(goal, stereo)], mirrored=True)
    twin = oversketch(
        SpaceCurve("pair", image), stereo, [stroke(goal, stereo)]
    ).spline.control_points
    np.testing.assert_allclose(made.spline.control_points, twin * MIRROR, atol=1e-9)


@pytest.mark.parametrize("side", [(0.55, 0.9), (0.1, 0.45)])
def test_a_curve_across_the_plane_follows_on_either_half(side):
    stereo = stereo_of(60, 30)
    goal = hump(seen(ACROSS.spline, stereo, *side), 12.0)
    made = oversketch(ACROSS, stereo, [stroke(goal, stereo)])
    check(made)
    off = distances_to_polyline(goal[20:-20], seen(made.spline, stereo, count=3000))
    assert off.max() < 3.5


def test_a_stroke_over_the_crossing_keeps_the_right_angle():
    stereo = stereo_of(5, 60)
    goal = hump(seen(ACROSS.spline, stereo, 0.3, 0.7), 10.0)
    made = oversketch(ACROSS, stereo, [stroke(goal, stereo)])
    check(made)
    middle = halves_of(made.spline).middle
    before = stereo.project(ACROSS.spline.value([middle]))[0]
    after = stereo.project(made.spline.value([middle]))[0]
    assert 8.0 < np.linalg.norm(after - before) < 12.0


def test_places_that_move_take_the_shortest_way_in_space():
    stereo = stereo_of(40, 25)
    goal = hump(seen(PAIR.spline, stereo, 0.3, 0.6), 12.0)
    made = oversketch(PAIR, stereo, [stroke(goal, stereo)])
    at = np.linspace(0.35, 0.55, 50)
    old, new = PAIR.spline.value(at), made.spline.value(at)
    rays = stereo.rays(stereo.project(new)).directions
    along = np.einsum("nk,nk->n", new - old, rays)
    assert np.abs(along).max() < 0.1 * np.linalg.norm(new - old, axis=1).max()


def test_firmer_strokes_pull_more():
    stereo = stereo_of(50, 20)
    path = seen(RAIL.spline, stereo, 0.2, 0.8)
    above, below = (path + shift * np.array([0, 10]) for shift in (-1, 1))
    middle = seen(RAIL.spline, stereo, 0.4999, 0.5001, 3)[1]

    def height(one, other):
        strokes = [stroke(above, stereo, one), stroke(below, stereo, other)]
        made = oversketch(RAIL, stereo, strokes)
        near = seen(made.spline, stereo, 0.3, 0.7, 2001)
        return float(np.interp(middle[0], *near[np.argsort(near[:, 0])].T) - middle[1])

    heights = [height(p, 1.0 - p) for p in (0.1, 0.3, 0.5, 0.7, 0.9)]
    assert (np.diff(heights) < -1.0).all()
    assert abs(heights[2]) < 0.5


def test_an_end_follows_a_stroke_that_runs_on():
    stereo = stereo_of(50, 20)
    path = seen(RAIL.spline, stereo, 0.6, 1.0, 300)
    way = path[-1] - path[-20]
    longer = np.vstack((path, path[-1] + np.linspace(0.1, 2.0, 40)[:, None] * way))
    made = oversketch(RAIL, stereo, [stroke(longer, stereo)])
    end = stereo.project(made.spline.value(made.spline.range[1:]))[0]
    assert np.linalg.norm(end - longer[-1]) < 4.0


def test_the_plane_seen_edge_on_is_refused_for_a_curve_in_it():
    stereo = stereo_of(0.0, 20)
    goal = seen(FLAT.spline, stereo, 0.3, 0.7) + np.array([6.0, 0.0])
    with pytest.raises(UserError, match="edge-on"):
        oversketch(FLAT, stereo, [stroke(goal, stereo)])


def test_a_curve_behind_the_eye_is_refused():
    stereo = Stereo(Camera(eye=(0, -900, 0), target=(0, -1800, 0)))
    with pytest.raises(UserError, match="not seen"):
        oversketch(RAIL, stereo, [stroke(np.array([[10.0, 10.0], [80.0, 90.0]]), stereo)])


@pytest.mark.parametrize("name", ALL)
def test_odd_ink_does_no_harm(name):
    random = np.random.default_rng(3)
    stereo = stereo_of(35, 20)
    for ink in (
        np.array([[600.0, 450.0]]),
        np.tile([[600.0, 450.0]], (30, 1)),
        random.uniform(0, 900, (200, 2)),
        np.array([[-1e6, 0.0], [1e6, 3.0]]),
        seen(ALL[name].spline, stereo) + tremor(400, 3.0, random),
    ):
        try:
            made = oversketch(ALL[name], stereo, [stroke(ink, stereo)])
        except UserError:
            assert name == "plane"  # whose horizon is on the sheet
        else:
            check(made)


@pytest.mark.slow
def test_real_curves_are_retraced_without_change_and_follow_what_is_drawn():
    random = np.random.default_rng(0)
    curves = real_curves(200)
    if not curves:
        pytest.skip("no recorded ink here")
    off = []
    for points in curves:
        spline = fit_spline(points, controls="adaptive", pixel=0.3).spline
        curve = SpaceCurve("pair", spline)
        view = camera(random.uniform(20, 70), random.uniform(5, 35), pixels=800.0)
        stereo = Stereo(view)
        assert oversketch(curve, stereo, [stroke(seen(spline, stereo), stereo)]) is curve
        begin = random.uniform(0.05, 0.6)
        goal = hump(seen(spline, stereo, begin, begin + 0.3), random.uniform(8, 20))
        made = oversketch(curve, stereo, [stroke(goal, stereo)])
        off.append(np.median(distances_to_polyline(goal, seen(made.spline, stereo, count=3000))))
    assert np.median(off) < 0.3
    assert np.quantile(off, 0.9) < 1.0
