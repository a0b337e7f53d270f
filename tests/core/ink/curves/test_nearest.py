"""Which curve an oversketch is meant for, against shapely's distances."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.ink.curves.nearest import distances_to_polyline, nearest_curve
from bozzetto.ink.curves.resample import resample


@given(st.integers(0, 10**6), st.integers(1, 40), st.sampled_from([1e-3, 1.0, 1e6]))
@settings(max_examples=40, deadline=None)
def test_distances_are_those_of_shapely(seed, count, scale):
    random = np.random.default_rng(seed)
    path, points = random.normal(size=(count, 2)) * scale, random.normal(size=(25, 2)) * scale
    shape = shapely.LineString(path) if count > 1 else shapely.Point(path[0])
    expected = shapely.distance(shape, shapely.points(points))
    np.testing.assert_allclose(distances_to_polyline(points, path), expected, atol=1e-12 * scale)


@given(st.integers(0, 10**6))
@example(640577)
@settings(max_examples=40, deadline=None)
def test_it_is_the_least_mean_distance_of_all(seed):
    random = np.random.default_rng(seed)
    curves = [np.cumsum(random.normal(0, 20, (30, 2)), axis=0) for _ in range(12)]
    stroke = np.cumsum(random.normal(0, 20, (30, 2)), axis=0)
    ink = shapely.points(resample(stroke, spacing=0.5))
    means = [shapely.distance(shapely.LineString(curve), ink).mean() for curve in curves]
    found = nearest_curve(curves, stroke)
    assert found.distance == pytest.approx(min(means), rel=0.06)
    assert means[found.index] <= 1.06 * min(means)


def test_length_does_not_count_and_the_first_of_equals_wins():
    near, far = np.array([[0.0, 0], [500, 0]]), np.array([[0.0, 40], [500, 40]])
    for length in (20, 480):
        found = nearest_curve([far, near, near], [[10, 8], [10 + length, 8]])
        assert found.index == 1
        assert found.distance == pytest.approx(8.0)


def test_odd_curves_and_strokes():
    curve = np.array([[0.0, 0], [500, 0]])
    assert nearest_curve([], curve) is None
    assert nearest_curve([np.full((3, 2), np.nan), np.zeros((0, 2))], curve) is None
    assert nearest_curve([np.full((3, 2), 1e200), curve], [[3, 4]]).index == 1
    assert nearest_curve([np.zeros((1, 2))], [[3, 4]]).distance == pytest.approx(5.0)
    for bad in ([[np.nan, 0]], [[0, np.inf]], np.zeros((0, 2))):
        with pytest.raises(UserError):
            nearest_curve([curve], bad)
