"""Curves that pass the places of their joints, however these contradict one another."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto_product.operations.meetings import parameter_at
from bozzetto_product.operations.settling import FARTHEST, passing


def curve(random, closed):
    count = int(random.integers(7, 20))
    turn = 2 * np.pi * np.arange(count) / count * (1.0 if closed else 0.7)
    points = np.column_stack((np.cos(turn), np.sin(turn), 0.1 * np.sin(2 * turn)))
    points = 50.0 * points + random.normal(scale=2.0, size=points.shape)
    if closed:
        knots = np.arange(-3, count + 4, dtype=float)
        return Spline(knots, np.vstack((points, points[:3])), closed=True)
    return Spline.uniform(points)


def moved(before, after):
    return np.linalg.norm(after.control_points - before.control_points, axis=1).max()


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("seed", range(9200, 9210))
def test_opposite_wishes_beside_one_another_do_not_throw_a_curve_off(seed, closed):
    random = np.random.default_rng(seed)
    spline = curve(random, closed)
    share = random.uniform(0.1, 0.9)
    apart = 10.0 ** random.uniform(-9.0, -2.0)
    way = random.normal(size=3)
    places = [
        (at, spline.value([parameter_at(spline, at)])[0] + sense * way)
        for at, sense in ((share, 1.0), (share + apart, -1.0))
    ]
    made = passing(spline, places)
    assert moved(spline, made) <= FARTHEST * np.linalg.norm(way) * (1 + 1e-9)
    if not closed:
        assert (made.control_points[[0, -1]] == spline.control_points[[0, -1]]).all()


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("seed", range(9210, 9215))
def test_wishes_that_agree_are_met(seed, closed):
    random = np.random.default_rng(seed)
    spline = curve(random, closed)
    shares = (0.2, 0.22, 0.55, 0.8)
    way = random.normal(scale=3.0, size=3)
    places = [(at, spline.value([parameter_at(spline, at)])[0] + way) for at in shares]
    made = passing(spline, places)
    for at, place in places:
        assert np.linalg.norm(made.value([parameter_at(made, at)])[0] - place) <= 1e-9 * 100.0


@pytest.mark.parametrize("share", [0.004, 0.01, 0.99, 0.996])
@pytest.mark.parametrize("seed", range(9220, 9225))
def test_a_short_tail_goes_along_without_a_corner(seed, share):
    """Held, an end half a millimetre from a place that moves as far would turn the curve by 50°."""
    random = np.random.default_rng(seed)
    spline = curve(random, closed=False)
    at = [parameter_at(spline, share)]
    before = spline.derivative(at)[0]
    way = np.cross(before, random.normal(size=3))
    way *= 0.5 / np.linalg.norm(way)
    far = 1.0 if share < 0.5 else 0.0
    made = passing(spline, [(share, spline.value(at)[0] + way)], held=(far,))
    after = made.derivative(at)[0]
    cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
    assert np.degrees(np.arccos(min(1.0, cosine))) < 10.0
    assert np.linalg.norm(made.value(at)[0] - spline.value(at)[0] - way) < 1e-9
    np.testing.assert_array_equal(made.control_points[int(-far)], spline.control_points[int(-far)])
