"""Where a person's letters are large, every row and chip is high enough for them."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QRect
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QAbstractButton, QAbstractItemView, QApplication, QWidget

from bozzetto.plugin.view_advice import ViewAdvice
from bozzetto_app.canvas.overlay.advice_light import ViewLight
from bozzetto_app.canvas.overlay.pace_badge import PaceBadge
from bozzetto_app.canvas.overlay.thickness_scale import BAR, ThicknessScale
from bozzetto_app.testing.stylus import Stylus
from bozzetto_app.widgets.choice import ChoiceBox, Segments
from bozzetto_app.widgets.section import Section
from tests.app.seen import part

DRAWN = [(400, 300), (520, 300), (460, 420), (400, 301)]


@pytest.fixture(params=[10.0, 18.0, 26.0])
def line(request, qapp):
    """The height of a line of letters, px."""
    before = QApplication.font()
    font = QApplication.font()
    font.setPointSizeF(request.param)
    QApplication.setFont(font)
    yield QFontMetrics(font).height()
    QApplication.setFont(before)


def test_every_row_of_the_window_is_as_high_as_its_letters(line, make_window, settle):
    window = make_window()
    Stylus(window.canvas).draw(DRAWN)
    settle(window.session, window.keeper)
    rows = [
        view.sizeHintForRow(row)
        for view in window.findChildren(QAbstractItemView)
        for row in range(view.model().rowCount())
        if view.isVisible()
    ]
    assert len(rows) >= 3
    assert min(rows) >= line
    headings = [b for b in window.findChildren(QAbstractButton) if isinstance(b.parent(), Section)]
    assert headings
    for widget in (
        *headings,
        *window.findChildren(ChoiceBox),
        *window.findChildren(Segments),
        part(window, "modelers"),
    ):
        assert widget.height() >= line
    assert part(window, "status-words").height() >= line


def test_chips_on_the_sheet_are_as_high_as_their_letters(line, qtbot):
    sheet = QWidget()
    qtbot.addWidget(sheet)
    area = QRect(0, 0, 1200, 800)
    light, pace, scale = ViewLight(sheet), PaceBadge(sheet), ThicknessScale(sheet)
    light.show_advice(ViewAdvice("warn", "Left and right nearly coincide"))
    pace.show_pace(0.4)
    scale.say(None)
    for chip in (light, pace, scale):
        chip.lie_on(area)
        assert area.contains(chip.geometry())
    assert light.height() >= line
    assert pace.height() >= line
    assert scale.height() >= 2 * line + BAR
