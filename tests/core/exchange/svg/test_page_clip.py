"""Paths clipped to a page: nothing beyond it is kept, and nothing on it is lost or moved."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.exchange.svg.page_clip import clip_path
from bozzetto.exchange.svg.path_data import Subpath, ellipse, polyline

LOW, HIGH = np.array([0.0, 0.0]), np.array([120.0, 90.0])
CHORD = 0.2
"""Farthest that a cubic of these tests strays from its chords between `SHARES`, px."""
SHARES = np.linspace(0.0, 1.0, 301)


def drawn(path: Subpath) -> np.ndarray:
    """Points of a path, each cubic at the same parameters."""
    s = 1.0 - SHARES
    weights = np.stack((s**3, 3 * s * s * SHARES, 3 * s * SHARES**2, SHARES**3), 1)
    return np.concatenate([weights @ cubic for cubic in path.cubics])


def away(points: np.ndarray, paths: list[Subpath]) -> float:
    """Farthest that points lie from the lines of paths."""
    lines = [drawn(path) for path in paths]
    begin = np.concatenate([line[:-1] for line in lines])
    along = np.concatenate([line[1:] for line in lines]) - begin
    length = np.maximum((along**2).sum(1), 1e-300)
    worst = 0.0
    for point in points:
        share = np.clip(((point - begin) * along).sum(1) / length, 0.0, 1.0)
        near = begin + share[:, None] * along
        worst = max(worst, float(np.linalg.norm(near - point, axis=1).min()))
    return worst


def check(path: Subpath) -> list[Subpath]:
    kept = clip_path(path, LOW, HIGH)
    points = drawn(path)
    inside = points[((points > LOW + 1e-3) & (points < HIGH - 1e-3)).all(1)]
    for part in kept:
        line = drawn(part)
        assert (line >= LOW - 1e-6).all()
        assert (line <= HIGH + 1e-6).all()
        gaps = np.abs(part.cubics[1:, 0] - part.cubics[:-1, 3])
        assert gaps.max(initial=0.0) < 1e-9
    if len(inside):
        assert away(inside[:: max(1, len(inside) // 40)], kept) < CHORD
    for part in kept:
        assert away(drawn(part)[::30], [path]) < CHORD
    return kept


def test_what_lies_on_the_page_stays_bit_for_bit():
    ring = ellipse(complex(60.0, 45.0), complex(30.0, 20.0))
    assert clip_path(ring, LOW, HIGH) == [ring]
    assert clip_path(ring, LOW, HIGH)[0] is ring


def test_what_lies_beyond_it_goes():
    assert clip_path(ellipse(complex(300.0, 45.0), complex(30.0, 20.0)), LOW, HIGH) == []
    around = polyline(np.array([[-9.0, -9], [200, -9], [200, 200], [-9, 200]]), closed=True)
    assert clip_path(around, LOW, HIGH) == []


def test_a_line_across_is_cut_at_the_borders():
    (part,) = clip_path(polyline(np.array([[-1e7, 45.0], [1e7, 45.0]]), closed=False), LOW, HIGH)
    np.testing.assert_allclose(part.cubics[0, [0, 3]], [[0, 45], [120, 45]], atol=1e-6)


def test_a_ring_over_a_corner_stays_one_stretch():
    """Also where the ring begins on the page, so that its first and last piece belong together."""
    ring = ellipse(complex(110.0, 45.0), complex(30.0, 20.0))
    (part,) = check(ring)
    assert not part.closed
    turned = Subpath(np.roll(ring.cubics, 2, axis=0), True)
    (again,) = check(turned)
    assert np.ptp(drawn(again), axis=0) == pytest.approx(np.ptp(drawn(part), axis=0))


def test_a_wave_over_the_border_falls_into_parts():
    x = np.linspace(5, 115, 12)
    wave = polyline(np.column_stack((x, np.where(np.arange(12) % 2, -20.0, 20.0))), closed=False)
    assert len(check(wave)) == 6


FAR = st.floats(-400, 500, allow_nan=False)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(FAR, FAR), min_size=4, max_size=4))
def test_any_cubic_is_cut_exactly(corners):
    check(Subpath(np.array(corners)[None], False))


def test_of_a_circle_of_kilometres_its_bow_on_the_page_stays():
    (bow,) = clip_path(ellipse(complex(60.0, 1e7 + 40.0), complex(1e7, 1e7)), LOW, HIGH)
    np.testing.assert_allclose(drawn(bow)[:, 1], 40.0, atol=0.01)
    assert np.ptp(drawn(bow)[:, 0]) == pytest.approx(120.0, abs=0.01)
