"""Curves across the plane fold over exactly."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_symmetry.fitting.half_curve import halves_of, symmetrize
from bozzetto_symmetry.fitting.space_curve import across
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry.edited_curves import ACROSS, LOOP, RING


def drawn(count: int, ring: bool):
    points = np.random.default_rng(count).normal((0.0, 3.0, 0.0), size=(count, 3))
    return across(points, ring=ring)


@pytest.mark.parametrize("ring", [False, True])
@pytest.mark.parametrize("count", [4, 5, 8, 13])
def test_mirrored_parameters_are_mirrored_places(count, ring):
    spline = drawn(count, ring)
    halves = halves_of(spline)
    assert halves.ring == ring
    away = np.linspace(0.0, halves.span, 40)
    here, there = spline.value(halves.middle + away), spline.value(halves.middle - away)
    np.testing.assert_allclose(here, there * MIRROR, atol=1e-13)
    np.testing.assert_allclose(spline.value([halves.middle])[0, 1], 0.0, atol=1e-13)


@pytest.mark.parametrize("spline", [ACROSS.spline, RING.spline])
def test_folded_parameters_belong_to_one_place_of_the_half(spline):
    halves = halves_of(spline)
    at = np.linspace(*spline.range, 77)
    away, beyond = halves.folded(at)
    assert (away >= 0).all()
    assert (away <= halves.span * (1 + 1e-12)).all()
    image = spline.value(halves.middle + away)
    image = np.where(beyond[:, None], image * MIRROR, image)
    np.testing.assert_allclose(image, spline.value(at), atol=1e-11)


@pytest.mark.parametrize("ring", [False, True])
def test_a_curve_with_more_knots_is_still_symmetric_and_becomes_so_exactly(ring):
    spline = drawn(7, ring)
    halves = halves_of(spline)
    away = halves.span * np.array([0.11, 0.36, 0.361, 0.9])
    finer = spline.refined(np.concatenate((halves.middle + away, halves.middle - away)))
    exact = symmetrize(finer)
    again = halves_of(exact)
    assert again.middle == pytest.approx(halves.middle, abs=1e-12)
    once = exact.control_points[:-3] if ring else exact.control_points
    assert (once[again.partner] * MIRROR == once).all()
    at = np.linspace(*spline.range, 200)
    np.testing.assert_allclose(exact.value(at), spline.value(at), atol=1e-12)


def test_a_closed_curve_beside_the_plane_has_no_halves():
    with pytest.raises(ValueError, match="not symmetric"):
        halves_of(LOOP.spline)
