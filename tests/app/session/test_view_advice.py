"""Advice on the view: when it is asked for, what is shown of it, and the way to the better view."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.plugin import ViewAdvice
from bozzetto.scene import Layer, Lines, Scene
from bozzetto.view.navigation import turn
from tests.adviser import MODELER
from tests.app.tablet import Stylus, stroke_of


def draw(session, settle):
    session.gestures.stroke_lifted(stroke_of([(300.0, 300.0), (400.0, 400.0)], session.view.camera))
    settle(session)


@pytest.fixture
def session(make_session, marks, settle):
    made = make_session(MODELER, extra=[marks.package])
    settle(made)
    return made


def test_advice_is_given_before_anything_is_drawn(session):
    assert len(session.drawing.document) == 0
    assert session.advice.advice.level == "refuse"


def test_advice_follows_the_view(session, settle):
    session.view.set_camera(session.advice.advice.better)
    settle(session)
    assert session.advice.advice.level == "good"
    assert session.advice.advice.better is None


def test_a_turning_view_is_asked_ten_times_a_second_at_most(session, settle, marks, qtbot):
    asked, begun = marks.asked, time.perf_counter()
    while time.perf_counter() - begun < 0.6:
        session.view.set_camera(turn(session.view.camera, 0.5, 0.0))
        qtbot.wait(5)
    settle(session)
    most = (time.perf_counter() - begun) / 0.1 + 1
    assert 2 <= marks.asked - asked <= most
    assert session.advice.is_about(session.view.camera)


def test_the_newest_view_wins(session, settle, marks):
    """While one answer is awaited, views come and go: only the last one is asked for next."""
    gate, whole, seen = threading.Event(), marks.advise, []

    def slow(state, camera):
        seen.append(camera)
        gate.wait(5)
        return whole(state, camera)

    marks.advise = slow
    for _ in range(20):
        session.view.set_camera(turn(session.view.camera, 3.0, 2.0))
    gate.set()
    settle(session)
    assert len(seen) <= 3
    assert np.allclose(seen[-1].eye, session.view.camera.eye)


def test_advice_is_about_a_moved_model_where_it_stands(session, settle, marks):
    from bozzetto.geometry import Placement

    draw(session, settle)
    quarter = Placement((1.0, 0, 0, 0, 0, -1.0, 0, 1.0, 0), 1.0, (0.0, 0.0, 0.0))  # about x
    session.objects.set_placement(session.selection.id, quarter)
    settle(session)
    # Seen from the front, which is from above in the frame of the model turned with it.
    assert session.advice.advice.level == "good"
    session.drawing.undo()
    settle(session)
    assert session.advice.advice.level == "refuse"


def test_layers_of_the_advice_are_shown_and_go_with_it(session, settle, boxes):
    assert [layer.name for layer in session.scene.live.layers] == ["vanishing"]
    session.toolbox.take_modeler("bozzetto.silhouette")
    settle(session)
    assert session.advice.advice is None
    assert session.scene.live.layers == ()


def test_a_modeler_that_gives_none_is_not_asked_again(make_session, settle):
    session = make_session("bozzetto.silhouette")
    session.view.set_camera(turn(session.view.camera, 5.0, 0.0))
    settle(session)
    assert session.advice.advice is None
    assert not session.advice.busy


@pytest.mark.parametrize(
    "advice",
    [42, "good", ViewAdvice("fine", "x"), ViewAdvice("good", 3), ViewAdvice("good", "", 7)],
)
def test_wrong_advice_is_a_fault_and_not_asked_for_again(make_session, marks, settle, advice):
    marks.advise = lambda state, camera: advice
    session = make_session(MODELER, extra=[marks.package])
    for _ in range(3):
        session.view.set_camera(turn(session.view.camera, 5.0, 0.0))
        settle(session)
    assert session.advice.advice is None
    assert len([n for n in session.heard if n.kind == "fault"]) == 1
    assert marks.asked == 1
    draw(session, settle)
    assert len(session.drawing.document) == 1


def test_the_button_turns_the_view(make_window, marks, settle, qtbot):
    window = make_window(MODELER, extra=[marks.package])
    session = window.session
    settle(session)
    assert not window.canvas.light.button.isVisible(), "a new sheet is seen from there"
    window.actions_.run("view.front")
    settle(session)
    assert window.canvas.light.button.isVisible()
    window.actions_.run("view.better")
    settle(session)
    assert session.advice.advice.level == "good"
    assert not window.canvas.light.button.isVisible()
    window.actions_.refresh()
    assert not window.actions_.qaction("view.better").isEnabled()
    session.toolbox.take_modeler("bozzetto.silhouette")
    settle(session)
    assert not window.canvas.light.isVisible()


# -- a picture that has another camera ---------------------------------------------------------


def beside(camera, step=40.0):
    """The same view from a place beside it."""
    eye = tuple(part + step * (axis == 0) for axis, part in enumerate(camera.eye))
    return replace(camera, eye=eye)


@pytest.fixture
def followed(make_window, marks, settle):
    """A window over a picture whose camera stands at `marks.goal`; None for where one looks."""
    marks.goal = None

    def advise(state, camera):
        if marks.goal is None or camera.eye == marks.goal.eye:
            return ViewAdvice("good", "Through the picture", pinned=True)
        return ViewAdvice("good", "It moved", better=marks.goal, pinned=True, follow=True)

    marks.advise = advise
    window = make_window(MODELER, extra=[marks.package])
    window.welcome.hide()
    draw(window.session, settle)
    return window


def test_the_view_goes_along_at_once(followed, marks, settle):
    session, canvas = followed.session, followed.canvas
    canvas.motion.reduced = False
    marks.goal = beside(session.view.camera)
    draw(session, settle)
    assert not canvas.motion.is_running
    assert session.view.camera.eye == marks.goal.eye
    settle(session)
    assert not session.advice.advice.follow


def test_in_a_drag_advice_is_on_the_previews_that_are_shown(followed, marks, settle, qtbot):
    """Who advises on results is asked with each of them, and never has to solve."""
    session, asked = followed.session, []

    def on_result(state, result, camera, seen):
        asked.append((state, result, camera, seen))
        where = beside(home, 10.0 * state.box)
        if camera.eye == where.eye:
            return ViewAdvice("good", "Through the picture", pinned=True)
        return ViewAdvice("good", "It moved", better=where, pinned=True, follow=True)

    home = session.view.camera
    marks.advice_on_result = on_result
    marks.solve = lambda state, job: (state.box, job.quality)
    marks.curves = lambda state, result: ()
    draw(session, settle)
    asked.clear()
    by_state = marks.asked
    for number in range(1, 6):
        model = session.selection.model
        changed = replace(model, state=replace(model.state, box=float(number)))
        session.drawing.commit("Box", session.drawing.document.with_model(changed), "drag")
        goal = beside(home, 10.0 * number).eye
        qtbot.waitUntil(lambda goal=goal: session.view.camera.eye == goal)
        assert session.drawing.is_dragging
    assert {result for _, result, _, _ in asked} == {(float(n), "preview") for n in range(1, 6)}
    assert all(state.box == result[0] for state, result, _, _ in asked)
    newest = next(seen for state, _, _, seen in asked if state.box == 4.0)
    assert newest[0] == (3.0, "preview"), "to which the view had gone"
    session.solver.let_go()
    settle(session)
    assert asked[-1][1] == (5.0, "final")
    assert marks.asked == by_state


def test_it_waits_for_the_hand(followed, marks, settle):
    """What is drawn belongs to the view in which it is drawn."""
    session, canvas = followed.session, followed.canvas
    stylus, before = Stylus(canvas), session.view.camera
    stylus.press((300.0, 300.0))
    stylus.move((320.0, 320.0))
    marks.goal = beside(before)
    model = session.selection.model
    renamed = replace(model, name="Other")  # advice is asked for on what is another model now
    session.drawing.commit("Rename", session.drawing.document.with_model(renamed))
    session.advice.look()
    settle(session)
    assert session.advice.advice.follow
    assert session.view.camera == before
    stylus.move((380.0, 380.0))
    stylus.lift((400.0, 400.0))
    settle(session)
    assert session.view.camera.eye == marks.goal.eye
    drawn = before.on_plane([(300.0, 300.0), (400.0, 400.0)], (0, 0, 0), (0, 1, 0))
    assert np.allclose(session.selection.model.state.marks[-1], drawn, atol=2.0)


def test_a_view_that_was_turned_meanwhile_stays(followed, marks, settle):
    session = followed.session
    advising = session.advice
    marks.goal = beside(session.view.camera)
    turned = turn(session.view.camera, 20.0, 5.0)
    session.view.camera = turned  # turned between the question and its answer
    advising.advice = ViewAdvice("good", "It moved", marks.goal, pinned=True, follow=True)
    advising.changed.emit()
    assert session.view.camera == turned


def test_layers_of_another_tool_are_not_there(session, settle, marks):
    lines = (Lines(np.zeros((2, 3), np.float32)),)
    mine, other = Layer("mine", lines, tool="mark"), Layer("other", lines, tool="another")
    marks.advise = lambda state, camera: ViewAdvice("good", "", scene=Scene((mine, other)))
    draw(session, settle)
    session.view.set_camera(turn(session.view.camera, 3.0, 0.0))
    settle(session)
    assert [layer.name for layer in session.scene.advice.layers] == ["mine"]


def test_a_model_still_to_be_drawn_is_begun_beside_what_is_visible(make_session, settle):
    """A product gets a box to draw on, but not where there is something to draw on already.

    It follows what its first curve is drawn on.
    """
    session = make_session("bozzetto.product")
    settle(session)
    assert session.scene.advice.layers
    session.toolbox.take_modeler("bozzetto.silhouette")
    angles = np.linspace(0.0, 2.0 * np.pi, 60)
    circle = np.column_stack((400.0 + 90.0 * np.cos(angles), 300.0 + 90.0 * np.sin(angles)))
    session.gestures.stroke_lifted(stroke_of(circle, session.view.camera))
    settle(session)
    session.toolbox.take_modeler("bozzetto.product")
    settle(session)
    assert not session.scene.advice.layers
    session.gestures.stroke_lifted(stroke_of(circle[5:25] * 0.5 + 175.0, session.view.camera))
    settle(session)
    drawn = session.drawing.document.models[-1]
    assert drawn.modeler == "bozzetto.product"
    assert [type(node).__name__ for node in drawn.state.nodes] == ["FollowedShape", "Curve"]
    session.drawing.undo()
    session.drawing.undo()
    settle(session)
    assert session.scene.advice.layers


def test_advice_that_looks_the_same_is_shown_once(session):
    """A view that goes along with a picture asks about it again: nothing is drawn anew."""
    told = []
    session.scene.live_changed.connect(lambda: told.append(session.scene.advice))
    line = Lines([(0.0, 0.0, 0.0), (9.0, 0.0, 0.0)])
    session.scene.show_advice(Scene((Layer("a", (line,)),)))
    assert len(told) == 1
    session.scene.show_advice(Scene((Layer("a", (line,)),)))
    assert len(told) == 1
    for other in (
        Scene((Layer("b", (line,)),)),
        Scene((Layer("b", (replace(line, color="accent"),)),)),
        Scene((Layer("b", (line,)), Layer("c", (line,)))),
        Scene(),
    ):
        before = len(told)
        session.scene.show_advice(other)
        assert len(told) == before + 1
        assert len(told[-1].layers) == len(other.layers)
