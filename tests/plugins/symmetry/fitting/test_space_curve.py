"""Symmetric curves: to the last bit, in every kind, and as they are handed over."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.geometry.spline import DEGREE, Spline
from bozzetto_symmetry.fitting.space_curve import Reading, SpaceCurve, across
from bozzetto_symmetry.fitting.symmetric_basis import SymmetricBasis
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

KINDS: list[tuple[Reading, bool, bool]] = [
    ("pair", False, False),
    ("pair", True, False),
    ("self", False, False),
    ("self", False, True),
    ("plane", False, False),
    ("plane", True, False),
]


def half(count: int, seed: int) -> np.ndarray:
    """Control points from the plane outwards."""
    return np.random.default_rng(seed).uniform(-100.0, 100.0, (count, 3))


@settings(max_examples=30, deadline=None)
@given(st.integers(4, 25), st.integers(0, 1000))
def test_across_is_its_own_mirror_image_to_the_last_bit(count: int, seed: int) -> None:
    spline = across(half(count, seed))
    assert (spline.control_points[::-1] == spline.control_points * MIRROR).all()
    assert (spline.knots[::-1] == -spline.knots).all()
    assert (spline.control_points[count - 1] == half(count, seed)[0] * (1, 0, 1)).all()
    assert spline.range == (-1.0, 1.0)


@settings(max_examples=30, deadline=None)
@given(st.integers(4, 25), st.integers(0, 1000))
def test_ring_is_its_own_mirror_image(count: int, seed: int) -> None:
    spline = across(half(count, seed), ring=True)
    once = spline.control_points[:-DEGREE]
    # The place in the plane goes second; the others are as far before it as behind it.
    turned = np.roll(once, -1, axis=0)
    assert (np.roll(turned[::-1], 1, axis=0) == turned * MIRROR).all()
    at = np.linspace(0.0, 1.0, 41)
    assert np.abs(spline.value(at) - spline.value(1.0 - at) * MIRROR).max() < 1e-11


@pytest.mark.parametrize(("ring", "crossings"), [(False, [0.0]), (True, [0.0, 0.5])])
def test_plane_is_crossed_squarely_and_smoothly(ring: bool, crossings: list[float]) -> None:
    spline = across(half(8, 3), ring=ring)
    for at in crossings:
        assert abs(spline.value([at])[0, 1]) < 1e-12
        tangent = spline.derivative([at])[0]
        assert abs(tangent[[0, 2]]).max() < 1e-12 * abs(tangent[1])
        below, above = spline.derivative([at - 1e-9, at + 1e-9], 2)
        if at == 0.0 and ring:
            below = spline.derivative([1.0 - 1e-9], 2)[0]
        assert np.abs(below - above).max() < 1e-4 * np.abs(above).max()


@pytest.mark.parametrize("closed", [False, True])
def test_handed_over_pair_differs_in_one_sign_only(closed: bool) -> None:
    one, other = SpaceCurve("pair", Spline.uniform(half(9, 1), closed=closed)).to_curves()
    assert (np.asarray(one.control_points) * MIRROR == np.asarray(other.control_points)).all()
    assert (np.asarray(one.knots) == np.asarray(other.knots)).all()


@pytest.mark.parametrize("ring", [False, True])
@pytest.mark.parametrize("count", [5, 7, 10, 13, 25])
def test_handed_over_curve_across_the_plane_is_exactly_symmetric(count: int, ring: bool) -> None:
    curve = SpaceCurve("self", across(half(count, 2), ring=ring))
    (made,) = curve.to_curves()
    points, knots = np.asarray(made.control_points), np.asarray(made.knots)
    assert (points[::-1] == points * MIRROR).all()
    assert np.abs(knots[0] + knots[-1] - knots[::-1] - knots).max() < 1e-15
    assert np.abs(Spline(knots, points).sampled(60) - curve.spline.sampled(60)).max() < 1e-11


@pytest.mark.parametrize(("reading", "closed", "ring"), KINDS)
def test_basis_is_linear_in_the_free_coordinates(
    reading: Reading, closed: bool, ring: bool
) -> None:
    basis = SymmetricBasis(reading, 7, closed, ring)
    points = half(7, 5)
    spline = basis.curve(points).spline
    at = np.linspace(*spline.range, 37)
    for order in (0, 1, 2):
        made = basis.at(basis.values(at, order), points)
        scale = np.abs(spline.derivative(at, order)).max()
        assert np.abs(made - spline.derivative(at, order)).max() < 1e-12 * scale
    step = np.random.default_rng(0).normal(size=int(basis.free.sum()))
    values = basis.values(at)
    moved = basis.at(values, basis.moved(points, step)) - basis.at(values, points)
    rows = np.stack([basis.rows(values, np.tile(a, (37, 1))) @ step for a in np.eye(3)], axis=1)
    assert np.abs(moved - rows).max() < 1e-11


@pytest.mark.parametrize(("reading", "closed", "ring"), KINDS)
def test_bending_is_the_integral_of_the_third_derivative(
    reading: Reading, closed: bool, ring: bool
) -> None:
    basis = SymmetricBasis(reading, 8, closed, ring)
    points = basis.moved(np.zeros((8, 3)), np.random.default_rng(1).normal(size=basis.free.sum()))
    low, high = basis.half
    count = 40_000
    at = low + (high - low) * (np.arange(count) + 0.5) / count
    third = basis.curve(points).spline.derivative(at, 3) * (high - low) ** 3
    integral = float((third**2).sum() / count)
    rows = basis.bending() @ points.ravel()[basis.free]
    assert float(rows @ rows) == pytest.approx(integral, rel=1e-3)


def test_in_the_plane_y_is_exactly_nought() -> None:
    spline = SymmetricBasis("plane", 7).curve(half(7, 9)).spline
    assert (spline.control_points[:, 1] == 0.0).all()
    assert (spline.sampled(50)[:, 1] == 0.0).all()
