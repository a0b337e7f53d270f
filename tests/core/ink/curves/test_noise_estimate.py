"""The estimate against noise of known size, on any curve at any sampling rate."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.ink.curves.noise_estimate import sample_noise


def arc(count, radius=80.0):
    """Three quarters of a circle, as a pen that is slow at both ends leaves it."""
    angle = 0.75 * np.pi * (1.0 - np.cos(np.linspace(0, np.pi, count)))
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def noisy(points, sigma, seed=0):
    return points + np.random.default_rng(seed).normal(0, sigma, points.shape)


@pytest.mark.parametrize("count", [60, 300, 1000])
@pytest.mark.parametrize("sigma", [0.1, 0.3, 1.0])
def test_the_noise_that_was_added_is_found(count, sigma):
    assert sample_noise(noisy(arc(count), sigma)) == pytest.approx(sigma, rel=0.35)


@pytest.mark.parametrize("count", [40, 200, 1000])
def test_bends_are_no_noise(count):
    assert sample_noise(arc(count, radius=20.0)) < 0.02


def test_corners_are_no_noise():
    side = np.linspace(0, 100, 50)
    corner = np.vstack((
        np.column_stack((side, 0 * side)),
        np.column_stack((0 * side[1:] + 100, side[1:])),
    ))  # fmt: skip
    assert sample_noise(corner + 0.25) < 1e-9


def test_whole_pixels_were_rounded():
    line = np.column_stack((np.arange(50), np.full(50, 7)))
    assert sample_noise(line) == 0.3
    assert sample_noise(line * 0.25, pixel=0.25) == 0.3 * 0.25
    assert sample_noise(line + 0.25) < 1e-9
    # rounding's own standard deviation, where the line crosses the grid at an angle
    assert sample_noise(np.round(arc(100, radius=300.0))) == pytest.approx(0.289, rel=0.5)


def test_turning_moving_and_scaling_change_nothing_but_the_unit():
    ink = noisy(arc(200), 0.5)
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])
    assert sample_noise(3.0 * ink @ turn + 9.1) == pytest.approx(3.0 * sample_noise(ink), rel=1e-6)


def test_in_space_it_is_the_noise_of_one_direction():
    ink = np.column_stack((arc(800), np.linspace(0, 200, 800)))
    assert sample_noise(noisy(ink, 0.2)) == pytest.approx(0.2, rel=0.35)


@given(st.integers(0, 999), st.integers(0, 30), st.sampled_from([1e-9, 1.0, 1e9]))
@settings(max_examples=60, deadline=None)
def test_any_ink_has_a_finite_noise(seed, count, scale):
    points = np.random.default_rng(seed).integers(0, 3, (count, 2)) * scale
    found = sample_noise(points)
    assert np.isfinite(found)
    assert found >= 0.0
