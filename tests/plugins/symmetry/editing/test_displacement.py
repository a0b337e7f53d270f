"""Displacements change a spline where they are asked to, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_symmetry.editing.displacement import displace
from bozzetto_symmetry.fitting.half_curve import halves_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry.edited_curves import ACROSS, LOOP, PAIR, RING


def bump(at, begin, end, way):
    share = np.clip((at - begin) / (end - begin), 0.0, 1.0)
    return np.where(share * (1 - share) > 0, np.sin(np.pi * share) ** 2, 0.0)[:, None] * way


@pytest.mark.parametrize("spline", [PAIR.spline, LOOP.spline])
def test_a_bump_is_followed_and_the_rest_stays(spline):
    at = np.linspace(0.0, 1.0, 401)[:-1]
    way = np.array([1.0, 5.0, -3.0])
    made = displace(spline, at, bump(at, 0.3, 0.6, way), np.full(400, 0.5))
    fine = np.linspace(0.0, 1.0, 2000)
    change = made.value(fine) - spline.value(fine)
    assert np.abs(change - bump(fine, 0.3, 0.6, way)).max() < 0.3
    outside = (fine < 0.299) | (fine > 0.601)
    assert np.abs(change[outside]).max() < 1e-10


def test_a_bump_over_the_seam_is_one_bump():
    spline = LOOP.spline
    at = np.linspace(0.0, 1.0, 401)[:-1]
    way = np.array([0.0, 4.0, 4.0])
    round_ = np.where(at < 0.5, at + 1.0, at)
    made = displace(spline, at, bump(round_, 0.85, 1.2, way), np.full(400, 0.5))
    assert made.closed
    for order in (0, 1, 2):
        before, after = made.derivative([-1e-9, 1e-9], order)
        np.testing.assert_allclose(before, after, rtol=1e-5, atol=1e-5)
    fine = np.linspace(0.85, 1.2, 500)
    change = made.value(fine) - spline.value(fine)
    assert np.abs(change - bump(fine, 0.85, 1.2, way)).max() < 0.3


@pytest.mark.parametrize("curve", [ACROSS, RING])
@pytest.mark.parametrize("side", [1, -1])
def test_what_moves_on_one_half_moves_on_the_other(curve, side):
    spline = curve.spline
    halves = halves_of(spline)
    away = np.linspace(-halves.span, halves.span, 601)[:-1]
    at = halves.middle + side * away
    way = np.array([2.0, 3.0, 4.0])
    shifts = bump(away, 0.3 * halves.span, 0.7 * halves.span, way)
    made = displace(spline, at, shifts, np.full(600, 0.5), symmetric=True)
    fine = np.linspace(0.0, 0.999 * halves.span, 700)
    wanted = bump(fine, 0.3 * halves.span, 0.7 * halves.span, way)
    for sign in (1, -1):
        place = halves.middle + sign * fine
        change = made.value(place) - spline.value(place)
        expected = wanted if sign == side else wanted * MIRROR
        assert np.abs(change - expected).max() < 0.3


def test_nothing_that_moves_less_than_anybody_sees_makes_knots():
    at = np.linspace(0.0, 1.0, 200)
    shifts = bump(at, 0.2, 0.8, np.array([0.1, 0.1, 0.0]))
    assert displace(PAIR.spline, at, shifts, np.ones(200)) is PAIR.spline


def test_knots_are_added_only_where_they_are_needed():
    at = np.linspace(0.0, 1.0, 400)
    made = displace(PAIR.spline, at, bump(at, 0.4, 0.5, np.array([0, 9.0, 0])), np.ones(400))
    fresh = np.setdiff1d(made.knots, PAIR.spline.knots)
    assert len(fresh) < 25
    assert fresh.min() > 0.25
    assert fresh.max() < 0.65
