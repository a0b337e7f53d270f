"""One stroke made ready: its form is kept, its noise is not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto_symmetry.ink.stroke_line import (
    CLOSING,
    MOST,
    calmest_noise,
    hand_noise,
    pen_down,
    smooth_line,
)
from tests.plugins.symmetry.scenes import ACROSS, FLAT, LOOPS, PAIRS, camera, drawn, tremor

VIEWS = [(10, 15), (30, 20), (60, 30), (85, 10)]
OPEN = {**PAIRS, **ACROSS, **FLAT}


@pytest.mark.parametrize("name", OPEN)
@pytest.mark.parametrize("view", VIEWS)
def test_ink_without_noise_keeps_its_form(name: str, view: tuple[float, float]) -> None:
    ink = drawn(OPEN[name], camera(*view))
    line = smooth_line(ink)
    assert not line.closed
    assert line.noise < 0.2
    assert distances_to_polyline(line.pixels, ink).max() < 0.15
    np.testing.assert_allclose(line.pixels[[0, -1]], ink[[0, -1]], atol=1e-6)


@pytest.mark.parametrize("radius", [10.0, 20.0, 100.0])
def test_a_bend_does_not_shrink(radius: float) -> None:
    turn = np.linspace(0.0, 1.5 * np.pi, 200)
    line = smooth_line(radius * np.column_stack((np.cos(turn), np.sin(turn))) + 300.0)
    assert np.abs(np.linalg.norm(line.pixels - 300.0, axis=1) - radius).max() < 0.02


@pytest.mark.parametrize("count", [60, 240, 960, 3840])
def test_points_are_even_whatever_the_sampling(count: int) -> None:
    turn = np.linspace(0.0, np.pi, count) ** 1.3
    ink = 200.0 * np.column_stack((turn, np.sin(turn)))
    steps = np.linalg.norm(np.diff(smooth_line(ink).pixels, axis=0), axis=1)
    assert steps.max() / steps.min() < 1.01
    assert 1.5 < steps.mean() < 2.5


@pytest.mark.parametrize("count", [300, 1500])
@pytest.mark.parametrize("noise", [0.5, 1.0, 2.0])
def test_noise_of_single_samples_goes(count: int, noise: float) -> None:
    random = np.random.default_rng(count)
    along = np.linspace(0.0, np.pi, count)
    true = np.column_stack((120.0 * along, 100.0 * np.sin(along)))
    line = smooth_line(true + noise * random.standard_normal(true.shape))
    left = np.sqrt(np.mean(distances_to_polyline(line.pixels[10:-10], true) ** 2))
    assert left < 0.5 * noise
    assert left < line.noise < 1.2 * noise


def test_integer_pixels_count_as_noise() -> None:
    along = np.linspace(0.0, np.pi, 800)
    true = np.column_stack((120.0 * along, 100.0 * np.sin(along)))
    line = smooth_line(np.round(true))
    assert 0.05 < line.noise < 0.6
    assert distances_to_polyline(line.pixels, true).mean() < 0.3


def test_sparse_samples_are_joined_by_curves() -> None:
    turn = np.linspace(0.0, np.pi, 20)
    line = smooth_line(100.0 * np.column_stack((np.cos(turn), np.sin(turn))))
    assert np.abs(np.linalg.norm(line.pixels, axis=1) - 100.0).max() < 0.1  # chords: 0.34


@pytest.mark.parametrize("name", LOOPS)
def test_loops_close(name: str) -> None:
    ink = drawn(LOOPS[name], camera(30, 20))
    line = smooth_line(np.vstack((ink, ink[:4])))
    assert line.closed
    ring = np.vstack((ink, ink[:1]))
    assert distances_to_polyline(line.pixels, ring).max() < 0.15
    steps = np.linalg.norm(line.pixels - np.roll(line.pixels, 1, axis=0), axis=1)
    assert steps.max() / np.percentile(steps, 5) < 1.05  # chords are short in a sharp bend


def test_an_arch_that_nearly_closes_stays_open() -> None:
    for share, closed in ((0.95, False), (0.99, True)):
        turn = 2.0 * np.pi * share * np.linspace(0.0, 1.0, 200)
        line = smooth_line(80.0 * np.column_stack((np.cos(turn), np.sin(turn))))
        assert line.closed is closed
    assert CLOSING < 0.1


def test_the_tail_of_a_lifted_pen_is_left_out() -> None:
    pressure = np.concatenate((np.full(50, 0.6), [0.02, 0.01, 0.005]))
    ink = np.column_stack((np.arange(53.0), np.zeros(53)))
    ink[50:, 1] = 5.0
    stroke = Stroke(ink[:, 0], ink[:, 1], camera(30, 20), pressure=pressure)
    assert len(pen_down(stroke)) == 50
    assert len(pen_down(Stroke(ink[:, 0], ink[:, 1], camera(30, 20)))) == 53
    assert len(pen_down(Stroke(ink[:, 0], ink[:, 1], camera(30, 20), pressure=np.zeros(53)))) == 53


def test_a_dot_is_refused() -> None:
    with pytest.raises(UserError, match="dot"):
        smooth_line(np.full((9, 2), 7.0))


@pytest.mark.parametrize("seed", range(4))
def test_corners_do_not_hide_how_steady_a_hand_is(seed: int) -> None:
    made = np.random.default_rng(seed)
    side = np.linspace(0.0, 1.0, 200)[:, None]
    bent = np.vstack((side * (150.0, 40.0), (150.0, 40.0) + side[1:] * (-30.0, 160.0)))
    assert calmest_noise(bent) < 1e-6
    assert calmest_noise(bent + tremor(len(bent), 1.0, made)) > 0.01


def test_short_lines_have_no_noise_to_tell() -> None:
    short = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    assert hand_noise(short) == 0.0
    assert calmest_noise(short) == 0.0


@settings(max_examples=40, deadline=None)
@given(arrays(np.float32, st.tuples(st.integers(1, 40), st.just(2)),
              elements=st.floats(-5000, 5000, width=32)))  # fmt: skip
def test_any_ink_gives_a_line_or_says_why_not(ink: np.ndarray) -> None:
    try:
        line = smooth_line(ink.astype(float))
    except UserError:
        return
    assert np.isfinite(line.pixels).all()
    assert 2 <= len(line.pixels) <= MOST
    assert np.isfinite(line.noise)
    assert line.noise >= 0.0


@pytest.mark.parametrize("radius", [22.0, 40.0, 200.0])
def test_a_loop_is_closed_by_a_hand_that_misses_its_beginning_by_five_pixels(radius: float) -> None:
    """A share of its size alone left small ones open: the lenses of glasses on a small screen."""
    for gap, closed in ((5.0, True), (0.07 * 2.0 * np.pi * radius, False)):
        angle = np.linspace(0.0, 2.0 * np.pi - gap / radius, 90)
        line = smooth_line(radius * np.column_stack((np.cos(angle), np.sin(angle))))
        assert line.closed is closed
