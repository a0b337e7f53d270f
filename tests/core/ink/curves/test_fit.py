"""The fit against curves whose truth is known, at any sampling rate, on any ink."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from bozzetto.errors import UserError
from bozzetto.geometry.spline import Spline
from bozzetto.ink import fit_spline


def wave(count, waves=1.5):
    s = np.linspace(0, 1, count)
    return np.column_stack((700 * s, 120 * np.sin(2 * np.pi * waves * s)))


def ellipse(count):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.column_stack((200 * np.cos(angle), 90 * np.sin(angle)))


def noisy(points, sigma=1.0, seed=0):
    return points + np.random.default_rng(seed).normal(0, sigma, points.shape)


def off(spline, truth):
    """Rms distance of the curve from the truth, and largest distance either way."""
    line = spline.sampled(2000)
    there = cKDTree(truth).query(line)[0]
    back = cKDTree(line).query(truth)[0]
    return np.sqrt((there**2).mean()), max(there.max(), back.max())


@pytest.mark.parametrize("count", [60, 200, 1000, 5000])
def test_any_sampling_rate_gives_the_same_curve(count):
    rms, worst = off(fit_spline(noisy(wave(count))).spline, wave(20000))
    assert rms < 0.8  # the notes' best at 1000 samples
    assert worst < 4.0


def test_the_length_does_not_grow_with_the_sampling_rate():
    lengths = [fit_spline(noisy(wave(n)), controls=13).spline.length for n in (200, 1000, 5000)]
    assert np.ptp(lengths) < 0.005 * lengths[0]


def test_a_cubic_comes_back():
    truth = Spline.uniform([[0, 0], [100, 300], [300, -200], [400, 100]])
    made = fit_spline(truth.sampled(400), controls=4)
    rms, worst = off(made.spline, truth.sampled(20000))
    assert rms < 0.02
    assert worst < 0.3  # half the distance of the places that are compared


@pytest.mark.parametrize("count", [80, 400, 4000])
def test_small_bends_of_clean_ink_do_not_shrink(count):
    angle = np.linspace(0, 1.5 * np.pi, count)
    bend = 20.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    made = fit_spline(bend, controls=13).spline.sampled(500)
    np.testing.assert_allclose(np.linalg.norm(made, axis=1), 20.0, atol=0.02)


def test_noisy_ink_gives_one_curve_at_all_sampling_rates():
    lines = [fit_spline(noisy(wave(n), 0.5), controls=13).spline.sampled(2000)
             for n in (400, 2000, 10000)]  # fmt: skip
    for line in lines[:-1]:
        assert np.sqrt((cKDTree(lines[-1]).query(line)[0] ** 2).mean()) < 0.3


def test_whole_pixels_are_smoothed():
    rounded = fit_spline(np.round(wave(2000)), controls=13).spline
    assert off(rounded, wave(20000))[0] < 0.15
    assert rounded.length == pytest.approx(
        fit_spline(wave(2000), controls=13).spline.length, rel=2e-3
    )


def test_adaptive_adds_control_points_only_where_they_are_needed():
    plain = fit_spline(noisy(wave(500, 0.5)), controls="adaptive")
    lively = fit_spline(noisy(wave(2000, 5)), controls="adaptive")
    assert len(plain.spline.control_points) == 7
    assert 13 <= len(lively.spline.control_points) <= 25
    assert off(lively.spline, wave(20000, 5))[0] < 1.5


def test_a_closed_curve_is_periodic_wherever_it_begins():
    ring = ellipse(500)
    for start in (0, 123):
        made = fit_spline(np.roll(ring, start, axis=0), closed=True)
        assert made.spline.closed
        assert off(made.spline, ellipse(20000))[1] < 1.0
        assert made.parameters[-1] - made.parameters[0] < 1.0


@pytest.mark.parametrize("size", [2, 3])
def test_end_tangents_are_exact(size):
    points = np.column_stack((wave(400), np.linspace(0, 200, 400)))[:, :size]
    start, end = np.eye(size)[1], np.full(size, -2.0)
    made = fit_spline(points, start_tangent=start, end_tangent=end).spline
    first, last = made.derivative([0.0, 1.0])
    np.testing.assert_allclose(first / np.linalg.norm(first), start, atol=1e-9)
    np.testing.assert_allclose(last / np.linalg.norm(last), end / np.linalg.norm(end), atol=1e-9)


def test_a_tangent_along_the_ink_costs_nothing():
    plain = fit_spline(wave(400))
    direction = plain.spline.derivative([0.0])[0]
    held = fit_spline(wave(400), start_tangent=direction)
    assert held.rms < 1.2 * plain.rms + 0.05


def test_space_curves_in_other_units_are_the_same_curves():
    helix = np.column_stack((wave(600), 80 * np.cos(np.linspace(0, 4, 600))))
    one = fit_spline(helix)
    other = fit_spline(helix * 1e-3, pixel=1e-3)
    np.testing.assert_allclose(
        other.spline.control_points * 1e3, one.spline.control_points, atol=1e-3
    )


def test_parameters_lead_to_the_given_points():
    points = wave(333)
    made = fit_spline(points, controls=13)
    assert (np.diff(made.parameters) >= 0).all()
    assert np.linalg.norm(made.spline.value(made.parameters) - points, axis=1).max() < 3.0


def test_ink_that_weighs_more_draws_the_curve():
    line = np.column_stack((np.linspace(0, 700, 400), np.zeros(400)))
    bump = line.copy()
    bump[150:250, 1] += 20 * np.sin(np.linspace(0, np.pi, 100))
    weights = np.where(bump[:, 1] > 0, 0.01, 1.0)
    highest = [
        fit_spline(bump, weights=given, controls=5).spline.sampled(200)[:, 1].max()
        for given in (None, weights)
    ]
    assert highest[1] < 0.3 * highest[0]


@pytest.mark.parametrize(
    "points",
    [
        [],
        [[1, 1]],
        [[3, 4]] * 20,
        [[0, 0], [np.nan, 1]],
        [[0, 0], [np.inf, 1]],
        [[0, 0], [1e300, 1]],
        [1, 2, 3],
        "ink",
    ],
)
def test_what_is_no_curve_is_refused_in_plain_words(points):
    with pytest.raises(UserError):
        fit_spline(points)


@given(
    st.integers(0, 999), st.integers(2, 30), st.sampled_from([1e-9, 1.0, 1e4]), st.booleans(),
    st.sampled_from([7, "adaptive"]),
)  # fmt: skip
@settings(max_examples=60, deadline=None)
def test_any_ink_gives_a_finite_curve(seed, count, scale, closed, controls):
    points = np.random.default_rng(seed).integers(0, 6, (count, 2)) * scale
    if not np.ptp(points, axis=0).any():
        return
    made = fit_spline(points, closed=closed, controls=controls)
    assert np.isfinite(made.spline.control_points).all()
    assert np.isfinite([made.rms, made.worst]).all()
    assert np.isfinite(made.parameters).all()
