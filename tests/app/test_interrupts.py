"""Ctrl+C is heard by a waiting event loop, and costs nothing while nobody presses it."""

from __future__ import annotations

import gc
import os
import signal
import socket

import pytest
from PySide6.QtCore import QAbstractEventDispatcher, QTimer
from PySide6.QtWidgets import QApplication

from bozzetto_app.interrupts import InterruptWatch


@pytest.fixture
def heard(qapp):
    return []


@pytest.fixture
def watch(heard):
    made = InterruptWatch(lambda: heard.append("interrupt"))
    gc.collect()  # what nobody owns is gone before anything is tested
    yield made
    made.close()


def turns_of_the_loop(milliseconds):
    """How often the event loop is woken while nothing happens."""
    count = 0

    def woken():
        nonlocal count
        count += 1

    dispatcher = QAbstractEventDispatcher.instance()
    dispatcher.awake.connect(woken)
    QTimer.singleShot(milliseconds, QApplication.instance().quit)
    QApplication.exec()
    dispatcher.awake.disconnect(woken)
    return count


def test_an_interrupt_reaches_a_waiting_loop(qtbot, watch, heard):
    QTimer.singleShot(0, lambda: os.kill(os.getpid(), signal.SIGINT))
    qtbot.waitUntil(lambda: heard == ["interrupt"])
    os.kill(os.getpid(), signal.SIGINT)
    qtbot.waitUntil(lambda: heard == ["interrupt"] * 2)


def test_a_waiting_loop_is_not_woken(qapp, watch):
    QApplication.processEvents()
    assert turns_of_the_loop(300) < 20


def test_nor_after_a_burst_of_interrupts(qtbot, watch, heard):
    for _ in range(300):
        os.kill(os.getpid(), signal.SIGINT)
    qtbot.waitUntil(lambda: len(heard) > 0)
    QApplication.processEvents()
    assert turns_of_the_loop(300) < 20


def test_closing_leaves_signals_as_they_were(qapp):
    def before(number, frame):
        pytest.fail("interrupted")

    mine, theirs = socket.socketpair()
    mine.setblocking(False)
    handler = signal.signal(signal.SIGINT, before)
    wakeup = signal.set_wakeup_fd(mine.fileno())
    try:
        watch = InterruptWatch(lambda: None)
        assert signal.getsignal(signal.SIGINT) is not before
        watch.close()
        watch.close()
        assert signal.getsignal(signal.SIGINT) is before
        assert signal.set_wakeup_fd(wakeup) == mine.fileno()
    finally:
        signal.set_wakeup_fd(wakeup)
        signal.signal(signal.SIGINT, handler)
        mine.close()
        theirs.close()


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="the system tells no open files")
def test_a_closed_watch_leaves_no_file_open(qapp):
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(10):
        InterruptWatch(lambda: None).close()
    assert len(os.listdir("/proc/self/fd")) == before
