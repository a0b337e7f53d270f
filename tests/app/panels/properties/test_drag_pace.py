"""Values of a drag: the first at once, the newest at each beat, the last at the end."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QObject

from bozzetto_app.panels.properties.drag_pace import DragPace


@pytest.fixture
def taken():
    return []


@pytest.fixture
def pace(qtbot, taken):
    owner = QObject()
    yield DragPace(lambda value, going: taken.append((value, going)), owner)
    owner.deleteLater()


def test_the_first_value_is_taken_at_once_and_the_newest_at_the_beat(qtbot, pace, taken):
    for value in range(5):
        pace.change(value, True)
    assert taken == [(0, True)]
    qtbot.waitUntil(lambda: len(taken) == 2)
    assert taken[-1] == (4, True)


def test_the_last_value_is_taken_when_the_drag_ends_and_only_once(qtbot, pace, taken):
    pace.change(1, True)
    pace.change(2, True)
    pace.end()
    assert taken == [(1, True), (2, True)]
    pace.change(3, True)
    assert taken[-1] == (3, True), "the next drag begins at once"


def test_a_value_that_is_no_drag_overtakes_what_waits(pace, taken):
    pace.change(1, True)
    pace.change(2, True)
    pace.change(3, False)
    pace.end()
    assert taken == [(1, True), (3, False)]


def test_what_waits_for_another_object_is_dropped(pace, taken):
    pace.change(1, True)
    pace.change(2, True)
    pace.forget()
    pace.end()
    assert taken == [(1, True)]
