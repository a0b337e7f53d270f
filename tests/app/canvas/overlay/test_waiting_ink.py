"""Ink with which something is wrong, as the sheet shows it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtGui import QImage, QPainter

from bozzetto.document.waiting_ink import WaitingStroke
from bozzetto.ink.stroke import Stroke
from bozzetto.scene import DARK, LIGHT
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import orbit, pan, zoom
from bozzetto_app.canvas.overlay.waiting_ink import FARTHEST_SHOWN, MarkedLine

CAMERA = Camera()
LINE = WaitingStroke(
    Stroke(np.linspace(100, 300, 60), np.full(60, 200.0), CAMERA),
    "m",
    "t",
    "refused",
    "No.",
    ((150.0, 100.0),),
)


def painted(line, palette=LIGHT):
    """Pixels (y, x, rgb) of a sheet with a line on it."""
    image = QImage(400, 300, QImage.Format.Format_RGB888)
    image.fill(0 if palette is DARK else 0xFFFFFF)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    line.paint(painter, palette)
    painter.end()
    rows = np.frombuffer(image.constBits(), np.uint8).reshape(300, image.bytesPerLine())
    return rows[:, : 3 * 400].reshape(300, 400, 3).astype(int)


@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
def test_the_line_is_dashed_over_a_halo_with_its_wrong_place_lit(palette):
    pixels = painted(MarkedLine.of(LINE, CAMERA, is_lit=True), palette)
    along = pixels[200, 110:290]
    is_ink = np.abs(along - np.array(palette.ink)).max(1) < 60
    changes = int(np.abs(np.diff(is_ink.astype(int))).sum())
    assert 0.4 < is_ink.mean() < 0.8
    assert changes > 10
    empty = pixels[250, 200]
    halo = pixels[205, 200]
    toward = np.array(palette.warning) - empty
    share = float((halo - empty) @ toward / (toward @ toward))
    assert 0.15 < share < 0.5
    assert np.abs(halo - (empty + share * toward)).max() < 8
    assert np.abs(pixels[90, 150] - np.array(palette.warning)).max() < 40  # the ring
    assert (pixels[100, 200] == empty).all()


def test_what_another_tool_has_marked_is_quiet():
    pixels = painted(MarkedLine.of(LINE, CAMERA, is_lit=False))
    assert (pixels[207, 110:290] == 255).all()
    assert (pixels[90:112, 138:162] == 255).all()
    darkest = pixels[200, 110:290].min()
    assert 100 < darkest < 200


def test_line_and_places_follow_the_view():
    line = MarkedLine.of(LINE, pan(CAMERA, 50.0, 20.0), is_lit=True)
    np.testing.assert_allclose(line.points, LINE.stroke.points + np.array((50.0, 20.0)), atol=0.5)
    np.testing.assert_allclose(line.places, [(200.0, 120.0)], atol=0.5)


@pytest.mark.parametrize("factor", [1e3, 1e6, 1e9])
def test_extreme_views_reach_no_impossible_place(factor):
    camera = zoom(orbit(CAMERA, 40.0, 20.0, (0.0, 0.0, 0.0)), factor)
    line = MarkedLine.of(LINE, camera, is_lit=True)
    for piece in line.pieces():
        assert np.isfinite(piece).all()
        assert np.abs(piece).max() <= FARTHEST_SHOWN
    assert len(line.places) <= 1
    painted(line)


def test_a_dot_and_a_line_of_which_nothing_is_near_are_painted_without_fault():
    dot = replace(LINE, stroke=Stroke([50], [60], CAMERA), places=())
    assert (painted(MarkedLine.of(dot, CAMERA, is_lit=True))[60, 50] != 255).any()
    far = replace(LINE, stroke=Stroke([1e7, 2e7], [1e7, 1e7], CAMERA), places=((1e8, 0.0),))
    line = MarkedLine.of(far, CAMERA, is_lit=True)
    assert list(line.pieces()) == []
    assert len(line.places) == 0
