"""Rational B-spline surfaces against SciPy, differences and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from bozzetto.geometry import BSplineSurface, Placement
from tests.core.geometry.brep.exact_shapes import bent_net

RNG = np.random.default_rng(5)
TURN = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 2.5, (3.0, -7.0, 11.0))
MIRROR = Placement((1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0), 0.5, (0.0, 40.0, 1.0))


def places(surface, count=200):
    (u0, u1), (v0, v1) = surface.ranges
    return RNG.uniform(u0, u1, count), RNG.uniform(v0, v1, count)


def by_scipy(surface, u, v):
    """Values by SciPy's splines, one direction after the other, in homogeneous coordinates."""
    weights = np.ones(surface.control_points.shape[:2])
    if surface.weights is not None:
        weights = surface.weights
    lifted = np.dstack((surface.control_points * weights[..., None], weights))
    found = np.empty((len(u), 4))
    for k, (a, b) in enumerate(zip(u, v, strict=True)):
        row = BSpline(surface.knots_u, lifted, surface.degrees[0])(a)
        found[k] = BSpline(surface.knots_v, row, surface.degrees[1])(b)
    return found[:, :3] / found[:, 3:]


@pytest.mark.parametrize("seed", range(3))
def test_values_are_scipys(seed):
    surface = bent_net(seed)
    u, v = places(surface)
    np.testing.assert_allclose(surface.value(u, v), by_scipy(surface, u, v), atol=1e-12)


def test_corners_are_control_points():
    surface = bent_net(1)
    (u0, u1), (v0, v1) = surface.ranges
    net = surface.control_points
    np.testing.assert_allclose(
        surface.value([u0, u1, u1, u0], [v0, v0, v1, v1]), net[[0, -1, -1, 0], [0, 0, -1, -1]]
    )


@pytest.mark.parametrize("order", [(1, 0), (0, 1), (1, 1), (2, 0), (0, 2)])
def test_derivatives_are_the_limits_of_differences(order):
    surface = bent_net(2)
    u, v = RNG.uniform(0.35, 0.65, 50), RNG.uniform(0.1, 0.9, 50)
    step = 1e-5
    lower = (max(order[0] - 1, 0), order[1] if order[0] else order[1] - 1)
    du, dv = (step, 0.0) if order[0] else (0.0, step)
    there = surface.derivative(u + du, v + dv, *lower)
    back = surface.derivative(u - du, v - dv, *lower)
    found = surface.derivative(u, v, *order)
    np.testing.assert_allclose(found, (there - back) / (2 * step), rtol=1e-5, atol=1e-4)


def test_more_derivatives_than_the_degree_are_none():
    flat = BSplineSurface((1, 1), (0, 0, 1, 1), (0, 0, 1, 1), RNG.normal(size=(2, 2, 3)))
    assert not flat.derivative([0.3], [0.4], 2, 0).any()


def test_normals_are_units_square_to_the_surface():
    surface = bent_net(0)
    u, v = places(surface)
    normals = surface.normals(u, v)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    for order in ((1, 0), (0, 1)):
        along = surface.derivative(u, v, *order)
        assert np.abs(np.einsum("nk,nk->n", normals, along)).max() < 1e-10
    assert (normals[:, 2] > 0).all()  # a net that rises nowhere beyond the upright


@pytest.mark.parametrize("placement", [TURN, MIRROR])
def test_a_placement_commutes_with_evaluation(placement):
    surface = bent_net(1)
    u, v = places(surface)
    moved = surface.placed(placement)
    at = (v, u) if placement.mirrors else (u, v)
    np.testing.assert_allclose(moved.value(*at), placement.points(surface.value(u, v)), atol=1e-11)
    turned = placement.directions(surface.normals(u, v))
    np.testing.assert_allclose(moved.normals(*at), turned, atol=1e-11)  # outside stays outside


def test_turned_over_twice_is_the_same_to_the_last_bit():
    surface = bent_net(2)
    again = surface.turned_over().turned_over()
    for name in ("knots_u", "knots_v", "control_points", "weights"):
        np.testing.assert_array_equal(getattr(again, name), getattr(surface, name))


def test_scaled_weights_change_nothing():
    surface = bent_net(1)
    other = BSplineSurface(
        surface.degrees, *surface.knots, surface.control_points, surface.weights * 1024.0
    )
    np.testing.assert_array_equal(other.value([0.2], [1.1]), surface.value([0.2], [1.1]))


NET = np.zeros((2, 2, 3))
ENDS = (0.0, 0.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (((1, 1), ENDS, ENDS, np.zeros((2, 2, 2))), "three coordinates"),
        (((0, 1), ENDS, ENDS, NET), "more control points than its degree"),
        (((2, 1), ENDS, ENDS, NET), "more control points than its degree"),
        (((1, 1), (0, 1, 0, 1), ENDS, NET), "must not decrease"),
        (((1, 1), (0, 0, 1), ENDS, NET), "must fit"),
        (((1, 1), (0, 0.1, 1, 1), ENDS, NET), "begin and end"),
        (((1, 1), (0, 0, 0.5, 0.5, 1, 1), ENDS, np.zeros((4, 2, 3))), "as often as the degree"),
        (((1, 1), (0, 0, 0, 0), ENDS, NET), "as often as|range"),
        (((1, 1), ENDS, ENDS, NET, [[1, 1], [1, 0]]), "positive weight"),
        (((1, 1), ENDS, ENDS, NET, [1, 1]), "positive weight"),
        (((1, 1), ENDS, ENDS, NET * np.nan), "not finite"),
        (((1, 1), (0, 0, np.inf, np.inf), ENDS, NET), "not finite"),
    ],
)
def test_what_is_no_surface_is_refused(arguments, said):
    with pytest.raises(ValueError, match=said):
        BSplineSurface(*arguments)
