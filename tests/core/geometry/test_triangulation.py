"""Triangles of rings: they fill the area, count as Euler says, and keep every vertex."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.geometry import ring_links, triangulate
from bozzetto.ink import signed_area


def ring(count, radius=10.0, seed=None, center=(0.0, 0.0)):
    """A star-shaped ring."""
    angle = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
    size = radius if seed is None else radius * np.random.default_rng(seed).uniform(0.5, 1.0, count)
    return np.column_stack((size * np.cos(angle), size * np.sin(angle))) + center


def areas(made):
    a, b, c = np.moveaxis(made.points[made.triangles], 1, 0)
    return 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


@given(st.integers(0, 10**6), st.integers(3, 80), st.integers(0, 3))
@settings(max_examples=30, deadline=None)
def test_the_area_is_filled_once_with_the_triangles_that_euler_counts(seed, count, holes):
    outer = ring(count + 20, 10.0, seed)
    inner = tuple(
        ring(12, 1.0, seed + k, (2.0 * np.cos(2 * k), 2.0 * np.sin(2 * k))) for k in range(holes)
    )
    made = triangulate(outer, inner)
    expected = abs(signed_area(outer)) - sum(abs(signed_area(hole)) for hole in inner)
    assert areas(made).sum() == pytest.approx(expected, rel=1e-9)
    np.testing.assert_array_equal(made.points, np.concatenate((outer, *inner)))
    vertices = len(made.points)
    assert len(made.triangles) == vertices + 2 * holes - 2
    assert len(made.chords) == vertices + 3 * holes - 3
    for chord, pair in zip(made.chords, made.across, strict=True):
        for triangle in pair:
            assert set(chord.tolist()) <= set(made.triangles[triangle].tolist())


def test_rings_that_cross_are_refused():
    with pytest.raises(ValueError, match="cross"):
        triangulate(np.array([(0, 0), (2, 2), (2, 0), (0, 2)], float))


def test_rings_are_linked_one_by_one():
    after, before = ring_links([3, 4])
    assert after.tolist() == [1, 2, 0, 4, 5, 6, 3]
    np.testing.assert_array_equal(after[before], np.arange(7))
