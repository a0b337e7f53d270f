"""Ends go where they are taken, and take along no more than they must."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_symmetry.editing.snap import snap_end
from bozzetto_symmetry.fitting.space_curve import SpaceCurve, across
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry.edited_curves import ACROSS, FLAT, LOOP, PAIR, check

WAY = np.array([1.0, -0.8, 0.6])


def direction(spline, end):
    velocity = spline.derivative([spline.range[end]])[0]
    return velocity / np.linalg.norm(velocity)


@pytest.mark.parametrize("curve", [PAIR, FLAT])
@pytest.mark.parametrize("end", [0, 1])
@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
def test_an_end_is_exactly_where_it_is_taken(curve, end, size):
    way = WAY * size * (1.0 if curve is PAIR else (1, 0, 1))
    goal = curve.spline.value([curve.spline.range[end]])[0] + way
    made = snap_end(curve, end, goal)
    check(made)
    assert (made.spline.value([made.spline.range[end]])[0] == goal).all()
    np.testing.assert_allclose(direction(made.spline, end), direction(curve.spline, end), atol=1e-9)
    assert made.spline.range == curve.spline.range
    at = np.linspace(*curve.spline.range, 500)
    moved = np.linalg.norm(made.spline.value(at) - curve.spline.value(at), axis=1)
    assert moved.max() <= np.linalg.norm(way) * (1 + 1e-9)
    far = at > 0.8 if end == 0 else at < 0.2
    assert moved[far].max() < 1e-10


def test_both_free_ends_of_a_curve_across_the_plane_go():
    goal = ACROSS.spline.value([1.0])[0] + WAY
    made = snap_end(ACROSS, 1, goal)
    check(made)
    assert (made.spline.value([1.0])[0] == goal).all()
    assert (made.spline.value([-1.0])[0] == goal * MIRROR).all()
    middle = np.linspace(-0.5, 0.5, 100)
    np.testing.assert_allclose(made.spline.value(middle), ACROSS.spline.value(middle), atol=1e-10)


def flat_across(bow):
    """A curve across the plane in a plane that holds y: straight without a bow."""
    share = np.linspace(0.0, 1.0, 9)
    out = np.outer(bow * share**2, (0.6, 0.0, 0.8))
    half = out + np.outer(share, (0.0, 30.0, 0.0)) + (10.0, 0.0, 5.0)
    half[1, ::2] = half[0, ::2]
    return SpaceCurve("self", across(half))


@pytest.mark.parametrize("bow", [0.0, 4.0, 40.0])
@pytest.mark.parametrize("way", [WAY, 5.0 * WAY])
def test_what_is_straight_or_flat_across_the_plane_stays_so(bow, way):
    """A bar that goes to the ends of two posts got a bend before each of them."""
    curve = flat_across(bow)
    goal = curve.spline.value([curve.spline.range[1]])[0] + way
    made = snap_end(curve, 1, goal)
    check(made)
    assert (made.spline.value([made.spline.range[1]])[0] == goal).all()
    points = made.spline.sampled(200)
    beside = points[:, ::2] - points[:, ::2].mean(axis=0)
    long, wide = np.linalg.svd(beside, compute_uv=False)
    assert wide < 1e-9
    assert (long < 1e-9) == (bow == 0.0)
    if bow == 40.0:  # what is seen of it hardly changes: it does not wind about the old one
        turns = np.diff(np.arctan2(*np.diff(points[100:], axis=0)[:, 1:].T))
        assert (turns <= 1e-9).all() or (turns >= -1e-9).all()


def test_an_end_that_stays_changes_nothing():
    made = snap_end(PAIR, 1, PAIR.spline.value([1.0])[0])
    at = np.linspace(0.0, 1.0, 300)
    np.testing.assert_allclose(made.spline.value(at), PAIR.spline.value(at), atol=1e-10)


def test_an_end_that_is_taken_to_the_plane_but_for_rounding_is_on_it():
    made = snap_end(PAIR, 0, (-80.0, 1e-15, 20.0))
    assert made.spline.control_points[0, 1] == 0.0


def test_what_has_no_end_or_no_place_is_refused():
    with pytest.raises(UserError, match="closed curve has no end"):
        snap_end(LOOP, 0, (0, 0, 0))
    with pytest.raises(UserError, match="another place"):
        snap_end(PAIR, 0, (np.nan, 0, 0))
