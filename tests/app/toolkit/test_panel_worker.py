"""A panel's work: off the window's thread, the newest of what was asked, dropped with its owner."""

from __future__ import annotations

import threading

import pytest
from PySide6.QtCore import QObject
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QWidget

from bozzetto.errors import UserError
from bozzetto.scene import DARK, LIGHT
from bozzetto_app.toolkit import PanelWorker, palette_of


@pytest.fixture
def owner(qapp):
    return QObject()


def test_work_is_done_elsewhere_and_answered_here(qtbot, owner):
    worker, threads = PanelWorker(owner), []
    worker.ask(threading.get_ident, lambda made: threads.extend((made, threading.get_ident())))
    assert worker.busy
    qtbot.waitUntil(lambda: bool(threads))
    assert threads[0] != threads[1] == threading.get_ident()
    assert not worker.busy


def test_of_what_is_asked_meanwhile_the_newest_is_done(qtbot, owner):
    worker, go, done, began = PanelWorker(owner), threading.Event(), [], []

    def slow():
        began.append("first")
        go.wait(30.0)
        return "first"

    worker.ask(slow, done.append)
    for name in ("second", "third"):
        worker.ask(lambda name=name: began.append(name) or name, done.append)
    go.set()
    qtbot.waitUntil(lambda: not worker.busy)
    assert began == done == ["first", "third"]


def test_a_refusal_is_told_to_who_wants_to_know(qtbot, owner):
    worker, told = PanelWorker(owner), []

    def refused():
        raise UserError("Draw more.")

    worker.ask(refused, told.append)
    qtbot.waitUntil(lambda: not worker.busy)
    assert told == []
    worker.ask(refused, told.append, lambda problem: told.append(str(problem)))
    qtbot.waitUntil(lambda: not worker.busy)
    assert told == ["Draw more."]


def test_an_answer_may_ask_again(qtbot, owner):
    worker, seen = PanelWorker(owner), []

    def done(count):
        seen.append(count)
        if count < 3:
            worker.ask(lambda: count + 1, done)

    worker.ask(lambda: 1, done)
    qtbot.waitUntil(lambda: seen == [1, 2, 3])


def test_the_palette_goes_with_the_text(qtbot):
    widget = QWidget()
    qtbot.addWidget(widget)
    for window, text, wanted in (("white", "black", LIGHT), ("black", "white", DARK)):
        colors = QPalette()
        colors.setColor(QPalette.ColorRole.Window, QColor(window))
        colors.setColor(QPalette.ColorRole.WindowText, QColor(text))
        widget.setPalette(colors)
        assert palette_of(widget) is wanted
