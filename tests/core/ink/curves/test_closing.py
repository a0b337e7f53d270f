"""Closing: on circles whose joint is known, and on outlines drawn by (simulated) hand."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bozzetto.ink.curves.closing import close_stroke, end_gap, is_closed_gesture, signed_area
from bozzetto.ink.curves.intersections import self_crossings

DRAWN = sorted((Path(__file__).parents[5] / "shared/data/silhouettes/ink").glob("*.json"))


def arc(begin, end, radius=100.0, count=300):
    angle = np.radians(np.linspace(begin, end, count))
    return radius * np.column_stack((np.cos(angle), np.sin(angle)))


def spiral(turns, growth=0.0):
    angle = np.linspace(0, 2 * np.pi * turns, 400)
    radius = 100 + growth * angle
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle)))


def test_area_has_the_sign_of_the_turn():
    square = [[0, 0], [2, 0], [2, 3], [0, 3]]
    assert signed_area(square) == 6
    assert signed_area(square[::-1]) == -6
    assert signed_area([*square, square[0]]) == 6
    assert signed_area(np.asarray(square) + 1e6) == pytest.approx(6)
    assert signed_area([[0, 0], [1, 1]]) == 0


@pytest.mark.parametrize("gap", [2, 10, 20])
def test_a_gap_is_bridged_and_nothing_is_lost(gap):
    stroke = arc(0, 360 - gap)
    loop = close_stroke(stroke)
    assert is_closed_gesture(stroke)
    np.testing.assert_array_equal(loop, stroke)


@pytest.mark.parametrize("extra", [3, 15, 30])
@pytest.mark.parametrize("growth", [0.0, 0.4, -0.4])
def test_an_overlap_is_trimmed(extra, growth):
    stroke = spiral(1 + extra / 360, growth)
    loop = close_stroke(stroke)
    assert is_closed_gesture(stroke)
    assert len(self_crossings(loop, closed=True)) == 0
    assert abs(abs(signed_area(loop)) / (np.pi * 100**2) - 1) < 0.05
    assert end_gap(loop) < 0.03


def test_ends_that_cross_are_cut_at_the_crossing():
    stroke = np.vstack(([[0.0, -20]], [[0, 0], [0, 100], [100, 100], [100, 0], [-20, 0]]))
    loop = close_stroke(stroke)
    np.testing.assert_allclose(
        np.sort(loop, axis=0), np.sort([[0, 0], [0, 100], [100, 100], [100, 0]], axis=0), atol=1e-9
    )


def test_a_hook_at_the_end_is_cut_off():
    body = arc(0, 359)
    hook = body[-1] + np.outer(np.linspace(0.2, 1, 5), (8.0, 6.0))
    loop = close_stroke(np.vstack((body, hook)))
    assert np.linalg.norm(loop, axis=1).max() < 103


@pytest.mark.parametrize(
    "stroke",
    [
        [[0.0, 0]],
        [[0.0, 0], [0, 0]],
        [[0.0, 0], [100, 0]],
        np.vstack((np.linspace((0, 0), (100, 0), 50), np.linspace((100, 1), (0, 1), 50))),
        arc(0, 180),
        arc(0, 270),
    ],
    ids=["dot", "rest", "line", "there and back", "half circle", "three quarters"],
)
def test_what_is_no_outline(stroke):
    assert not is_closed_gesture(stroke)


def test_neither_scale_nor_direction_nor_start_matters_much():
    rng = np.random.default_rng(2)
    blob = arc(0, 352) * (1 + 0.3 * np.sin(np.radians(np.linspace(0, 352, 300)) * 3))[:, None]
    blob += rng.normal(0, 0.3, blob.shape)
    for shape in (blob, blob[::-1], blob * 1e-3, blob * 1e5 + 1e6):
        assert is_closed_gesture(shape)


@pytest.mark.skipif(not DRAWN, reason="the drawn outlines are not here")
def test_outlines_drawn_in_one_stroke_are_seen_as_closed():
    single = 0
    for path in DRAWN:
        strokes = json.loads(path.read_text())["strokes"]
        if len(strokes) == 1:
            single += 1
            stroke = np.column_stack((strokes[0]["x"], strokes[0]["y"]))
            assert is_closed_gesture(stroke), path.stem
    assert single >= 8


def test_the_cheapest_crossing_is_found_among_many():
    """Against the plain way: one crossing after the other."""
    from bozzetto.ink.curves.closing import END_SHARE, SEARCH_POINTS, TRIM_COST, best_joint
    from bozzetto.ink.curves.intersections import self_crossings
    from bozzetto.ink.curves.resample import arc_length

    assert SEARCH_POINTS > 1
    rng = np.random.default_rng(3)
    for _ in range(20):
        place = rng.uniform(0.0, 100.0, (40, 2))
        along = arc_length(place)
        length = float(along[-1])
        begin, end = best_joint(place, along, length)
        met = self_crossings(place)
        at = np.interp(met.first, np.arange(len(place)), along)
        to = np.interp(met.second, np.arange(len(place)), along)
        good = (at <= END_SHARE * length) & (to >= length - END_SHARE * length)
        trimmed = TRIM_COST * (at + length - to)[good]
        taken = TRIM_COST * (begin + length - end)
        ends = np.array([np.interp((begin, end), along, column) for column in place.T])
        cost = taken + float(np.linalg.norm(ends[:, 0] - ends[:, 1]))
        assert cost <= min(trimmed, default=np.inf) + 1e-9
