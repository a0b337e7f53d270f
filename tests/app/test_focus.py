"""Keys mean on the sheet what they always mean, wherever the last click went."""

from __future__ import annotations

import sys

import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox, QApplication, QLineEdit, QToolButton, QWidget

from bozzetto.plugin import Context
from bozzetto_app.actions.menu_actions import NUMBER_ROW
from bozzetto_app.panels.tool_rail import ToolRail
from bozzetto_app.testing.stylus import Stylus
from bozzetto_app.widgets.number_field import NumberField
from bozzetto_app.widgets.text_field import TextField
from tests.app.tablet import circle

CTRL = Qt.KeyboardModifier.ControlModifier
TAKES_TEXT = (QLineEdit, QAbstractSpinBox)


@pytest.fixture
def window(make_window, settle, qtbot):
    window = make_window()
    Stylus(window.canvas).draw(circle(radius=60.0))
    settle(window.session, window.keeper)
    window.show()
    window.activateWindow()
    qtbot.waitUntil(lambda: window.isActiveWindow() and window.docks.parameters.is_ready)
    return window


def parts(window, within=None):
    """Everything seen in the window, or in a part of it, that Tab goes to."""
    return [
        widget
        for widget in (within or window).findChildren(QWidget)
        if widget.isVisible()
        and widget.window() is window
        and widget.focusPolicy() & Qt.FocusPolicy.TabFocus
    ]


def test_letters_and_digits_reach_the_sheet_from_everywhere_but_fields(window, qtbot):
    tools = window.session.toolbox
    first, second = (group.tools[0].id for group in tools.groups[:2])
    asked = 0
    for widget in parts(window):
        widget.setFocus(Qt.FocusReason.TabFocusReason)
        if not widget.hasFocus():
            continue
        tools.take_tool(first)
        QTest.keyClick(widget, Qt.Key.Key_2)
        expected = first if isinstance(widget, TAKES_TEXT) else second
        assert tools.tool == expected, (type(widget).__name__, widget.accessibleName())
        asked += 1
    assert asked > 20


@pytest.mark.parametrize(
    ("key", "letter"), [(Qt.Key.Key_Eacute, "é"), (Qt.Key.Key_Plus, "+"), (Qt.Key.Key_At, "@")]
)
def test_the_row_above_the_letters_takes_tools_where_it_has_no_digits(window, key, letter):
    """French and others have signs and letters there; the second key, without Shift."""
    tools = window.session.toolbox
    first, second = (group.tools[0].id for group in tools.groups[:2])
    code = NUMBER_ROW[sys.platform][1]
    for held, expected in ((Qt.KeyboardModifier.NoModifier, second), (CTRL, first)):
        tools.take_tool(first)
        event = QKeyEvent(QEvent.Type.KeyPress, key, held, code, code, 0, letter)
        QApplication.sendEvent(window.canvas, event)
        assert tools.tool == expected
    field = next(one for one in window.findChildren(NumberField) if one.isVisible())
    tools.take_tool(first)
    field.setFocus()
    plain = Qt.KeyboardModifier.NoModifier
    event = QKeyEvent(QEvent.Type.KeyPress, key, plain, code, code, 0, letter)
    QApplication.sendEvent(field, event)
    assert tools.tool == first


@pytest.mark.parametrize("key", [Qt.Key.Key_Return, Qt.Key.Key_Backspace])
def test_a_key_that_a_button_has_no_use_for_is_the_sheets(window, settle, key):
    """Both take the waiting ink, one to try it and one to take it back."""
    Stylus(window.canvas).draw(circle(x=900.0, share=0.6))
    settle(window.session, window.keeper)
    assert window.session.drawing.pending
    focus = parts(window, window.findChild(ToolRail))[0]
    focus.setFocus(Qt.FocusReason.TabFocusReason)
    QTest.keyClick(focus, key)
    settle(window.session, window.keeper)
    assert not window.session.drawing.pending


def test_undo_reaches_the_document_from_a_field_whose_number_was_taken(window, settle):
    """While somebody types it is the field's: what was typed is no step yet."""
    session = window.session
    field = next(one for one in window.findChildren(NumberField) if one.isVisible())
    before, first = session.drawing.document, field.value()
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, f"{first * 0.9:g}")
    QTest.keyClick(field, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert session.drawing.document is before
    assert field.value() == first
    field.selectAll()
    QTest.keyClicks(field, f"{first * 0.9:g}")
    QTest.keyClick(field, Qt.Key.Key_Return)
    settle(session, window.keeper)
    assert session.drawing.document is not before
    QTest.keyClick(field, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    settle(session, window.keeper)
    assert session.drawing.document is before
    assert field.value() == first


def test_the_sheet_has_the_keys_when_the_welcome_strip_is_closed(make_window, qtbot):
    """The next widget had them, with a ring around it: the first modeler's button."""
    window = make_window()
    window.show()
    window.activateWindow()
    qtbot.waitUntil(lambda: window.isActiveWindow())
    close = next(
        b for b in window.welcome.findChildren(QToolButton) if b.accessibleName() == "Close"
    )
    close.setFocus()
    QTest.mouseClick(close, Qt.MouseButton.LeftButton)
    assert not window.welcome.isVisible()
    assert window.focusWidget() is window.canvas


def test_undo_reaches_the_document_from_a_line_of_text_that_was_taken(make_window, settle, qtbot):
    """Esc gives back what the object has; what is refused stays, to be mended."""
    window = make_window("bozzetto.car")
    session = window.session
    car = session.workbench.create("bozzetto.car", Context())
    session.drawing.apply_model("New car", car, is_new=True)
    session.selection.select(car.id)
    settle(session, window.keeper)
    qtbot.waitUntil(lambda: window.docks.parameters.is_ready)
    form = window.docks.parameters.form
    field = form.rows[("", "tyre")].findChild(TextField)
    field.setFocus()

    def typed(text):
        field.selectAll()
        QTest.keyClicks(field, text)
        QTest.keyClick(field, Qt.Key.Key_Return)
        settle(session, window.keeper)
        return session.selection.model.state.tyre, field.text()

    assert typed("205/55 R16") == ("205/55 R16", "205/55 R16")
    assert typed("big") == ("205/55 R16", "big")
    QTest.keyClick(field, Qt.Key.Key_Escape)
    assert field.text() == "205/55 R16"
    assert typed("225/45 R17") == ("225/45 R17", "225/45 R17")
    for kept in ("205/55 R16", ""):
        QTest.keyClick(field, Qt.Key.Key_Z, CTRL)
        settle(session, window.keeper)
        assert (session.selection.model.state.tyre, field.text()) == (kept, kept)
    QTest.keyClicks(field, "1")
    QTest.keyClick(field, Qt.Key.Key_Z, CTRL)
    settle(session, window.keeper)
    assert (session.selection.model.id, field.text()) == (car.id, "")
