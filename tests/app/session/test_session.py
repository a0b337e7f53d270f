"""The session without a window: gestures become states, each edit is one step, work is orderly."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from bozzetto.document import edit
from bozzetto.document.model import Underlay
from bozzetto.errors import UserError
from bozzetto.exchange.mesh.manifold_check import bounds_volume
from bozzetto.ink.stroke import Stroke
from tests.app.seen import meshes
from tests.app.tablet import circle, stroke_of
from tests.app.troublemaker import MODELER

ARC = 0.6
"""Share of a circle that is far from closed."""


@pytest.fixture
def draw(settle):
    def draw_on(session, *strokes):
        for points in strokes:
            session.gestures.stroke_lifted(stroke_of(points, session.view.camera))
            settle(session)

    return draw_on


def kinds(session):
    return [notice.kind for notice in session.heard]


# -- from ink to solids ------------------------------------------------------------------------


def test_a_closed_outline_is_a_watertight_solid_and_a_second_one_inside_a_hole(
    make_session, draw, settle
):
    session = make_session()
    draw(session, circle(radius=150))
    assert all(map(bounds_volume, meshes(session)))
    assert len(meshes(session)) == 1
    assert session.solver.report["parts"][0]["genus"] == 0
    draw(session, circle(radius=50))
    assert bounds_volume(meshes(session)[0])
    assert session.solver.report["parts"][0]["genus"] == 1
    session.drawing.undo()
    settle(session)
    assert session.solver.report["parts"][0]["genus"] == 0
    assert "fault" not in kinds(session)
    assert "error" not in kinds(session)


def eight():
    """An outline that crosses itself at (500, 360)."""
    turn = np.linspace(0, 2 * np.pi, 120)
    return np.column_stack((500 + 150 * np.sin(turn), 360 + 100 * np.sin(2 * turn)))


def test_an_outline_that_crosses_itself_is_refused_with_its_place_and_waits(make_session, draw):
    session = make_session()
    draw(session, eight())
    refused = [notice for notice in session.heard if notice.kind == "error"]
    assert len(refused) == 1
    assert np.hypot(*(np.array(refused[0].places[0]) - (500, 360))) < 10
    assert len(session.drawing.document) == 0
    (ink,) = session.drawing.marked_ink
    assert (ink.status, ink.reason) == ("refused", refused[0].text)
    assert ink.places == refused[0].places
    assert session.scene.live.layers == ()
    draw(session, circle())
    assert len(session.drawing.document) == 1
    assert session.drawing.marked_ink == (ink,)


def test_open_strokes_wait_with_a_hint_until_enter(session, draw, settle):
    draw(session, circle(share=ARC))
    assert len(session.drawing.pending) == 1
    assert session.hints.step.sentence == "Close the box, or press Enter."
    assert session.drawing.is_modified
    draw(session, circle(share=ARC, radius=60))
    assert len(session.drawing.pending) == 2
    session.gestures.drop_last()
    assert len(session.drawing.pending) == 1
    session.gestures.commit()
    settle(session)
    assert session.drawing.pending == ()
    assert len(session.drawing.document.models[0].state.strokes) == 1


def test_enter_at_once_after_the_stroke_makes_one_object(session, settle):
    session.gestures.stroke_lifted(stroke_of(circle(share=ARC), session.view.camera))
    session.gestures.commit()
    settle(session)
    assert session.drawing.pending == ()
    assert [len(model.state.strokes) for model in session.drawing.document] == [1]


def test_closed_strokes_in_quick_succession_are_taken_one_by_one(session, settle):
    for number in range(5):
        session.gestures.stroke_lifted(stroke_of(circle(radius=50 + number), session.view.camera))
    settle(session)
    assert session.drawing.pending == ()
    strokes = session.drawing.document.models[0].state.strokes
    assert len(strokes) == 5
    widths = [np.ptp(stroke.x) for stroke in strokes]
    assert widths == sorted(widths)
    assert len(set(widths)) == 5
    assert len(session.drawing.history.entries) == 6


def test_enter_with_nothing_waiting_starts_a_new_object(session, draw):
    draw(session, circle())
    session.gestures.commit()
    assert session.selection.id is None
    draw(session, circle())
    assert [model.name for model in session.drawing.document] == ["Boxes", "Boxes 2"]
    assert session.selection.id == session.drawing.document.models[1].id


def test_a_stroke_taken_back_while_it_is_worked_on_leaves_nothing(session, boxes, settle):
    gate = threading.Event()
    boxes.misdeeds["apply"] = lambda state, gesture, context: (gate.wait(10), state)[1]
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    session.drawing.undo()
    gate.set()
    settle(session)
    assert session.drawing.pending == ()
    assert len(session.drawing.document) == 0
    assert session.drawing.history.entries == ("Start", "Stroke")
    assert not session.drawing.is_modified
    del boxes.misdeeds["apply"]
    session.drawing.redo()
    settle(session)
    assert session.drawing.pending == ()
    assert len(session.drawing.document) == 1
    assert session.drawing.history.entries == ("Start", "Draw")


def test_a_gesture_overtaken_by_an_edit_is_worked_out_again(session, boxes, draw, settle):
    draw(session, circle())
    gate, well = threading.Event(), boxes.misdeeds
    begun = threading.Event()

    def slow(state, gesture, context):
        begun.set()
        gate.wait(10)
        del well["apply"]
        return session.workbench.tool(MODELER, "draw").apply(state, gesture, context)

    well["apply"] = slow
    session.gestures.stroke_lifted(stroke_of(circle(radius=44), session.view.camera))
    assert begun.wait(10)
    session.objects.set_parameter("size", 33.0)
    gate.set()
    settle(session)
    state = session.drawing.document.models[0].state
    assert state.size == 33.0
    assert len(state.strokes) == 2
    assert session.drawing.pending == ()


def test_ink_waits_while_the_tools_are_still_being_imported(make_session, boxes, settle):
    session = make_session(extra=[boxes.package])
    session.toolbox.take_modeler(MODELER)
    assert session.toolbox.tool == ""
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    settle(session)
    assert len(session.drawing.document) == 1
    assert session.toolbox.tool == "draw"


def test_tools_that_are_known_stand_at_once(session, settle):
    settle(session)
    tools = session.toolbox.tools
    session.toolbox.take_modeler("bozzetto.silhouette")
    session.toolbox.take_modeler(MODELER)
    assert session.toolbox.tools == tools
    assert session.toolbox.tool == tools[0].id
    settle(session)
    assert session.toolbox.tools == tools


def test_changing_the_modeler_keeps_waiting_ink_and_leaves_others_models_alone(session, draw):
    draw(session, circle(), circle(share=ARC))
    first = session.drawing.document.models[0]
    session.toolbox.take_modeler("bozzetto.silhouette")
    assert len(session.drawing.pending) == 1
    session.gestures.drop_last()
    draw(session, circle(radius=140))
    assert [model.modeler for model in session.drawing.document] == [MODELER, "bozzetto.silhouette"]
    assert session.drawing.document.models[0] is first


def test_locked_and_hidden_models_get_no_ink(session, draw):
    draw(session, circle())
    model = session.drawing.document.models[0]
    session.objects.set_locked(model.id, True)
    draw(session, circle())
    session.selection.select(model.id)
    session.objects.set_locked(model.id, False)
    session.objects.set_visible(model.id, False)
    draw(session, circle())
    assert len(session.drawing.document) == 3
    assert session.drawing.document.models[0].state is model.state


# -- undo, redo, edits ---------------------------------------------------------------------------


def test_undo_and_redo_walk_through_everything_drawn(session, draw, settle):
    draw(session, *(circle(radius=40 + 10 * k) for k in range(4)))
    states = [session.drawing.document]
    while session.drawing.history.position:
        session.drawing.undo()
        states.append(session.drawing.document)
    assert [sum(len(m.state.strokes) for m in d) for d in states] == [4, 3, 2, 1, 0]
    for before in reversed(states[:-1]):
        session.drawing.redo()
        assert session.drawing.document is before
    session.drawing.redo()
    settle(session)
    assert session.drawing.document is states[0]
    assert len(meshes(session)) == 4


@pytest.mark.parametrize(
    "edit",
    [
        lambda s, m: s.objects.rename(m.id, "Cat"),
        lambda s, m: s.objects.set_visible(m.id, False),
        lambda s, m: s.objects.set_locked(m.id, True),
        lambda s, m: s.objects.set_color(m.id, (10, 200, 30)),
        lambda s, m: s.objects.delete(m.id),
        lambda s, m: s.objects.duplicate(m.id),
        lambda s, m: s.objects.move_to(m.id, 1),
        lambda s, m: s.objects.set_parameter("size", 42.0),
    ],
    ids="rename hide lock colour delete duplicate reorder parameter".split(),
)
def test_every_edit_is_one_step_back_and_forth(session, draw, settle, edit):
    draw(session, circle())
    session.gestures.commit()
    draw(session, circle())
    session.selection.select(session.drawing.document.models[0].id)
    before, steps = session.drawing.document, len(session.drawing.history.entries)
    edit(session, session.drawing.document.models[0])
    after = session.drawing.document
    assert after is not before
    assert len(session.drawing.history.entries) == steps + 1
    session.drawing.undo()
    assert session.drawing.document is before
    session.drawing.redo()
    settle(session)
    assert session.drawing.document is after
    assert "error" not in kinds(session)


def test_a_slider_drag_is_one_step_and_solves_what_it_ends_with(session, draw, settle):
    draw(session, circle())
    steps = len(session.drawing.history.entries)
    for value in np.linspace(10, 60, 30):
        session.objects.set_parameter("size", float(value), dragging=True)
    session.objects.end_drag()
    for value in (50.0, 40.0):
        session.objects.set_parameter("size", value, dragging=True)
    session.objects.end_drag()
    settle(session)
    assert len(session.drawing.history.entries) == steps + 2
    assert np.ptp(meshes(session)[0].vertices, axis=0) == pytest.approx(40)
    session.drawing.undo()
    settle(session)
    assert np.ptp(meshes(session)[0].vertices, axis=0) == pytest.approx(60)


def test_refused_edits_say_why_and_change_nothing(session, draw):
    draw(session, circle())
    model = session.drawing.document.models[0]
    session.objects.set_locked(model.id, True)
    before = session.drawing.document
    for refused in (
        lambda: session.objects.rename(model.id, "Cat"),
        lambda: session.objects.delete(model.id),
        lambda: session.objects.set_parameter("size", 3.0),
        lambda: session.objects.rename("nobody", "Cat"),
    ):
        session.heard.clear()
        refused()
        assert kinds(session) == ["error"]
        assert session.drawing.document is before
    session.objects.set_locked(model.id, False)
    session.heard.clear()
    session.objects.set_parameter("size", 1e9)
    assert kinds(session) == ["error"]


def test_underlays_fade_as_one_step_and_leave(session):
    pixels = np.full((4, 6, 4), 255, np.uint8)
    place = {"corner": (0.0, 0.0, 0.0), "across": (6.0, 0.0, 0.0), "down": (0.0, 0.0, -4.0)}
    session.objects.edit(edit.add_underlay, Underlay("u1", "Sketch", pixels, **place))
    for opacity in (0.4, 0.3, 0.2):
        session.objects.set_underlay_opacity("u1", opacity, dragging=True)
    session.objects.end_drag()
    assert session.drawing.document.underlays[0].opacity == 0.2
    assert len(session.drawing.history.entries) == 3
    assert len(session.scene.visible.layers) == 1
    session.objects.set_underlay_visible("u1", False)
    assert len(session.scene.visible.layers) == 0
    session.objects.delete_underlay("u1")
    assert session.drawing.document.underlays == ()


def test_jumping_in_the_history_goes_to_the_ink_that_waited_then(session, draw, settle):
    draw(session, circle(), circle(), circle(share=ARC))
    session.drawing.go_to(1)
    settle(session)
    assert session.drawing.pending == ()
    assert len(session.drawing.document.models[0].state.strokes) == 1
    session.drawing.go_to(3)
    settle(session)
    assert len(session.drawing.pending) == 1
    session.gestures.commit()
    settle(session)
    assert len(session.drawing.document.models[0].state.strokes) == 3


# -- work under way ------------------------------------------------------------------------------


class Slow:
    """A solve that goes on until it is let go, and listens meanwhile."""

    def __init__(self, boxes):
        self.gate, self.begun, self.stopped = threading.Event(), threading.Event(), 0
        self.boxes = boxes
        boxes.misdeeds["solve"] = self.solve

    def solve(self, state, job):
        self.begun.set()
        try:
            while not self.gate.is_set():
                job.checkpoint(0.5, "waiting")
                time.sleep(0.002)
        except BaseException:
            self.stopped += 1
            raise
        del self.boxes.misdeeds["solve"]
        return session_result(state)


def session_result(state):
    from tests.app.troublemaker import box

    return [box(state.size, 2.0 * state.size * k) for k in range(len(state.strokes))]


def test_undo_while_solving_drops_the_answer(session, boxes, settle):
    slow = Slow(boxes)
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    assert_soon(session, slow.begun.is_set)
    session.drawing.undo()
    slow.gate.set()
    settle(session)
    assert len(session.drawing.document) == 0
    assert meshes(session) == []


def test_ink_is_shown_while_its_shape_is_being_solved(session, boxes, settle):
    slow = Slow(boxes)
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    assert_soon(
        session, lambda: [layer.name for layer in session.scene.visible.layers] == ["shape", "ink"]
    )
    assert meshes(session) == []
    slow.gate.set()
    settle(session)
    assert len(meshes(session)) == 1


def test_cancelled_work_leaves_what_was_shown_and_the_document(session, boxes, draw, settle):
    draw(session, circle())
    before = meshes(session)
    slow = Slow(boxes)
    session.objects.set_parameter("size", 50.0)
    document = session.drawing.document
    assert_soon(session, slow.begun.is_set)
    session.cancel_work()
    settle(session)
    assert slow.stopped == 1
    assert session.drawing.document is document
    assert meshes(session) == before
    assert "fault" not in kinds(session)
    (told,) = (notice.text for notice in session.heard if notice.text.startswith("Stopped."))
    assert "What you changed stays" in told  # the step is in the history, and the form shows it


def test_renaming_while_solving_does_not_begin_again(session, boxes, settle):
    slow = Slow(boxes)
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    assert_soon(session, slow.begun.is_set)
    for name in ("Cat", "Dog"):
        session.objects.rename(session.drawing.document.models[0].id, name)
    assert_soon(session, lambda: True)
    slow.gate.set()
    settle(session)
    assert slow.stopped == 0
    assert boxes.calls["solve"] == 2  # preview and final
    assert len(meshes(session)) == 1


def test_a_new_object_does_not_wait_for_the_solve_of_another(session, boxes, draw, settle):
    draw(session, circle())
    slow = Slow(boxes)
    session.objects.set_parameter("size", 50.0)
    assert_soon(session, slow.begun.is_set)
    session.gestures.commit()

    def only_the_first_is_slow(state, job):
        return slow.solve(state, job) if state.size == 50.0 else session_result(state)

    boxes.misdeeds["solve"] = only_the_first_is_slow
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    assert_soon(session, lambda: len(session.drawing.document) == 2 and slow.stopped == 1)
    slow.gate.set()
    settle(session)
    assert len(meshes(session)) == 2


def test_another_document_during_a_solve_gets_nothing_of_the_old_one(session, boxes, settle):
    slow = Slow(boxes)
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    assert_soon(session, slow.begun.is_set)
    session.files.new()
    slow.gate.set()
    settle(session)
    assert len(session.drawing.document) == 0
    assert session.scene.visible.layers == ()
    assert session.solver.report == {}
    assert not session.drawing.is_modified


def test_one_bad_recipe_complains_once_and_the_others_are_shown(session, boxes, draw, settle):
    draw(session, circle())
    session.gestures.commit()

    def solve(state, job):
        if state.size == 77.0:
            raise UserError("No solution. Make it smaller.")
        return session_result(state)

    boxes.misdeeds["solve"] = solve
    draw(session, circle())
    session.objects.set_parameter("size", 77.0)
    settle(session)
    session.objects.rename(session.drawing.document.models[0].id, "Good")
    settle(session)
    assert [n.text for n in session.heard if n.kind == "error"] == ["No solution. Make it smaller."]
    assert len(meshes(session)) == 2  # of the bad one what was there before
    session.objects.set_parameter("size", 20.0)
    settle(session)
    assert max(np.ptp(mesh.vertices) for mesh in meshes(session)) >= 20


def test_the_live_preview_goes_when_its_shape_comes_but_not_under_the_next_stroke(
    session, boxes, settle
):
    first = stroke_of(circle(), session.view.camera)
    session.gestures.stroke_moved(first)
    settle(session)
    assert session.scene.live.layers
    session.gestures.stroke_lifted(first)
    settle(session)
    assert not session.scene.live.layers
    slow = Slow(boxes)
    session.gestures.stroke_lifted(stroke_of(circle(radius=60), session.view.camera))
    assert_soon(session, slow.begun.is_set)
    session.gestures.stroke_moved(stroke_of(circle(share=ARC), session.view.camera))
    assert_soon(session, lambda: bool(session.scene.live.layers))
    slow.gate.set()
    settle(session)
    assert session.scene.live.layers
    session.gestures.cancel()
    assert not session.scene.live.layers


def assert_soon(session, true):
    """Turn the event loop until something holds."""
    from PySide6.QtWidgets import QApplication

    until = time.monotonic() + 20
    while not true() and time.monotonic() < until:
        QApplication.processEvents()
        time.sleep(0.002)
    QApplication.processEvents()
    assert true()


def test_a_tap_reaches_the_tool_that_is_in_the_hand(session, boxes, settle):
    from bozzetto.plugin.gesture import Tap

    seen = []

    def apply(state, gesture, context):
        seen.append(gesture)
        return type(state)(size=5.0)

    boxes.misdeeds["apply"] = apply
    session.gestures.tap(Tap(10.0, 20.0, session.view.camera, shift=True))
    settle(session)
    assert isinstance(seen[0], Tap)
    assert (seen[0].x, seen[0].y, seen[0].shift) == (10.0, 20.0, True)
    assert session.drawing.document.models[0].state.size == 5.0


def test_without_a_modeler_a_stroke_waits_with_a_word(make_session, settle):
    from bozzetto.plugin.host.registry import Registry
    from bozzetto_app.session.session import Session

    session = Session(Registry(no_plugins=True))
    session.gestures.stroke_lifted(Stroke(x=[1, 2], y=[1, 2], camera=session.view.camera))
    assert session.hints.step.sentence == "Choose a modeler first."
    assert len(session.drawing.pending) == 1
    session.gestures.commit()
    assert len(session.drawing.pending) == 1
    assert session.toolbox.modelers == ()


def test_what_redo_brings_back_is_selected_again(make_session, boxes, settle):
    session = make_session(MODELER, extra=[boxes.package])
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    settle(session)
    drawn = session.selection.id
    session.drawing.undo()
    assert session.selection.id is None
    session.drawing.redo()
    settle(session)
    assert session.selection.id == drawn


# -- what a closed document leaves behind --------------------------------------------------------


def test_the_shapes_of_a_closed_document_are_forgotten(session, draw, settle):
    """However many documents a day has, the process holds the one that is open."""
    for _ in range(3):
        draw(session, circle())
        model = session.drawing.document.models[-1]
        assert session.workbench.best_result(model) is not None
        session.files.new()
        settle(session)
        assert session.workbench.best_result(model) is None


def test_shapes_that_undo_may_bring_back_are_kept(session, draw, settle):
    draw(session, circle())
    model = session.drawing.document.models[-1]
    session.drawing.undo()
    settle(session)
    assert session.workbench.best_result(model) is not None


def test_shapes_that_come_together_are_one_change_of_the_scene(make_session, qtbot):
    session = make_session()
    seen = []
    session.scene.changed.connect(lambda: seen.append(session.scene.visible))
    for _ in range(100):
        session.solver.changed.emit("some object", True)
    qtbot.waitUntil(lambda: bool(seen))
    qtbot.wait(50)
    assert len(seen) == 1
