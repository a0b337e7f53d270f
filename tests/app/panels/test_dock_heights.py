"""How the objects, a plugin's panel and the history share the height beside the sheet."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from bozzetto_app.panels.objects.list_widget import ROW, ObjectList
from bozzetto_app.testing.stylus import Stylus
from tests.app.seen import part

CORNERS = [(300, 300), (420, 300), (420, 400), (300, 400), (340, 260), (460, 260), (460, 360)]
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 5), (2, 6), (4, 5), (5, 6)]


@pytest.fixture
def window(make_window, settle, qtbot):
    window = make_window("bozzetto.polyhedron")
    window.resize(1280, 800)
    qtbot.wait(50)
    for first, last in EDGES:
        Stylus(window.canvas).draw([CORNERS[first], CORNERS[last]])
        settle(window.session, window.keeper)
    qtbot.waitUntil(part(window, "plugin-panel").isVisible)
    qtbot.wait(50)
    return window


def listed(window):
    return window.findChild(ObjectList)


def test_a_panel_that_asks_for_little_leaves_the_room_to_the_list(window):
    assert listed(window).viewport().height() >= 5 * ROW
    assert part(window, "plugin-panel").height() >= 280


def test_the_chosen_row_stays_in_sight_when_the_list_becomes_lower(make_window, settle, qtbot):
    window = make_window()
    for _ in range(14):
        Stylus(window.canvas).draw([(400, 300), (460, 300), (430, 360), (400, 301)])
        settle(window.session, window.keeper)
        QTest.keyClick(window.canvas, Qt.Key.Key_Return)
        settle(window.session, window.keeper)
    rows = listed(window)
    assert rows.count() >= 14
    rows.choose(rows.count() - 1)
    for height in (800, 560, 640):
        window.resize(1280, height)
        qtbot.wait(50)
        seen = rows.visualItemRect(rows.currentItem())
        assert 0 <= seen.top() < seen.bottom() <= rows.viewport().height()


@pytest.mark.parametrize("modeler", ["bozzetto.silhouette", "bozzetto.polyhedron"])
def test_panels_that_were_hidden_are_as_high_as_before(make_window, settle, qtbot, modeler):
    """The objects took what the parameters had, more with every Tab."""
    window = make_window(modeler)
    window.resize(1280, 800)
    window.show()
    qtbot.wait(50)
    Stylus(window.canvas).draw([(400, 300), (460, 300), (430, 360), (400, 301)])
    settle(window.session, window.keeper)
    qtbot.wait(200)
    column = [part(window, f"dock-{name}") for name in ("objects", "parameters", "history")]
    window.resizeDocks(column, [150, 400, 160], Qt.Orientation.Vertical)
    qtbot.wait(200)
    before = window.docks.ends
    for _ in range(3):
        window.toggle_panels()
        qtbot.wait(300)
        window.toggle_panels()
        qtbot.wait(300)
        assert window.docks.ends == pytest.approx(before, abs=2)
