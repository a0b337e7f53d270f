"""Thin walls, frames and plates: lines side by side that a steady hand keeps apart."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.plugins.polyhedron.graph_truth import graph_of, is_right
from tests.plugins.polyhedron.hand import SIZE, Hand, strokes_of

FLIPPED = np.array((1.0, -1.0))


def _prism(profile: list[tuple[float, float]], height: float) -> tuple[np.ndarray, list]:
    """Return the corners and edges of a profile that was extruded."""
    count = len(profile)
    ring = np.array(profile, float)
    corners = np.vstack([np.c_[ring, np.full(count, z)] for z in (0.0, height)])
    rings = [(k + i, k + (i + 1) % count) for k in (0, count) for i in range(count)]
    return corners, rings + [(i, count + i) for i in range(count)]


def _least_gap(places: np.ndarray, edges: list) -> float:
    """Return the least distance of a corner from another one, or from a line it is not on."""
    gaps = [np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(len(places), 1)]]
    for one, two in edges:
        way = places[two] - places[one]
        others = np.delete(places, (one, two), axis=0) - places[one]
        share = np.clip(others @ way / (way @ way), 0.0, 1.0)
        gaps.append(np.linalg.norm(others - share[:, None] * way, axis=1))
    return float(np.concatenate(gaps).min())


def _thin_views(count: int, first: int, least: float, most: float) -> list:
    """Return pictures of thin angles and channels of which the least gap is within bounds."""
    made = []
    for seed in range(first, first + 4000):
        chance = np.random.default_rng(seed)
        t = chance.uniform(0.02, 0.08)
        angle = [(0, 0), (1, 0), (1, t), (t, t), (t, 1), (0, 1)]
        channel = [(0, 0), (1, 0), (1, 0.8), (1 - t, 0.8), (1 - t, t), (t, t), (t, 0.8), (0, 0.8)]
        corners, edges = _prism(channel if seed % 2 else angle, 0.7)
        turned = (chance.uniform(0.0, 360.0), chance.uniform(-75.0, -30.0))
        view = Rotation.from_euler("zx", turned, degrees=True).as_matrix()
        places = (corners @ view.T)[:, :2]
        places = places / np.linalg.norm(np.ptp(places, axis=0)) * FLIPPED
        if least <= _least_gap(places, edges) < most:
            made.append((places, edges, seed))
        if len(made) == count:
            break
    return made


def _share_right(views: list, hand: Hand) -> float:
    found = [
        is_right(graph_of(strokes_of(places, edges, hand, seed)), SIZE * places + 200.0, edges)
        for places, edges, seed in views
    ]
    return float(np.mean(found))


@pytest.mark.parametrize(("least", "most", "jitter"), [(0.005, 0.008, 0.002), (0.01, 0.02, 0.004)])
def test_a_steady_hand_keeps_thin_walls_apart(least, most, jitter):
    """Lines are apart by two and a half errors of the hand at least, far under two per cent."""
    steady = Hand(jitter=jitter, wobble=0.6 * jitter, tremble=0.08 * jitter)
    views = _thin_views(10, 15001, least, most)
    assert len(views) == 10
    assert _share_right(views, steady) >= 0.8


def test_a_steady_hand_that_goes_over_its_lines_again_draws_them_once():
    hand = Hand(jitter=0.003, wobble=0.002, tremble=0.0003, retraced=0.3, split=0.1, doubled=0.5)
    views = _thin_views(10, 15002, 0.02, 0.06)
    assert len(views) == 10
    assert _share_right(views, hand) >= 0.8
