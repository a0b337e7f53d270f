"""Ink that waits: who tries it, when, with what; and how a person is rid of it."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from bozzetto.document.model import Document
from bozzetto.document.waiting_ink import WaitingStroke
from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_mesh
from bozzetto.view.camera import Camera
from bozzetto_app.session.gesture_application import ink_to_try
from tests.app.seen import colour, darkness
from tests.app.tablet import Mouse, Stylus, circle, stroke_of
from tests.app.two_boxes import FIRST, PLACE, REFUSAL, SECOND, two_boxes

ARC = 0.6


@pytest.fixture
def pair(tmp_path):
    with two_boxes(tmp_path) as (first, second, packages):
        first.packages = packages
        yield first, second


@pytest.fixture
def session(make_session, pair):
    return make_session(FIRST, extra=pair[0].packages)


@pytest.fixture
def lift(session, settle):
    def lift(points, tool="pen"):
        stroke = stroke_of(points, session.view.camera, tool)
        session.gestures.stroke_lifted(stroke)
        settle(session)
        return stroke

    return lift


def statuses(session):
    return [one.status for one in session.drawing.document.waiting]


def strokes(session):
    return [len(model.state.strokes) for model in session.drawing.document]


# -- who tries what --------------------------------------------------------------------------------


def one(status, modeler="m", tool="t"):
    return WaitingStroke(stroke_of(circle(), Camera()), modeler, tool, status)


@pytest.mark.parametrize(
    ("waiting", "committed", "tries"),
    [
        (["new"], False, ["0"]),
        (["unfinished", "new"], False, ["01"]),
        (["refused", "new"], False, ["01", "1"]),
        (["refused", "unfinished", "new"], False, ["012", "12"]),
        (["failed", "new"], False, ["1"]),
        (["failed", "refused", "new"], False, ["12", "2"]),
        (["refused"], True, ["0"]),
        (["failed"], True, ["0"]),
        (["failed", "unfinished"], True, ["1"]),
        (["refused", "unfinished"], True, ["01", "1"]),
        (["unfinished of another", "new"], False, ["1"]),
        (["unfinished of another", "unfinished"], True, ["1"]),
        (["unfinished of another", "refused of another"], True, ["01", "0"]),
        (["new of a tool not known yet", "new"], False, ["01"]),
    ],
)
def test_which_ink_is_tried(waiting, committed, tries):
    ink = []
    for told in waiting:
        status, _, whose = told.partition(" of ")
        if whose == "another":
            ink.append(one(status, tool="other"))
        else:
            ink.append(one(status, tool="" if whose else "t"))
    ink = tuple(ink)
    found = ink_to_try(ink, ink[-1].stroke, "m", "t", committed=committed)
    places = {id(entry.stroke): str(place) for place, entry in enumerate(ink)}
    assert ["".join(places[id(stroke)] for stroke in strokes) for strokes in found] == tries
    assert ink_to_try(ink[:-1], ink[-1].stroke, "m", "t", committed=committed) == ()


def test_refused_ink_waits_with_its_reason_and_undo_and_redo_carry_it(session, pair, lift):
    pair[0].mood = "refuse"
    drawn = lift(circle())
    (ink,) = session.drawing.marked_ink
    assert ink.stroke is drawn
    assert (ink.status, ink.reason, ink.places) == ("refused", REFUSAL, (PLACE,))
    assert session.heard[-1].text == REFUSAL
    session.drawing.undo()
    assert session.drawing.pending == ()
    session.drawing.redo()
    assert session.drawing.marked_ink == (ink,)


def test_the_missing_piece_is_tried_together_with_refused_ink(session, pair, lift, settle):
    lift(circle(share=ARC))
    pair[0].mood = "refuse"
    session.gestures.commit()
    settle(session)
    assert statuses(session) == ["refused"]
    pair[0].mood = "well"
    turn = np.linspace(2 * np.pi * ARC, 2 * np.pi, 40)
    lift(np.column_stack((640 + 120 * np.cos(turn), 360 + 120 * np.sin(turn))))
    assert session.drawing.pending == ()
    assert strokes(session) == [2]


def test_refused_ink_does_not_stand_in_the_way_of_other_ink(session, pair, lift, monkeypatch):
    pair[0].mood = "refuse"
    bad = lift(circle())
    pair[0].mood = "well"
    well = pair[0].do

    def only_alone(what, way, *arguments):
        if what == "apply" and len(arguments[1].strokes) > 1:
            raise UserError("Too much at once.")
        return well(what, way, *arguments)

    monkeypatch.setattr(pair[0], "do", only_alone)
    lift(circle(radius=60))
    assert strokes(session) == [1]
    assert session.drawing.pending == (bad,)
    assert session.drawing.marked_ink[0].reason == REFUSAL
    lift(circle(radius=60, share=ARC))
    assert statuses(session) == ["refused", "unfinished"]
    assert session.hints.step.sentence == "Close the box, or press Enter."


def test_a_stroke_and_what_comes_of_it_are_one_step_however_fast_they_come(session, pair, settle):
    for number in range(4):
        session.gestures.stroke_lifted(stroke_of(circle(radius=40 + number), session.view.camera))
    settle(session)
    assert session.drawing.history.entries == ("Start", "Draw", "Draw", "Draw", "Draw")
    for left in (3, 2, 1):
        session.drawing.undo()
        settle(session)
        assert (strokes(session), session.drawing.pending) == ([left], ())
    session.drawing.go_to(4)
    settle(session)
    assert (strokes(session), session.drawing.pending) == ([4], ())


def test_quick_strokes_of_which_one_is_refused_keep_their_order(session, pair, settle, monkeypatch):
    well = pair[0].do

    def not_the_second(what, way, *arguments):
        widths = [np.ptp(s.x) for s in arguments[1].strokes] if what == "apply" else []
        if any(100 < width < 103 for width in widths):
            raise UserError("Not this one.")
        return well(what, way, *arguments)

    monkeypatch.setattr(pair[0], "do", not_the_second)
    for radius in (50, 51, 52):
        session.gestures.stroke_lifted(stroke_of(circle(radius=radius), session.view.camera))
    settle(session)
    taken = [np.ptp(s.x) for s in session.drawing.document.models[0].state.strokes]
    assert taken == sorted(taken)
    assert len(taken) == 2
    assert [np.ptp(s.x) for s in session.drawing.pending] == [pytest.approx(102, abs=0.5)]
    session.drawing.go_to(0)
    settle(session)
    session.drawing.go_to(len(session.drawing.history.entries) - 1)
    settle(session)
    assert [np.ptp(s.x) for s in session.drawing.document.models[0].state.strokes] == taken


def test_what_enter_makes_of_waiting_ink_is_a_step_that_gives_it_back(session, lift, settle):
    drawn = lift(circle(share=ARC))
    session.gestures.commit()
    settle(session)
    assert (strokes(session), session.drawing.pending) == ([1], ())
    session.drawing.undo()
    settle(session)
    assert (strokes(session), session.drawing.pending) == ([], (drawn,))


def test_another_modeler_reads_refused_ink_at_enter(session, pair, lift, settle):
    pair[0].mood = "refuse"
    drawn = lift(circle())
    session.toolbox.take_modeler(SECOND)
    settle(session)
    assert session.drawing.pending == (drawn,)
    lift(circle(radius=44))  # its own ink comes by itself
    assert session.drawing.pending == (drawn,)
    session.gestures.commit()
    settle(session)
    assert session.drawing.pending == ()
    assert [(model.modeler, len(model.state.strokes)) for model in session.drawing.document] == [
        (SECOND, 2)
    ]
    session.drawing.undo()
    settle(session)
    assert session.drawing.pending == (drawn,)


# -- plugins that fail -----------------------------------------------------------------------------


@pytest.mark.parametrize("mood", ["raise", "garbage"])
def test_ink_that_a_plugin_failed_over_waits_and_is_not_tried_again_unasked(
    mood, session, pair, lift, settle
):
    pair[0].mood = mood
    drawn = lift(circle())
    assert statuses(session) == ["failed"]
    assert session.drawing.marked_ink[0].reason == session.heard[-1].text
    assert session.heard[-1].kind == "fault"
    assert session.hints.step.sentence.startswith("The ink waits.")
    pair[0].mood = "well"
    lift(circle(radius=50))
    assert (strokes(session), session.drawing.pending) == ([1], (drawn,))
    session.gestures.commit()
    settle(session)
    assert (strokes(session), session.drawing.pending) == ([2], ())


def test_ink_whose_plugin_hangs_waits_and_later_strokes_come_through(
    make_session, pair, settle, monkeypatch, qtbot
):
    monkeypatch.setattr("bozzetto_app.session.gestures.APPLY_LIMIT", 0.3)
    session = make_session(FIRST, extra=pair[0].packages)
    pair[0].mood = "hang"
    first, second = (stroke_of(circle(radius=r), session.view.camera) for r in (50, 60))
    session.gestures.stroke_lifted(first)
    qtbot.waitUntil(
        lambda: bool(session.heard) and session.heard[-1].kind == "slow", timeout=10_000
    )
    assert session.drawing.pending == (first,)
    session.cancel_work()
    settle(session)
    assert statuses(session) == ["failed"]
    pair[0].mood = "well"
    pair[0].gate.set()
    session.gestures.stroke_lifted(second)
    settle(session)
    assert session.drawing.pending == (first,)
    assert strokes(session) == [1]


def test_esc_stops_a_modeler_and_its_ink_waits(make_window, pair, settle, qtbot):
    window = make_window(FIRST, extra=pair[0].packages)
    session = window.session
    pair[0].mood = "hang"
    Stylus(window.canvas).draw(circle())
    qtbot.waitUntil(lambda: pair[0].calls["apply"] == 1)
    QTest.keyClick(window.canvas, Qt.Key.Key_Escape)
    assert statuses(session) == ["failed"]
    assert "Enter" in session.drawing.marked_ink[0].reason
    pair[0].mood = "well"
    pair[0].gate.set()
    settle(session)
    assert len(session.drawing.document) == 0
    QTest.keyClick(window.canvas, Qt.Key.Key_Return)
    settle(session)
    assert (strokes(session), session.drawing.pending) == ([1], ())


# -- how one is rid of it --------------------------------------------------------------------------


def test_undo_takes_the_stroke_under_the_pen_and_not_the_shape_before_it(make_window, pair, settle):
    window = make_window(FIRST, extra=pair[0].packages)
    session = window.session
    stylus = Stylus(window.canvas)
    stylus.draw(circle())
    settle(session)
    path = circle(radius=60)
    stylus.draw(path, lift=False)
    QTest.keyClick(window.canvas, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    settle(session)
    assert (strokes(session), session.drawing.pending) == ([1], ())
    stylus.move((path[-1][0] + 20.0, path[-1][1]))
    stylus.lift(path[-1])
    settle(session)
    assert (strokes(session), session.drawing.pending) == ([1], ())
    session.drawing.redo()
    settle(session)
    assert (strokes(session), len(session.drawing.pending)) == ([2], 0)


def test_esc_with_an_idle_hand_takes_waiting_ink_back_and_undo_brings_it_again(
    make_window, pair, settle
):
    window = make_window(FIRST, extra=pair[0].packages)
    session = window.session
    stylus = Stylus(window.canvas)
    for radius in (60, 90):
        stylus.draw(circle(share=ARC, radius=radius))
        settle(session)
    waiting = session.drawing.document.waiting
    QTest.keyClick(window.canvas, Qt.Key.Key_Escape)
    assert session.drawing.pending == ()
    session.drawing.undo()
    assert session.drawing.document.waiting == waiting
    pair[0].mood = "refuse"
    session.gestures.commit()
    settle(session)
    assert window.canvas.overlay.lit.places == (PLACE,)
    QTest.keyClick(window.canvas, Qt.Key.Key_Escape)
    assert window.canvas.overlay.lit.places == ()


def test_the_eraser_takes_waiting_strokes_one_by_one_and_undo_brings_them_again(
    session, pair, lift, settle
):
    pair[0].mood = "refuse"
    left, right = lift(circle(x=300)), lift(circle(x=800))
    pair[0].mood = "well"
    calls = pair[0].calls["apply"]
    lift([(800.0, 200.0), (800.0, 300.0)], "eraser")
    assert session.drawing.pending == (left,)
    assert pair[0].calls["apply"] == calls
    session.drawing.undo()
    settle(session)
    assert session.drawing.pending == (left, right)
    lift([(300.0, 360.0), (310.0, 365.0)], "eraser")  # inside the circle, far from its line
    assert session.drawing.pending == (left, right)
    assert pair[0].calls["apply"] == calls + 1


@pytest.mark.parametrize("device", [Stylus, Mouse])
def test_what_has_no_other_end_erases_with_ctrl(make_window, pair, settle, device):
    window = make_window(FIRST, extra=pair[0].packages)
    session, canvas = window.session, window.canvas
    pair[0].mood = "refuse"
    across, down = canvas.width() / 2, canvas.height() / 2
    drawn = device(canvas)
    for place in (across - 120, across + 120):
        drawn.draw(circle(place, down, 60))
        settle(session)
    left, _ = session.drawing.pending
    rub = [(across + 180, down + 4 * k) for k in range(-10, 11)]
    device(canvas, keys=Qt.KeyboardModifier.ControlModifier).draw(rub)
    settle(session)
    assert session.drawing.pending == (left,)


def test_an_eraser_that_meets_nothing_leaves_nothing_behind(session, pair, lift):
    pair[0].mood = "refuse"
    lift([(10.0, 10.0), (60.0, 10.0)], "eraser")
    assert session.drawing.pending == ()
    assert session.drawing.history.entries == ("Start",)
    assert session.heard[-1].text == REFUSAL


def test_a_tool_that_does_not_draw_says_so_at_enter(session, pair, lift, monkeypatch):
    drawn = lift(circle(share=ARC))
    session.toolbox.tools = tuple(t._replace(gesture="tap") for t in session.toolbox.tools)
    session.gestures.commit()
    assert "does not draw" in session.heard[-1].text
    assert session.drawing.pending == (drawn,)


def test_a_tool_that_did_not_mark_it_shows_ink_without_a_halo(make_window, pair, settle):
    window = make_window(FIRST, extra=pair[0].packages)
    session = window.session
    pair[0].mood = "refuse"
    Stylus(window.canvas).draw(circle())
    settle(session)

    overlay = window.canvas.overlay

    def has_halo():
        """The halo has a colour; the ink itself has none, and is always there."""
        overlay.light_up(())
        assert darkness(overlay).max() > 0.2
        return (colour(overlay) > 0.05).sum() > 500

    assert has_halo()
    session.toolbox.take_tool("trace")
    assert not has_halo()
    session.toolbox.take_tool("draw")
    assert has_halo()
    session.toolbox.take_modeler(SECOND)
    settle(session)
    assert not has_halo()
    assert session.scene.live.layers == ()


def test_ink_of_a_journal_of_before_waits_as_if_just_drawn(session, settle):
    drawn = stroke_of(circle(), session.view.camera)
    session.drawing.show(Document(), None, saved=False, pending=(drawn,))
    settle(session)
    assert session.drawing.pending == (drawn,)
    assert session.drawing.is_modified
    session.gestures.commit()
    settle(session)
    assert (strokes(session), session.drawing.pending) == ([1], ())


# -- files -----------------------------------------------------------------------------------------


def test_a_document_that_is_opened_says_that_ink_waits_and_an_export_that_it_is_no_shape(
    session, pair, lift, settle, tmp_path
):
    lift(circle())
    lift(circle(share=ARC))
    session.files.save(tmp_path / "a.bozz")
    settle(session)
    assert not session.drawing.is_modified
    session.files.open(tmp_path / "a.bozz")
    settle(session)
    assert statuses(session) == ["unfinished"]
    assert "Ink is waiting" in session.heard[-1].text
    session.files.exchange.export(tmp_path / "a.stl")
    settle(session)
    assert "Waiting ink is not exported" in session.heard[-1].text


def test_a_stroke_lifted_while_an_export_runs_is_taken_and_the_export_is_of_before(
    session, pair, lift, settle, tmp_path, monkeypatch, qtbot
):
    lift(circle())
    gate, begun = threading.Event(), threading.Event()
    shapes = pair[0].shapes

    def slow(state, result):
        begun.set()
        gate.wait(20)
        return shapes(state, result)

    monkeypatch.setattr(pair[0], "shapes", slow)
    session.files.exchange.export(tmp_path / "a.stl")
    qtbot.waitUntil(begun.is_set)
    session.gestures.stroke_lifted(stroke_of(circle(radius=50), session.view.camera))
    qtbot.waitUntil(lambda: strokes(session) == [2])
    gate.set()
    settle(session)
    (exported,) = read_mesh(tmp_path / "a.stl").meshes()
    assert len(exported.mesh.faces) == 12


def test_a_stroke_under_the_pen_while_a_document_opens_is_lifted_onto_that_document(
    make_window, pair, settle, tmp_path, qtbot
):
    window = make_window(FIRST, extra=pair[0].packages)
    session = window.session
    Stylus(window.canvas).draw(circle())
    settle(session)
    session.files.save(tmp_path / "a.bozz")
    settle(session)
    session.files.new()
    stylus = Stylus(window.canvas)
    path = circle(radius=60)
    stylus.draw(path, lift=False)
    session.files.open(tmp_path / "a.bozz")
    settle(session)
    assert strokes(session) == [1]
    stylus.lift(path[-1])
    settle(session)
    assert strokes(session) == [2]
