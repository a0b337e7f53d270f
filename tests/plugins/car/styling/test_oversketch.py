"""Styling curves drawn over and smoothed."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto_car.body.body import Body
from bozzetto_car.state import StylingCurve
from bozzetto_car.styling.curve import project_stroke
from bozzetto_car.styling.curve_fit import as_curves
from bozzetto_car.styling.erase import without_stretch
from bozzetto_car.styling.oversketch import oversketch, smooth_curve
from tests.plugins.car.styled_body import (
    QUARTER,
    SHOULDER,
    assert_sound,
    dense,
    styled,
    template_body,
    through,
    whole,
)
from tests.plugins.car.traced_car import view

Array = NDArray[np.float64]


def bulging(stroke: Array, first: int, last: int, height: float) -> Array:
    """A part of a stroke, pushed aside in its middle, px."""
    part = stroke[first:last].copy()
    part[:, 1] -= height * np.sin(np.linspace(0.0, np.pi, last - first)) ** 2
    return part


def seen(curve: StylingCurve, body: Body) -> Array:
    return QUARTER.project(dense(curve, body))[0]


@pytest.mark.parametrize("turned", [False, True])
def test_the_curve_goes_to_the_stroke_and_the_rest_stays(turned: bool) -> None:
    body, stroke = template_body(), through(QUARTER, SHOULDER)
    curve = styled(body)
    over = bulging(stroke, 80, 170, 12.0)
    bent = oversketch(curve, body, over[::-1] if turned else over, QUARTER)
    assert_sound(bent, body)
    line = seen(bent, body)
    away = distances_to_polyline(over, line)
    assert away.max() < 1.0
    assert np.median(away) < 0.3
    before, after = seen(curve, body), seen(bent, body)
    # Beyond the stroke and the 40 px in which it is led back nothing has moved.
    far = distances_to_polyline(before, over) > 45.0
    assert far.sum() > 300
    assert distances_to_polyline(before[far], after).max() < 0.02


def test_the_change_is_as_smooth_as_the_stroke() -> None:
    body, stroke = template_body(), through(QUARTER, SHOULDER)
    bent = oversketch(styled(body), body, bulging(stroke, 80, 170, 12.0), QUARTER)
    line = QUARTER.project(dense(bent, body, 300))[0]
    way = np.diff(line, axis=0)
    turns = np.degrees(np.abs(np.diff(np.unwrap(np.arctan2(way[:, 1], way[:, 0])))))
    assert turns.max() < 3.0


def test_a_stroke_along_the_curve_as_it_is_changes_nothing() -> None:
    body, stroke = template_body(), through(QUARTER, SHOULDER)
    curve = styled(body)
    assert oversketch(curve, body, stroke[40:200], QUARTER) is curve


def test_a_stroke_that_runs_on_beyond_an_end_takes_it_along() -> None:
    body = template_body()
    long = through(QUARTER, SHOULDER)
    curve = StylingCurve("n1", "Short", True, "", *project_stroke(body, long[40:200], QUARTER))
    for part, end, goal in ((long[150:], -1, long[-1]), (long[:90], 0, long[0])):
        grown = oversketch(curve, body, part, QUARTER)
        assert_sound(grown, body)
        assert np.linalg.norm(seen(grown, body)[end] - goal) < 3.0
        assert distances_to_polyline(seen(grown, body), long).max() < 1.0


def test_what_is_not_seen_stays() -> None:
    """A curve round the nose, changed on one side of it only."""
    body, front = template_body(), view(0.0, 25.0)
    curve = styled(body, front, [[500, 850, 600], [0, 0, 700], [500, -850, 600]])
    before = dense(curve, body)
    pixels = QUARTER.project(before)[0]
    right = pixels[before[:, 1] > 350.0]
    right = right[np.linspace(0, len(right) - 1, 80).astype(int)]
    over = right + np.column_stack((np.zeros(80), -8.0 * np.sin(np.linspace(0, np.pi, 80)) ** 2))
    bent = oversketch(curve, body, over, QUARTER)
    assert_sound(bent, body)
    after = dense(bent, body)
    left = before[before[:, 1] < -300.0]
    assert distances_to_polyline(left, after).max() < 1.0
    assert distances_to_polyline(before[before[:, 1] > 500.0], after).max() > 10.0


def test_from_where_the_curve_is_not_seen_it_is_refused() -> None:
    body = template_body()
    with pytest.raises(UserError, match="not seen"):
        oversketch(styled(body), body, [[300.0, 400.0], [700.0, 420.0]], view(-90.0, 10.0))


def test_random_strokes_give_sound_curves_or_are_refused() -> None:
    body, stroke = template_body(), through(QUARTER, SHOULDER)
    rng = np.random.default_rng(4)
    curve, refused = styled(body), 0
    for _ in range(8):
        first = int(rng.integers(0, 180))
        last = int(rng.integers(first + 30, 240))
        over = bulging(stroke, first, last, rng.normal(0.0, 25.0)) + rng.normal(0.0, 4.0, 2)
        try:
            curve = oversketch(curve, body, over, QUARTER)
        except UserError:
            refused += 1
            continue
        assert_sound(curve, body)
    assert refused <= 2


# -- smoothed --------------------------------------------------------------------------------------


def bending(points: Array) -> float:
    """Sum of the squared angles between steps of equal length."""
    way = np.diff(points, axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    return float((np.diff(way, axis=0) ** 2).sum())


def test_smoothing_takes_waves_out_and_keeps_the_ends() -> None:
    body, stroke = template_body(), through(QUARTER, SHOULDER)
    waves = stroke.copy()
    waves[:, 1] += 4.0 * np.sin(np.linspace(0.0, 16.0 * np.pi, len(stroke)))
    curve = StylingCurve("n1", "Waves", True, "", *project_stroke(body, waves, QUARTER))
    soft = smooth_curve(curve, body, 0.03)
    assert_sound(soft, body)
    ends = dense(soft, body)[[0, -1]] - dense(curve, body)[[0, -1]]
    assert np.abs(ends).max() < 1e-6
    own = bending(dense(styled(body), body, 200))  # that of the body
    bent = [bending(dense(each, body, 200)) - own for each in (curve, soft)]
    assert bent[1] < 0.2 * bent[0]
    off = [np.mean(distances_to_polyline(seen(c, body), stroke)) for c in (curve, soft)]
    assert off[1] < 0.4 * off[0]


def test_the_more_the_share_the_smoother() -> None:
    body = template_body()
    stroke = through(QUARTER, SHOULDER)
    stroke[:, 1] += 4.0 * np.sin(np.linspace(0.0, 12.0 * np.pi, len(stroke)))
    curve = StylingCurve("n1", "Waves", True, "", *project_stroke(body, stroke, QUARTER))
    bent = [
        bending(dense(smooth_curve(curve, body, share), body, 200)) for share in (0.005, 0.02, 0.08)
    ]
    assert bent[0] > bent[1] > bent[2]


def test_smoothing_over_creases_stays_on_the_body() -> None:
    body = template_body()
    curve = styled(body, view(30.0, 40.0), [[600, 400, 850], [1900, 350, 1300], [2500, 300, 1440]])
    for share in (0.02, 0.2):
        assert_sound(smooth_curve(curve, body, share), body)
    assert whole(curve, body).length > 1000.0


def test_there_is_nothing_to_smooth_without_patches() -> None:
    with pytest.raises(UserError, match="no part"):
        smooth_curve(StylingCurve("n1", "Empty"), template_body(), 0.02)


# -- loops -----------------------------------------------------------------------------------------


def loop(body: Body) -> tuple[StylingCurve, Array]:
    """A ring over the shut line of a door, and the stroke that it was drawn with."""
    (middle,) = QUARTER.project([[2400.0, 880.0, 600.0]])[0]
    at = np.linspace(0.0, 2.0 * np.pi, 300)
    ring = middle + np.column_stack((90.0 * np.cos(at), 45.0 * np.sin(at)))
    return StylingCurve("n1", "Loop", True, "", *project_stroke(body, ring, QUARTER)), ring


def test_a_loop_stays_closed_wherever_it_is_drawn_over() -> None:
    body = template_body()
    curve, ring = loop(body)
    assert len(curve.patches) > 1
    for first in (0, 120, 260):  # the last one goes over the place where it was begun
        part = ring[np.arange(first, first + 80) % 299].copy()
        outward = part - ring.mean(axis=0)
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        over = part + 8.0 * outward * np.sin(np.linspace(0.0, np.pi, 80))[:, None] ** 2
        bent = oversketch(curve, body, over, QUARTER)
        assert_sound(bent, body)
        ends = dense(bent, body)[[0, -1]]
        assert np.abs(ends[0] - ends[1]).max() < 1e-6
        assert np.median(distances_to_polyline(over, seen(bent, body))) < 0.6


def test_a_loop_is_handed_over_as_one() -> None:
    body = template_body()
    handed = as_curves(loop(body)[0], body.nets, body.template)
    assert [curve.closed for curve in handed] == [True, True]
    assert not as_curves(styled(body), body.nets, body.template)[0].closed


def test_what_is_left_of_a_loop_is_one_open_curve() -> None:
    body = template_body()
    curve, ring = loop(body)
    for first in (0, 120, 270):
        rubber = ring[np.arange(first, first + 60) % 299]
        (left,) = without_stretch(curve, body, rubber, QUARTER)
        assert_sound(left, body)
        assert 0.5 < whole(left, body).length / whole(curve, body).length < 0.85
        assert distances_to_polyline(rubber[20:40], seen(left, body)).min() > 9.0
