"""The spline of styling lines: SciPy's, and what it is exact for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import interpolate

from bozzetto_car.styling.path_spline import CubicSpline


@given(st.integers(0, 2**32 - 1), st.integers(2, 40), st.integers(1, 3))
def test_it_is_scipys(seed: int, count: int, axes: int) -> None:
    rng = np.random.default_rng(seed)
    knots = rng.uniform(-50.0, 50.0) + np.cumsum(10.0 ** rng.uniform(-1.0, 1.0, count))
    places = rng.normal(0.0, 1.0, (count, axes))
    oracle = interpolate.CubicSpline(knots, places)
    at = rng.uniform(knots[0], knots[-1], 200)
    own, expected = CubicSpline.through(knots, places)(at), oracle(at)
    assert np.abs(own - expected).max() <= 1e-11 * (1.0 + np.abs(expected).max())


@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_polynomials_of_its_degree_are_met(count: int) -> None:
    rng = np.random.default_rng(count)
    polynomial = np.polynomial.Polynomial(rng.normal(0.0, 1.0, min(count, 4)))
    knots = np.sort(rng.uniform(-1.0, 1.0, count))
    at = np.linspace(-1.2, 1.2, 50)
    own = CubicSpline.through(knots, polynomial(knots)[:, None])
    assert np.abs(own(at)[:, 0] - polynomial(at)).max() < 1e-9


def test_it_passes_through_its_places_to_the_last_bit() -> None:
    rng = np.random.default_rng(3)
    knots, places = np.cumsum(rng.uniform(0.1, 2.0, 30)), rng.normal(0.0, 100.0, (30, 2))
    spline = CubicSpline.through(knots, places)
    assert np.array_equal(spline(knots)[:-1], places[:-1])
    assert np.abs(spline(knots[-1:]) - places[-1:]).max() < 1e-12
