"""The questions about files, in the window: what is asked, and that each answer is done."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QFileDialog, QMessageBox
from shiboken6 import isValid

from bozzetto.document.recovery.file_lock import FileLock, document_lock_path
from bozzetto.exchange.formats import find, writers
from tests.app.tablet import circle, stroke_of
from tests.app.troublemaker import MODELER


@pytest.fixture
def window(make_window, boxes, settle):
    made = make_window(MODELER, extra=[boxes.package])
    made.session.gestures.stroke_lifted(stroke_of(circle(), made.session.view.camera))
    settle(made.session, made.keeper)
    return made


@pytest.fixture
def saved(window, settle, tmp_path):
    """Where the window's document was saved; it was changed since, here and there."""
    window.session.files.save(tmp_path / "a.bozz")
    settle(window.session, window.keeper)
    window.session.objects.rename(window.session.selection.id, "Later")
    (tmp_path / "a.bozz").write_bytes(b"theirs")
    return tmp_path / "a.bozz"


def asked(window, qtbot, name):
    qtbot.waitUntil(lambda: window.findChild(QMessageBox, name) is not None, timeout=10_000)
    return window.findChild(QMessageBox, name)


def press(box, words):
    """Answer a question, each of whose buttons has a letter of its own."""
    texts = [button.text() for button in box.buttons()]
    assert len({text.partition("&")[2][:1].lower() for text in texts} - {""}) == len(texts), texts
    next(button for button in box.buttons() if button.text().replace("&", "") == words).click()


@pytest.mark.parametrize("answer", ["Keep both", "Overwrite", "Cancel"])
def test_a_changed_file_is_shown_and_the_answer_done(window, saved, settle, qtbot, answer):
    window.files.ask_save()
    box = asked(window, qtbot, "hindered")
    assert "changed by another program" in box.text()
    assert " 6 bytes" in box.informativeText()
    assert "As you had it" in box.informativeText()
    assert box.defaultButton().text().replace("&", "") == "Keep both"
    press(box, answer)
    settle(window.session, window.keeper)
    assert (saved.read_bytes() == b"theirs") is (answer != "Overwrite")
    assert window.session.drawing.is_modified is (answer == "Cancel")
    assert saved.with_name("a 2.bozz").exists() is (answer == "Keep both")


def test_who_closes_the_window_and_cancels_the_save_stays(window, saved, settle, qtbot):
    window.close()
    press(asked(window, qtbot, "unsaved"), "Save")
    press(asked(window, qtbot, "hindered"), "Cancel")
    settle(window.session, window.keeper)
    assert window.isVisible()
    assert window.session.drawing.is_modified


def test_a_name_that_the_dialog_did_not_ask_about_is_asked_about(
    window, settle, qtbot, tmp_path, monkeypatch
):
    (tmp_path / "b.bozz").write_bytes(b"theirs")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "b"), ""))
    window.files.ask_save_as()
    box = asked(window, qtbot, "hindered")
    assert "already" in box.text()
    box.reject()
    assert (tmp_path / "b.bozz").read_bytes() == b"theirs"

    (tmp_path / "b.stl").write_bytes(b"theirs")
    monkeypatch.setattr(
        QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "b"), "STL (*.stl)")
    )
    monkeypatch.setattr(QMessageBox, "question", lambda *_: QMessageBox.StandardButton.No)
    window.files.ask_place_of_export([find("a.stl", writers())])
    settle(window.session, window.keeper)
    assert (tmp_path / "b.stl").read_bytes() == b"theirs"


def test_an_export_proposes_the_place_of_the_last_one_of_this_document(
    window, settle, tmp_path, monkeypatch
):
    proposals = []

    def ask(_parent, _title, proposal, _kinds):
        proposals.append(proposal)
        return str(tmp_path / "cat.v2.stl"), "STL (*.stl)"

    monkeypatch.setattr(QFileDialog, "getSaveFileName", ask)
    stl, glb = find("a.stl", writers()), find("a.glb", writers())
    assert window.files.ask_place_of_export([stl])
    settle(window.session, window.keeper)
    window.files.ask_place_of_export([glb])
    assert proposals[0].endswith("Untitled")
    assert proposals[1] == str(tmp_path / "cat.v2")
    window.session.files.save(tmp_path / "dog.bozz")
    settle(window.session, window.keeper)
    window.files.ask_place_of_export([stl])
    assert proposals[2] == str(tmp_path / "dog")
    window.session.files.new()
    settle(window.session, window.keeper)
    window.files.ask_place_of_export([stl])
    assert proposals[3].endswith("Untitled")


def test_a_document_that_is_open_elsewhere_can_be_taken_over(
    window, settle, qtbot, tmp_path, monkeypatch
):
    path = tmp_path / "a.bozz"
    window.session.files.save(path)
    settle(window.session, window.keeper)
    window.session.files.new()
    settle(window.session, window.keeper)
    theirs = FileLock.acquire(document_lock_path(path), "a.bozz")
    window.open(path)
    box = asked(window, qtbot, "locked")
    assert window.session.drawing.read_only
    assert "(read only)" in window.windowTitle()
    assert box.defaultButton().text().replace("&", "") == "Look at it"
    press(box, "Take over")
    settle(window.session, window.keeper)
    assert not window.session.drawing.read_only
    assert "(read only)" not in window.windowTitle()
    assert not theirs.is_held


def test_a_question_goes_with_the_document_that_it_is_about(
    window, settle, qtbot, tmp_path, monkeypatch
):
    """Else *Take over* would take a file that is not on the sheet from who works on it."""
    paths = [tmp_path / "a.bozz", tmp_path / "b.bozz"]
    for path in paths:
        window.session.files.save(path)
        settle(window.session, window.keeper)
    window.session.files.new()
    settle(window.session, window.keeper)
    theirs = [FileLock.acquire(document_lock_path(path), path.name) for path in paths]
    window.open(paths[0])
    first = asked(window, qtbot, "locked")
    window.open(paths[1])  # as a file that is dropped, or opened by another program
    qtbot.waitUntil(lambda: window.session.drawing.path == paths[1])
    assert not isValid(first) or not first.isVisible()

    def about_b():
        boxes = window.findChildren(QMessageBox, "locked")
        return [box for box in boxes if box.isVisible() and "b.bozz" in box.text()]

    qtbot.waitUntil(lambda: bool(about_b()))
    (second,) = about_b()
    press(second, "Take over")
    settle(window.session, window.keeper)
    assert theirs[0].is_held
    assert not theirs[1].is_held
