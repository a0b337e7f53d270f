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
