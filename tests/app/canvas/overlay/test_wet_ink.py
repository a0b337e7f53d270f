from __future__ import annotations

import math

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QImage, QRegion

from bozzetto.ink.checked_points import seen_through
from bozzetto.ink.stroke import Stroke
from bozzetto.scene import DARK, LIGHT
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import pan, zoom
from bozzetto_app.canvas.overlay import wet_ink
from bozzetto_app.canvas.overlay.ribbon import smoothed
from bozzetto_app.canvas.overlay.wet_ink import InkOverlay
from tests.app.seen import darkness


@pytest.fixture
def overlay(qtbot):
    made = InkOverlay()
    qtbot.addWidget(made)
    made.resize(600, 400)
    made.show()
    return made


def spiral(count):
    return [
        (
            300 + (20 + 0.03 * i) * math.cos(0.05 * i),
            200 + (20 + 0.03 * i) * math.sin(0.05 * i),
            0.5,
        )
        for i in range(count)
    ]


def test_the_area_painted_for_a_sample_does_not_grow_with_the_stroke(overlay):
    overlay.begin()
    areas = []
    for sample in spiral(5000):
        dirty = overlay.extend([sample])
        areas.append(dirty.width() * dirty.height())
    early, late = areas[200:400], areas[-200:]
    # the spiral opens, so steps get longer by a factor of 5; the stroke by a factor of 16
    assert np.median(late) < 8 * np.median(early)
    assert np.median(late) < 0.02 * 600 * 400


def test_ink_is_where_the_pen_was(overlay):
    overlay.begin()
    overlay.extend([(x, 100.0, 0.8) for x in range(100, 500, 4)])
    dark = darkness(overlay)
    assert dark[100, 110:490].min() > 0.7
    assert dark[:90].max() == 0
    assert dark[110:].max() == 0


def test_pressing_harder_draws_wider(overlay):
    widths = []
    for pressure in (0.1, 0.5, 1.0):
        overlay.begin()
        overlay.extend([(x, 200.0, pressure) for x in range(100, 300, 5)])
        widths.append(darkness(overlay)[:, 200].sum())
    assert widths[0] < 0.6 * widths[1] < 0.6 * widths[2]


def test_one_predicted_segment_that_vanishes(overlay, qtbot):
    overlay.begin()
    overlay.extend([(100 + 10 * i, 100, 0.5) for i in range(10)])
    x, y = overlay.prediction
    assert (x, y) == pytest.approx((200, 100))
    ahead = darkness(overlay)[100, 195]
    behind = darkness(overlay)[100, 150]
    assert 0 < ahead < 0.6 * behind
    qtbot.waitUntil(lambda: overlay.prediction is None, timeout=1000)
    assert darkness(overlay)[100, 195] == 0
    assert darkness(overlay)[100, 150] == pytest.approx(behind)


def test_a_prediction_is_never_kept(overlay):
    overlay.begin()
    overlay.extend([(100 + 10 * i, 100, 0.5) for i in range(60)])
    overlay.extend([(690 - 10 * i, 100 + 10 * i, 0.5) for i in range(1, 28)])
    dark = darkness(overlay)
    # beyond the turn at (690, 100), outside of the sheet; and below it nothing stays
    assert dark[90, :].max() == 0
    assert dark[200:, 100:300].max() == 0


def test_a_stroke_taken_away_leaves_nothing(overlay):
    overlay.begin()
    overlay.extend(spiral(800))
    assert darkness(overlay).sum() > 100
    overlay.clear_wet()
    assert darkness(overlay).sum() == 0
    assert not overlay.has_wet_ink


def test_a_resize_keeps_the_stroke(overlay):
    overlay.begin()
    overlay.extend([(x, 100.0, 0.8) for x in range(100, 500, 4)])
    before = darkness(overlay)
    overlay.resize(700, 500)
    after = darkness(overlay)[:400, :600]
    assert np.abs(after - before).max() < 0.4
    assert after.sum() == pytest.approx(before.sum(), rel=0.01)


def stroke(camera):
    x = np.linspace(200, 400, 60)
    return Stroke(x, 200 + 30 * np.sin(x / 20), camera, pressure=np.full(60, 0.7))


def test_pending_ink_stays_dark_and_follows_the_view(overlay):
    camera = Camera(viewport=(600, 400))
    overlay.set_pending([stroke(camera)], camera)
    still = darkness(overlay)
    assert still.sum() > 100
    overlay.set_pending([stroke(camera)], pan(camera, 50, 20))
    moved = darkness(overlay)
    assert np.abs(np.roll(still, (20, 50), (0, 1)) - moved).max() < 0.15
    overlay.set_pending([], camera)
    assert darkness(overlay).sum() == 0


def test_a_further_stroke_that_waits_costs_no_more_than_the_first(overlay, monkeypatch):
    """Each lift shows all that waits: thirty quick strokes held the window for a second."""
    camera = Camera(viewport=(600, 400))
    strokes, made = [stroke(camera) for _ in range(6)], []
    monkeypatch.setattr(wet_ink, "smoothed", lambda line: made.append(0) or smoothed(line))
    for count in range(1, 7):
        overlay.set_pending(strokes[:count], camera)
    assert len(made) == 6
    by_and_by = darkness(overlay)
    overlay.set_pending([], camera)
    overlay.set_pending(strokes, camera)
    np.testing.assert_array_equal(darkness(overlay), by_and_by)
    overlay.set_pending(strokes[1:3], camera)
    made.clear()
    overlay.set_pending(strokes[1:4], camera)
    assert len(made) == 1
    overlay.set_pending(strokes[1:4], pan(camera, 50, 20))
    assert len(made) == 4


def test_ink_lies_on_the_sheet_of_its_own_camera():
    camera = Camera(viewport=(600, 400))
    drawn = stroke(camera)
    np.testing.assert_array_equal(seen_through(drawn.points, drawn.camera, camera), drawn.points)
    closer = seen_through(drawn.points, drawn.camera, zoom(camera, 2.0))
    np.testing.assert_allclose(closer - (300, 200), 2.0 * (drawn.points - (300, 200)), atol=1e-3)


def test_ink_has_the_colour_of_the_theme(overlay):
    overlay.begin()
    overlay.extend([(x, 100.0, 1.0) for x in range(100, 500, 4)])
    for palette in (DARK, LIGHT):
        overlay.set_colors(palette)
        image = QImage(overlay.size(), QImage.Format.Format_ARGB32_Premultiplied)
        image.fill(Qt.GlobalColor.transparent)
        overlay.render(image, QPoint(), QRegion(), overlay.RenderFlag.DrawChildren)
        color = image.pixelColor(300, 100)
        assert (color.red(), color.green(), color.blue()) == palette.ink


def test_places_are_lit_and_go_out(overlay, qtbot):
    overlay.light_up([(300, 200)])
    assert darkness(overlay)[180:220, 280:320].sum() > 5
    qtbot.waitUntil(lambda: not overlay.lit.places, timeout=4000)
    assert darkness(overlay).sum() == 0


@pytest.mark.parametrize("place", [(5, 5), (395, 295), (200, 150), (-40, 900)])
def test_words_beside_a_lit_place_stay_on_the_sheet_and_off_the_place(overlay, place):
    overlay.light_up([place], "The outline crosses itself at the marked place. Draw it again.")
    area = overlay.lit.words_area
    assert overlay.rect().contains(area)
    assert not area.contains(*place)


def test_a_new_stroke_ends_what_was_said(overlay):
    overlay.light_up([(100, 100)], "Not like this.")
    assert not overlay.lit.words_area.isEmpty()
    overlay.begin()
    assert overlay.lit.places == ()
    assert overlay.lit.words_area.isEmpty()
