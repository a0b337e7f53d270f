"""What an end is caught by: near on the sheet, and as near in depth as the hand can tell."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.plugin import Context
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.snap_candidates import DEPTH_SIGMAS, TOLERANCE, snap_of, snaps_of
from bozzetto_symmetry.operations.snap_targets import targets
from tests.plugins.symmetry.edited_curves import ACROSS, LOOP, PAIR
from tests.plugins.symmetry.scenes import camera

STATE = SymmetryState()
CORNER = np.array([100.0, 50.0, 50.0])
VIEWS = [camera(35, 20), camera(35, 20, "orthographic"), camera(-120, 50)]


def moved(view, point, pixels, depth):
    """A point that is so many pixels and mm of depth away."""
    place = view.project(point)[0] + (pixels, 0.0)
    rays = view.rays(place)
    along = (point - rays.origins[0]) @ rays.directions[0]
    return rays.origins[0] + (along + depth) * rays.directions[0]


@pytest.mark.parametrize("view", VIEWS)
def test_a_corner_catches_within_the_tolerance(view):
    known = targets(STATE, [], Context())
    for pixels, depth, sigma, hit in [
        (0.9 * TOLERANCE, 0.0, 0.0, True),
        (1.1 * TOLERANCE, 0.0, 0.0, False),
        (0.0, 0.9 * DEPTH_SIGMAS * 5.0, 5.0, True),
        (0.0, 2.0 * DEPTH_SIGMAS * 5.0 + 20.0, 5.0, False),
    ]:
        snap = snap_of(1, moved(view, CORNER, pixels, depth), sigma, view, known, STATE)
        assert (snap is not None and snap.point == tuple(CORNER)) == hit


def test_a_point_wins_over_an_edge_and_that_over_the_plane_and_that_over_a_face():
    view = VIEWS[0]
    known = targets(STATE, [], Context())
    pixel = 1.0 / view.pixels_per_mm

    def caught(point):
        snap = snap_of(0, point, 0.0, view, known, STATE)
        return None if snap is None else np.array(snap.point)

    near = 4.0 * pixel
    np.testing.assert_array_equal(caught(CORNER - (0, 0, near)), CORNER)
    edge = caught((100.0, 50.0 - near / 2, 10.0))
    np.testing.assert_allclose(edge[:2], (100.0, 50.0), atol=1e-9)
    assert abs(edge[2] - 10.0) < near
    plane = caught((99.0, near / 2, 10.0))
    assert abs(plane[1]) < 1e-12
    face = caught((99.5, 20.0, 10.0))
    assert abs(face[0] - 100.0) < 1e-12
    assert caught((60.0, 20.0, 10.0)) is None


def test_other_curves_catch_by_their_ends_first():
    view = VIEWS[0]
    known = targets(STATE, [PAIR], Context())
    end = PAIR.spline.value([1.0])[0]
    snap = snap_of(1, end + np.array([0.3, 0.2, -0.4]), 0.2, view, known, STATE)
    np.testing.assert_allclose(snap.point, end, atol=1e-9)
    inside = PAIR.spline.value([0.4])[0]
    snap = snap_of(1, inside + np.array([0.3, 0.2, -0.4]), 0.2, view, known, STATE)
    assert np.linalg.norm(np.array(snap.point) - inside) < 1.5
    foot = PAIR.spline.value(PAIR.spline.foot_points(np.array([snap.point])))[0]
    assert np.linalg.norm(foot - snap.point) < 0.05


def test_curves_are_caught_at_their_free_ends():
    view = VIEWS[0]
    known = targets(STATE, [PAIR], Context())
    snaps = snaps_of(PAIR, np.full(200, 0.2), view, known, STATE)
    assert [snap.end for snap in snaps] == [0, 1]
    assert snaps_of(LOOP, np.full(200, 0.2), view, known, STATE) == ()
    own = targets(STATE, [ACROSS], Context())
    (snap,) = snaps_of(ACROSS, np.full(200, 0.2), view, own, STATE)
    assert snap.end == 1


def test_an_end_behind_the_eye_is_not_caught():
    view = VIEWS[0]
    behind = 2.0 * np.array(view.eye)
    assert snap_of(0, behind, 1.0, view, targets(STATE, [], Context()), STATE) is None
