from __future__ import annotations

import math

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QImage, QPainter

from bozzetto_app.canvas.ribbon import ribbon_path, smoothed


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


def test_a_smooth_line_keeps_its_ends_and_has_no_corners():
    samples = [(0, 0, 1), (40, 0, 2), (40, 40, 3), (80, 40, 4)]
    line = smoothed(samples)
    assert line[0] == samples[0]
    assert line[-1] == samples[-1]
    steps = np.diff(np.array(line)[:, :2], axis=0)
    directions = steps / np.linalg.norm(steps, axis=1, keepdims=True)
    cosines = np.einsum("ij,ij->i", directions[1:], directions[:-1])
    assert cosines.min() > math.cos(math.radians(25))


def test_a_single_point_is_a_disc_and_nothing_is_nothing(cover):
    assert cover(ribbon_path([(100, 100, 20)])).sum() == pytest.approx(math.pi * 100, rel=0.02)
    assert ribbon_path([]).isEmpty()
