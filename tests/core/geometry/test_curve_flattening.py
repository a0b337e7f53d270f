"""Polylines for drawing against dense evaluation of the curve itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from bozzetto.errors import UserError
from bozzetto.geometry.curve_flattening import flattened
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.view.camera import Camera


def evaluated(pieces, parameters):
    curve = BPoly(np.moveaxis(np.asarray(pieces, float), 1, 0), np.arange(len(pieces) + 1.0))
    return curve(parameters)


def chained(random, count, size):
    ends = random.uniform(-size, size, (count + 1, 3))
    inner = random.uniform(-size, size, (count, 2, 3))
    return np.concatenate((ends[:-1, None], inner, ends[1:, None]), axis=1)


@given(
    st.floats(1e-3, 1e6), st.integers(0, 10**6), st.integers(1, 5), st.sampled_from([1e-4, 0.01, 3])
)
@settings(max_examples=60, deadline=None)
def test_no_place_of_the_curve_is_off_by_more_than_the_tolerance(size, seed, count, share):
    pieces = chained(np.random.default_rng(seed), count, size)
    points, parameters = flattened(pieces, share * size)
    assert (np.diff(parameters) > 0).all()
    np.testing.assert_allclose(points, evaluated(pieces, parameters), atol=1e-12 * size)
    dense = evaluated(pieces, np.linspace(0, count, 800))
    assert distances_to_polyline(dense, points).max() <= share * size * (1 + 1e-6)
    assert set(range(count + 1)) <= set(parameters.tolist())


def test_few_points_where_few_are_needed():
    straight = [[[0, 0, 0], [1, 0, 1], [7, 0, 7], [9, 0, 9]]]
    assert len(flattened(straight, 0.1)[0]) == 2
    k = 0.5522847498
    quarter = 300 * np.array([[[1, 0, 0], [1, 0, k], [k, 0, 1], [0, 0, 1.0]]])
    # A chord of angle a on a circle of r is r (1 - cos a / 2) off.
    fewest = (np.pi / 2) / (2 * np.arccos(1 - 0.25 / 300))
    assert fewest <= len(flattened(quarter, 0.25)[0]) - 1 <= 2.5 * fewest


def test_points_lie_close_where_the_curve_bends():
    bent = [[[0, 0, 0], [100, 0, 0], [100, 0, 0], [100, 0, 100]]]
    points, parameters = flattened(bent, 0.01)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    middle = np.abs(parameters[:-1] - 0.5) < 0.15
    assert steps[middle].max() < steps[~middle].max()


def test_parallel_views_are_within_the_pixels_that_were_asked_for():
    pieces = chained(np.random.default_rng(3), 3, 50.0)
    for eye in ((0, -400, 0), (300, -200, 150), (0, 0, 500)):
        camera = Camera("orthographic", eye=eye, height=200.0, viewport=(1000.0, 800.0))
        points, _ = flattened(pieces, 0.25 / camera.pixels_per_mm)
        dense, _ = camera.project(evaluated(pieces, np.linspace(0, 3, 800)))
        assert distances_to_polyline(dense, camera.project(points)[0]).max() <= 0.25 * (1 + 1e-6)


def test_odd_pieces():
    assert len(flattened(np.zeros((2, 4, 3)), 1.0)[0]) == 3
    for bad in (np.full((1, 4, 3), np.nan), np.full((1, 4, 3), np.inf), np.zeros((0, 4, 3))):
        with pytest.raises(UserError):
            flattened(bad, 1.0)
    for bad in (0.0, -1.0, np.nan):
        with pytest.raises(UserError):
            flattened(np.zeros((1, 4, 3)), bad)
