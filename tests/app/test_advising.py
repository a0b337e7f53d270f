"""Advice on the view: when it is asked for, what is shown of it, and the way to the better view."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from bozzetto.plugin import ViewAdvice
from bozzetto.view.navigation import turn
from tests.adviser import MODELER
from tests.app.tablet import stroke_of


def draw(session, settle):
    session.pen_lifted(stroke_of([(300.0, 300.0), (400.0, 400.0)], session.camera))
    settle(session)


@pytest.fixture
def session(make_session, marks, settle):
    made = make_session(MODELER, extra=[marks.package])
    settle(made)
    return made


def test_advice_is_given_before_anything_is_drawn(session):
    assert len(session.document) == 0
    assert session.advising.advice.level == "refuse"


def test_advice_follows_the_view(session, settle):
    session.set_camera(session.advising.advice.better)
    settle(session)
    assert session.advising.advice.level == "good"
    assert session.advising.advice.better is None


def test_a_turning_view_is_asked_ten_times_a_second_at_most(session, settle, marks, qtbot):
    asked, begun = marks.asked, time.perf_counter()
    while time.perf_counter() - begun < 0.6:
        session.set_camera(turn(session.camera, 0.5, 0.0))
        qtbot.wait(5)
    settle(session)
    most = (time.perf_counter() - begun) / 0.1 + 1
    assert 2 <= marks.asked - asked <= most
    assert session.advising._asked[2] == session.camera


def test_the_newest_view_wins(session, settle, marks):
    """While one answer is awaited, views come and go: only the last one is asked for next."""
    gate, whole, seen = threading.Event(), marks.advise, []

    def slow(state, camera):
        seen.append(camera)
        gate.wait(5)
        return whole(state, camera)

    marks.advise = slow
    for _ in range(20):
        session.set_camera(turn(session.camera, 3.0, 2.0))
    gate.set()
    settle(session)
    assert len(seen) <= 3
    assert np.allclose(seen[-1].eye, session.camera.eye)


def test_advice_is_about_a_moved_model_where_it_stands(session, settle, marks):
    from bozzetto.geometry import Placement

    draw(session, settle)
    quarter = Placement((1.0, 0, 0, 0, 0, -1.0, 0, 1.0, 0), 1.0, (0.0, 0.0, 0.0))  # about x
    session.set_placement(session.selected, quarter)
    settle(session)
    # Seen from the front, which is from above in the frame of the model turned with it.
    assert session.advising.advice.level == "good"
    session.undo()
    settle(session)
    assert session.advising.advice.level == "refuse"


def test_layers_of_the_advice_are_shown_and_go_with_it(session, settle, boxes):
    assert [layer.name for layer in session.live_scene.layers] == ["vanishing"]
    session.activate_modeler("bozzetto.silhouette")
    settle(session)
    assert session.advising.advice is None
    assert session.live_scene.layers == ()


def test_a_modeler_that_gives_none_is_not_asked_again(make_session, settle):
    session = make_session("bozzetto.silhouette")
    session.set_camera(turn(session.camera, 5.0, 0.0))
    settle(session)
    assert session.advising.advice is None
    assert not session.advising.busy


@pytest.mark.parametrize(
    "advice", [42, None, ViewAdvice("fine", "x"), ViewAdvice("good", 3), ViewAdvice("good", "", 7)]
)
def test_wrong_advice_is_a_fault_and_not_asked_for_again(make_session, marks, settle, advice):
    marks.advise = lambda state, camera: advice
    session = make_session(MODELER, extra=[marks.package])
    for _ in range(3):
        session.set_camera(turn(session.camera, 5.0, 0.0))
        settle(session)
    assert session.advising.advice is None
    assert len([n for n in session.heard if n.kind == "fault"]) == 1
    assert marks.asked == 1
    draw(session, settle)
    assert len(session.document) == 1


def test_the_button_turns_the_view(make_window, marks, settle, qtbot):
    window = make_window(MODELER, extra=[marks.package])
    session = window.session
    settle(session)
    assert window.canvas.light.button.isVisible()
    window.actions_.run("view.better")
    settle(session)
    assert session.advising.advice.level == "good"
    assert not window.canvas.light.button.isVisible()
    window.actions_.refresh()
    assert not window.actions_.qaction("view.better").isEnabled()
    session.activate_modeler("bozzetto.silhouette")
    settle(session)
    assert not window.canvas.light.isVisible()
