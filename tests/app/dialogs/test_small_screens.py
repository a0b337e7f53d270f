"""Every dialog fits on the smallest screen, with its buttons in reach."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QRect, QSize
from PySide6.QtGui import QScreen
from PySide6.QtWidgets import QApplication, QPushButton

from bozzetto_app.dialogs.dialog import Page
from bozzetto_app.style.theme import FRAME
from bozzetto_app.testing.stylus import Stylus
from tests.app.tablet import circle

SMALLEST = QSize(800, 600)
"""The screen on which the guide and the export did not fit, px."""


ACTIONS = (
    "file.export",
    "edit.preferences",
    *(f"help.{name}" for name in ("guide", "shortcuts", "pen", "plugins", "about")),
)


def test_every_dialog_fits_and_its_buttons_are_in_reach(make_window, settle, qtbot, monkeypatch):
    window = make_window()
    Stylus(window.canvas).draw(circle(radius=60.0))
    settle(window.session, window.keeper)
    window.show()
    monkeypatch.setattr(QScreen, "availableGeometry", lambda screen: QRect(QPoint(), SMALLEST))
    room = SMALLEST - QSize(*FRAME)
    for action in ACTIONS:
        window.actions_.run(action)
        (page,) = [
            widget
            for widget in QApplication.topLevelWidgets()
            if isinstance(widget, Page) and widget.isVisible()
        ]
        if action == "file.export":  # it grows with what is measured
            qtbot.waitUntil(page.go.isEnabled, timeout=20_000)
        QApplication.processEvents()
        assert page.size() == page.size().boundedTo(room), (action, page.size())
        buttons = [b for b in page.findChildren(QPushButton) if b.parentWidget() is page]
        assert buttons
        for button in buttons:
            place = QRect(button.mapTo(page, QPoint()), button.size())
            assert page.rect().contains(place), (action, button.text())
        page.reject()
        QApplication.processEvents()
