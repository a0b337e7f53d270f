from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QImage, QPainter

from bozzetto_app.canvas.overlay.ribbon import CORNER, SAME_PLACE, ribbon_path, smoothed


@pytest.fixture
def cover(qapp):
    """Coverage 0 … 1 of paths filled one after the other, shape (200, 200)."""

    def paint(*paths):
        image = QImage(200, 200, QImage.Format.Format_Grayscale8)
        image.fill(0)
        painter = QPainter(image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor("white"))
        for path in paths:
            painter.drawPath(path)
        painter.end()
        rows = np.frombuffer(image.constBits(), np.uint8).reshape(200, image.bytesPerLine())
        return rows[:, :200] / 255.0

    return paint


def circle(radius, width, count=120):
    return [
        (100 + radius * math.cos(a), 100 + radius * math.sin(a), width)
        for a in np.linspace(0, 2 * math.pi, count)
    ]


def test_a_straight_ribbon_has_the_area_of_a_capsule(cover):
    area = cover(ribbon_path([(50.3, 60.7, 8), (150.3, 60.7, 8)])).sum()
    assert area == pytest.approx(100 * 8 + math.pi * 16, rel=0.01)


def test_a_ring_has_the_area_of_an_annulus(cover):
    area = cover(ribbon_path(circle(60, 6))).sum()
    assert area == pytest.approx(math.pi * (63**2 - 57**2), rel=0.02)


def test_width_follows_the_points(cover):
    wedge = cover(ribbon_path([(20, 100, 2), (180, 100, 22)]))
    assert wedge[:, 60].sum() == pytest.approx(2 + 20 * 40 / 160, abs=0.3)
    assert wedge[:, 140].sum() == pytest.approx(2 + 20 * 120 / 160, abs=0.3)


def test_joints_between_ribbons_leave_neither_gap_nor_bead(cover):
    line = smoothed(circle(70, 5))
    whole = cover(ribbon_path(line))
    parts, begin = [], 0
    while begin < len(line) - 1:
        end = min(begin + 20, len(line) - 1)
        parts.append(
            ribbon_path(line[begin : end + 1], open_start=begin > 0, open_end=end < len(line) - 1)
        )
        begin = end
    assert len(parts) > 3
    assert np.abs(cover(*parts) - whole).max() < 0.35
    assert np.abs(cover(*parts) - whole).sum() < 0.004 * whole.sum()


def test_a_sharp_turn_has_no_hole_and_no_spike(cover):
    hook = cover(ribbon_path([(40, 100, 10), (140, 100, 10), (42, 108, 10)]))
    assert hook[100, 60:140].min() > 0.99
    assert hook[:, 147:].sum() == 0  # a mitre would reach far beyond the corner


PIXELS = st.integers(-60, 60).map(lambda n: 0.5 * n)
STROKES = st.lists(st.tuples(PIXELS, PIXELS, st.floats(1.0, 5.0)), min_size=1, max_size=40)


def distance_to_line(places, line):
    """Distance of every place (n, 2) to a chain of straight pieces (m, 2)."""
    places, line = np.asarray(places, float), np.asarray(line, float)
    if len(line) == 1:
        return np.linalg.norm(places - line, axis=1)
    begin, way = line[:-1], np.diff(line, axis=0)
    length = np.maximum((way**2).sum(1), 1e-12)
    off = places[:, None] - begin
    share = np.clip((off * way).sum(2) / length, 0.0, 1.0)
    return np.linalg.norm(off - share[..., None] * way, axis=2).min(1)


@given(STROKES)
def test_what_is_shown_is_what_is_kept(samples):
    """The line stays within a pixel of the straight pieces between the samples, and they of it."""
    kept, shown = np.array(samples)[:, :2], np.array(smoothed(samples))[:, :2]
    assert distance_to_line(shown, kept).max() <= 0.5 * CORNER + 1e-9
    assert distance_to_line(kept, shown).max() <= 0.5 * CORNER + SAME_PLACE
    np.testing.assert_allclose(shown[[0, -1]], kept[[0, -1]], atol=SAME_PLACE)


def test_a_sparse_stroke_looks_sparse():
    square = [(0, 0, 4), (100, 0, 4), (100, 100, 4), (0, 100, 4), (0, 0, 4)]
    shown = np.array(smoothed(square))
    assert distance_to_line([(50, 0), (100, 50), (50, 100)], shown[:, :2]).max() < 1e-9
    assert distance_to_line([(100, 0), (100, 100), (0, 100)], shown[:, :2]).max() <= 0.5 * CORNER


def test_a_dense_stroke_has_no_corners_even_where_samples_are_whole_pixels():
    samples = [(round(x), round(y), width) for x, y, width in circle(60, 4, 250)]
    steps = np.diff(np.array(smoothed(samples))[:, :2], axis=0)
    steps = steps[np.linalg.norm(steps, axis=1) > SAME_PLACE]
    turns = np.degrees(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))))
    raw = np.diff(np.array(samples)[:, :2], axis=0)
    raw = raw[np.linalg.norm(raw, axis=1) > 0]
    jags = np.degrees(np.diff(np.unwrap(np.arctan2(raw[:, 1], raw[:, 0]))))
    assert np.abs(turns).max() < 0.8 * np.abs(jags).max()
    assert np.abs(turns).max() < 50.0


def test_widths_change_evenly_between_samples():
    line = smoothed([(0, 0, 1), (40, 0, 3), (80, 0, 5)])
    assert [width for _, _, width in line] == sorted(width for _, _, width in line)
    assert {line[0][2], line[-1][2]} == {1, 5}


def test_a_single_point_is_a_disc_and_nothing_is_nothing(cover):
    assert cover(ribbon_path([(100, 100, 20)])).sum() == pytest.approx(math.pi * 100, rel=0.02)
    assert ribbon_path([]).isEmpty()
