"""The chart of colours opens beside its disc, all of it on the screen."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QRect
from PySide6.QtWidgets import QWidget

from bozzetto.scene.palette import LIGHT
from bozzetto_app.style.theme import apply_theme
from bozzetto_app.widgets.swatch import Swatch

CORNERS = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 0.5))


@pytest.mark.parametrize("share", CORNERS)
def test_the_chart_is_on_the_screen_and_leaves_its_disc_free(
    qapp, qtbot, monkeypatch, share
) -> None:
    apply_theme(qapp, LIGHT)
    window = QWidget()
    qtbot.addWidget(window)
    room = window.screen().availableGeometry()
    swatch = Swatch(window)
    window.setFixedSize(room.size())
    window.move(room.topLeft())
    window.show()
    place = QPoint(
        room.left() + round(share[0] * (room.width() - swatch.width())),
        room.top() + round(share[1] * (room.height() - swatch.height())),
    )
    swatch.move(window.mapFromGlobal(place))
    asked: list[QPoint] = []
    monkeypatch.setattr(QWidget, "move", lambda widget, at: asked.append(at))
    popup = swatch.open_chart()
    # Without a window manager's frames, where it was asked to go is where it is.
    chart = QRect(asked[0], popup.size())
    disc = QRect(swatch.mapToGlobal(QPoint(0, 0)), swatch.size())
    assert room.contains(chart)
    assert not disc.intersects(chart)
    assert chart.adjusted(0, -1, 0, 1).intersects(disc)
    popup.close()
