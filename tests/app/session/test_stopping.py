"""Reports, imports and advice end when the document closes or the model is another one."""

from __future__ import annotations

import threading

import pytest

from bozzetto.errors import Cancelled
from bozzetto.exchange.export import write_drawing
from bozzetto.ink import Strokes
from bozzetto.ink.drawing import Drawing
from bozzetto.plugin import ViewAdvice
from tests.adviser import MODELER as ADVISER
from tests.app.tablet import circle, stroke_of
from tests.app.troublemaker import MODELER


class Loop:
    """Work that looks at its job until it is stopped, or told to answer."""

    def __init__(self):
        self.begun, self.stopped, self.may_end = (threading.Event() for _ in range(3))

    def run(self, job):
        self.begun.set()
        try:
            while not self.may_end.wait(0.002):
                job.checkpoint(0.5, "for ever")
        except Cancelled:
            self.stopped.set()
            raise


@pytest.fixture
def loop():
    loop = Loop()
    yield loop
    loop.may_end.set()


def draw(session, points=None):
    session.gestures.stroke_lifted(stroke_of(points or circle(), session.view.camera))


def long_report(loop):
    def report(state, result, job):
        loop.run(job)
        return {"boxes": len(result)}

    return report


def begin_report(session, boxes, loop, qtbot):
    boxes.misdeeds["report"] = long_report(loop)
    draw(session)
    qtbot.waitUntil(loop.begun.is_set)


def test_a_report_ends_when_the_model_is_another_one_and_is_whole_later(
    session, boxes, loop, settle, qtbot
):
    begin_report(session, boxes, loop, qtbot)
    state = session.selection.model.state
    boxes.misdeeds.pop("report")
    session.objects.set_parameter("size", 20.0)
    qtbot.waitUntil(loop.stopped.is_set)
    settle(session)
    assert session.solver.report == {"boxes": 1}
    asked = boxes.calls["report"]
    session.drawing.undo()
    settle(session)
    assert session.selection.model.state is state
    assert session.solver.report == {"boxes": 1}
    assert boxes.calls["report"] == asked + 1
    assert [notice for notice in session.heard if notice.kind in ("fault", "slow")] == []


def test_a_report_ends_when_its_document_closes(session, boxes, loop, settle, qtbot):
    begin_report(session, boxes, loop, qtbot)
    session.files.new()
    qtbot.waitUntil(loop.stopped.is_set)
    settle(session)
    assert session.solver.report == {}


def test_a_report_that_is_stopped_by_hand_is_made_again(session, boxes, loop, settle, qtbot):
    begin_report(session, boxes, loop, qtbot)
    model = session.selection.id
    session.cancel_work()
    qtbot.waitUntil(loop.stopped.is_set)
    settle(session)
    boxes.misdeeds.pop("report")
    session.selection.select(None)
    session.selection.select(model)
    settle(session)
    assert session.solver.report == {"boxes": 1}


def test_a_report_that_never_looks_is_told_as_slow(
    make_session, boxes, loop, settle, qtbot, monkeypatch
):
    monkeypatch.setattr("bozzetto_app.session.solver.LATE_AFTER", 0.2)
    session = make_session(MODELER, extra=[boxes.package])

    def report(state, result, job):
        loop.may_end.wait(20)
        return {"boxes": len(result)}

    boxes.misdeeds["report"] = report
    draw(session)
    qtbot.waitUntil(lambda: any(notice.kind == "slow" for notice in session.heard))
    loop.may_end.set()  # and it is taken all the same
    settle(session)
    assert session.solver.report == {"boxes": 1}


def test_an_import_ends_when_its_document_closes(session, boxes, loop, settle, qtbot, tmp_path):
    ink = Strokes((stroke_of(circle(), session.view.camera),))
    write_drawing(Drawing(ink, session.view.camera), tmp_path / "ink.json")
    boxes.misdeeds["read_drawing"] = lambda drawing, context, job: loop.run(job)
    session.files.exchange.import_file(tmp_path / "ink.json")
    qtbot.waitUntil(loop.begun.is_set)
    session.files.new()
    qtbot.waitUntil(loop.stopped.is_set)
    settle(session)
    assert len(session.drawing.document.models) == 0
    boxes.misdeeds.pop("read_drawing")
    session.files.exchange.import_file(tmp_path / "ink.json")
    settle(session)
    assert len(session.drawing.document.models) == 1


@pytest.fixture
def advised(make_session, marks):
    return make_session(ADVISER, extra=[marks.package])


@pytest.mark.parametrize("change", ["close", "draw"])
def test_advice_ends_when_it_is_about_another_model(
    advised, marks, loop, settle, qtbot, monkeypatch, change
):
    def advise(self, state, camera, job):
        loop.run(job)
        return ViewAdvice("good", "at last")

    whole = type(marks).view_advice
    draw(advised, [(100.0, 100.0), (300.0, 300.0)])
    settle(advised)
    monkeypatch.setattr(type(marks), "view_advice", advise)
    advised.view.set_camera(advised.view.camera.with_viewport(800.0, 600.0))
    qtbot.waitUntil(loop.begun.is_set)
    monkeypatch.setattr(type(marks), "view_advice", whole)
    if change == "close":
        advised.files.new()
    else:
        draw(advised, [(100.0, 200.0), (300.0, 500.0)])
    qtbot.waitUntil(loop.stopped.is_set)
    settle(advised)
    assert advised.advice.advice is not None
    assert advised.advice.advice.message != "at last"
