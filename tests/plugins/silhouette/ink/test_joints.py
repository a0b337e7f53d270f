"""Outlines that close nearly: smooth where the hand was, sharp where it drew a corner."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from bozzetto.ink import resample
from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes
from tests.plugins.silhouette.ink.hand_drawn import (
    SIZE,
    by_a_fast_pen,
    ellipse,
    polygon,
    turning,
    turns,
    with_fold,
    with_folded_end,
)

SQUARE = np.array(((0.0, 0.0), (300.0, 0.0), (300.0, 260.0), (0.0, 260.0)))
TRIANGLE = np.array(((0.0, 0.0), (300.0, 40.0), (120.0, 260.0)))


def ring_of(*lines):
    (ring,) = rings_from_strokes(lines)
    return ring


@pytest.mark.parametrize("tremor", [0.0, 0.3, 1.0])
def test_an_ellipse_has_no_corner_where_its_ends_meet(tremor):
    sharpest = [
        turns(ring_of(ellipse(np.random.default_rng(seed), tremor)))[0].max()
        for seed in range(61_000, 61_040)
    ]
    assert max(sharpest) < 30.0
    assert np.median(sharpest) < 10.0


def test_a_fold_in_the_ink_leaves_none_either():
    for seed in range(62_000, 62_040):
        random = np.random.default_rng(seed)
        assert turns(ring_of(with_fold(random, ellipse(random, 0.5))))[0].max() < 30.0


@pytest.mark.parametrize("start", [False, True])
def test_an_end_that_goes_back_over_the_ink_leaves_none_either(start):
    for seed in range(68_000, 68_040):
        random = np.random.default_rng(seed)
        line = with_folded_end(random, ellipse(random, 0.3), start=start)
        assert turns(ring_of(line))[0].max() < 30.0


def test_a_thin_limb_is_no_fold_in_the_ink():
    """Its sides run closer than those of a fold may, and strokes meet on one of them."""
    limb = np.array(((120.0, 0.0), (120.0, 90.0), (123.0, 90.0), (123.0, 0.0), (300.0, 0.0)))
    body = np.array(((300.0, 0.0), (300.0, -200.0), (0.0, -200.0), (0.0, 0.0), (120.0, 0.0)))
    outline = np.vstack((limb, body[1:]))
    for first in (80.0, 85.0):  # begins on the left side of the limb, goes round its tip
        one = resample(np.vstack(((120.0, first), outline[1:-1])), spacing=3.0)
        other = resample(np.array(((0.0, 0.0), (120.0, 0.0), (120.0, first))), spacing=3.0)
        ring = ring_of(one, other)
        assert ring[:, 1].max() > 87.0
        assert shapely.Polygon(ring).area == pytest.approx(60_270.0, rel=0.01)


@pytest.mark.parametrize(("spacing", "jitter"), [(3.0, 0.5), (7.0, 1.4)])
def test_ink_of_few_samples_is_calm(spacing, jitter):
    """The same in shares of the size as 1 px of 600 at 6 px, and as 3 px at 14 px."""
    unrest, sharpest = [], []
    for seed in range(69_000, 69_030):
        random = np.random.default_rng(seed)
        ring = ring_of(by_a_fast_pen(random, ellipse(random, 0.0), spacing, jitter))
        unrest.append(turning(ring))
        sharpest.append(turns(ring)[0].max())
    assert np.median(unrest) < 1.5
    assert np.median(sharpest) < 20.0
    assert np.mean(np.array(sharpest) > 30.0) <= 0.1


@pytest.mark.parametrize("spacing", [12.0, 18.0, 24.0])
def test_a_small_shape_closes_without_a_fold(spacing):
    """Thirty samples, as an eye has that is drawn 30 px long: hardly one lies in the joint."""
    sharpest = []
    for seed in range(75_000, 75_060):
        random = np.random.default_rng(seed)
        line = by_a_fast_pen(random, ellipse(random, 0.0), spacing, 1.0)
        drift = random.normal(0.0, 6.0, 2) * np.linspace(0.0, 1.0, len(line))[:, None]
        sharpest.append(turns(ring_of(line + drift))[0].max())
    assert max(sharpest) < 65.0
    assert np.mean(np.array(sharpest) > 30.0) <= 0.1


@pytest.mark.parametrize("first", range(4))
def test_the_missing_side_between_two_sharp_corners_stays(first):
    """It goes back against both, as the end of ink does that ran on beside its start."""
    angle = np.pi * np.arange(16) / 8
    radius = np.where(np.arange(16) % 2, 45.0, 150.0)
    star = radius[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    bolt = np.array(
        ((60, 200), (0, 90), (50, 100), (20, 0), (110, 120), (60, 110), (110, 200)), float
    )
    for corners in (star, resample(bolt, spacing=30.0, closed=True), bolt):
        corners = np.roll(corners, first, axis=0)
        assert shapely.Polygon(ring_of(corners)).area == pytest.approx(
            shapely.Polygon(corners).area, rel=1e-12
        )


@pytest.mark.parametrize("samples", [32, 45, 60])
def test_a_hasty_circle_has_no_facets(samples):
    angle = 2.0 * np.pi * (np.arange(samples) + 0.3) / samples
    line = 150.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    ring = ring_of(line)
    assert np.abs(np.hypot(*ring.T) - 150.0).max() < 0.1
    assert turns(ring)[0].max() < 2.0


@pytest.mark.parametrize("sides", [3, 6, 12, 24])
def test_regular_polygons_keep_their_sides(sides):
    angle = 2.0 * np.pi * np.arange(sides) / sides
    corners = 150.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    assert shapely.Polygon(ring_of(corners)).area == pytest.approx(
        shapely.Polygon(corners).area, rel=1e-12
    )


def test_a_corner_in_hasty_ink_stays():
    """A drop: three quarters of a circle and two tangents to its tip."""
    angle = np.linspace(0.75 * np.pi, -0.75 * np.pi, 24)
    arc = 100.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    tip = np.array((-100.0 * np.sqrt(2.0), 0.0))
    sides = [
        a + (b - a) * np.linspace(0.0, 1.0, 6)[:, None] for a, b in ((arc[-1], tip), (tip, arc[0]))
    ]
    ring = ring_of(np.vstack((arc, sides[0][1:], sides[1][1:-1])))
    assert np.hypot(*(ring - tip).T).min() < 0.5
    turn, places = turns(ring)
    assert turn[np.hypot(*(places - tip).T) < 8.0].max() > 45.0
    assert turn[np.hypot(*(places - tip).T) > 12.0].max() < 6.0


def test_cogs_of_few_vertices_are_no_jitter():
    angle = 2.0 * np.pi * np.arange(72) / 72
    radius = 150.0 - 9.0 * (np.arange(72) % 2)
    cogs = np.column_stack((radius * np.cos(angle), radius * np.sin(angle)))
    assert turning(ring_of(cogs)) > 0.8 * turning(cogs)


@pytest.mark.parametrize("corners", [SQUARE, TRIANGLE])
def test_the_corner_at_which_a_stroke_begins_stays(corners):
    angles, misses = [], []
    for seed in range(63_000, 63_030):
        line, true = polygon(np.random.default_rng(seed), corners, 0.5)
        ring = ring_of(line)
        turn, places = turns(ring)
        near = np.hypot(*(places - true[0]).T) < 22.0
        angles.append(turn[near].max())
        misses.append(np.hypot(*(ring - true[0]).T).min())
    assert np.median(angles) > 70.0
    assert min(angles) > 30.0
    assert np.median(misses) < 0.01 * SIZE


def test_ellipses_of_two_strokes_are_smooth_at_both_joints():
    for seed in range(64_000, 64_020):
        line = ellipse(np.random.default_rng(seed), 0.3)
        half = len(line) // 2
        ring = ring_of(line[: half + 3], line[half - 2 :][::-1] + np.array((0.8, -0.8)))
        assert turns(ring)[0].max() < 30.0


def test_the_other_way_round_is_the_same_outline():
    for seed in range(65_000, 65_010):
        line = ellipse(np.random.default_rng(seed), 0.3)
        one, other = ring_of(line), ring_of(line[::-1])
        far = np.hypot(*(one[:, None] - other[None]).transpose(2, 0, 1))
        assert max(far.min(axis=0).max(), far.min(axis=1).max()) < 0.01 * SIZE


def test_the_unit_does_not_matter():
    line = ellipse(np.random.default_rng(66_000), 0.3)
    np.testing.assert_allclose(ring_of(1000.0 * line), 1000.0 * ring_of(line), atol=1e-6 * SIZE)


def test_the_ink_away_from_the_joint_stays():
    line = ellipse(np.random.default_rng(67_000), 0.0)
    ring = ring_of(line)
    middle = line[len(line) // 4 : -len(line) // 4]
    far = np.hypot(*(middle[:, None] - ring[None]).transpose(2, 0, 1)).min(axis=1)
    assert far.max() < 0.5
