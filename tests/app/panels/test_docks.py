"""Docks stand before their panels are made, and do not move when these come."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QApplication, QDockWidget, QWidget

from bozzetto.plugin.host.registry import Registry
from bozzetto_app.main_window import Window
from bozzetto_app.session.session import Session
from tests.app.seen import part

PANELS = ("objects", "parameters", "history")


@pytest.fixture
def unpainted(qapp, qtbot, tmp_path):
    """A window before it is shown."""
    session = Session(Registry(no_plugins=True))
    window = Window(session, tmp_path / "recovery")
    qtbot.addWidget(window)
    yield window
    session.cancel_all()


def places(window):
    docks = {dock.objectName(): dock for dock in window.findChildren(QDockWidget)}
    return {name: docks[f"dock-{name}"].geometry().getRect() for name in PANELS}


def made(window):
    return [name for name in PANELS if window.findChild(QWidget, name) is not None]


def test_nothing_moves_when_the_panels_come(unpainted, qtbot):
    window = unpainted
    seen = []
    window.canvas.viewports.first_painted.disconnect(window.docks.fill)
    window.canvas.viewports.first_painted.connect(lambda: seen.append(places(window)))
    window.show()
    qtbot.waitUntil(lambda: bool(seen))
    sheet = window.canvas.geometry()
    window.docks.fill()
    qtbot.wait(50)
    assert places(window) == seen[0]
    assert window.canvas.geometry() == sheet
    assert all(part(window, name).isVisible() for name in PANELS)


def test_panels_come_after_the_first_paint(unpainted, qtbot):
    window = unpainted
    assert made(window) == []
    window.show()
    qtbot.waitUntil(lambda: made(window) == [*PANELS])


def test_a_panel_that_is_asked_for_earlier_is_the_one_that_is_shown(unpainted, qtbot):
    window = unpainted
    asked = window.docks.parameters
    assert window.docks.objects.chosen_models() == []
    window.show()
    qtbot.waitUntil(lambda: made(window) == [*PANELS])
    assert part(window, "parameters") is asked
    assert asked.isVisible()


def test_docks_that_are_hidden_at_the_start_stay_hidden(unpainted, qtbot):
    window = unpainted
    window.toggle_panels()
    window.show()
    qtbot.waitUntil(lambda: made(window) == [*PANELS])
    QApplication.processEvents()
    assert not window.panels_shown
    window.toggle_panels()
    assert all(part(window, name).isVisible() for name in PANELS)
