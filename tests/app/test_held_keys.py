"""A key that is held down repeats what may be repeated, and deletes once."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QApplication

from bozzetto_app.panels.objects.list_widget import ObjectList
from bozzetto_app.testing.stylus import Stylus
from tests.app.tablet import circle

NO_KEYS = Qt.KeyboardModifier.NoModifier
CTRL = Qt.KeyboardModifier.ControlModifier


def hold(target, key, keys=NO_KEYS, text="", times=8):
    """Send a press as the keyboard's first, and as often again as one that is held makes it."""
    for number in range(times):
        event = QKeyEvent(QEvent.Type.KeyPress, key, keys, text, number > 0)
        shortcut = QKeyEvent(QEvent.Type.ShortcutOverride, key, keys, text, number > 0)
        QApplication.sendEvent(target, shortcut)
        QApplication.sendEvent(target, event)
        QApplication.processEvents()


@pytest.fixture
def window(make_window, settle):
    window = make_window()
    window.show()
    for x in (250, 400, 550):
        Stylus(window.canvas).draw(circle(x, 300.0, radius=50.0))
        settle(window.session, window.keeper)
        window.session.gestures.commit()
        settle(window.session, window.keeper)
    window.session.selection.select(window.session.drawing.document.models[0].id)
    return window


def test_delete_on_the_sheet_deletes_one_thing(window):
    window.canvas.setFocus()
    hold(window.canvas, Qt.Key.Key_Delete)
    assert len(window.session.drawing.document) == 2


def test_delete_in_the_list_deletes_one_thing(window):
    rows = window.findChild(ObjectList)
    rows.choose(0)
    rows.setFocus()
    hold(rows, Qt.Key.Key_Delete)
    assert len(window.session.drawing.document) == 2


def test_what_switches_is_switched_once(window):
    was = window.session.view.show_grid
    hold(window, Qt.Key.Key_G, text="g", times=4)
    assert window.session.view.show_grid is not was


def test_every_command_but_those_of_steps_is_done_once(window):
    repeated = {
        a.id for a in window.actions_.actions() if window.actions_.qaction(a.id).autoRepeat()
    }
    assert repeated == {"edit.undo", "edit.redo", "edit.drop"}


def test_undo_that_is_held_goes_on(window):
    for again in (False, *[True] * 20):
        window.actions_.take_key("Ctrl+Z", again=again)
    assert not len(window.session.drawing.document)
    for again in (False, *[True] * 20):
        window.actions_.take_key("Ctrl+Shift+Z", again=again)
    assert len(window.session.drawing.document) == 3


def test_escape_that_is_held_drops_the_stroke_and_leaves_the_ink_that_waits(window, settle):
    Stylus(window.canvas).draw([(300, 500), (420, 520)])
    settle(window.session, window.keeper)
    assert len(window.session.drawing.pending) == 1
    pen = Stylus(window.canvas)
    pen.draw([(300, 400), (360, 420)], lift=False)
    hold(window.canvas, Qt.Key.Key_Escape)
    pen.lift((360, 420))
    assert len(window.session.drawing.pending) == 1


def test_a_stroke_goes_to_the_tool_with_which_it_was_begun(window, settle):
    toolbox = window.session.toolbox
    before = len(window.session.drawing.document)
    window.session.selection.select(None)
    drawing, other = toolbox.tools[0].id, toolbox.groups[3].tools[0].id
    assert toolbox.tool == drawing
    pen = Stylus(window.canvas)
    places = circle(400.0, 480.0, radius=60.0)
    pen.draw(places[:20], lift=False)
    window.actions_.take_key("4")
    assert toolbox.tool == drawing
    for place in places[20:]:
        pen.move(place)
    pen.lift(places[-1])
    assert toolbox.tool == other
    settle(window.session, window.keeper)
    assert len(window.session.drawing.document) == before + 1
    assert not window.session.drawing.pending
