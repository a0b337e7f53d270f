"""The filter against the closed form of the Gaussian on circles and waves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.ink.curves.smooth import smooth


def circle(count, radius=10.0):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def test_a_circle_shrinks_by_the_known_factor():
    made = smooth(circle(2000), 2.0, closed=True)
    np.testing.assert_allclose(
        np.linalg.norm(made, axis=1), 10 * np.exp(-0.5 * (2 / 10) ** 2), rtol=2e-3
    )


def test_the_phase_does_not_move():
    x = np.linspace(0, 100, 4001)
    wave = np.column_stack((x, 0.05 * np.sin(x)))  # so shallow that arc length is x
    made = smooth(wave, 1.0)
    inner = slice(400, -400)
    expected = 0.05 * np.exp(-0.5) * np.sin(x)
    np.testing.assert_allclose(made[inner, 1], expected[inner], atol=2e-4)


def test_a_straight_line_and_the_ends_stay():
    x = np.sort(np.random.default_rng(1).random(100))
    line = np.column_stack((x, 2 * x))
    np.testing.assert_allclose(smooth(line, 0.3), line, atol=1e-9)
    bent = np.column_stack((x, np.sin(20 * x)))
    made = smooth(bent, 0.5)
    np.testing.assert_allclose(made[[0, -1]], bent[[0, -1]], atol=1e-12)
    assert np.abs(made[50] - bent[50]).max() > 1e-3


def test_sampling_more_often_changes_nothing():
    corners = np.array([[0.0, 0], [10, 0], [10, 8], [3, 5]])
    dense = np.column_stack(
        [np.interp(np.linspace(0, 3, 901), np.arange(4), corners[:, k]) for k in (0, 1)]
    )
    sparse, fine = smooth(corners, 1.0), smooth(dense, 1.0)
    np.testing.assert_allclose(fine[::300], sparse, atol=1e-9)
    # and a rest of the pen (many equal samples) weighs nothing
    rest = np.vstack((dense[:300], np.repeat(dense[300:301], 500, axis=0), dense[300:]))
    np.testing.assert_allclose(smooth(rest, 1.0)[-600:], fine[-600:], atol=1e-9)


@pytest.mark.parametrize("repeat", [0, 1])
def test_a_closed_curve_has_no_seam(repeat):
    ring = circle(300)
    turned = np.roll(ring, 77, axis=0)
    if repeat:
        ring, turned = np.vstack((ring, ring[:1])), np.vstack((turned, turned[:1]))
    one, other = smooth(ring, 1.5, closed=True), smooth(turned, 1.5, closed=True)
    np.testing.assert_allclose(np.roll(one[:300], 77, axis=0), other[:300], atol=5e-3)
    if repeat:
        np.testing.assert_allclose(one[-1], one[0], atol=1e-9)


@given(st.floats(1e-6, 1e9), st.integers(1, 30), st.booleans(), st.integers(0, 99))
@settings(max_examples=100, deadline=None)
def test_any_width_on_any_ink_stays_in_its_box(sigma, count, closed, seed):
    points = np.random.default_rng(seed).integers(0, 5, (count, 2)).astype(float)
    made = smooth(points, sigma, closed=closed)
    assert made.shape == points.shape
    assert np.isfinite(made).all()
    if closed:  # a convex mean cannot leave the box
        assert (made >= points.min(0) - 1e-9).all()
        assert (made <= points.max(0) + 1e-9).all()
