"""Splines against SciPy, closed forms and laws."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BSpline

from bozzetto.geometry.spline import Spline


def drawn(closed=False, size=3, count=9, seed=4):
    points = np.random.default_rng(seed).normal(size=(count, size)) * 100
    return Spline.uniform(points, closed=closed)


def uneven(seed=2):
    """Knots of all multiplicities, over a range that is not 0 … 1."""
    knots = np.array([2, 2, 2, 2, 2.5, 3, 3, 4, 4, 4, 6.5, 7, 7, 7, 7])
    return Spline(knots, np.random.default_rng(seed).normal(size=(11, 2)))


def everywhere(spline, count=301):
    return np.linspace(*spline.range, count)


@pytest.mark.parametrize("spline", [drawn(), drawn(size=2), uneven()])
def test_values_and_derivatives_are_scipys(spline):
    other = BSpline(spline.knots, spline.control_points, 3)
    at = np.setdiff1d(everywhere(spline), spline.knots)
    np.testing.assert_allclose(spline.value(at), other(at), atol=1e-10)
    np.testing.assert_allclose(spline.derivative(at), other(at, 1), atol=1e-8)
    np.testing.assert_allclose(spline.derivative(at, 2), other(at, 2), atol=1e-6)


def test_a_closed_curve_runs_smoothly_over_its_seam():
    ring = drawn(closed=True)
    for order in range(3):
        before, after = ring.derivative([-1e-9], order), ring.derivative([1e-9], order)
        np.testing.assert_allclose(before, after, rtol=1e-5, atol=1e-3)
    np.testing.assert_allclose(ring.value([0.3, 2.3]), ring.value([1.3, -0.7]), atol=1e-9)


@pytest.mark.parametrize("closed", [False, True])
def test_length_is_the_integral_of_the_speed(closed):
    spline = drawn(closed)
    expected = quad(
        lambda u: np.linalg.norm(spline.derivative([u])), 0, 1, limit=500, points=spline.knots[4:-4]
    )[0]
    assert spline.length == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("spline", [drawn(), drawn(True), uneven()])
def test_foot_points_are_the_nearest_of_a_brute_search(spline):
    points = np.random.default_rng(0).normal(size=(60, spline.control_points.shape[1])) * 100
    at = spline.foot_points(points)
    found = np.linalg.norm(spline.value(at) - points, axis=1)
    chain = spline.value(everywhere(spline, 20001))
    best = np.linalg.norm(chain[None] - points[:, None], axis=2).min(axis=1)
    assert (found <= best + 1e-9 * 100).all()


@pytest.mark.parametrize("spline", [drawn(), drawn(True), uneven(), drawn(size=2)])
def test_bounds_of_distances_are_below_them_and_near(spline):
    random = np.random.default_rng(1)
    points = random.normal(size=(80, spline.control_points.shape[1])) * 100
    points = np.vstack([points, spline.value(random.uniform(0, 1, 20))])
    away = np.linalg.norm(spline.value(spline.foot_points(points)) - points, axis=1)
    least = spline.least_distances(points)
    assert (least <= away + 1e-9).all()
    assert (least >= 0).all()
    assert (away - least <= 0.05 * spline.length).all()


def test_foot_points_of_the_curves_own_places_are_these_places():
    spline = drawn(size=2)
    at = np.linspace(0, 1, 50)
    np.testing.assert_allclose(spline.foot_points(spline.value(at), at + 0.002), at, atol=1e-6)


@pytest.mark.parametrize("spline", [drawn(), uneven()])
def test_pieces_lie_on_the_curve(spline):
    begin, end = spline.range
    cuts = begin + np.array([0.21, 0.5, 0.77]) * (end - begin)
    pieces = spline.split(*cuts)
    assert len(pieces) == 4
    for piece in pieces:
        at = everywhere(piece)[1:-1]
        np.testing.assert_allclose(piece.value(at), spline.value(at), atol=1e-9)
    assert sum(piece.length for piece in pieces) == pytest.approx(spline.length, rel=1e-6)


def test_a_closed_curve_is_cut_into_as_many_pieces_as_cuts():
    ring = drawn(closed=True)
    for cuts in ((0.4,), (0.0,), (0.9, 0.1, 0.5)):
        pieces = ring.split(*cuts)
        assert len(pieces) == len(cuts)
        for piece in pieces:
            np.testing.assert_allclose(
                piece.value(everywhere(piece)), ring.value(everywhere(piece)), atol=1e-9
            )


@pytest.mark.parametrize("spline", [drawn(), drawn(True), uneven(), drawn(True, count=4)])
def test_knots_are_added_without_changing_the_curve(spline):
    begin, end = spline.range
    fresh = np.random.default_rng(3).uniform(begin, end, 9)
    finer = spline.refined(fresh).refined([begin + 0.37 * (end - begin), begin, end])
    assert len(finer.control_points) == len(spline.control_points) + 10
    assert finer.range == spline.range
    assert np.isin(fresh, finer.knots).all()
    at = everywhere(spline)
    size = np.abs(spline.control_points).max()
    np.testing.assert_allclose(finer.value(at), spline.value(at), atol=1e-13 * size)
    assert finer.refined(fresh) is finer


@pytest.mark.parametrize("spline", [drawn(), drawn(True), uneven()])
def test_bezier_pieces_are_the_curve(spline):
    breaks = np.unique(spline.knots)
    breaks = breaks[(breaks >= spline.range[0]) & (breaks <= spline.range[1])]
    pieces = spline.beziers()
    assert len(pieces) == len(breaks) - 1
    share = np.linspace(0, 1, 11)[:, None]
    for piece, low, high in zip(pieces, breaks[:-1], breaks[1:], strict=True):
        level = [piece[k] for k in range(4)]
        while len(level) > 1:  # de Casteljau
            level = [(1 - share) * a + share * b for a, b in itertools.pairwise(level)]
        inner = (low + share[:, 0] * (high - low))[1:-1]
        np.testing.assert_allclose(level[0][1:-1], spline.value(inner), atol=1e-9)


def test_the_mirror_image_is_exact_and_its_own_inverse():
    spline = drawn()
    image = spline.mirrored([0, 1, 0])
    assert np.array_equal(image.control_points, spline.control_points * [1, -1, 1])
    assert np.array_equal(image.knots, spline.knots)
    there = spline.mirrored([1, 2, -3], 7.0)
    back = there.mirrored([1, 2, -3], 7.0)
    np.testing.assert_allclose(back.control_points, spline.control_points, atol=1e-10)


@pytest.mark.parametrize("spline", [drawn(), drawn(True), uneven()])
def test_reversed_runs_through_the_same_places(spline):
    at = everywhere(spline)[1:-1]
    begin, end = spline.range
    np.testing.assert_allclose(
        spline.reversed().value(begin + end - at), spline.value(at), atol=1e-9
    )


@pytest.mark.parametrize("spline", [drawn(), drawn(True), uneven()])
def test_the_hand_over_is_clamped_and_the_same_curve(spline):
    curve = spline.to_curve("rail")
    other = BSpline(curve.knots, curve.control_points, 3)
    at = everywhere(spline)[1:-1]
    size = spline.control_points.shape[1]
    np.testing.assert_allclose(other(at)[:, :size], spline.value(at), atol=1e-9)
    assert (curve.knots[:4] == curve.knots[0]).all()
    assert curve.closed == spline.closed


@pytest.mark.parametrize(
    ("knots", "points"),
    [
        (np.arange(8.0), np.zeros((3, 2))),
        (np.arange(8.0)[::-1], np.zeros((4, 2))),
        (np.arange(9.0), np.zeros((4, 2))),
        (np.zeros(8), np.zeros((4, 2))),
        (np.arange(8.0), np.full((4, 2), np.nan)),
        (np.arange(8.0), np.zeros((4, 5))),
    ],
)
def test_what_is_no_spline_is_refused(knots, points):
    with pytest.raises(ValueError, match=r"."):
        Spline(knots, points)


@pytest.mark.parametrize("closed", [False, True])
def test_a_cut_off_a_knot_by_rounding_cuts_at_the_knot(closed):
    points = np.random.default_rng(5).normal(size=(9, 3))
    spline = Spline.uniform(points, closed=closed)
    begin, end = spline.range
    knot = float(spline.knots[6])
    assert begin < knot < end
    exact = spline.split(knot, 0.9 * end)
    for off in (np.nextafter(knot, begin), np.nextafter(knot, end)):
        pieces = spline.split(off, 0.9 * end)
        assert len(pieces) == len(exact)
        for piece, same in zip(pieces, exact, strict=True):
            np.testing.assert_array_equal(piece.knots, same.knots)
            np.testing.assert_array_equal(piece.control_points, same.control_points)
        assert min(np.diff(np.unique(piece.knots)).min() for piece in pieces) > 1e-6


def test_a_cut_at_the_seam_by_rounding_is_one_cut():
    ring = Spline.uniform(np.random.default_rng(6).normal(size=(8, 2)), closed=True)
    begin, end = ring.range
    (once,) = ring.split(begin)
    (again,) = ring.split(np.nextafter(end, begin))
    np.testing.assert_array_equal(once.control_points, again.control_points)
    assert len(ring.split(np.nextafter(end, begin), begin, 0.4 * end)) == 2
