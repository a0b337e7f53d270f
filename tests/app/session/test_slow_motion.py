"""What is slower than time says so; films are made of it all the same, and change nothing."""

from __future__ import annotations

import json
import struct

from PIL import Image

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
