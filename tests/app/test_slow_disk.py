"""The window's thread never waits for the disk on which documents and recovery data lie."""

from __future__ import annotations

import os
import threading
import time

import pytest
from PySide6.QtWidgets import QPushButton

from bozzetto_app.dialogs.recovery import RecoveryDialog
from tests.app.tablet import circle, stroke_of
from tests.app.troublemaker import MODELER
from tests.disk_faults import watch


@pytest.fixture
def drawn(make_window, boxes, tmp_path, settle):
    """A window with a drawing on a disk of its own."""
    folder = tmp_path / "disk"
    folder.mkdir()
    window = make_window(MODELER, extra=[boxes.package], recovery=folder / "recovery")

    def draw(radius=100.0):
        window.session.gestures.stroke_lifted(
            stroke_of(circle(radius=radius), window.session.view.camera)
        )
        settle(window.session, window.keeper)

    return window, folder, draw


def of_the_window(calls):
    """The calls that the window's thread made."""
    mine = threading.main_thread().name
    return [name for name, who in zip(calls.names, calls.threads, strict=True) if who == mine]


def test_the_windows_thread_asks_the_disk_nothing(drawn, settle, monkeypatch, qtbot):
    window, folder, draw = drawn
    session = window.session
    with watch(folder) as calls:
        draw()
        session.files.save(folder / "a.bozz")
        settle(session, window.keeper)
        draw(60.0)
        session.files.save()
        settle(session, window.keeper)
        session.files.new()
        settle(session, window.keeper)
        session.files.open(folder / "a.bozz")
        settle(session, window.keeper)
        draw(50.0)
        session.files.given_up.emit()
        session.files.new()
        settle(session, window.keeper)
        draw()
        session.files.new()  # nobody answered: it is set aside, and offered
        settle(session, window.keeper)
        window.offer_recovery()
        qtbot.waitUntil(lambda: window.findChild(RecoveryDialog) is not None, timeout=10_000)
        dialog = window.findChild(RecoveryDialog)
        next(b for b in dialog.findChildren(QPushButton) if b.text() == "Open").click()
        settle(session, window.keeper)
        assert len(session.drawing.document) == 1
        session.files.close()
        window.keeper.close()
        settle(session, window.keeper)
    assert len(calls.names) > 100
    assert of_the_window(calls) == []


def test_a_very_slow_disk_holds_up_no_stroke(drawn, settle, qtbot):
    window, folder, draw = drawn
    session = window.session
    draw()

    def slow(name, size):
        time.sleep(0.02)

    with watch(folder, slow) as calls:
        session.files.save(folder / "a.bozz")
        drawn_meanwhile = 0
        while session.files.saving:
            drawn_meanwhile += 1
            radius = 40.0 + drawn_meanwhile
            session.gestures.stroke_lifted(stroke_of(circle(radius=radius), session.view.camera))
            qtbot.wait(20)
        settle(session, window.keeper)
    assert drawn_meanwhile > 3
    assert of_the_window(calls) == []
    assert os.path.getsize(folder / "a.bozz") > 1000
