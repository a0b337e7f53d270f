"""Tools that move a model in time: one step of the history, never behind the pen."""

from __future__ import annotations

import time

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.plugin import Drag
from tests.app.tablet import stroke_of
from tests.spring import MODELER, Pull


def hang_a_ball(session, settle):
    session.toolbox.take_tool("draw")
    points = [(400.0, 300.0), (420.0, 310.0), (480.0, 330.0)]
    session.gestures.stroke_lifted(stroke_of(points, session.view.camera))
    settle(session)
    session.toolbox.take_tool("pull")
    settle(session)


@pytest.fixture
def session(make_session, springs, settle):
    made = make_session(MODELER, extra=[springs.package])
    hang_a_ball(made, settle)
    yield made
    made.gestures.motion.stop()
    settle(made)


def ball(session):
    return session.selection.model.state


def drag_to(session, *points):
    return Drag("ball", stroke_of(list(points), session.view.camera))


def path_of(count):
    return [(480.0 + 3.0 * k, 330.0 + 2.0 * k) for k in range(count)]


def test_what_a_press_was_taken_for_is_said_where_the_tool_takes_it(session):
    session.gestures.explain("tap")
    assert "wants a short tap" in session.heard[-1].text
    box = session.toolbox
    box.tools = tuple(tool._replace(touches=False) for tool in box.tools)
    session.gestures.explain("tap")
    assert session.heard[-1].text == "Nothing changed. Pull the ball."


def wait_for_steps(session, qtbot, count):
    had = ball(session).steps
    qtbot.waitUntil(lambda: ball(session).steps >= had + count, timeout=20_000)


def pulled(session, qtbot, count=20):
    """Drag in many small moves, each of which is taken by a step; then lift."""
    path = path_of(count)
    for k in range(2, count):
        session.gestures.handle_moved(drag_to(session, *path[:k]))
        wait_for_steps(session, qtbot, 1)
    session.gestures.handle_released(drag_to(session, *path))
    qtbot.waitUntil(lambda: not session.gestures.motion.is_moving, timeout=20_000)
    return path


def test_from_the_touch_to_the_lift_is_one_step_of_the_history(session, springs, qtbot, settle):
    before, steps = ball(session), len(session.drawing.history.entries)
    path = pulled(session, qtbot)
    settle(session)
    assert len(session.drawing.history.entries) == steps + 1
    assert session.drawing.history.undo_label == "Pull"
    assert ball(session).steps >= 19
    camera = session.view.camera
    lifted_at = camera.on_plane([path[-1]], (0, 0, 0), (0, 1, 0))[0]
    assert ball(session).place == pytest.approx(tuple(lifted_at))
    session.drawing.undo()
    assert ball(session) == before
    session.drawing.redo()
    assert ball(session).place == pytest.approx(tuple(lifted_at))
    pulled(session, qtbot, 5)
    assert len(session.drawing.history.entries) == steps + 2


def test_each_step_has_the_pen_where_it_is(session, springs, qtbot):
    springs.takes = 0.05
    path = path_of(30)
    for k in range(2, 30):
        session.gestures.handle_moved(drag_to(session, *path[:k]))
        qtbot.wait(5)
    session.gestures.handle_released(drag_to(session, *path))
    qtbot.waitUntil(lambda: not session.gestures.motion.is_moving, timeout=20_000)
    lengths = [len(held.path) for held in springs.seen]
    assert lengths == sorted(lengths)
    assert lengths[-1] == 30
    assert len(lengths) < 29, "a slow step waits for no move that was overtaken"


def test_what_is_shown_is_where_the_ball_is(session, qtbot, settle):
    pulled(session, qtbot)
    settle(session)
    (line,) = (item for _, item in session.scene.visible.items() if hasattr(item, "points"))
    assert np.allclose(line.points[1], ball(session).place, atol=1e-3)


def test_a_drag_begins_anywhere_and_a_touch_stays_a_tap(make_window, springs, settle, qtbot):
    from tests.app.tablet import Stylus

    window = make_window(MODELER, extra=[springs.package])
    session = window.session
    hang_a_ball(session, settle)
    Stylus(window.canvas).draw([(100.0 + 4.0 * k, 120.0) for k in range(20)])
    qtbot.waitUntil(lambda: not session.gestures.motion.is_moving, timeout=20_000)
    assert springs.seen
    assert {held.handle for held in springs.seen} == {""}
    Stylus(window.canvas).draw([(100.0, 120.0), (100.5, 120.0)])
    settle(session)
    assert ball(session).speed[2] > 0.0
    assert session.drawing.history.undo_label == "Pull"


def test_it_plays_until_it_is_stopped(session, qtbot, settle):
    steps = len(session.drawing.history.entries)
    assert session.gestures.motion.can_play
    begun = time.perf_counter()
    session.gestures.motion.play()
    wait_for_steps(session, qtbot, 10)
    session.gestures.motion.play()
    lasted = time.perf_counter() - begun
    assert not session.gestures.motion.is_playing
    settle(session)
    stopped = ball(session)
    assert 0.0 < stopped.clock <= lasted
    qtbot.wait(60)
    assert ball(session) is stopped
    assert len(session.drawing.history.entries) == steps + 1


def test_to_play_takes_the_tool_for_it(session, qtbot, settle):
    able = session.toolbox.tool
    session.toolbox.take_tool("draw")
    assert not session.gestures.motion.can_play
    assert session.gestures.motion.player == able
    session.gestures.motion.play()
    assert session.toolbox.tool == able
    wait_for_steps(session, qtbot, 3)
    session.gestures.motion.play()
    settle(session)
    assert ball(session).clock > 0.0
    session.selection.select(None)
    assert session.gestures.motion.player == ""


def test_a_hand_may_hold_what_plays(session, springs, qtbot):
    steps = len(session.drawing.history.entries)
    session.gestures.motion.play()
    wait_for_steps(session, qtbot, 3)
    session.gestures.handle_moved(drag_to(session, *path_of(4)))
    qtbot.waitUntil(lambda: springs.seen[-1] is not None, timeout=20_000)
    session.gestures.handle_released(drag_to(session, *path_of(6)))
    qtbot.waitUntil(lambda: springs.seen[-1] is None, timeout=20_000)
    assert session.gestures.motion.is_playing
    session.escape()
    assert not session.gestures.motion.is_moving
    assert len(session.drawing.history.entries) == steps + 1


def test_what_plays_goes_on_where_a_hand_misses_it(session, springs, qtbot, monkeypatch):
    """A pen that missed a corner that moved stopped all of it."""
    step = Pull.step

    def missing(self, state, held, seconds, context):
        if held is not None and held.path.x[0] != 480.0:
            raise UserError("There is no ball here.")
        return step(self, state, held, seconds, context)

    monkeypatch.setattr(Pull, "step", missing)
    motion = session.gestures.motion
    motion.play()
    wait_for_steps(session, qtbot, 3)
    beside = [(100.0 + k, 100.0) for k in range(6)]
    session.gestures.handle_moved(drag_to(session, *beside[:3]))
    wait_for_steps(session, qtbot, 5)
    session.gestures.handle_moved(drag_to(session, *beside))
    session.gestures.handle_released(drag_to(session, *beside))
    wait_for_steps(session, qtbot, 5)
    assert motion.is_playing
    assert [each.text for each in session.heard].count("There is no ball here.") == 1
    session.gestures.handle_moved(drag_to(session, *path_of(4)))
    qtbot.waitUntil(lambda: springs.seen[-1] is not None, timeout=20_000)
    session.gestures.handle_released(drag_to(session, *path_of(6)))
    session.escape()
    session.gestures.handle_moved(drag_to(session, *beside))
    qtbot.waitUntil(lambda: not motion.is_moving, timeout=20_000)


def test_a_step_keeps_its_name_when_another_modeler_is_taken(session, qtbot):
    session.gestures.motion.play()
    wait_for_steps(session, qtbot, 3)
    session.toolbox.take_modeler("bozzetto.silhouette")
    qtbot.waitUntil(lambda: not session.gestures.motion.is_moving, timeout=20_000)
    assert session.drawing.history.undo_label == "Pull"


def test_what_is_changed_meanwhile_is_kept(session, qtbot, settle):
    session.gestures.motion.play()
    wait_for_steps(session, qtbot, 3)
    session.objects.set_parameter("stiffness", 3.0)
    wait_for_steps(session, qtbot, 3)
    session.gestures.motion.stop()
    settle(session)
    assert ball(session).stiffness == 3.0


@pytest.mark.parametrize("way", ["undo", "tool", "modeler", "delete", "close"])
def test_something_else_stops_it(session, qtbot, settle, way):
    session.gestures.motion.play()
    wait_for_steps(session, qtbot, 3)
    if way == "undo":
        session.drawing.undo()
    elif way == "tool":
        session.toolbox.take_tool("draw")
    elif way == "modeler":
        session.toolbox.take_modeler("bozzetto.silhouette")
    elif way == "delete":
        session.objects.delete(session.selection.id)
    else:
        session.files.new()
    qtbot.waitUntil(lambda: not session.gestures.motion.is_moving, timeout=20_000)
    document = session.drawing.document
    settle(session)
    assert session.drawing.document is document
    assert not [notice for notice in session.heard if notice.kind in ("fault", "error")]


def test_a_drag_that_is_dropped_goes_back(session, qtbot, settle):
    before = ball(session)
    session.gestures.handle_moved(drag_to(session, *path_of(4)))
    wait_for_steps(session, qtbot, 2)
    session.gestures.cancel()
    settle(session)
    assert ball(session) == before
    assert not session.gestures.motion.is_moving


def refuses(state):
    raise UserError("It cannot go on. Pull less.")


def fails(state):
    raise ValueError("half a ball")


@pytest.mark.parametrize(("misdeed", "kind"), [(refuses, "error"), (fails, "fault")])
def test_a_step_that_fails_ends_it_where_it_is(session, springs, qtbot, settle, misdeed, kind):
    session.gestures.motion.play()
    wait_for_steps(session, qtbot, 4)
    springs.misdeed = misdeed
    qtbot.waitUntil(lambda: not session.gestures.motion.is_moving, timeout=20_000)
    stopped = ball(session)
    assert stopped.steps >= 4
    told = [notice for notice in session.heard if notice.kind == kind]
    assert len(told) == 1
    springs.misdeed = lambda state: None
    pulled(session, qtbot, 5)
    assert ball(session).steps > stopped.steps


def test_a_locked_ball_stays(session, qtbot, settle):
    session.objects.set_locked(session.selection.id, True)
    before = ball(session)
    session.gestures.handle_moved(drag_to(session, *path_of(4)))
    session.gestures.handle_released(drag_to(session, *path_of(5)))
    session.gestures.motion.play()
    settle(session)
    assert ball(session) is before
    assert any("locked" in notice.text for notice in session.heard)
    assert not session.gestures.motion.is_moving


def test_a_film_is_offered_whatever_tool_is_in_the_hand(make_window, springs, settle):
    window = make_window(MODELER, extra=[springs.package])
    film = next(one for one in window.actions_.actions() if one.id == "file.film")
    assert not film.enabled()
    assert "Choose an object" in film.why_not()
    hang_a_ball(window.session, settle)
    for tool in ("pull", "draw"):
        window.session.toolbox.take_tool(tool)
        assert film.enabled()
    window.session.selection.select(None)
    assert not film.enabled()
