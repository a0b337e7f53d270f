"""Laying sheets over each other, against doing it pixel by pixel."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.scene.renderer.compositing import Sheet, blend_sheets, nearest_sheet

PIXELS = 12


def sheets_of(seed, count):
    random = np.random.default_rng(seed)
    sheets = []
    for _ in range(count):
        pixel = np.flatnonzero(random.random(PIXELS) < 0.7)
        near = random.choice([-1e5, -2.0, -1e-3, 0.0, 1e-30, 0.5, 3.0, 1e7], len(pixel))
        sheets.append(
            Sheet(
                pixel,
                (near * random.uniform(0.5, 1, len(pixel))).astype(np.float32),
                random.uniform(0, 255, (len(pixel), 3)).astype(np.float32),
                random.random(len(pixel)).astype(np.float32),
            )
        )
    return sheets


@given(st.integers(0, 10**6), st.integers(0, 6))
@settings(deadline=None)
def test_far_sheets_first_at_every_pixel(seed, count):
    sheets = sheets_of(seed, count)
    pixels = np.random.default_rng(seed).uniform(0, 1, (PIXELS, 4)).astype(np.float32)
    expected = pixels.astype(float).copy()
    for k in range(PIXELS):
        here = [
            (float(s.nearness[i]), number, s.color[i], float(s.opacity[i]))
            for number, s in enumerate(sheets)
            for i in np.flatnonzero(s.pixel == k)
        ]
        for _, _, color, alpha in sorted(here, key=lambda entry: entry[:2]):
            expected[k] = alpha * np.append(color, 1) + (1 - alpha) * expected[k]
    blend_sheets(pixels, sheets)
    np.testing.assert_allclose(pixels, expected, rtol=1e-4, atol=1e-3)


@given(st.integers(0, 10**6), st.integers(0, 6))
@settings(deadline=None)
def test_the_veil_is_the_nearest_sheet(seed, count):
    sheets = sheets_of(seed, count)
    nearness, opacity = nearest_sheet(sheets, PIXELS)
    for k in range(PIXELS):
        here = [
            (s.nearness[s.pixel == k][0], s.opacity[s.pixel == k][0])
            for s in sheets
            if k in s.pixel
        ]
        best = max((near for near, _ in here), default=-np.inf)
        assert nearness[k] == best
        assert (best, opacity[k]) in here or (not here and opacity[k] == 0)


def test_what_lies_behind_an_opaque_surface_is_left_out():
    sheet = sheets_of(3, 1)[0]
    surface = np.zeros(PIXELS, np.float32)
    kept = sheet.before(surface)
    assert (kept.nearness >= 0).all()
    assert len(kept.pixel) == (sheet.nearness >= 0).sum()
