"""What is slower than time says so; films are made of it all the same, and change nothing."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from PIL import Image
from PySide6 import QtWidgets

from bozzetto_app.paths import recovery_folder
from tests.app.session.test_motion import hang_a_ball, pulled
from tests.app.test_main_window import answer, question
from tests.spring import MODELER


def test_steps_that_take_longer_than_they_stand_for_are_told(make_window, springs, settle, qtbot):
    window = make_window(MODELER, extra=[springs.package])
    session, badge = window.session, window.canvas.pace_badge
    hang_a_ball(session, settle)
    told = []
    session.gestures.motion.pace_changed.connect(told.append)
    springs.takes = 0.2
    session.gestures.motion.play()
    qtbot.waitUntil(lambda: bool(told), timeout=30_000)
    assert 0.0 < told[0] < 0.3
    assert badge.isVisibleTo(window.canvas)
    assert "Slow motion" in badge.words
    assert window.canvas.rect().contains(badge.geometry())
    session.gestures.motion.stop()
    assert told[-1] is None
    assert not badge.isVisibleTo(window.canvas)
    springs.takes = 0.0


def test_a_film_is_made_of_the_next_seconds_and_changes_nothing(
    make_session, springs, settle, qtbot, tmp_path
):
    session = make_session(MODELER, extra=[springs.package])
    hang_a_ball(session, settle)
    pulled(session, qtbot)
    settle(session)
    before, steps = session.drawing.document, len(session.drawing.history.entries)
    for ending in ("glb", "gif"):
        session.files.exchange.films.make(tmp_path / f"ball.{ending}", 0.4)
    settle(session)
    data = (tmp_path / "ball.glb").read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    assert len(json.loads(data[20 : 20 + length])["animations"]) == 1
    with Image.open(tmp_path / "ball.gif") as film:
        assert film.size[1] <= 480
    assert session.drawing.document is before
    assert len(session.drawing.history.entries) == steps


def ask_film(window, monkeypatch, path):
    """Ask for a film in a window that is told where to; return the dialog that asks of what."""
    questions = window.files
    monkeypatch.setattr(questions, "_place", lambda *_: (path, True))
    questions.ask_film()
    return window.findChild(QtWidgets.QDialog, "film")


def test_a_film_of_what_the_pen_did_is_offered_first_and_holds_it(
    make_window, springs, settle, qtbot, tmp_path, monkeypatch
):
    window = make_window(MODELER, extra=[springs.package])
    session = window.session
    springs.records = True
    hang_a_ball(session, settle)
    pulled(session, qtbot)
    settle(session)
    before, steps = session.drawing.document, len(session.drawing.history.entries)
    (model,) = before
    kept = np.array(model.state.kept)
    assert len(kept) > 1
    asked = ask_film(window, monkeypatch, tmp_path / "ball.glb")
    assert asked.recorded.isChecked()
    assert f"{kept[-1, 0] - kept[0, 0]:.1f} s" in asked.recorded.text()
    asked.accept()
    settle(session)
    data = (tmp_path / "ball.glb").read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    said = json.loads(data[20 : 20 + length])
    (times,) = {one["input"] for one in said["animations"][0]["samplers"]}
    assert said["accessors"][times]["max"] == pytest.approx([kept[-1, 0] - kept[0, 0]])
    assert session.drawing.document is before
    assert len(session.drawing.history.entries) == steps


def test_the_next_seconds_can_be_filmed_in_the_place_of_a_recording(
    make_window, springs, settle, qtbot, tmp_path, monkeypatch
):
    window = make_window(MODELER, extra=[springs.package])
    session = window.session
    springs.records = True
    hang_a_ball(session, settle)
    pulled(session, qtbot)
    settle(session)
    made = []
    monkeypatch.setattr(session.files.exchange.films, "make", lambda *how: made.append(how))
    asked = ask_film(window, monkeypatch, tmp_path / "ball.gif")
    assert not asked.seconds.isEnabled()
    asked.next.setChecked(True)
    asked.seconds.setValue(1.5)
    asked.accept()
    assert made == [(tmp_path / "ball.gif", 1.5)]
    asked = ask_film(window, monkeypatch, tmp_path / "ball.gif")
    asked.reject()
    assert len(made) == 1


def test_a_plugin_that_fails_over_its_recording_is_told_and_the_rest_can_be_filmed(
    make_session, springs, settle, monkeypatch
):
    """It is asked on the window's thread, before anything is filmed."""
    session = make_session(MODELER, extra=[springs.package])
    hang_a_ball(session, settle)

    def fails(self, state):
        raise RuntimeError("no film")

    monkeypatch.setattr(type(springs), "recorded", fails, raising=False)
    kinds = []
    session.notices.noticed.connect(lambda notice: kinds.append(notice.kind))
    assert session.files.exchange.films.recorded == 0.0
    assert kinds == ["fault"]


def test_a_film_that_never_ends_is_refused_with_a_sentence(
    make_session, springs, settle, tmp_path, monkeypatch
):
    session = make_session(MODELER, extra=[springs.package])
    hang_a_ball(session, settle)
    said = []
    monkeypatch.setattr(session.notices, "complain", said.append)
    session.files.exchange.films.make(tmp_path / "ball.glb", 1e6)
    settle(session)
    assert not (tmp_path / "ball.glb").exists()
    assert "frames" in said[0].message


def test_a_window_closed_while_something_plays_leaves_nothing_to_recover(
    make_window, springs, settle, qtbot
):
    window = make_window(MODELER, extra=[springs.package])
    session = window.session
    hang_a_ball(session, settle)
    session.gestures.motion.play()
    steps = len(springs.seen)
    qtbot.waitUntil(lambda: len(springs.seen) > steps + 5, timeout=30_000)
    window.close()
    qtbot.waitUntil(lambda: question(window) is not None)
    assert not session.gestures.motion.is_playing
    answer(window, "Don’t save")
    qtbot.waitUntil(lambda: not window.isVisible())
    assert not list(recovery_folder().glob("*/*"))
