"""Strokes smoothed in the image."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.signal import savgol_filter

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.ink.curves.resample import arc_length
from bozzetto.view import Camera
from bozzetto_car.styling.stroke_line import STEP, one_stroke, smooth_line


def arc(radius: float = 300.0, count: int = 200, turn: float = 1.4) -> np.ndarray:
    at = np.linspace(0.0, turn, count)
    return 400.0 + radius * np.column_stack((np.cos(at), np.sin(at)))


def test_ends_stay_and_steps_are_even() -> None:
    rng = np.random.default_rng(0)
    stroke = arc() + rng.normal(0.0, 0.5, (200, 2))
    line = smooth_line(stroke)
    assert np.abs(line[[0, -1]] - stroke[[0, -1]]).max() < 1e-9
    steps = np.diff(arc_length(line))
    assert np.ptp(steps) < 0.02 * STEP
    assert abs(steps.mean() - STEP) < 0.1 * STEP


def test_it_is_savitzky_and_golays_filter_as_scipy_has_it() -> None:
    x = np.linspace(0.0, 400.0, 1601)
    stroke = np.column_stack((x, np.where((x > 150) & (x < 260), 0.04 * (x - 150), np.sin(x / 9))))
    along = arc_length(stroke)
    fine = np.linspace(0.0, along[-1], round(along[-1]) + 1)
    expected = np.column_stack([np.interp(fine, along, column) for column in stroke.T])
    half = round(0.07 * along[-1] / (fine[1] - fine[0]))
    for _ in range(2):
        padded = np.pad(expected, ((half, half), (0, 0)), mode="reflect", reflect_type="odd")
        expected = savgol_filter(padded, 2 * half + 1, 3, axis=0)[half:-half]
    assert distances_to_polyline(smooth_line(stroke), expected).max() < 1e-3


@pytest.mark.parametrize("radius", [60.0, 150.0, 500.0])
def test_bends_keep_their_form(radius: float) -> None:
    line = smooth_line(arc(radius))
    away = np.abs(np.linalg.norm(line - 400.0, axis=1) - radius)
    assert away.max() < 0.2  # near the ends, which are continued by their reflection
    assert np.median(away) < 0.01


def test_the_tremor_goes() -> None:
    rng = np.random.default_rng(1)
    tremor = gaussian_filter1d(rng.normal(0.0, 1.0, (200, 2)), 3, axis=0)
    stroke = arc() + 0.8 * tremor / tremor.std()
    line = smooth_line(stroke)
    away = [np.abs(np.linalg.norm(each - 400.0, axis=1) - 300.0) for each in (stroke, line)]
    # A waver as slow as the window is wide cannot be told from the form.
    assert away[1].mean() < 0.9 * away[0].mean()
    assert turning(line) - 1.4 < 0.1 * (turning(stroke) - 1.4)


def turning(line: np.ndarray) -> float:
    """How far the direction of a line turns to and fro in all, radians."""
    way = np.diff(line, axis=0)
    return float(np.abs(np.diff(np.unwrap(np.arctan2(way[:, 1], way[:, 0])))).sum())


def test_the_sampling_rate_does_not_matter() -> None:
    fine, coarse = smooth_line(arc(count=2000)), smooth_line(arc(count=120))
    assert distances_to_polyline(coarse, fine).max() < 0.05


def test_pauses_of_the_pen_do_not_matter() -> None:
    stroke = arc()
    paused = np.concatenate((stroke[:80], np.repeat(stroke[[80]], 50, axis=0), stroke[81:]))
    assert np.array_equal(smooth_line(paused), smooth_line(stroke))


@pytest.mark.parametrize(
    "stroke",
    [
        [[5.0, 5.0]],
        [[5.0, 5.0], [6.0, 5.0]],
        [[1e12, 0.0], [0.0, 0.0]],
        [[np.nan, 0.0], [9.0, 9.0]],
    ],
)
def test_dots_and_nonsense_are_refused_in_words(stroke: list[list[float]]) -> None:
    with pytest.raises(UserError):
        smooth_line(stroke)


@pytest.mark.parametrize("length", [6.0, 7.5, 11.0, 20.0])
def test_very_short_strokes_are_lines_too(length: float) -> None:
    line = smooth_line([[0.0, 0.0], [length, 0.0]])
    assert np.abs(line[[0, -1], 0] - [0.0, length]).max() < 1e-9
    assert np.abs(line[:, 1]).max() < 1e-12


def test_several_strokes_settle_into_one_in_the_sense_of_the_first() -> None:
    rng = np.random.default_rng(3)
    strokes = []
    for number in range(4):
        place = arc() + rng.normal(0.0, 2.0, 2)
        place = place[::-1] if number % 2 else place
        strokes.append(Stroke(place[:, 0], place[:, 1], Camera()))
    line = one_stroke(strokes)
    assert np.median(distances_to_polyline(line, arc())) < 2.0
    assert np.linalg.norm(line[0] - arc()[0]) < np.linalg.norm(line[0] - arc()[-1])


def test_a_dot_beside_a_stroke_is_left_out() -> None:
    place = arc()
    strokes = [Stroke([3.0], [3.0], Camera()), Stroke(place[:, 0], place[:, 1], Camera())]
    assert np.abs(one_stroke(strokes) - place).max() < 1e-3


def test_a_loop_is_closed_without_a_corner() -> None:
    rng = np.random.default_rng(6)
    at = np.linspace(0.0, 2.0 * np.pi + 0.05, 300)
    stroke = np.column_stack((400.0 + 120.0 * np.cos(at), 300.0 + 60.0 * np.sin(at)))
    line = smooth_line(stroke + rng.normal(0.0, 0.3, stroke.shape))
    assert np.abs(line[0] - line[-1]).max() < 1e-9
    way = np.diff(np.vstack((line, line[1:3])), axis=0)
    turns = np.degrees(np.diff(np.unwrap(np.arctan2(way[:, 1], way[:, 0]))))
    assert np.abs(turns).max() < 12.0  # the ellipse itself turns by 11° in a step at its ends
    assert distances_to_polyline(line, stroke).max() < 0.7


@pytest.mark.parametrize("radius", [0.3, 1.0, 2.0, 3.0, 5.0])
def test_a_tiny_loop_is_a_line_of_places_that_differ_or_a_dot(radius: float) -> None:
    said = ""
    line = np.zeros((0, 2))
    try:
        line = smooth_line(arc(radius, 90, 2.0 * np.pi))
    except UserError as problem:
        said = problem.message
    assert "is a dot" in said if said else (np.diff(arc_length(line)) > 0.0).all()
