"""Curves of any degree: values against SciPy; the same curve over more knots and a degree up."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from bozzetto.geometry import Curve, Placement
from bozzetto.geometry.basis import basis, lifted, lowered
from bozzetto.geometry.refinement import elevated, refined

RNG = np.random.default_rng(12)


def curve(degree, rational, clamped=True, count=9):
    inner = np.sort(RNG.choice([0.2, 0.35, 0.5, 0.5, 0.8], count - degree - 1))
    if degree == 1:
        inner = np.linspace(0, 1, count - degree + 1)[1:-1]
    ends = np.zeros(degree + 1), np.ones(degree + 1)
    knots = np.concatenate((ends[0], inner, ends[1]))
    if not clamped:
        knots = np.cumsum(RNG.uniform(0.1, 1.0, count + degree + 1))
    weights = RNG.uniform(0.4, 2.5, count) if rational else None
    return Curve(degree, knots, RNG.normal(size=(count, 3)) * 50, weights)


CURVES = [
    curve(degree, rational, clamped)
    for degree in (1, 2, 3, 5)
    for rational in (False, True)
    for clamped in (True, False)
]


def by_scipy(one, at):
    rows = BSpline(one.knots, lifted(one.control_points, one.weights), one.degree)(at)
    return rows[:, :3] / rows[:, 3:]


def inside(one, count=101):
    return np.linspace(*one.range, count)


@pytest.mark.parametrize("one", CURVES)
def test_values_are_scipys_at_both_ends_too(one):
    at = inside(one)
    np.testing.assert_allclose(one.value(at), by_scipy(one, at), atol=1e-11)


@pytest.mark.parametrize("one", CURVES)
def test_parameters_beyond_the_ends_are_taken_to_them(one):
    begin, end = one.range
    np.testing.assert_array_equal(one.value([begin - 1, end + 9]), one.value([begin, end]))


@pytest.mark.parametrize("one", [c for c in CURVES if c.weights is None])
@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_derivatives_are_scipys(one, order):
    at = inside(one)[1:-1] + 1e-9
    expected = BSpline(one.knots, one.control_points, one.degree)(at, nu=order)
    np.testing.assert_allclose(one.derivative(at, order), expected, rtol=1e-8, atol=1e-6)


@pytest.mark.parametrize("one", [c for c in CURVES if c.weights is not None and c.degree > 1])
@pytest.mark.parametrize("order", [1, 2])
def test_derivatives_of_rational_curves_are_limits_of_differences(one, order):
    at = RNG.choice(np.setdiff1d(inside(one, 40)[1:-1], one.knots), 10)
    step = 1e-6
    there, back = one.derivative(at + step, order - 1), one.derivative(at - step, order - 1)
    expected = (there - back) / (2 * step)
    np.testing.assert_allclose(
        one.derivative(at, order), expected, rtol=1e-3, atol=1e-3 * np.abs(expected).max()
    )


@pytest.mark.parametrize("one", CURVES)
def test_basis_functions_add_up_to_one_and_their_derivatives_to_none(one):
    for order, total in ((0, 1.0), (1, 0.0)):
        _, values = basis(one.degree, one.knots, inside(one), order)
        np.testing.assert_allclose(values.sum(axis=1), total, atol=1e-10)


@pytest.mark.parametrize("one", CURVES)
def test_clamped_and_reversed_curves_are_the_same_places(one):
    clamped = one.clamped()
    assert clamped.is_clamped
    at = inside(one)
    np.testing.assert_allclose(clamped.value(at), one.value(at), atol=1e-10)
    begin, end = one.range
    np.testing.assert_allclose(one.reversed().value(begin + end - at), one.value(at), atol=1e-10)
    assert clamped.clamped() is clamped


@pytest.mark.parametrize("one", CURVES)
def test_a_polyline_has_even_steps_on_each_span_and_is_worked_out_once(one):
    at, places = one.polyline(6)
    begin, end = one.range
    breaks = np.unique(np.clip(one.knots, begin, end))
    np.testing.assert_allclose(one.value(at), places, atol=0.0)
    assert (at[0], at[-1]) == (begin, end)
    assert len(at) == (len(breaks) - 1) * (1 if one.degree == 1 else 6) + 1
    assert np.isin(breaks, at).all()
    assert one.polyline(6)[1] is places


@pytest.mark.parametrize("one", CURVES)
def test_more_knots_change_no_place(one):
    clamped = one.clamped()
    new = np.sort(np.append(clamped.knots, RNG.uniform(*one.range, 5)))
    at = inside(one)
    np.testing.assert_allclose(clamped.with_knots(new).value(at), one.value(at), atol=1e-10)


def test_the_same_knots_give_the_same_control_points():
    for one in CURVES:
        rows = lifted(one.control_points, one.weights)
        np.testing.assert_allclose(
            refined(one.degree, one.knots, rows, one.knots), rows, atol=1e-11
        )


@pytest.mark.parametrize("one", [c for c in CURVES if c.is_clamped])
def test_a_degree_more_changes_no_place_and_no_smoothness(one):
    rows = lifted(one.control_points, one.weights)
    knots, points = elevated(one.degree, one.knots, rows)
    at = inside(one)
    places, weights = lowered(points)
    other = Curve(one.degree + 1, knots, places, weights)
    np.testing.assert_allclose(other.value(at), one.value(at), atol=1e-10)
    _, before = np.unique(one.knots, return_counts=True)
    _, after = np.unique(knots, return_counts=True)
    np.testing.assert_array_equal(after, before + 1)
    np.testing.assert_allclose(places[[0, -1]], one.control_points[[0, -1]], rtol=1e-15)


def test_a_placement_commutes_with_evaluation():
    place = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 2.5, (3.0, -7.0, 11.0))
    for one in CURVES:
        at = inside(one)
        np.testing.assert_allclose(
            one.placed(place).value(at), place.points(one.value(at)), atol=1e-10
        )
