"""Every dialog fits on the smallest screen, with its buttons in reach."""

from __future__ import annotations

from itertools import pairwise

import pytest
from PySide6.QtCore import QPoint, QRect, QSize
from PySide6.QtGui import QScreen
from PySide6.QtWidgets import QApplication, QLabel, QPushButton

from bozzetto_app.dialogs.dialog import Page
from bozzetto_app.panels.tool_rail import ToolRail
from bozzetto_app.style.theme import FRAME
from bozzetto_app.testing.stylus import Stylus
from bozzetto_app.toolkit.panel_scroll import PanelScroll
from bozzetto_app.widgets.icon_button import IconButton
from tests.app.tablet import circle

SCREENS = (QSize(800, 600), QSize(683, 384), QSize(900, 620))
"""The one on which the guide and the export did not fit, px; 1366 × 768 at scale 2; and one that
is high enough for most."""


ACTIONS = (
    "file.export",
    "edit.preferences",
    *(f"help.{name}" for name in ("guide", "shortcuts", "pen", "plugins", "about")),
)


@pytest.mark.parametrize("screen", SCREENS, ids=lambda size: f"{size.width()}x{size.height()}")
def test_every_dialog_fits_and_its_buttons_are_in_reach(
    screen, make_window, settle, qtbot, monkeypatch
):
    window = make_window()
    Stylus(window.canvas).draw(circle(radius=60.0))
    settle(window.session, window.keeper)
    window.show()
    monkeypatch.setattr(QScreen, "availableGeometry", lambda _: QRect(QPoint(), screen))
    room = screen - QSize(*FRAME)
    for action in ACTIONS:
        window.actions_.run(action)
        (page,) = [
            widget
            for widget in QApplication.topLevelWidgets()
            if isinstance(widget, Page) and widget.isVisible()
        ]
        if action == "file.export":  # it grows with what is measured
            qtbot.waitUntil(page.go.isEnabled, timeout=20_000)
        page.hide()
        page.resize(
            page.width(), 0
        )  # as low as Qt lets it be, which knows two thirds of the screen
        page.show()
        QApplication.processEvents()
        assert page.size() == page.size().boundedTo(room), (action, page.size())
        for label in page.findChildren(QLabel):
            needed = label.heightForWidth(label.width())
            assert label.isHidden() or label.height() >= needed, (action, label.text())
        for area in page.findChildren(PanelScroll):
            assert area.viewport().width() >= area.widget().minimumSizeHint().width(), action
        if action == "file.export":
            place = QRect(page.state.mapTo(page, QPoint()), page.state.size())
            assert page.rect().contains(place)
            assert not isinstance(QApplication.focusWidget(), QPushButton)
        buttons = [
            b for b in page.findChildren(QPushButton) if b.parentWidget() is page and b.isVisible()
        ]
        assert buttons
        for button in buttons:
            place = QRect(button.mapTo(page, QPoint()), button.size())
            assert page.rect().contains(place), (action, button.text())
        page.reject()
        QApplication.processEvents()


@pytest.mark.parametrize("modeler", ["silhouette", "symmetry", "car", "product"])
def test_the_window_fits_on_a_small_screen_also_while_ink_waits(
    make_window, settle, qtbot, modeler
):
    window = make_window(f"bozzetto.{modeler}")
    window.show()
    qtbot.wait(50)
    room = SCREENS[1] - QSize(*FRAME)
    assert window.minimumSizeHint().height() <= room.height()
    Stylus(window.canvas).draw([(300, 300), (400, 300)])
    qtbot.wait(50)
    assert window.minimumSizeHint().height() <= room.height() + 8, "ink waits"
    window.resize(room)
    qtbot.wait(50)
    assert window.height() <= room.height() + 8
    tools = window.findChild(ToolRail)
    shown = [b for b in tools.findChildren(IconButton) if b.isVisible()]
    assert len(shown) > 2
    places = [QRect(b.mapTo(tools, QPoint()), b.size()) for b in shown]
    assert all(tools.rect().contains(place) for place in places)
    assert not any(a.intersects(b) for a, b in pairwise(places))


def test_what_is_first_is_not_said_where_there_is_no_room_for_a_word(make_window, qtbot):
    window = make_window()
    window.show()
    hint = window.canvas.empty_hint
    assert hint.text
    hint.resize(600, 300)
    wide = hint.grab().toImage()
    hint.resize(60, 300)
    narrow = hint.grab().toImage()
    grounds = [
        {image.pixel(x, y) for x in range(image.width()) for y in range(image.height())}
        for image in (wide, narrow)
    ]
    assert len(grounds[0]) > 1 == len(grounds[1])


def test_the_palette_ends_above_the_foot_of_a_low_window(make_window, qtbot):
    from bozzetto_app.dialogs.command_palette import CommandPalette

    window = make_window()
    window.show()
    window.resize(SCREENS[1] - QSize(*FRAME))
    qtbot.wait(50)
    for _ in range(2):
        window.actions_.run("edit.palette")
        palette = QApplication.activePopupWidget()
        assert isinstance(palette, CommandPalette)
        bottom = palette.mapToGlobal(QPoint(0, palette.height())).y()
        assert bottom <= window.mapToGlobal(QPoint(0, window.height())).y()
        assert palette.list.count() > palette.list.height() // palette.list.sizeHintForRow(0) >= 3
        palette.close()


@pytest.mark.parametrize("screen", [SCREENS[2], QSize(1366, 768)])
def test_many_warnings_of_an_export_leave_its_buttons_in_reach(
    screen, make_window, settle, qtbot, monkeypatch
):
    window = make_window()
    Stylus(window.canvas).draw(circle(radius=60.0))
    settle(window.session, window.keeper)
    window.show()
    monkeypatch.setattr(QScreen, "availableGeometry", lambda _: QRect(QPoint(), screen))
    seen = []
    exchange = window.session.files.exchange
    exchange.foreseen.connect(seen.append)
    window.actions_.run("file.export")
    (page,) = [
        widget
        for widget in QApplication.topLevelWidgets()
        if isinstance(widget, Page) and widget.isVisible()
    ]
    qtbot.waitUntil(page.go.isEnabled, timeout=20_000)
    sentence = "Left out of the file: 16 curves (such files hold triangles only)."
    exchange.foreseen.emit(seen[-1]._replace(warnings=(sentence,) * 40))
    QApplication.processEvents()
    assert page.warning.text().count(sentence) == 40
    assert page.minimumSizeHint().height() <= screen.height() - FRAME[1]
    place = QRect(page.go.mapTo(page, QPoint()), page.go.size())
    assert page.rect().contains(place)
    assert page.height() <= screen.height() - FRAME[1]
    page.reject()
