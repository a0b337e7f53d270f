"""When free memory is given back: now and then, in a thread, one at a time."""

from __future__ import annotations

import gc
import threading

import pytest
from PySide6.QtCore import QTimer

from bozzetto_app.workers import gc_on_main_thread as tidying
from bozzetto_app.workers.gc_on_main_thread import REST, Tidier


@pytest.fixture
def tidier(qapp):
    tidier = Tidier()
    tidier.findChild(QTimer).stop()
    yield tidier
    gc.enable()
    tidier.deleteLater()


def join_givers():
    """Wait for the threads that give memory back."""
    for thread in threading.enumerate():
        if thread.name == "bozzetto-heap":
            thread.join(10.0)


def test_memory_is_given_back_now_and_then_in_a_thread(tidier, monkeypatch):
    threads = []
    monkeypatch.setattr(tidying, "give_back", lambda: threads.append(threading.get_ident()))
    for number in range(1, 3 * REST + 1):
        tidier.tidy()
        join_givers()
        assert len(threads) == number // REST
    assert threading.get_ident() not in threads


def test_a_slow_one_is_not_joined_by_another(tidier, monkeypatch):
    gate, begun = threading.Event(), []

    def slow():
        begun.append(1)
        assert gate.wait(10.0)

    monkeypatch.setattr(tidying, "give_back", slow)
    for _ in range(3 * REST):
        tidier.tidy()
    gate.set()
    join_givers()
    assert begun == [1]
