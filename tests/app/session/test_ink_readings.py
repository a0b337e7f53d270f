"""“Read this ink as …” in a session: what is offered, what is taken, and what is stopped."""

from __future__ import annotations

import threading
import time

import pytest
from msgspec.structs import replace

from bozzetto.scene.palette import DARK
from bozzetto_app.session import ink_readings
from tests.app.tablet import circle, stroke_of
from tests.app.troublemaker import MODELER

SILHOUETTE, SYMMETRY, PRODUCT = "bozzetto.silhouette", "bozzetto.symmetry", "bozzetto.product"


@pytest.fixture
def session(make_session, boxes):
    return make_session(extra=[boxes.package])


@pytest.fixture
def drawn(session, settle):
    """A session with one silhouette, drawn by hand."""
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    settle(session)
    return session


def readings_of(session, settle, ink=None):
    found = []
    session.readings.found.connect(found.append)
    session.readings.ask(ink or session.readings.ink, DARK, 32)
    settle(session)
    session.readings.found.disconnect(found.append)
    return {reading.model.modeler: reading for reading in found}


def test_only_what_succeeds_is_offered_and_not_the_modeler_itself(drawn, settle):
    assert set(readings_of(drawn, settle)) == {SYMMETRY, PRODUCT, MODELER}
    assert [notice.kind for notice in drawn.heard if notice.kind in ("error", "fault")] == []


@pytest.mark.parametrize("reader", [SYMMETRY, MODELER])
def test_in_its_place_is_one_step_and_undo_gives_the_same_document(drawn, settle, reader):
    before, ink = drawn.drawing.document, drawn.readings.ink
    position = drawn.drawing.history.position
    reading = readings_of(drawn, settle, ink)[reader]
    drawn.readings.take(ink, reading, in_place=True)
    settle(drawn)
    (model,) = drawn.drawing.document.models
    assert (model.modeler, model.id, model.name) == (reader, before.models[0].id, ink.name)
    assert drawn.drawing.history.position == position + 1
    assert drawn.toolbox.modeler == reader
    assert drawn.selection.target(reader) is model
    drawn.drawing.undo()
    settle(drawn)
    assert drawn.drawing.document is before
    assert drawn.toolbox.modeler == SILHOUETTE


def test_beside_it_the_object_stays(drawn, settle):
    before, ink = drawn.drawing.document.models[0], drawn.readings.ink
    drawn.readings.take(ink, readings_of(drawn, settle)[SYMMETRY], in_place=False)
    settle(drawn)
    first, second = drawn.drawing.document.models
    assert first is before
    assert second.modeler == SYMMETRY
    assert second.name != first.name
    assert drawn.selection.model is second


def test_ink_that_waits_goes_into_the_new_object(session, settle):
    session.gestures.stroke_lifted(stroke_of(circle(share=0.6), session.view.camera))
    settle(session)
    assert len(session.drawing.pending) == 1
    ink = session.readings.ink
    found = readings_of(session, settle, ink)
    assert SILHOUETTE not in found
    session.readings.take(ink, found[MODELER], in_place=False)
    settle(session)
    assert session.drawing.pending == ()
    assert [model.modeler for model in session.drawing.document] == [MODELER]
    session.drawing.undo()
    assert session.drawing.pending == ink.strokes
    assert not len(session.drawing.document)


def test_what_has_changed_meanwhile_is_not_overwritten(drawn, settle):
    ink = drawn.readings.ink
    reading = readings_of(drawn, settle, ink)[SYMMETRY]
    drawn.objects.set_parameter("resolution", 64)
    changed = drawn.drawing.document
    drawn.readings.take(ink, reading, in_place=True)
    assert drawn.drawing.document is changed
    assert drawn.heard[-1].kind == "error"
    drawn.readings.take(ink, reading, in_place=False)
    assert len(drawn.drawing.document) == 2


def test_a_locked_object_is_read_beside_and_not_replaced(drawn, settle):
    drawn.objects.set_locked(drawn.selection.id, True)
    ink = drawn.readings.ink
    reading = readings_of(drawn, settle, ink)[SYMMETRY]
    locked = drawn.drawing.document
    drawn.readings.take(ink, reading, in_place=True)
    assert drawn.drawing.document is locked
    assert "locked" in drawn.heard[-1].text


def test_a_hidden_object_can_be_read(drawn, settle):
    drawn.objects.set_visible(drawn.selection.id, False)
    assert SYMMETRY in readings_of(drawn, settle)


@pytest.mark.parametrize("listens", [True, False], ids=["checkpoints", "deaf"])
def test_slow_readers_are_stopped_and_the_others_are_offered(
    drawn, settle, boxes, monkeypatch, qtbot, listens
):
    monkeypatch.setattr(ink_readings, "READING_LIMIT", 0.3)
    drawn.readings.channel.time_limit = 0.6
    gate = threading.Event()

    def solve(state, job):
        while not gate.wait(0.01):
            if listens:
                job.checkpoint(0.5, "Thinking")
        return []

    boxes.misdeeds["solve"] = solve
    ink = replace(drawn.readings.ink, readers=(MODELER,))
    with qtbot.waitSignal(drawn.readings.ended, timeout=10_000):
        drawn.readings.ask(ink, DARK, 32)
    gate.set()
    settle(drawn)
    assert len(drawn.drawing.document) == 1


def test_when_nobody_looks_any_more_nobody_is_asked(drawn, settle, boxes, qtbot):
    begun, seen = threading.Event(), []

    def solve(state, job):
        begun.set()
        until = time.monotonic() + 10.0
        while time.monotonic() < until:
            time.sleep(0.005)
            try:
                job.checkpoint(0.5, "Thinking")
            except BaseException as end:
                seen.append(type(end).__name__)
                raise
        return []

    boxes.misdeeds["solve"] = solve
    drawn.readings.ask(replace(drawn.readings.ink, readers=(MODELER, SYMMETRY)), DARK, 32)
    qtbot.waitUntil(begun.is_set)
    found = []
    drawn.readings.found.connect(found.append)
    drawn.readings.cancel()
    settle(drawn)
    assert seen == ["Cancelled"]
    assert found == []


def test_a_fault_is_told_and_the_others_are_offered(drawn, settle, boxes):
    boxes.misdeeds["read_drawing"] = lambda *_: 1 / 0
    assert set(readings_of(drawn, settle)) == {SYMMETRY, PRODUCT}
    assert [notice.kind for notice in drawn.heard].count("fault") == 1
