"""Undo that comes before an answer takes back what was done last, and nothing before it."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from bozzetto.plugin.gesture import Tap
from tests.app.tablet import circle, stroke_of
from tests.app.troublemaker import MODELER

STEP = 0.5
"""mm."""

CTRL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def window(make_window, boxes, settle):
    made = make_window(MODELER, extra=[boxes.package])
    made.session.gestures.stroke_lifted(stroke_of(circle(), made.session.view.camera))
    settle(made.session, made.keeper)
    return made


def size(window):
    return window.session.drawing.document.models[0].state.size


@pytest.mark.parametrize("lifted", [1, 2, 3])
@pytest.mark.parametrize("undone", [1, 2])
def test_undo_takes_back_only_the_newest(window, boxes, settle, lifted, undone):
    """A tap is answered; of some more gestures none is yet, when undo comes."""
    session, gate = window.session, threading.Event()

    def larger(state, gesture, context):
        return replace(state, size=state.size + STEP)

    def slow(state, gesture, context):
        gate.wait(20.0)
        return larger(state, gesture, context)

    before, position = size(window), session.drawing.history.position
    tap = Tap(10.0, 10.0, session.view.camera)
    boxes.misdeeds["apply"] = larger
    session.gestures.tap(tap)
    settle(session, window.keeper)
    assert size(window) == before + STEP
    boxes.misdeeds["apply"] = slow
    for _ in range(lifted):
        session.gestures.tap(tap)
    window.show()
    window.activateWindow()
    for _ in range(undone):
        QTest.keyClick(window.canvas, Qt.Key.Key_Z, CTRL)
    gate.set()
    settle(session, window.keeper)
    left = 1 + lifted - undone
    assert size(window) == before + STEP * left
    assert session.drawing.history.position == position + left


def test_a_stroke_that_is_taken_back_leaves_the_touch_before_it(window, boxes, settle):
    """Neither is answered yet; the stroke is a step of the history, the touch is none."""
    session, gate = window.session, threading.Event()

    def slow(state, gesture, context):
        gate.wait(20.0)
        return replace(state, size=state.size + STEP)

    before, boxes.misdeeds["apply"] = size(window), slow
    session.gestures.tap(Tap(10.0, 10.0, session.view.camera))
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    window.show()
    window.activateWindow()
    QTest.keyClick(window.canvas, Qt.Key.Key_Z, CTRL)
    gate.set()
    settle(session, window.keeper)
    assert size(window) == before + STEP
    assert session.drawing.document.waiting == ()
    assert session.drawing.history.undo_label != "Stroke"
