"""Polylines for drawing against dense evaluation of the curve itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from bozzetto.errors import UserError
from bozzetto.geometry.flatten import FLATNESS, flattened
from bozzetto.ink.nearest import distances_to_polyline
from bozzetto.view.camera import Camera
from tests.core.view.cameras import cameras


def evaluated(pieces, parameters):
    curve = BPoly(np.moveaxis(np.asarray(pieces, float), 1, 0), np.arange(len(pieces) + 1.0))
    return curve(parameters)


def chained(random, count, size):
    ends = random.uniform(-size, size, (count + 1, 3))
    inner = random.uniform(-size, size, (count, 2, 3))
    return np.concatenate((ends[:-1, None], inner, ends[1:, None]), axis=1)


@given(cameras(), st.integers(0, 10**6), st.integers(1, 5), st.sampled_from([0.1, FLATNESS, 3.0]))
@settings(max_examples=60, deadline=None)
def test_no_place_of_the_curve_is_off_by_more_than_the_tolerance(camera, seed, count, tolerance):
    # Thousands of sheets wide a curve is halved as often as may be, and still not flat.
    reach = min(0.3 * camera.distance, 100.0 * camera.visible_height)
    pieces = chained(np.random.default_rng(seed), count, reach) + camera.target
    points, parameters = flattened(pieces, camera, tolerance=tolerance)
    assert (np.diff(parameters) > 0).all()
    size = np.abs(pieces).max()
    np.testing.assert_allclose(points, evaluated(pieces, parameters), atol=1e-12 * size)
    seen, _ = camera.project(points)
    dense, _ = camera.project(evaluated(pieces, np.linspace(0, count, 800)))
    assert distances_to_polyline(dense, seen).max() <= tolerance * (1 + 1e-6) + 1e-9 * size
    assert set(range(count + 1)) <= set(parameters.tolist())


def test_few_points_where_few_are_needed():
    camera = Camera("orthographic", height=100.0, viewport=(1000.0, 1000.0))
    straight = [[[0, 0, 0], [1, 0, 1], [7, 0, 7], [9, 0, 9]]]
    assert len(flattened(straight, camera)[0]) == 2
    end_on = [[[0, 0, 0], [0, 9, 0], [0, -9, 0], [0, 3, 0]]]
    assert len(flattened(end_on, camera)[0]) == 2
    k = 0.5522847498
    quarter = 30 * np.array([[[1, 0, 0], [1, 0, k], [k, 0, 1], [0, 0, 1.0]]])
    # A chord of angle a on a circle of r px is r (1 - cos a / 2) off: 300 px need 20 chords.
    fewest = (np.pi / 2) / (2 * np.arccos(1 - FLATNESS / 300))
    assert fewest <= len(flattened(quarter, camera)[0]) - 1 <= 2.5 * fewest


def test_finer_where_it_is_nearer_to_the_eye():
    camera = Camera(eye=(0, -100, 0), target=(0, 0, 0))
    t = np.linspace(0, 1, 4)
    wave = np.column_stack((20 * np.sin(9 * t), -80 + 900 * t, 10 * np.cos(5 * t)))
    _, parameters = flattened(wave[None], camera)
    steps = np.diff(parameters)
    assert steps[:3].max() < steps[-3:].min()


def test_curves_beside_and_behind_the_eye_end():
    camera = Camera(eye=(0, -100, 0), target=(0, 0, 0))
    behind = [[[0, -200, 0], [50, -300, 0], [0, -400, 90], [9, -500, 0]]]
    assert len(flattened(behind, camera)[0]) == 2
    through = [[[0, -200, 0], [3, -120, 1], [-2, -80, 0], [0, 100, 5]]]
    points, _ = flattened(through, camera)
    assert np.isfinite(points).all()
    assert len(points) < 5000


def test_odd_pieces():
    camera = Camera()
    assert len(flattened(np.zeros((2, 4, 3)), camera)[0]) == 3
    for bad in (np.full((1, 4, 3), np.nan), np.full((1, 4, 3), np.inf), np.zeros((0, 4, 3))):
        with pytest.raises(UserError):
            flattened(bad, camera)
    for bad in (0.0, -1.0, np.nan):
        with pytest.raises(UserError):
            flattened(np.zeros((1, 4, 3)), camera, tolerance=bad)
