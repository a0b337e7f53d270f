"""Joined curves run smoothly, keep what they were made of, and stay symmetric."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry.spline import Spline
from bozzetto.ink import fit_spline
from bozzetto_symmetry.editing.bridge import bridge, close_with_bridge
from bozzetto_symmetry.editing.join import close_up, join_across, join_curves
from bozzetto_symmetry.editing.snap import snap_end
from bozzetto_symmetry.editing.trim import trim
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from tests.plugins.symmetry.edited_curves import (
    ACROSS,
    FLAT,
    LOOP,
    OPEN,
    PAIR,
    RAIL,
    RING,
    check,
    farthest,
    kink,
    same,
)  # fmt: skip


def turned(curve: SpaceCurve) -> SpaceCurve:
    return SpaceCurve(curve.reading, curve.spline.reversed())


@pytest.mark.parametrize("curve", [PAIR, FLAT, RAIL])
@pytest.mark.parametrize("senses", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_what_was_split_and_is_joined_is_the_curve_again(curve, senses):
    halves = [trim(curve, 0.0, 0.43), trim(curve, 0.43, 1.0)]
    halves = [h if sense == 1 else turned(h) for h, sense in zip(halves, senses, strict=True)]
    whole = join_curves(halves[0], (senses[0] + 1) // 2, halves[1], (1 - senses[1]) // 2)
    assert same(whole.spline, curve.spline) < 1e-8
    check(whole)


def test_a_curve_across_the_plane_and_what_was_cut_off_are_the_curve_again():
    middle, rest = trim(ACROSS, 0.0, 0.6), trim(ACROSS, 0.6, 1.0)
    image = SpaceCurve("pair", rest.spline.mirrored((0, 1, 0)))
    for whole in (
        join_curves(middle, 1, rest, 0),
        join_curves(rest, 0, middle, 1),
        join_curves(middle, 1, image, 0, mirrored=True),
    ):
        assert whole.reading == "self"
        assert same(whole.spline, ACROSS.spline) < 1e-8
        check(whole)


def test_both_parts_of_a_ring_are_the_ring_again():
    first, second = trim(RING, 0.0, 0.3), trim(RING, 0.3, 1.0)
    whole = join_curves(first, 1, second, 1)
    assert whole.closed
    assert same(whole.spline, RING.spline) < 1e-8
    check(whole)


def test_an_opened_loop_closes_to_what_it_was():
    whole = close_up(trim(LOOP, 0.3, 1.3))
    assert whole.closed
    assert same(whole.spline, LOOP.spline) < 1e-8


@pytest.mark.parametrize("name", OPEN)
@pytest.mark.parametrize("gap", [0.005, 0.02, 0.1])
def test_a_gap_is_bridged_without_a_kink_and_close_to_what_was_there(name, gap):
    curve = OPEN[name]
    first, second = trim(curve, 0.0, 0.5 - gap / 2), trim(curve, 0.5 + gap / 2, 1.0)
    whole = join_curves(first, 1, second, 0)
    assert kink(whole.spline) < 1e-5
    for part in (first, second):
        assert farthest(part.spline, whole.spline) < 1e-8
    assert farthest(whole.spline, curve.spline) < 5.0 * gap * curve.spline.length * gap + 1e-6
    check(whole)


def test_a_corner_is_rounded_over_a_short_stretch():
    line = np.linspace(0.0, 1.0, 4)[:, None]
    one = Spline.uniform(line * (100.0, 0.0, 0.0) - (100.0, 0.0, 0.0))
    other = Spline.uniform(line * (70.0, 70.0, 0.0))
    whole = bridge(one, other)
    assert kink(whole) < 1e-5
    away = min(np.linalg.norm(whole.sampled(2000), axis=1))
    assert 0.1 < away < 5.0
    far = np.abs(whole.sampled(500)[:, 0]) > 25.0
    assert np.abs(whole.sampled(500)[far][:, 1] * (whole.sampled(500)[far][:, 0] < 0)).max() < 1e-9


def test_a_bridge_between_ends_on_a_circle_is_the_circle():
    angle = np.linspace(0.0, np.pi, 200)
    half = np.column_stack((np.cos(angle), np.sin(angle), 0.0 * angle)) * 50.0
    spline = fit_spline(half, controls=16, pixel=0.05).spline
    ring = close_with_bridge(spline)
    radius = np.linalg.norm(ring.sampled(400), axis=1)
    assert np.abs(radius - 50.0).max() < 1.5
    assert kink(ring) < 1e-5


def test_an_end_joined_to_its_own_image_crosses_the_plane_at_a_right_angle():
    for end in (0, 1):
        whole = join_across(PAIR, end)
        assert whole.reading == "self"
        check(whole)
        assert kink(whole.spline) < 1e-5
        # The ends run along the plane, 15 and 45 mm beside it: they have to turn back.
        assert farthest(PAIR.spline, whole.spline) < 0.1 * PAIR.spline.length
        ring = join_across(whole, 1)
        assert ring.closed
        check(ring)
        assert kink(ring.spline) < 1e-5
        assert ring.spline.range == (0.0, 1.0)
        half = ring.spline.value(np.linspace(0.05, 0.45, 50))
        assert (half[:, 1] > 0).all()


def test_a_curve_that_ends_square_on_the_plane_is_not_cut_back():
    half = SpaceCurve("pair", ACROSS.spline.split(0.0)[1])
    whole = join_across(half, 0)
    assert same(whole.spline, ACROSS.spline) < 1e-8


def test_a_curve_that_falls_short_of_the_plane_is_led_on_to_it():
    short = trim(ACROSS, 0.1, 1.0)
    whole = join_across(short, 0)
    assert farthest(short.spline, whole.spline) < 1e-8
    assert same(whole.spline, ACROSS.spline) < 0.1
    check(whole)


def test_curves_in_the_plane_stay_in_it_when_they_are_closed():
    check(close_up(FLAT))
    assert close_up(FLAT).closed
    assert kink(close_up(FLAT).spline) < 1e-5


def test_joining_the_mirror_image_is_joining_the_mirrored_curve():
    other = SpaceCurve("pair", RAIL.spline.mirrored((0, 1, 0)))
    one = join_curves(PAIR, 1, RAIL, 0, mirrored=True)
    two = join_curves(PAIR, 1, other, 0)
    assert (one.spline.control_points == two.spline.control_points).all()


def test_what_cannot_be_joined_is_refused_in_words():
    with pytest.raises(UserError, match="closed curve has no end"):
        join_curves(LOOP, 0, PAIR, 1)
    with pytest.raises(UserError, match="closed curve has no end"):
        close_up(LOOP)
    with pytest.raises(UserError, match="centre plane and one beside it"):
        join_curves(FLAT, 0, PAIR, 1)
    with pytest.raises(UserError, match="its own mirror image already"):
        join_across(FLAT, 0)


def test_free_ends_that_touch_on_the_plane_become_one_crossing():
    touching = snap_end(ACROSS, 1, (60.0, 0.0, 20.0))
    ring = join_across(touching, 1)
    assert ring.closed
    check(ring)
    assert kink(ring.spline) < 1e-5
