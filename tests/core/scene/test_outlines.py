"""Convex outlines against counting places."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.scene.renderer.clipping import crossed, cut, cut_to_window


def convex(seed, corners=5, size=20.0):
    random = np.random.default_rng(seed)
    angle = np.sort(random.uniform(0, 2 * np.pi, corners))
    return random.uniform(-5, 25, 2) + size * np.column_stack((np.cos(angle), np.sin(angle)))


def holds(outline, places):
    """Which places are in a convex outline that turns to the left."""
    inside = np.full(len(places), len(outline) > 2)
    for a, b in zip(outline, np.roll(outline, -1, 0), strict=True):
        side, away = b - a, places - a
        inside &= side[0] * away[:, 1] - side[1] * away[:, 0] >= 0
    return inside


@given(st.integers(0, 10**6))
@settings(deadline=None, max_examples=60)
def test_what_is_cut_is_what_is_on_the_right_side(seed):
    random = np.random.default_rng(seed)
    outline = convex(seed)
    normal, least = random.normal(size=2), random.normal(0, 10)
    places = random.uniform(-30, 50, (2000, 2))
    expected = holds(outline, places) & (places @ normal >= least)
    agree = holds(cut(outline, normal, least), places) == expected
    assert agree.mean() > 0.999, "but for rounding on the border"


@given(st.integers(0, 10**6))
@settings(deadline=None, max_examples=60)
def test_in_a_window_nothing_is_lost(seed):
    outline = convex(seed)
    places = np.random.default_rng(seed).uniform(0, (30, 20), (2000, 2))
    agree = holds(cut_to_window(outline, 30, 20), places) == holds(outline, places)
    assert agree.mean() > 0.999


def test_beside_the_window_nothing_is_left():
    assert not len(cut_to_window(convex(1) + 500, 30, 20))
    assert not len(cut(np.zeros((0, 3)), (0, 0, 1), 0.0))


@given(st.integers(0, 10**6))
@settings(deadline=None, max_examples=60)
def test_every_pixel_on_the_outline_is_found_once(seed):
    outline = convex(seed, corners=3 + seed % 4, size=10.0 ** (seed % 5 - 2))
    cells = crossed(outline)
    t = np.linspace(0, 1, 3001)[:, None]
    along = [a + t * (b - a) for a, b in zip(outline, np.roll(outline, -1, 0), strict=True)]
    needed = np.unique(np.floor(np.concatenate(along)).astype(int), axis=0)
    found = set(map(tuple, cells.tolist()))
    assert len(found) == len(cells)
    assert found >= set(map(tuple, needed.tolist()))
    length = sum(float(np.linalg.norm(piece[-1] - piece[0])) for piece in along)
    assert len(cells) <= 3 * (length + 2 * len(outline)), "only those near the outline"
