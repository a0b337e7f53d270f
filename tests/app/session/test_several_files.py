"""Several files that are dropped at once: all are taken, and what is wrong with each is read."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QMimeData, QUrl
from PySide6.QtWidgets import QFileDialog

from bozzetto_app.canvas.input.drag_and_drop import take

SQUARE = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">'
    '<rect x="5" y="5" width="30" height="30"/></svg>'
)


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "files"
    place.mkdir()
    for name in ("one.svg", "two.svg"):
        (place / name).write_text(SQUARE)
    (place / "broken.svg").write_text("<svg><rect")
    (place / "note.txt").write_text("words")
    Image.fromarray(np.full((20, 30, 3), 90, np.uint8)).save(place / "page.png")
    return place


def drop(window, folder, *names):
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(folder / name)) for name in names])
    assert take(window.session, data)


@pytest.mark.parametrize("turn", range(3))
def test_what_is_wrong_with_any_of_them_is_the_last_word(make_window, settle, folder, turn):
    window = make_window()
    session, events = window.session, []
    session.drawing.changed.connect(lambda: events.append("changed"))  # it clears what was said
    session.notices.noticed.connect(lambda _: events.append("told"))
    names = ["broken.svg", "one.svg", "note.txt", "page.png", "two.svg"]
    drop(window, folder, *names[turn:], *names[:turn])
    settle(session)
    assert sorted(model.name for model in session.drawing.document) == ["one", "two"]
    assert len(session.drawing.document.underlays) == 1
    (told,) = session.heard
    assert told.kind == "error"
    assert "broken.svg" in told.text
    assert ".txt" in told.text
    assert events[-1] == "told"
    drop(window, folder, "broken.svg")  # one alone is told at once, as ever
    settle(session)
    assert len(session.heard) == 2


def test_several_files_are_chosen_in_the_dialog(make_window, settle, folder, monkeypatch):
    window = make_window()
    names = [str(folder / name) for name in ("one.svg", "broken.svg", "two.svg")]
    monkeypatch.setattr(QFileDialog, "getOpenFileNames", lambda *_: (names, ""))
    window.actions_.run("file.import")
    settle(window.session)
    assert sorted(model.name for model in window.session.drawing.document) == ["one", "two"]
    assert "broken.svg" in window.session.heard[-1].text


def test_a_document_takes_the_sheet_for_itself_and_the_others_are_named(
    make_window, settle, folder
):
    window = make_window()
    session = window.session
    drop(window, folder, "one.svg")
    settle(session)
    session.files.save(folder / "kept.bozz")
    settle(session)
    session.files.new()
    settle(session)
    drop(window, folder, "two.svg", "kept.bozz", "broken.svg")
    settle(session)
    assert session.drawing.path == folder / "kept.bozz"
    assert [model.name for model in session.drawing.document] == ["one"]
    assert session.heard[-1].kind == "error"
    assert "two.svg, broken.svg" in session.heard[-1].text
