"""Strokes whose end nobody told of, and events that come late: nothing drawn is lost."""

from __future__ import annotations

import time

import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QApplication

LEFT, RIGHT, NONE = Qt.MouseButton.LeftButton, Qt.MouseButton.RightButton, Qt.MouseButton.NoButton
PRESS, MOVE = QEvent.Type.MouseButtonPress, QEvent.Type.MouseMove
RELEASE = QEvent.Type.MouseButtonRelease


class Mouse:
    """Sends mouse events as the system does, with the buttons that are down."""

    def __init__(self, canvas):
        self.canvas, self.buttons, self.stamp = canvas, NONE, 1000

    def send(self, kind, x, y, button=NONE):
        self.stamp += 5
        if kind in (PRESS, QEvent.Type.MouseButtonDblClick):
            self.buttons |= button
        elif kind == RELEASE:
            self.buttons &= ~button
        place = QPointF(x, y)
        event = QMouseEvent(
            kind, place, QPointF(self.canvas.mapToGlobal(place)), button, self.buttons,
            Qt.KeyboardModifier.NoModifier,
        )  # fmt: skip
        event.setTimestamp(self.stamp)
        QApplication.sendEvent(self.canvas, event)

    def press(self, x, y, button=LEFT):
        self.send(PRESS, x, y, button)

    def move(self, x, y):
        self.send(MOVE, x, y)

    def release(self, x, y, button=LEFT):
        self.send(RELEASE, x, y, button)

    def lose_lift(self):
        """Another program takes the pointer, and the button is let go there."""
        self.buttons = NONE


@pytest.fixture
def mouse(canvas):
    return Mouse(canvas)


@pytest.fixture(params=["pen", "mouse"])
def pointer(request, pen, mouse):
    """A pen or a mouse, whichever draws, with a way to lose its lift."""
    if request.param == "pen":
        pen.lose_lift = lambda: setattr(pen, "buttons", NONE)
        return pen
    return mouse


def half_a_stroke(pointer):
    pointer.press(100, 100)
    for x in range(110, 210, 10):
        pointer.move(x, 100)


def test_a_stroke_whose_lift_was_lost_ends_with_the_next_movement(session, canvas, pointer):
    half_a_stroke(pointer)
    pointer.lose_lift()
    pointer.move(500, 400)
    (stroke,) = session.strokes
    assert stroke.x.tolist() == list(range(100, 210, 10))
    assert not canvas.overlay.has_wet_ink
    pointer.move(520, 400)
    assert len(session.strokes) == 1


def test_or_with_the_next_press_which_begins_the_next_stroke(session, pointer):
    half_a_stroke(pointer)
    pointer.lose_lift()
    pointer.press(300, 300)
    pointer.move(400, 300)
    pointer.release(400, 300)
    first, second = session.strokes
    assert first.x.tolist() == list(range(100, 210, 10))
    assert second.x.tolist() == [300, 400]


def test_or_when_the_window_is_put_away(session, canvas, pointer):
    half_a_stroke(pointer)
    canvas.hide()
    (stroke,) = session.strokes
    assert stroke.x[-1] == 200
    pointer.release(300, 300)  # told after all
    assert len(session.strokes) == 1


def test_a_turn_of_the_view_whose_lift_was_lost_stays_where_it_is(session, canvas, mouse):
    middle = Qt.MouseButton.MiddleButton
    mouse.press(300, 300, middle)
    mouse.move(340, 320)
    turned = session.view.camera
    mouse.lose_lift()
    mouse.move(600, 100)
    assert session.view.camera == turned
    mouse.move(620, 120)
    assert session.view.camera == turned


@pytest.mark.parametrize("other", [RIGHT, Qt.MouseButton.MiddleButton])
def test_a_second_button_leaves_the_stroke_alone(session, canvas, pointer, other):
    camera = session.view.camera
    half_a_stroke(pointer)
    pointer.press(200, 100, button=other)
    pointer.move(210, 100)
    pointer.release(210, 100, button=other)
    pointer.move(220, 100)
    pointer.release(230, 100)
    (stroke,) = session.strokes
    assert stroke.x.tolist() == list(range(100, 240, 10))
    assert session.view.camera == camera


def test_a_stroke_may_leave_the_sheet_and_come_back(session, canvas, pointer):
    pointer.press(700, 100)
    for x in (780, 900, 1500, 900, 780):
        pointer.move(x, 100)
    pointer.release(700, 120)
    (stroke,) = session.strokes
    assert stroke.x.tolist() == [700, 780, 900, 1500, 900, 780, 700]


def test_a_line_ends_as_wide_as_it_was_also_when_all_of_it_was_painted(session, pen):
    pen.press(100, 100, 0.6)
    pen.move(200, 100, 0.6)
    QApplication.processEvents()
    pen.release(250, 100)
    (stroke,) = session.strokes
    assert stroke.x.tolist() == [100, 200, 250]
    assert stroke.pressure[-1] == pytest.approx(0.6)


def test_two_quick_clicks_are_two_taps(session, canvas, mouse):
    session.toolbox.tool = "mark"
    mouse.press(100, 100)
    mouse.release(100, 100)
    mouse.send(QEvent.Type.MouseButtonDblClick, 100, 100, LEFT)
    mouse.release(100, 100)
    assert len(session.first("gestures.tap")) == 2


def test_a_tap_is_as_long_as_the_hand_made_it_not_as_the_window_took(session, mouse, monkeypatch):
    """The press is handled, a slow frame comes, and the lift waits in the queue."""
    session.toolbox.tool = "mark"
    mouse.press(100, 100)
    later = time.perf_counter() + 0.3
    for module in ("controller", "tablet_events"):
        monkeypatch.setattr(f"bozzetto_app.canvas.input.{module}.perf_counter", lambda: later)
    mouse.release(100, 100)
    assert len(session.first("gestures.tap")) == 1
