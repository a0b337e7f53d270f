"""Pictures that are traced into waiting ink, and the dialog for it."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.document import edit
from bozzetto.images.png import write_png
from bozzetto.ink.stroke import Stroke
from bozzetto_app.dialogs.trace_picture import TraceDialog
from bozzetto_app.session.pictures import laid_on_sheet
from tests.core.ink.trace.pencil_paper import PHONE, TABLE, paper_picture
from tests.core.ink.trace.test_trace import SIZE, circle, line

RING = circle(300, 300, 180)


@pytest.fixture
def session(make_session):
    return make_session()


LINES = (RING, line((560, 100), (740, 500)))


def picture(lines=LINES, conditions=PHONE):
    return paper_picture(lines, SIZE, conditions, 9)[0]


def underlay(session, conditions=PHONE):
    laid = laid_on_sheet(picture(conditions=conditions), "sketch")
    session.objects.edit(edit.add_underlay, laid)
    return session.pictures.tracing.underlay


def opened(qtbot, session, source):
    dialog = TraceDialog(session, source)
    qtbot.addWidget(dialog)
    dialog.show()
    return dialog


def test_a_file_is_traced_as_one_step_that_undo_takes_back(qtbot, session, settle, tmp_path):
    path = tmp_path / "sketch.png"
    write_png(path, picture())
    dialog = opened(qtbot, session, path)
    assert not dialog.go.isEnabled()
    settle(session)
    assert "2 strokes, 1 of them closed" in dialog.state.text()
    dialog.go.click()
    settle(session)
    assert not dialog.isVisible()
    drawing = session.drawing
    assert (drawing.history.position, drawing.history.undo_label) == (1, "Trace into ink")
    assert len(drawing.pending) == 2
    assert len(drawing.document) == 0
    drawing.undo()
    settle(session)
    assert drawing.pending == ()
    drawing.redo()
    settle(session)
    assert len(drawing.pending) == 2
    assert len(drawing.document) == 0


def test_traced_ink_is_cleaned_with_the_eraser_and_makes_a_shape(qtbot, session, settle):
    traced = underlay(session)
    dialog = opened(qtbot, session, traced)
    settle(session)
    dialog.go.click()
    settle(session)
    stray = min(session.drawing.pending, key=lambda stroke: np.ptp(stroke.points[:, 0]))
    at = stray.points[len(stray.points) // 2]
    eraser = Stroke(at[0] + [-8, 0, 8], at[1] + [0, 0, 0], stray.camera, tool="eraser")
    session.gestures.stroke_lifted(eraser)
    settle(session)
    assert len(session.drawing.pending) == 1
    session.gestures.commit()
    settle(session)
    (model,) = session.drawing.document
    assert model.modeler == "bozzetto.silhouette"
    assert session.drawing.pending == ()


def test_ink_goes_along_an_underlay_that_is_seen_from_the_front(qtbot, session, settle):
    traced = underlay(session)
    dialog = opened(qtbot, session, traced)
    assert dialog.place.value == "picture"
    settle(session)
    dialog.go.click()
    ring = max(session.drawing.pending, key=lambda stroke: np.ptp(stroke.points[:, 0]))
    scale = 200.0 / SIZE[0]
    middle = np.array(traced.corner) + scale * np.array((300.0, 0.0, -300.0))
    seen, _ = session.view.camera.project([middle])
    assert ring.points.mean(axis=0) == pytest.approx(seen[0], abs=5.0)


def test_a_page_that_was_straightened_takes_the_underlays_place(qtbot, session, settle):
    traced = underlay(session, TABLE)
    dialog = opened(qtbot, session, traced)
    settle(session)
    assert "straightened" in dialog.state.text()
    dialog.go.click()
    (laid,) = session.drawing.document.underlays
    assert laid.id == traced.id
    assert laid.pixels.shape[1] < traced.pixels.shape[1]
    assert laid.across[0] == pytest.approx(200.0 * laid.pixels.shape[1] / traced.pixels.shape[1])
    session.drawing.undo()
    assert session.drawing.document.underlays == (traced,)


def test_the_page_is_left_as_it_is_where_that_is_wanted(qtbot, session, settle):
    dialog = opened(qtbot, session, underlay(session, TABLE))
    settle(session)
    dialog.straighten.click()
    settle(session)
    assert "straightened" not in dialog.state.text()


def test_a_slider_traces_again_without_preparing_the_picture_anew(
    qtbot, session, settle, monkeypatch
):
    dialog = opened(qtbot, session, underlay(session))
    settle(session)
    from bozzetto.ink.trace import trace as tracing

    monkeypatch.setattr(tracing, "sheet_of", lambda *_, **__: pytest.fail("prepared again"))
    heard = []
    session.pictures.tracing.found.connect(heard.append)
    dialog.sensitivity.slid.emit(0.6, True)
    settle(session)
    assert len(heard) == 1


def test_paper_without_a_line_is_told_and_cannot_be_taken(qtbot, session, settle):
    laid = laid_on_sheet(np.full((300, 400, 4), 255, np.uint8), "blank")
    dialog = opened(qtbot, session, laid)
    settle(session)
    assert "no line" in dialog.state.text()
    assert not dialog.go.isEnabled()


def test_closing_the_dialog_or_the_document_stops_the_work(qtbot, session, settle):
    heard = []
    session.pictures.tracing.found.connect(heard.append)
    dialog = opened(qtbot, session, underlay(session))
    dialog.reject()
    settle(session)
    assert heard == []
    second = opened(qtbot, session, session.pictures.tracing.underlay)
    session.files.new()
    settle(session)
    assert heard == []
    assert not second.isVisible()
    assert session.drawing.pending == ()


def test_stopping_the_work_leaves_the_dialog_with_advice(qtbot, session, settle):
    dialog = opened(qtbot, session, underlay(session))
    session.cancel_work()
    settle(session)
    assert "Stopped" in dialog.state.text()
    dialog.sensitivity.slid.emit(0.5, False)
    settle(session)
    assert dialog.go.isEnabled()


def test_ink_as_large_as_the_view_leaves_the_underlay_alone(qtbot, session, settle):
    traced = underlay(session, TABLE)
    dialog = opened(qtbot, session, traced)
    dialog.place.chosen.emit("view")
    settle(session)
    dialog.go.click()
    assert session.drawing.document.underlays == (traced,)
    points = np.vstack([stroke.points for stroke in session.drawing.pending])
    assert (points >= 0).all()
    assert (points <= session.view.camera.viewport).all()


def test_an_underlay_that_is_deleted_meanwhile_is_told(qtbot, session, settle):
    traced = underlay(session)
    dialog = opened(qtbot, session, traced)
    settle(session)
    session.objects.delete_underlay(traced.id)
    dialog.go.click()
    assert session.drawing.pending == ()
    assert "no longer" in session.heard[-1].text
