"""The scan converter: every pixel centre once, nothing outside, depth on the plane."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from bozzetto.scene.renderer.zbuffer import blank_buffer, rasterize

WIDTH, HEIGHT = 60, 40


def cover_counts(places, faces):
    """How many triangles own each pixel, each drawn alone."""
    counts = np.zeros(WIDTH * HEIGHT, int)
    for face in faces:
        buffer = blank_buffer(WIDTH, HEIGHT)
        rasterize(buffer, places, face[None])
        counts += buffer.triangle >= 0
    return counts.reshape(HEIGHT, WIDTH)


@given(st.integers(0, 10**6), st.integers(0, 40), st.booleans())
@settings(max_examples=25, deadline=None)
def test_a_triangulated_sheet_has_neither_cracks_nor_overlaps(seed, count, on_lattice):
    random = np.random.default_rng(seed)
    border = np.array([(-3.0, -3.0), (65, -2), (64, 44), (-4, 43)])
    inner = random.uniform((0, 0), (WIDTH, HEIGHT), (count, 2))
    if on_lattice:  # vertices and edges right on pixel centres
        inner = np.floor(inner) + 0.5
    points = np.unique(np.concatenate((border, inner)), axis=0)
    faces = Delaunay(points).simplices.astype(np.int32)
    faces = np.where(random.random((len(faces), 1)) < 0.5, faces, faces[:, ::-1])
    places = np.column_stack((points, random.random(len(points))))
    np.testing.assert_array_equal(cover_counts(places, faces), 1)


@given(st.floats(0, 30), st.floats(0, 20), st.floats(0.1, 29), st.floats(0.1, 19))
def test_a_rectangle_owns_the_pixel_centres_in_it(x, y, width, height):
    corners = np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)])
    places = np.column_stack((corners, np.ones(4)))
    buffer = blank_buffer(WIDTH, HEIGHT)
    rasterize(buffer, places, np.array([(0, 1, 2), (0, 2, 3)], np.int32))
    columns, rows = (np.arange(n) + 0.5 for n in (WIDTH, HEIGHT))
    inside = ((rows >= y) & (rows < y + height))[:, None] & (columns >= x) & (columns < x + width)
    np.testing.assert_array_equal(buffer.triangle.reshape(HEIGHT, WIDTH) >= 0, inside)


@given(st.integers(0, 10**6))
@settings(deadline=None)
def test_nearness_lies_on_the_plane_and_within_the_corners(seed):
    random = np.random.default_rng(seed)
    corners = random.uniform((-200, -200), (260, 240), (3, 2))
    if seed % 3 == 0:  # a sliver
        corners[2] = corners[0] + 0.37 * (corners[1] - corners[0]) + 1e-7
    near = random.uniform(-5, 5, 3)
    buffer = blank_buffer(WIDTH, HEIGHT)
    rasterize(buffer, np.column_stack((corners, near)), np.array([(0, 1, 2)], np.int32))
    drawn = np.flatnonzero(buffer.triangle >= 0)
    values = buffer.nearness[drawn]
    assert (values >= near.min() - 1e-4).all()
    assert (values <= near.max() + 1e-4).all()
    if seed % 3:
        plane = np.linalg.solve(np.column_stack((corners, np.ones(3))), near)
        row, column = np.divmod(drawn, WIDTH)
        expected = plane @ (column + 0.5, row + 0.5, np.ones(len(drawn)))
        np.testing.assert_allclose(values, expected, atol=1e-3)


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_the_order_of_drawing_does_not_matter(seed):
    random = np.random.default_rng(seed)
    count = 200
    center = random.uniform((0, 0, 0), (WIDTH, HEIGHT, 9), (count, 1, 3))
    spread = random.choice([2, 6, 20], (count, 1, 1)) * (1, 1, 0.1)
    places = (center + random.normal(0, 1, (count, 3, 3)) * spread).reshape(-1, 3)
    faces = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    plain, hinted = blank_buffer(WIDTH, HEIGHT), blank_buffer(WIDTH, HEIGHT)
    rasterize(plain, places, faces)
    rasterize(hinted, places, faces, random.random(count) < 0.5)
    np.testing.assert_array_equal(plain.nearness, hinted.nearness)
    np.testing.assert_array_equal(plain.triangle, hinted.triangle)


def test_what_is_hidden_at_its_corners_alone_is_still_seen():
    """A far sheet over the window, a near frame around its rim drawn first."""

    def quad(left, top, right, bottom, near):
        return [(left, top, near), (right, top, near), (right, bottom, near), (left, bottom, near)]

    frame = [(0, 0, 60, 16), (0, 24, 60, 40), (0, 0, 16, 40), (44, 0, 60, 40)]
    places = np.array(
        [corner for side in frame for corner in quad(*side, 5.0)] + quad(1, 1, 59, 39, 1.0)
    )
    faces = np.concatenate([np.array([(0, 1, 2), (0, 2, 3)]) + 4 * k for k in range(5)])
    buffer = blank_buffer(WIDTH, HEIGHT)
    rasterize(buffer, places, faces.astype(np.int32), np.arange(10) < 8)
    seen = buffer.nearness.reshape(HEIGHT, WIDTH)
    np.testing.assert_array_equal(seen[16:24, 16:44], 1.0)
    assert (seen == 5.0).sum() == WIDTH * HEIGHT - 8 * 28


@pytest.mark.parametrize("chunk", [1, 7])
def test_working_in_small_portions_changes_nothing(monkeypatch, chunk):
    random = np.random.default_rng(3)
    places = random.uniform((-20, -20, 0), (80, 60, 5), (60, 3))
    faces = np.arange(60, dtype=np.int32).reshape(-1, 3)
    whole, parts = blank_buffer(WIDTH, HEIGHT), blank_buffer(WIDTH, HEIGHT)
    rasterize(whole, places, faces)
    monkeypatch.setattr("bozzetto.scene.renderer.zbuffer.SPANS_AT_ONCE", chunk)
    monkeypatch.setattr("bozzetto.scene.renderer.zbuffer.FRAGMENTS_AT_ONCE", chunk)
    rasterize(parts, places, faces)
    np.testing.assert_array_equal(whole.nearness, parts.nearness)
    np.testing.assert_array_equal(whole.triangle, parts.triangle)


def test_what_is_far_outside_or_flat_draws_nothing():
    buffer = blank_buffer(WIDTH, HEIGHT)
    places = np.array(
        [(-1e12, 5, 1), (-1e9, 1e12, 1), (-1e9, -1e12, 1), (5, 5, 1), (9, 9, 1), (13, 13, 1.0)]
    )
    rasterize(buffer, places, np.array([(0, 1, 2), (3, 4, 5), (3, 3, 3)], np.int32))
    assert (buffer.triangle == -1).all()


def test_a_huge_triangle_around_the_window_fills_it():
    buffer = blank_buffer(WIDTH, HEIGHT)
    places = np.array([(-1e9, -1e9, 1), (3e9, -1e9, 1), (-1e9, 3e9, 1.0)])
    rasterize(buffer, places, np.array([(0, 1, 2)], np.int32))
    assert (buffer.triangle == 0).all()
