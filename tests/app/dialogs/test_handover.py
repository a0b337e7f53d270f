"""The export dialog: what it shows is what is written, and it remembers the last choice."""

from __future__ import annotations

import struct
from threading import Event

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QMessageBox

from bozzetto.exchange.handover import Handover
from bozzetto.geometry import Mesh, Shapes, Solid
from bozzetto_app.dialogs.handover import HandoverDialog
from bozzetto_app.session.exchange import Foreseen


def block(x):
    import manifold3d

    made = manifold3d.Manifold.cube((10, 20, 30)).refine(6).translate((x, 0, 0)).to_mesh()
    return Mesh(made.vert_properties[:, :3], made.tri_verts)


@pytest.fixture
def window(make_window, settle):
    made = make_window()
    for number in range(2):
        shapes = Shapes(solids=(Solid(block(50.0 * number)),))
        model = made.session.workbench.sources.from_shapes("bozzetto.mesh", shapes, f"box {number}")
        made.session.drawing.apply_model("Import", model, is_new=True)
    settle(made.session)
    return made


def opened(window):
    window.files.ask_export()
    return window.findChildren(HandoverDialog)[-1]


def ready(qtbot, dialog):
    qtbot.waitUntil(dialog.go.isEnabled, timeout=30_000)


def choose(dialog, *wanted):
    for name, toggle in dialog.formats.items():
        toggle.setChecked(name in wanted)


def test_what_the_dialog_foresees_is_written_and_remembered(
    window, settle, qtbot, tmp_path, monkeypatch
):
    dialog = opened(window)
    choose(dialog, "stl", "obj")
    dialog.triangles.setValue(100)
    dialog.scale.setValue(2.0)
    ready(qtbot, dialog)
    assert "120 × 40 × 60 mm" in dialog.state.text()
    assert dialog.handover == Handover(scale=2.0, triangles=100)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "a.stl"), ""))
    said = dialog.state.text()
    dialog.go.click()
    settle(window.session)
    data = (tmp_path / "a.stl").read_bytes()
    count = struct.unpack_from("<I", data, 80)[0]
    assert count <= 100
    # Two boxes as one: STL has those of both.
    assert f"{count} triangles" in said
    assert (tmp_path / "a.obj").exists()
    assert (tmp_path / "a.mtl").exists()
    again = opened(window)
    assert again.chosen == tuple(n for n in again.formats if n in ("stl", "obj"))
    assert again.handover == Handover(scale=2.0, triangles=100)


def test_quads_take_the_place_of_triangles_and_both_are_counted(
    window, settle, qtbot, tmp_path, monkeypatch
):
    dialog = opened(window)
    choose(dialog, "obj")
    dialog.mesh.set_silently("quads")
    dialog.mesh.chosen.emit("quads")
    dialog.quads.setValue(400)
    assert not dialog.triangles.isEnabled()
    assert dialog.handover == Handover(quads=400)
    ready(qtbot, dialog)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "a.obj"), ""))
    said = dialog.state.text()
    dialog.go.click()
    settle(window.session)
    sizes = [line.count(" ") for line in (tmp_path / "a.obj").read_text().splitlines()
             if line.startswith("f ")]  # fmt: skip
    assert f"{sizes.count(4)} quads, {sizes.count(3)} triangles" in said
    assert sizes.count(4) > 300
    again = opened(window)
    assert again.handover == Handover(quads=400)


def test_objects_are_chosen_and_none_cannot_be_exported(window, qtbot, settle, tmp_path):
    dialog = opened(window)
    choose(dialog, "stl")
    ready(qtbot, dialog)
    assert dialog.names is None
    dialog.objects.item(0).setCheckState(Qt.CheckState.Unchecked)
    assert dialog.names == ("box 1",)
    assert not dialog.go.isEnabled()
    ready(qtbot, dialog)
    assert "10 × 20 × 30 mm" in dialog.state.text()
    dialog.objects.item(1).setCheckState(Qt.CheckState.Unchecked)
    assert not dialog.go.isEnabled()
    choose(dialog)
    assert "format" in dialog.state.text()


def test_what_a_format_cannot_hold_is_said_before_it_is_chosen(window, qtbot):
    dialog = opened(window)
    choose(dialog, "step")
    qtbot.waitUntil(lambda: "STEP" in dialog.state.text(), timeout=30_000)
    assert not dialog.go.isEnabled()


def test_what_no_chosen_format_heeds_is_grey_and_kept_for_those_that_do(window, qtbot):
    dialog = opened(window)
    choose(dialog, "glb")
    dialog.uvs.setChecked(True)
    dialog.lines.chosen.emit("outlines")
    assert dialog.handover == Handover(uvs=True)
    assert not dialog.lines.isEnabled()
    assert "formats" in dialog.lines.toolTip()
    choose(dialog, "svg")
    assert dialog.handover == Handover()
    assert dialog.lines.isEnabled()
    grey = dialog.uvs, dialog.triangles, dialog.unit
    assert not any(widget.isEnabled() for widget in grey)
    dialog.lines.set_silently("blueprint")
    dialog.lines.chosen.emit("blueprint")
    assert dialog.unit.isEnabled(), "of the dimensions"
    dialog.lines.set_silently("curves")
    choose(dialog, "glb", "svg")
    assert dialog.handover == Handover(uvs=True)
    assert dialog.triangles.toolTip() == ""


@pytest.mark.parametrize("wrong", ["nonsense", "nan", "-inf"])
def test_settings_that_anybody_wrote_do_not_stop_the_dialog(window, qtbot, wrong):
    from bozzetto_app.settings import settings

    keys = "formats unit up scale triangles quads mesh lines lay_flat"
    for key in keys.split():
        settings().setValue(f"handover/{key}", wrong)
    dialog = opened(window)
    ready(qtbot, dialog)
    assert dialog.handover == Handover()


def test_each_file_that_is_there_is_asked_about(window, qtbot, settle, tmp_path, monkeypatch):
    (tmp_path / "a.obj").write_bytes(b"theirs")
    dialog = opened(window)
    choose(dialog, "stl", "obj")
    ready(qtbot, dialog)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "a.stl"), ""))
    monkeypatch.setattr(QMessageBox, "question", lambda *_: QMessageBox.StandardButton.No)
    dialog.go.click()
    settle(window.session)
    assert (tmp_path / "a.obj").read_bytes() == b"theirs"
    assert not (tmp_path / "a.stl").exists()
    assert np.isfinite(dialog.scale.value())


def test_asking_twice_opens_one_dialog_and_again_another_one(window, qtbot):
    first = opened(window)
    assert opened(window) is first
    first.close()
    assert opened(window) is not first


def test_nothing_moves_under_the_pointer_when_the_answer_comes(window, qtbot):
    """The dialog grew when it had measured, and the switches went down with it."""
    window.session.objects.delete(window.session.drawing.document.models[1].id)  # no list of them
    dialog = opened(window)
    qtbot.waitUntil(dialog.isVisible)
    controls = [*dialog.formats.values(), dialog.unit, dialog.scale, dialog.hidden, dialog.state]
    qtbot.wait(50)

    def places():
        return [one.mapTo(dialog, one.rect().topLeft()).toTuple() for one in controls]

    before = places()
    choose(dialog, "stl", "glb")
    ready(qtbot, dialog)
    said = Foreseen((1.0, 2.0, 3.0), 12, 0, ((".glb", 100),), ("What is said of the file.",))
    window.session.files.exchange.foreseen.emit(said)
    assert dialog.warning.isVisible()
    qtbot.wait(50)
    assert places() == before
    assert dialog.warning.height() >= dialog.warning.heightForWidth(dialog.warning.width())


def test_on_a_low_screen_it_says_that_there_are_warnings_below(window, qtbot, monkeypatch):
    from PySide6.QtCore import QRect
    from PySide6.QtGui import QScreen

    seen = Foreseen((1.0, 2.0, 3.0), 12, 0, ((".stl", 100),), ("The walls are thin.",))
    for size, is_told in (((1280, 1400), False), ((683, 384), True)):
        free = QRect(0, 0, *size)
        monkeypatch.setattr(QScreen, "availableGeometry", lambda _, free=free: free)
        dialog = opened(window)
        ready(qtbot, dialog)
        window.session.files.exchange.foreseen.emit(seen)
        assert dialog.is_scrolled is is_told
        assert ("below" in dialog.state.text()) is is_told
        assert dialog.state.height() >= dialog.state.heightForWidth(dialog.state.width())
        dialog.reject()


def test_shapes_are_made_once_for_all_looks_and_the_export(
    window, settle, qtbot, tmp_path, monkeypatch
):
    bench, asked = window.session.workbench, []
    make = bench.shapes
    monkeypatch.setattr(bench, "shapes", lambda *args: asked.append(args) or make(*args))
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "a.stl"), ""))
    dialog = opened(window)
    choose(dialog, "stl")
    ready(qtbot, dialog)
    first = len(asked)
    assert first == 2
    dialog.scale.setValue(2.0)
    choose(dialog, "obj")
    ready(qtbot, dialog)
    assert "120 × 40 × 60 mm" in dialog.state.text()
    choose(dialog, "stl")
    ready(qtbot, dialog)
    dialog.go.click()
    settle(window.session)
    assert (tmp_path / "a.stl").exists()
    assert len(asked) == first
    # Another dialog looks anew, and so does this one once the objects or the choice differ.
    again = opened(window)
    ready(qtbot, again)
    assert len(asked) == 2 * first
    model = window.session.drawing.document.models[0]
    window.session.objects.rename(model.id, "other")
    ready(qtbot, again)
    assert len(asked) == 3 * first
    again.objects.item(0).setCheckState(Qt.CheckState.Unchecked)
    ready(qtbot, again)
    assert len(asked) == 3 * first + 1


def test_the_answer_to_a_choice_that_has_changed_is_not_shown(window, qtbot, monkeypatch):
    """Its shapes are taken all the same: while the first look goes on another format is chosen."""
    bench, asked, go_on = window.session.workbench, [], Event()
    make = bench.shapes

    def late(*args):
        asked.append(args)
        assert go_on.wait(20.0)
        return make(*args)

    monkeypatch.setattr(bench, "shapes", late)
    seen = []
    window.session.files.exchange.foreseen.connect(seen.append)
    dialog = opened(window)
    choose(dialog, "stl")
    qtbot.waitUntil(lambda: bool(asked), timeout=20_000)
    choose(dialog, "obj")
    qtbot.wait(600)
    go_on.set()
    ready(qtbot, dialog)
    assert [[ending for ending, _ in one.files] for one in seen] == [[".obj"]]
    assert "OBJ" in dialog.state.text()
    assert len(asked) == 2


def test_the_dialog_shows_a_picture_of_what_is_chosen(window, settle, qtbot):
    dialog = opened(window)
    qtbot.waitUntil(lambda: not dialog.picture.pixmap().isNull(), timeout=20_000)
    first = dialog.picture.pixmap().toImage()
    assert first.height() <= 200 * dialog.devicePixelRatioF()
    dialog.objects.item(1).setCheckState(Qt.CheckState.Unchecked)
    qtbot.waitUntil(lambda: dialog.go.isEnabled(), timeout=20_000)
    assert dialog.picture.pixmap().toImage() != first
    dialog.reject()
