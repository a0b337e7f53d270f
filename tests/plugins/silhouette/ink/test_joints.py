"""Outlines that close nearly: smooth where the hand was, sharp where it drew a corner."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes
from tests.plugins.silhouette.ink.hand_drawn import SIZE, ellipse, polygon, turns, with_fold

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
