"""Files of a session: saved and reopened as they were, handed over, brought in, and locked."""

from __future__ import annotations

import json
import math
import os
import stat
import subprocess
import sys
import threading
import zipfile

import numpy as np
import pytest

from bozzetto.atomic_files import FileChanged
from bozzetto.document.model import Model, OpaqueState, new_id
from bozzetto.document.recovery.file_lock import FileLock, Locked, document_lock_path, holder
from bozzetto.exchange.import_file import read_mesh, read_mesh_file
from bozzetto.exchange.ink.ink_json import write_drawing
from bozzetto.exchange.mesh.manifold_check import bounds_volume
from bozzetto.ink import Drawing, Strokes
from bozzetto.scene import snapshot
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto_app.session import thumbnail as small_picture
from bozzetto_app.session.files import LAST_FOLDER
from bozzetto_app.session.recent_files import recent_files
from bozzetto_app.settings import settings
from tests.app.seen import meshes
from tests.app.tablet import circle, draw, stroke_of
from tests.app.troublemaker import MODELER

SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">
<path d="M10 10 L90 10 L90 90 L10 90 Z" fill="none" stroke="black"/></svg>"""


def words(session, kind):
    return [notice.text for notice in session.heard if notice.kind == kind]


def save(session, settle, path):
    session.files.save(path)
    settle(session)


def reopen(session, settle, path):
    session.files.open_safely(path)
    settle(session)


# -- saving and opening --------------------------------------------------------------------------


def test_a_drawing_comes_back_to_the_last_bit(make_session, settle, tmp_path):
    first = make_session()
    draw(first, settle, radius=150)
    draw(first, settle, radius=60)
    first.objects.set_parameter("inflation", 1.3)
    first.objects.set_color(first.selection.id, (200, 120, 30))
    settle(first)
    assert first.drawing.is_modified
    save(first, settle, tmp_path / "horse")
    assert first.drawing.path == tmp_path / "horse.bozz"
    assert (first.drawing.title, first.drawing.is_modified) == ("horse", False)
    first.files.close()

    second = make_session()
    reopen(second, settle, tmp_path / "horse.bozz")
    assert not second.drawing.is_modified
    assert second.view.camera == first.view.camera
    (mine,), (other,) = first.drawing.document.models, second.drawing.document.models
    assert (mine.name, mine.color, mine.id) == (other.name, other.color, other.id)
    inflation = [[part.inflation for part in model.state.parts] for model in (mine, other)]
    assert inflation[0] == inflation[1]
    assert 1.3 in inflation[1]
    for one, two in zip(meshes(first), meshes(second), strict=True):
        assert one.vertices.tobytes() == two.vertices.tobytes()
        assert one.faces.tobytes() == two.faces.tobytes()


def test_what_is_drawn_while_saving_counts_as_unsaved(session, settle, tmp_path):
    draw(session, settle)
    session.files.save(tmp_path / "a.bozz")
    session.objects.rename(session.selection.id, "Later")
    settle(session)
    assert session.drawing.is_modified
    reopened_names = json_names(tmp_path / "a.bozz")
    assert reopened_names == ["Boxes"]
    session.drawing.undo()
    assert not session.drawing.is_modified


def json_names(path, *names):
    with zipfile.ZipFile(path) as file:
        models = json.loads(file.read("core/models.json"))
    found = json.dumps(models)
    return [name for name in names or ("Boxes", "Later") if f'"{name}"' in found]


def test_a_save_that_ends_after_a_new_sheet_was_begun_does_not_name_it(session, settle, tmp_path):
    draw(session, settle)
    session.files.save(tmp_path / "old.bozz")
    session.files.new()
    settle(session)
    assert (tmp_path / "old.bozz").exists()
    assert session.drawing.path is None
    assert not document_lock_path(tmp_path / "old.bozz").exists()


def test_a_failed_save_is_told_and_the_work_stays_unsaved(session, settle, tmp_path):
    draw(session, settle)
    save(session, settle, tmp_path / "no" / "such" / "folder.bozz")
    assert len(words(session, "error")) == 1
    assert session.drawing.is_modified
    assert session.drawing.path is None


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 not really", b"\0" * 5000])
def test_a_damaged_document_is_refused_and_the_sheet_stays(session, settle, tmp_path, content):
    draw(session, settle)
    before = session.drawing.document
    (tmp_path / "bad.bozz").write_bytes(content)
    reopen(session, settle, tmp_path / "bad.bozz")
    reopen(session, settle, tmp_path / "missing.bozz")
    assert session.drawing.document is before
    assert len(words(session, "error")) == 2
    assert not document_lock_path(tmp_path / "bad.bozz").exists()


def test_drawing_while_a_document_is_being_read_is_not_thrown_away(session, settle, tmp_path):
    draw(session, settle)
    save(session, settle, tmp_path / "a.bozz")
    session.files.new()
    session.files.open(tmp_path / "a.bozz")
    session.gestures.stroke_lifted(stroke_of(circle(share=0.5), session.view.camera))
    settle(session)
    assert session.drawing.path is None
    assert len(session.drawing.pending) == 1
    assert "you were drawing" in words(session, "info")[-1]


def test_recent_files_are_those_opened_and_saved_newest_first(session, settle, tmp_path):
    draw(session, settle)
    for name in ("a", "b", "c"):
        save(session, settle, tmp_path / f"{name}.bozz")
    reopen(session, settle, tmp_path / "b.bozz")
    assert [path.name for path in recent_files()] == ["b.bozz", "c.bozz", "a.bozz"]
    (tmp_path / "c.bozz").unlink()
    session.files.tidy()
    settle(session)
    assert [path.name for path in recent_files()] == ["b.bozz", "a.bozz"]


def test_what_killed_processes_left_is_gone_after_the_start(session, settle, tmp_path):
    code = (
        "import os, sys; from bozzetto.atomic_files import atomic_write; "
        "atomic_write(sys.argv[1], lambda file: os._exit(0))"
    )
    draw(session, settle)
    folders = [tmp_path / "documents", tmp_path / "exports"]
    for folder in folders:
        folder.mkdir()
    save(session, settle, folders[0] / "a.bozz")
    settings().setValue(LAST_FOLDER, str(folders[1]))
    for folder in folders:
        subprocess.run([sys.executable, "-c", code, str(folder / "x.stl")], check=True)
        assert list(folder.glob(".bozzetto-*"))
    session.files.tidy()
    settle(session)
    assert [*folders[0].glob(".bozzetto-*"), *folders[1].glob(".bozzetto-*")] == []
    assert (folders[0] / "a.bozz").exists()


@pytest.mark.parametrize("ending", ["stl", "3mf", "glb", "obj", "ply"])
def test_what_is_exported_is_closed_and_as_large_as_what_is_shown(
    make_session, settle, tmp_path, ending
):
    session = make_session()
    draw(session, settle)
    session.files.exchange.export(tmp_path / f"out.{ending}")
    settle(session)
    assert (tmp_path / f"out.{ending}").stat().st_size > 1000
    assert words(session, "error") == []
    if ending == "3mf":
        return
    (mesh,) = read_mesh(tmp_path / f"out.{ending}").meshes()
    shown = meshes(session)[0]
    assert np.allclose(
        np.ptp(mesh.mesh.vertices, axis=0), np.ptp(shown.vertices, axis=0), rtol=1e-4
    )
    assert bounds_volume(mesh.mesh)


def test_hidden_objects_are_not_exported_and_nothing_is_an_error(session, settle, tmp_path):
    draw(session, settle)
    session.objects.set_visible(session.selection.id, False)
    session.files.exchange.export(tmp_path / "out.stl")
    settle(session)
    assert not (tmp_path / "out.stl").exists()
    assert len(words(session, "error")) == 1


def test_what_an_export_leaves_out_is_named(session, settle, tmp_path):
    draw(session, settle)
    stranger = Model(new_id(), "Stranger", "nobody.knows", OpaqueState(1, b"{}", (), ()))
    session.drawing.commit("open", session.drawing.document.with_model(stranger))
    settle(session)
    session.files.exchange.export(tmp_path / "out.stl")
    settle(session)
    (said,) = words(session, "error")
    assert said.startswith("Exported “out.stl”. Left out of the STL file: “Stranger” (")
    assert "is not installed" in said
    assert (tmp_path / "out.stl").exists()


def test_a_cancelled_export_writes_nothing(session, boxes, settle, qtbot, tmp_path):
    draw(session, settle)
    gate, well = threading.Event(), boxes.misdeeds

    def slow(state, result):
        del well["shapes"]
        gate.wait(10)
        return session.registry.modeler(MODELER).shapes(state, result)

    well["shapes"] = slow
    session.files.exchange.export(tmp_path / "out.stl")
    qtbot.waitUntil(lambda: boxes.calls["shapes"] == 1)
    session.cancel_work()
    gate.set()
    settle(session)
    assert list(tmp_path.glob("out*")) == []
    assert words(session, "error") == []


def test_an_export_that_is_cancelled_while_its_file_is_made_writes_nothing(
    session, boxes, settle, qtbot, tmp_path, monkeypatch
):
    """The formats ask nobody whether to go on: that is looked at before the file is put there."""
    from bozzetto.exchange.mesh import stl

    draw(session, settle)
    begun, gate, written = threading.Event(), threading.Event(), stl.write_shapes

    def slow(*arguments, **named):
        begun.set()
        gate.wait(10)
        return written(*arguments, **named)

    monkeypatch.setattr(stl, "write_shapes", slow)
    session.files.exchange.export(tmp_path / "out.stl")
    qtbot.waitUntil(begun.is_set)
    session.cancel_work()
    gate.set()
    settle(session)
    qtbot.wait(300)
    assert list(tmp_path.glob("out*")) == []


# -- bringing in ---------------------------------------------------------------------------------


def test_what_is_not_read_of_a_drawing_is_said(make_session, settle, tmp_path):
    session = make_session()
    (tmp_path / "named.svg").write_text(SVG.replace("</svg>", "<text>Front</text></svg>"))
    session.files.exchange.import_file(tmp_path / "named.svg")
    settle(session)
    (said,) = words(session, "error")
    assert "1 text of this drawing is left out" in said
    assert len(session.drawing.document) == 1


@pytest.mark.parametrize(("head", "said"), [("", 1), ("# Bozzetto: inches, Y up\n", 0)])
def test_how_a_mesh_is_read_is_said_unless_its_file_says_it(
    make_session, settle, tmp_path, head, said
):
    session = make_session()
    corners = "v 0 0 0\nv 10 0 0\nv 0 20 0\nv 0 0 30\n"
    (tmp_path / "tent.obj").write_text(f"{head}{corners}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    session.files.exchange.import_file(tmp_path / "tent.obj")
    settle(session)
    assert words(session, "error") == []
    assert sum("Parameters can change both" in text for text in words(session, "info")) == said


def test_flat_curves_are_ink_for_the_modeler_in_use_and_others_stay_curves(
    make_session, settle, tmp_path
):
    from bozzetto.exchange.cad.curve_pieces import polyline
    from bozzetto.exchange.export import export
    from bozzetto.geometry import Shapes

    session = make_session()
    flat = [(0, 0, 0), (90, 0, 0), (90, 50, 0), (0, 50, 0), (0, 0, 0)]
    bent = [(x, y, 0.01 * x * y) for x, y, _ in flat]
    for name, places in (("flat", flat), ("bent", bent)):
        export(Shapes(curves=(polyline(places),)), tmp_path / f"{name}.step")
        session.files.exchange.import_file(tmp_path / f"{name}.step")
        settle(session)
    assert words(session, "error") == []
    ink, curves = session.drawing.document
    assert (ink.modeler, curves.modeler) == ("bozzetto.silhouette", "bozzetto.mesh")
    assert curves.state.curves[0].control_points.tolist() == [list(map(float, p)) for p in bent]


def test_a_drawing_a_mesh_and_a_picture_come_in_each_as_one_step(make_session, settle, tmp_path):
    from bozzetto.images.png import write_png

    session = make_session()
    (tmp_path / "square.svg").write_text(SVG)
    session.files.exchange.import_file(tmp_path / "square.svg")
    settle(session)
    session.files.exchange.export(tmp_path / "square.stl")
    settle(session)
    session.files.exchange.import_file(tmp_path / "square.stl")
    settle(session)
    write_png(tmp_path / "photo.png", np.full((30, 40, 4), 200, np.uint8))
    session.files.exchange.import_file(tmp_path / "photo.png")
    settle(session)
    (left_out,) = words(session, "error")  # the black of the drawing's line
    assert "the colours of 1 solid" in left_out
    assert [model.modeler for model in session.drawing.document] == [
        "bozzetto.silhouette",
        "bozzetto.mesh",
    ]
    assert [under.name for under in session.drawing.document.underlays] == ["photo"]
    assert len(session.drawing.history.entries) == 4
    drawn, read = meshes(session)
    assert np.allclose(np.ptp(drawn.vertices, axis=0), np.ptp(read.vertices, axis=0), rtol=1e-4)
    # In an SVG drawing a unit is a millimetre, and (x, y) lies at (x, 0, -y).
    assert np.allclose(drawn.vertices.min(0)[[0, 2]], (10, -90), atol=1.5)
    across, down = (
        session.drawing.document.underlays[0].across,
        session.drawing.document.underlays[0].down,
    )
    assert abs(across[0] / down[2]) == pytest.approx(40 / 30)
    for _ in range(3):
        session.drawing.undo()
    assert len(session.drawing.document) + len(session.drawing.document.underlays) == 0


def test_an_import_that_ends_on_another_sheet_is_dropped(session, settle, tmp_path):
    (tmp_path / "square.svg").write_text(SVG)
    session.files.exchange.import_file(tmp_path / "square.svg")
    session.files.new()
    settle(session)
    assert len(session.drawing.document) == 0


def test_opening_a_drawing_makes_a_new_document_of_it(session, settle, tmp_path):
    draw(session, settle)
    (tmp_path / "square.svg").write_text(SVG)
    session.files.open_safely(tmp_path / "square.svg")
    settle(session)
    assert len(session.drawing.document) == 1
    assert session.drawing.path is None
    assert session.drawing.is_modified


def test_a_refused_drawing_lights_no_places_of_ink_that_is_not_on_the_sheet(
    make_session, settle, tmp_path
):
    session = make_session("bozzetto.silhouette")
    settle(session)
    bend = [(640 + 0.9 * k + 30 * math.sin(k / 6), 700 - 8 * k) for k in range(60)]
    drawn = Drawing(Strokes([Pen().along(bend)]), Camera())
    (tmp_path / "bend.json").write_bytes(write_drawing(drawn))
    session.files.exchange.import_file(tmp_path / "bend.json")
    settle(session)
    assert "crosses itself" in session.heard[-1].text
    assert session.heard[-1].places == ()
    assert not session.drawing.pending


def test_nonsense_is_refused_with_a_sentence(session, settle, tmp_path):
    for name, content in (("a.svg", "<svg"), ("b.stl", "solid"), ("c.png", "x"), ("d.xyz", "x")):
        (tmp_path / name).write_text(content)
        session.files.exchange.import_file(tmp_path / name)
        settle(session)
    assert len(words(session, "error")) == 4
    assert words(session, "fault") == []
    assert len(session.drawing.document) == 0


# -- who has it open -----------------------------------------------------------------------------


def test_the_lock_is_there_while_a_document_is_open_and_goes_with_it(session, settle, tmp_path):
    one, two = tmp_path / "one.bozz", tmp_path / "two.bozz"
    draw(session, settle)
    save(session, settle, one)
    assert holder(document_lock_path(one)).pid == os.getpid()
    save(session, settle, two)
    assert not document_lock_path(one).exists()
    reopen(session, settle, one)
    assert not document_lock_path(two).exists()
    assert document_lock_path(one).exists()
    reopen(session, settle, one)
    assert document_lock_path(one).exists()
    session.files.new()
    settle(session)
    assert not document_lock_path(one).exists()
    reopen(session, settle, one)
    session.files.close()
    settle(session)
    assert not document_lock_path(one).exists()


def test_somebody_elses_document_opens_to_be_looked_at(make_session, settle, tmp_path):
    mine, theirs = tmp_path / "mine.bozz", make_session()
    draw(theirs, settle)
    save(theirs, settle, mine)
    me = make_session()
    reopen(me, settle, mine)
    assert len(me.drawing.document) == 1
    assert me.drawing.read_only
    (said,) = words(me, "error")
    lock = holder(document_lock_path(mine))
    assert lock.user in said
    assert lock.host in said
    before = mine.read_bytes()
    me.objects.rename(me.selection.id, "Other")
    save(me, settle, mine)
    assert mine.read_bytes() == before
    assert me.drawing.is_modified
    save(me, settle, tmp_path / "copy.bozz")
    assert not me.drawing.read_only
    assert not me.drawing.is_modified
    assert holder(document_lock_path(mine)) == lock


def test_a_lock_of_a_dead_process_is_taken_over(session, settle, tmp_path):
    path = tmp_path / "a.bozz"
    draw(session, settle)
    save(session, settle, path)
    session.files.new()
    code = (
        "import os, sys; from bozzetto.document.recovery.file_lock import *; "
        "FileLock.acquire(document_lock_path(sys.argv[1]), 'a'); os._exit(0)"
    )
    subprocess.run([sys.executable, "-c", code, str(path)], check=True)
    assert holder(document_lock_path(path)).is_gone
    reopen(session, settle, path)
    assert not session.drawing.read_only
    assert holder(document_lock_path(path)).pid == os.getpid()


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write everywhere")
def test_a_document_in_a_folder_without_permission_can_be_looked_at(session, settle, tmp_path):
    folder = tmp_path / "shelf"
    folder.mkdir()
    draw(session, settle)
    save(session, settle, folder / "a.bozz")
    session.files.new()
    folder.chmod(stat.S_IRUSR | stat.S_IXUSR)
    try:
        reopen(session, settle, folder / "a.bozz")
        assert session.drawing.read_only
        assert len(session.drawing.document) == 1
    finally:
        folder.chmod(0o755)


def test_where_no_lock_can_be_made_a_document_is_read_only(session, settle, tmp_path, monkeypatch):
    from bozzetto.errors import UserError

    path = tmp_path / "a.bozz"
    draw(session, settle)
    save(session, settle, path)
    session.files.new()

    def refuse(*_, **__):
        raise UserError("the folder cannot be written to")

    monkeypatch.setattr(FileLock, "acquire", refuse)
    reopen(session, settle, path)
    assert session.drawing.read_only
    assert len(session.drawing.document) == 1
    assert "nothing can be written" in words(session, "error")[0]


def test_a_document_can_be_taken_over_and_who_lost_it_is_asked(make_session, settle, tmp_path):
    path, theirs = tmp_path / "a.bozz", make_session()
    draw(theirs, settle)
    save(theirs, settle, path)
    me = make_session()
    locked = []
    me.files.locked.connect(locked.append)
    reopen(me, settle, path)
    assert locked == [path]
    me.files.take_over(path)
    settle(me)
    assert not me.drawing.read_only
    me.objects.rename(me.selection.id, "Mine")
    me.files.save()
    settle(me)
    assert not me.drawing.is_modified

    met = []
    theirs.files.when_hindered = met.append
    theirs.objects.rename(theirs.selection.id, "Theirs")
    theirs.files.save()
    settle(theirs)
    assert isinstance(met[0].problem, Locked)
    assert theirs.drawing.is_modified
    met[0].go_on()
    settle(theirs)
    assert isinstance(met[1].problem, FileChanged)  # it was saved meanwhile
    met[1].go_on()
    settle(theirs)
    assert not theirs.drawing.is_modified
    assert json_names(path, "Theirs", "Mine") == ["Theirs"]


# -- what other programs do to the file ----------------------------------------------------------


@pytest.fixture
def saved(session, settle, tmp_path):
    """The session's document, saved and then changed."""
    draw(session, settle)
    save(session, settle, tmp_path / "a.bozz")
    session.objects.rename(session.selection.id, "Later")
    return tmp_path / "a.bozz"


def test_a_file_that_another_program_changed_is_not_written_over(session, saved, settle):
    saved.write_bytes(b"theirs")
    session.files.save()
    settle(session)
    assert saved.read_bytes() == b"theirs"
    assert session.drawing.is_modified
    assert "changed by another program" in words(session, "error")[-1]


@pytest.mark.parametrize("answer", ["go_on", "keep_both", "leave"])
def test_the_answer_to_a_changed_file_is_done(session, saved, settle, answer):
    saved.write_bytes(b"theirs")
    met, ended = [], []
    session.files.when_hindered = met.append
    session.files.save(None, lambda: ended.append("then"), lambda: ended.append("failed"))
    settle(session)
    assert ended == []
    getattr(met[0], answer)()
    settle(session)
    assert ended == (["failed"] if answer == "leave" else ["then"])
    assert session.drawing.is_modified is (answer == "leave")
    beside = saved.with_name("a 2.bozz")
    assert session.drawing.path == (beside if answer == "keep_both" else saved)
    assert beside.exists() is (answer == "keep_both")
    if answer == "go_on":
        assert json_names(saved) == ["Later"]
        assert saved.with_name("a.bozz~1").read_bytes() == b"theirs"
    else:
        assert saved.read_bytes() == b"theirs"
    session.objects.rename(session.selection.id, "Last")
    if answer != "leave":
        session.files.save()
        settle(session)
        assert not session.drawing.is_modified
        assert len(met) == 1


def test_a_file_that_changes_again_while_the_person_thinks_is_asked_about_again(
    session, saved, settle
):
    met = []
    session.files.when_hindered = met.append
    saved.write_bytes(b"theirs")
    session.files.save()
    settle(session)
    saved.write_bytes(b"theirs, once more")
    met[0].go_on()
    settle(session)
    assert len(met) == 2
    assert saved.read_bytes() == b"theirs, once more"


def test_what_was_opened_and_changed_elsewhere_is_asked_about(make_session, saved, session, settle):
    session.files.save()
    settle(session)
    session.files.close()
    other = make_session()
    reopen(other, settle, saved)
    saved.write_bytes(saved.read_bytes() + b" ")
    other.objects.rename(other.selection.id, "Mine")
    other.files.save()
    settle(other)
    assert other.drawing.is_modified


def test_saving_beside_never_hits_a_file_that_is_there(session, settle, tmp_path):
    draw(session, settle)
    (tmp_path / "a.bozz").write_bytes(b"theirs")
    save(session, settle, tmp_path / "a")
    assert (tmp_path / "a.bozz").read_bytes() == b"theirs"
    assert "already" in words(session, "error")[-1]


def test_a_file_that_is_gone_is_saved_anew_and_said(session, saved, settle, tmp_path):
    saved.rename(tmp_path / "moved.bozz")
    session.files.save()
    settle(session)
    assert saved.exists()
    assert "moved or deleted" in words(session, "info")[-1]


def test_a_file_that_became_a_folder_or_read_only_stays_as_it_is(session, saved, settle, tmp_path):
    saved.chmod(0o444)
    session.files.save()
    settle(session)
    assert "may not be written" in words(session, "error")[-1]
    saved.unlink()
    saved.mkdir()
    session.files.save()
    settle(session)
    assert "is a folder" in words(session, "error")[-1]
    assert session.drawing.is_modified
    save(session, settle, tmp_path / "b.bozz")
    assert not session.drawing.is_modified


@pytest.mark.skipif(os.name == "nt", reason="links")
def test_other_names_of_a_file_are_told(session, saved, settle, tmp_path):
    os.link(saved, tmp_path / "other.bozz")
    session.files.save()
    settle(session)
    assert "hard links" in words(session, "info")[-1]
    assert json_names(tmp_path / "other.bozz") == ["Boxes"]


@pytest.mark.skipif(os.name == "nt", reason="any bytes are a name")
def test_a_document_whose_name_is_not_text_is_opened_and_saved(session, saved, settle, tmp_path):
    session.files.save()
    settle(session)
    odd = tmp_path / "caf\udce9.bozz"
    try:
        os.rename(saved, odd)
    except OSError:
        pytest.skip("the disk wants text")
    reopen(session, settle, odd)
    assert session.drawing.path == odd
    session.objects.rename(session.selection.id, "Boxes")
    session.files.save()
    settle(session)
    assert not session.drawing.is_modified
    assert json_names(odd) == ["Boxes"]
    assert words(session, "error") + words(session, "fault") == []
    assert recent_files()[0] == odd


# -- the small picture ---------------------------------------------------------------------------


def has_picture(path):
    with zipfile.ZipFile(path) as file:
        return "thumbnail.png" in file.namelist()


def test_a_document_has_a_small_picture(session, settle, tmp_path, monkeypatch):
    monkeypatch.setattr(small_picture, "PATIENCE", 30.0)
    draw(session, settle)
    save(session, settle, tmp_path / "a.bozz")
    assert has_picture(tmp_path / "a.bozz")


def test_a_picture_that_cannot_be_made_does_not_stop_the_save(
    session, settle, tmp_path, monkeypatch
):
    def fail(*_, **__):
        raise MemoryError

    monkeypatch.setattr(snapshot, "thumbnail", fail)
    draw(session, settle)
    save(session, settle, tmp_path / "a.bozz")
    assert not session.drawing.is_modified
    assert not has_picture(tmp_path / "a.bozz")
    reopen(session, settle, tmp_path / "a.bozz")
    assert len(session.drawing.document) == 1


def test_a_picture_that_is_late_does_not_hold_the_save_up(session, settle, tmp_path, monkeypatch):
    gate, begun, paint = threading.Event(), [], snapshot.thumbnail

    def wait(*asked, **more):
        begun.append(None)
        gate.wait(30)
        return paint(*asked, **more)

    monkeypatch.setattr(snapshot, "thumbnail", wait)
    draw(session, settle)
    for name in ("a.bozz", "b.bozz"):
        save(session, settle, tmp_path / name)
        assert not session.drawing.is_modified
        assert not has_picture(tmp_path / name)
    assert len(begun) == 1  # the second save did not start another beside it
    gate.set()


# -- slow files ------------------------------------------------------------------------------------


@pytest.fixture
def waiting_reader(monkeypatch):
    """A reader of meshes that answers only when it is let go, told as slow soon."""
    gate = threading.Event()

    def wait(path, **options):
        gate.wait(60)
        return read_mesh_file(path, trusted=True)

    monkeypatch.setattr("bozzetto.exchange.import_file.read_mesh_file", wait)
    monkeypatch.setattr("bozzetto_app.workers.channel.LATE_AFTER", 0.1)
    yield gate
    gate.set()


CUBE = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def test_a_file_that_takes_long_is_told_as_slow_and_waited_for(
    waiting_reader, make_session, boxes, settle, tmp_path, qtbot
):
    session = make_session(MODELER, extra=[boxes.package])
    (tmp_path / "a.obj").write_text(CUBE)
    session.files.exchange.import_file(tmp_path / "a.obj")
    qtbot.waitUntil(lambda: words(session, "slow") != [], timeout=10_000)
    waiting_reader.set()
    settle(session)
    assert len(session.drawing.document) == 1
    assert words(session, "slow") == ["Still working. Esc stops it."]
    assert words(session, "fault") == words(session, "error") == []


def test_a_file_that_takes_long_can_be_stopped(
    waiting_reader, make_session, boxes, settle, tmp_path, qtbot
):
    session = make_session(MODELER, extra=[boxes.package])
    (tmp_path / "a.obj").write_text(CUBE)
    session.files.exchange.import_file(tmp_path / "a.obj")
    qtbot.waitUntil(lambda: words(session, "slow") != [], timeout=10_000)
    session.cancel_work()
    settle(session)
    assert len(session.drawing.document) == 0
    assert words(session, "info") == ["Stopped. Nothing was changed."]
    assert words(session, "fault") == words(session, "error") == []


# -- turntables ------------------------------------------------------------------------------------


def test_a_turntable_is_written_and_never_over_pictures_that_are_there(
    make_session, settle, tmp_path
):
    session = make_session()
    (tmp_path / "a.obj").write_text(CUBE)
    session.files.exchange.import_file(tmp_path / "a.obj")
    settle(session)
    before = session.drawing.document
    session.files.exchange.films.turn(tmp_path / "turn.gif", 0.3)
    session.files.exchange.films.turn(tmp_path / "row.png", 0.3)
    settle(session)
    assert (tmp_path / "turn.gif").read_bytes()[:4] == b"GIF8"
    assert len(list(tmp_path.glob("row-*.png"))) == 4
    assert words(session, "error") == []
    (tmp_path / "row-3.png").write_bytes(b"mine")
    session.files.exchange.films.turn(tmp_path / "row.png", 0.3)
    settle(session)
    assert (tmp_path / "row-3.png").read_bytes() == b"mine"
    assert session.drawing.document is before


def test_a_turntable_begins_with_the_sketch_where_there_is_one(make_session, settle, tmp_path):
    session = make_session()
    (tmp_path / "a.obj").write_text(CUBE)
    session.files.exchange.import_file(tmp_path / "a.obj")
    settle(session)
    session.files.exchange.films.turn(tmp_path / "none.png", 0.3, from_sketch=True)
    settle(session)
    (said,) = words(session, "error")
    assert "no sketch" in said
    assert not list(tmp_path.glob("none-*.png"))
    session.files.exchange.import_file(boat(session, tmp_path))
    settle(session)
    session.files.exchange.films.turn(tmp_path / "turn.png", 0.3, from_sketch=True)
    settle(session)
    assert len(list(tmp_path.glob("turn-*.png"))) > 4


def boat(session, tmp_path, **facts):
    """Write the drawing of the boat with other facts."""
    (sample,) = session.registry.info("bozzetto.symmetry").samples
    (tmp_path / "boat.json").write_text(json.dumps(json.loads(sample.read_bytes()) | facts))
    return tmp_path / "boat.json"


@pytest.mark.parametrize("name", ["symmetry", "bozzetto.symmetry"])
def test_ink_that_names_its_modeler_goes_to_it_whichever_is_in_the_hand(
    make_session, settle, tmp_path, name
):
    session = make_session("bozzetto.silhouette")
    session.files.exchange.import_file(boat(session, tmp_path, modeler=name))
    settle(session)
    (model,) = session.drawing.document
    assert model.modeler == "bozzetto.symmetry"
    assert words(session, "error") == []


def test_ink_of_a_modeler_that_is_not_there_says_which_is_missing(make_session, settle, tmp_path):
    session = make_session("bozzetto.silhouette")
    session.files.exchange.import_file(boat(session, tmp_path, modeler="somebody.boats"))
    settle(session)
    assert len(session.drawing.document) == 0
    (said,) = words(session, "error")
    assert "somebody.boats" in said
    assert "Install" in said
