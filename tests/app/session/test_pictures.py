"""Pictures that come in: to the modeler that works on them, or under the sheet."""

from __future__ import annotations

import json
import threading

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent, QGuiApplication, QImage, QWheelEvent
from PySide6.QtTest import QTest

from bozzetto.document.storage.zip_container import ContainerReader
from bozzetto.images.png import write_png
from bozzetto.plugin import ViewAdvice
from bozzetto.scene import Layer, Points, Scene
from bozzetto_app.session.pictures import pixels_of
from tests.app.canvas.conftest import Pen
from tests.app.tablet import circle, stroke_of
from tests.tracer import DEPTH, MODELER, STAND, drawn_car

SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def session(make_session, sketches):
    return make_session(MODELER, extra=[sketches.package])


@pytest.fixture
def page(tmp_path):
    path = tmp_path / "page.png"
    write_png(path, drawn_car(180, 120))
    return path


def pictures(session):
    return [picture.name for model in session.drawing.document for picture in model.state.pictures]


def steps(session):
    return session.drawing.history.position


def test_a_picture_with_nothing_selected_makes_a_model(session, settle, page):
    session.files.exchange.import_file(page)
    settle(session)
    (model,) = session.drawing.document
    assert (model.name, model.modeler) == ("page", MODELER)
    assert pictures(session) == ["page"]
    assert session.selection.id == model.id
    assert (steps(session), session.drawing.history.undo_label) == (1, "Add sketch")
    assert session.drawing.document.underlays == ()
    session.drawing.undo()
    settle(session)
    assert len(session.drawing.document) == 0


def test_a_further_one_goes_to_the_selected_model_as_one_step(session, settle, page, tmp_path):
    session.files.exchange.import_file(page)
    settle(session)
    write_png(tmp_path / "rear.png", drawn_car(90, 60))
    session.files.exchange.import_file(tmp_path / "rear.png")
    settle(session)
    assert pictures(session) == ["page", "rear"]
    assert (len(session.drawing.document), steps(session)) == (1, 2)


def test_two_at_once_both_arrive(session, settle, page, tmp_path):
    """The second finds the model as the first one left it."""
    session.files.exchange.import_file(page)
    settle(session)
    for name in ("a.png", "b.png"):
        write_png(tmp_path / name, drawn_car(30, 20))
        session.files.exchange.import_file(tmp_path / name)
    settle(session)
    assert pictures(session) == ["page", "a", "b"]


def test_a_refusal_is_told_and_changes_nothing(session, settle, page):
    for _ in range(4):
        session.files.exchange.import_file(page)
        settle(session)
    assert len(pictures(session)) == 3
    assert "Three sketches are enough" in session.heard[-1].text


def test_a_fault_leaves_the_document(session, settle, page, sketches):
    sketches.take = lambda state, picture: 1 / 0
    session.files.exchange.import_file(page)
    settle(session)
    assert len(session.drawing.document) == 0
    assert session.heard[-1].kind == "fault"


def test_asked_for_it_lies_under_the_sheet(session, settle, page):
    session.pictures.take_file(page, under=True)
    settle(session)
    (underlay,) = session.drawing.document.underlays
    assert underlay.name == "page"
    assert underlay.pixels.shape == (120, 180, 4)
    assert len(session.drawing.document) == 0


def test_an_underlay_becomes_a_sketch_and_is_hidden_as_one_step(session, settle, page):
    session.pictures.take_file(page, under=True)
    settle(session)
    (underlay,) = session.drawing.document.underlays
    session.toolbox.take_modeler("bozzetto.silhouette")
    settle(session)
    assert session.pictures.sketch_taker == ""
    session.pictures.take_underlay(underlay.id)
    settle(session)
    assert (len(session.drawing.document), steps(session)) == (0, 1)
    assert "The chosen object takes no sketch" in session.heard[-1].text
    session.toolbox.take_modeler(MODELER)
    settle(session)
    assert session.pictures.sketch_taker
    session.pictures.take_underlay(underlay.id)
    settle(session)
    (model,) = session.drawing.document
    assert np.array_equal(model.state.pictures[0].pixels, underlay.pixels)
    assert not session.drawing.document.underlays[0].visible
    assert steps(session) == 2
    session.drawing.undo()
    settle(session)
    assert len(session.drawing.document) == 0
    assert session.drawing.document.underlays[0].visible


@pytest.mark.parametrize("how", ["other modeler", "locked", "hidden"])
def test_all_others_lie_under_the_sheet_as_ever(session, settle, page, how):
    if how == "other modeler":
        session.toolbox.take_modeler("bozzetto.silhouette")
        settle(session)
    else:
        session.files.exchange.import_file(page)
        settle(session)
        change = session.objects.set_locked if how == "locked" else session.objects.set_visible
        change(session.selection.id, how == "locked")
    session.files.exchange.import_file(page)
    settle(session)
    assert len(session.drawing.document.underlays) == 1
    assert len(session.drawing.document) == (0 if how == "other modeler" else 1)


def test_a_selected_model_of_another_modeler_comes_before_the_active_one(session, settle, page):
    """Nothing is made behind the back of what is selected."""
    session.toolbox.take_modeler("bozzetto.silhouette")
    settle(session)
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    settle(session)
    session.toolbox.take_modeler(MODELER)
    settle(session)
    session.files.exchange.import_file(page)
    settle(session)
    assert len(session.drawing.document.underlays) == 1


def test_another_document_gets_nothing(session, settle, page):
    session.files.exchange.import_file(page)
    session.files.new()
    settle(session)
    assert len(session.drawing.document) == 0
    assert session.drawing.document.underlays == ()


def test_broken_files_are_told(session, settle, tmp_path):
    (tmp_path / "x.png").write_bytes(b"words")
    session.files.exchange.import_file(tmp_path / "x.png")
    settle(session)
    assert "x.png" in session.heard[-1].text
    assert len(session.drawing.document) == 0


# -- facts ------------------------------------------------------------------------------------


def test_a_file_of_facts_goes_to_the_modeler_that_is_meant(session, settle, page):
    marks = page.with_name("marks.json")
    marks.write_text(json.dumps({"template": "sedan", "image": {"file": "page.png"}}))
    session.toolbox.take_modeler("bozzetto.silhouette")
    settle(session)
    session.files.exchange.import_file(marks)
    settle(session)
    (model,) = session.drawing.document
    assert (model.modeler, model.state.template) == (MODELER, "sedan")
    assert pictures(session) == ["page"]
    assert session.toolbox.modeler == MODELER


def test_facts_of_nobody_go_to_the_active_modeler(session, settle, tmp_path):
    path = tmp_path / "x.json"
    path.write_text('{"marks": []}')
    session.files.exchange.import_file(path)
    settle(session)
    assert "names no template" in session.heard[-1].text


# -- clipboard and drops ------------------------------------------------------------------------


def image(width=31, height=20):
    pixels = drawn_car(width, height)
    return QImage(
        np.ascontiguousarray(pixels).data, width, height, 4 * width, QImage.Format.Format_RGBA8888
    ).copy()


@pytest.mark.parametrize(
    "kind", [QImage.Format.Format_RGB32, QImage.Format.Format_RGB888, QImage.Format.Format_ARGB32]
)
def test_pixels_of_qt_pictures(kind):
    np.testing.assert_array_equal(pixels_of(image().convertToFormat(kind)), drawn_car(31, 20))


@pytest.fixture
def window(make_window, sketches):
    return make_window(MODELER, extra=[sketches.package])


def test_a_copied_picture_is_pasted(window, settle):
    session = window.session
    QGuiApplication.clipboard().setImage(image())
    window.actions_.run("edit.paste")
    settle(session)
    assert pictures(session) == ["Picture"]
    window.actions_.run("edit.paste_under")
    settle(session)
    assert len(session.drawing.document.underlays) == 1
    QGuiApplication.clipboard().setText("words")
    window.actions_.run("edit.paste")
    settle(session)
    assert "nothing to paste" in session.heard[-1].text


def drop(canvas, data, keys=Qt.KeyboardModifier.NoModifier):
    copy, left = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
    canvas.dropEvent(QDropEvent(QPointF(200, 200), copy, data, left, keys))


def test_a_dropped_sketch_is_seen_from_where_it_was_drawn(window, settle, page, qtbot):
    session = window.session
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(page))])
    drop(window.canvas, data)
    settle(session)
    assert pictures(session) == ["page"]
    assert session.view.camera.eye == STAND.eye
    assert session.advice.advice.pinned
    assert session.advice.holds_eye(session.view.camera)
    assert "Shift" in session.heard[-1].text
    drop(window.canvas, data, SHIFT)
    settle(session)
    assert pictures(session) == ["page"]
    assert len(session.drawing.document.underlays) == 1


def test_a_picture_out_of_a_browser_is_taken(window, settle):
    data = QMimeData()
    data.setImageData(image())
    drop(window.canvas, data)
    settle(window.session)
    assert pictures(window.session) == ["Picture"]


def test_a_document_is_saved_with_its_pictures_and_a_small_one_of_what_is_seen(
    window, settle, page, tmp_path, sketches
):
    session = window.session
    session.files.exchange.import_file(page)
    settle(session)

    def advise(state, camera):
        place = camera.on_plane([(128.0, 128.0)], camera.target, camera.axes[2])
        dot = Points(place.astype(np.float32), color=(0, 0, 255), size=40.0, hidden="show")
        return ViewAdvice("good", "x", scene=Scene((Layer("dot", (dot,)),)))

    sketches.view_advice = advise
    session.files.save(tmp_path / "car.bozz")
    settle(session)
    kept = ContainerReader((tmp_path / "car.bozz").read_bytes()).read("thumbnail.png")
    assert QImage.fromData(kept).pixelColor(128, 128).getRgb()[:3] == (0, 0, 255)
    session.files.new()
    session.files.open(tmp_path / "car.bozz")
    settle(session)
    assert pictures(session) == ["page"]
    assert session.drawing.document.models[0].state.pictures[0].pixels.shape == (120, 180, 4)


def test_a_modeler_that_hangs_over_advice_does_not_hold_up_a_save(
    window, settle, page, tmp_path, sketches, monkeypatch, qtbot
):
    session = window.session
    session.files.exchange.import_file(page)
    settle(session)
    gate = threading.Event()
    monkeypatch.setattr("bozzetto_app.session.thumbnail.PATIENCE", 0.05)
    sketches.view_advice = lambda state, camera: gate.wait(20)
    try:
        session.files.save(tmp_path / "car.bozz")
        qtbot.waitUntil(lambda: (tmp_path / "car.bozz").exists(), timeout=10_000)
    finally:
        gate.set()
    settle(session)


# -- the view that is pinned --------------------------------------------------------------------


@pytest.fixture
def pinned(window, settle, page):
    window.session.files.exchange.import_file(page)
    settle(window.session)
    return window


def test_moving_and_zooming_keep_the_eye_and_fit_lets_go(pinned, settle):
    session, canvas = pinned.session, pinned.canvas
    before = session.view.camera
    none = Qt.MouseButton.NoButton
    wheel = QWheelEvent(
        QPointF(500, 300), canvas.mapToGlobal(QPointF(500, 300)), QPoint(), QPoint(0, 360), none,
        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    canvas.wheelEvent(wheel)
    assert session.view.camera.eye == before.eye
    assert session.view.camera.fov_y < before.fov_y
    # What was under the pen is there still, though nothing of the model is.
    place = before.rays([(500.0, 300.0)])
    (seen,), _ = session.view.camera.project(place.origins + DEPTH * place.directions)
    np.testing.assert_allclose(seen, (500, 300), atol=1e-6)
    settle(session)
    assert session.advice.holds_eye(session.view.camera)
    canvas.views.fit()
    settle(session)
    assert session.view.camera.eye != before.eye
    assert session.view.camera.fov_y == 35.0
    assert not session.advice.holds_eye(session.view.camera)


# -- a tap that is aimed ------------------------------------------------------------------------


def test_a_mark_is_where_the_pen_lifts_and_is_previewed_on_the_way(pinned, settle, qtbot):
    session, canvas = pinned.session, pinned.canvas
    pen = Pen(canvas)
    pen.press(300, 300)
    assert canvas.loupe.isVisible()
    pen.move(420, 350)
    layers = lambda: [layer.name for layer in session.scene.preview.layers]  # noqa: E731
    qtbot.waitUntil(lambda: "marks" in layers(), timeout=5000)
    pen.move(430, 360)
    pen.release(430, 360)
    assert not canvas.loupe.isVisible()
    settle(session)
    (mark,) = session.selection.model.state.marks
    camera = session.view.camera
    (handle,) = (item for _, item in session.scene.visible.items() if hasattr(item, "point"))
    (seen,), _ = camera.project(handle.point)
    np.testing.assert_allclose(seen, (430, 360), atol=1e-6)
    assert "marks" not in [layer.name for layer in session.scene.preview.layers]
    assert session.drawing.history.undo_label == "Mark"
    # The handle is dragged with the loupe, too.
    pen.press(430, 360)
    pen.move(460, 380)
    qtbot.waitUntil(canvas.loupe.isVisible, timeout=5000)
    pen.release(460, 380)
    assert not canvas.loupe.isVisible()
    settle(session)
    (moved,) = session.selection.model.state.marks
    assert moved[0] > mark[0]


def test_escape_takes_an_aimed_tap_back(pinned, settle, qtbot):
    session, canvas = pinned.session, pinned.canvas
    pen = Pen(canvas)
    pen.press(300, 300)
    pen.move(420, 350)
    qtbot.waitUntil(lambda: bool(session.scene.preview.layers), timeout=5000)
    QTest.keyClick(canvas, Qt.Key.Key_Escape)
    assert not canvas.loupe.isVisible()
    pen.release(420, 350)
    settle(session)
    assert session.selection.model.state.marks == ()
    assert session.scene.preview.layers == ()


def test_a_refused_tap_leaves_no_preview(window, settle):
    session = window.session
    pen = Pen(window.canvas)
    pen.press(300, 300)
    pen.move(420, 350)
    pen.release(420, 350)
    settle(session)
    assert "There is no sketch" in session.heard[-1].text
    assert session.scene.preview.layers == ()
