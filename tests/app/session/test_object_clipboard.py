"""Copied objects: into the same document, into another one, and into another program."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QMimeData
from PySide6.QtGui import QGuiApplication

from bozzetto_app.session.object_clipboard import OBJECTS
from bozzetto_app.testing.stylus import Stylus
from tests.app.tablet import circle

RING = b"""<!-- a note --><svg xmlns="http://www.w3.org/2000/svg" width="80" height="80">
<circle cx="40" cy="40" r="30"/></svg>"""


@pytest.fixture
def window(make_window, settle):
    window = make_window()
    for _ in range(2):
        Stylus(window.canvas).draw(circle(radius=60.0))
        settle(window.session, window.keeper)
        window.session.gestures.commit()
        settle(window.session, window.keeper)
    QGuiApplication.clipboard().clear()
    assert len(window.session.drawing.document) == 2
    return window


def names(window):
    return [model.name for model in window.session.drawing.document]


def test_what_was_copied_is_pasted_at_once_as_one_step(window, settle):
    session = window.session
    first, second = session.drawing.document
    session.selection.select(first.id)
    before = session.drawing.history.position
    window.actions_.run("edit.copy")
    window.actions_.run("edit.paste")  # before any worker had a chance
    *_, copy = session.drawing.document
    assert session.drawing.history.position == before + 1
    assert copy.state is first.state
    assert copy.id not in (first.id, second.id)
    assert len(set(names(window))) == 3
    assert session.selection.id == copy.id
    settle(session, window.keeper)
    session.drawing.undo()
    assert [model.id for model in session.drawing.document] == [first.id, second.id]


def test_a_locked_object_can_be_copied_and_its_copy_is_free(window):
    session = window.session
    (model, _) = session.drawing.document
    session.objects.set_locked(model.id, True)
    session.selection.select(model.id)
    window.actions_.run("edit.copy")
    window.actions_.run("edit.paste")
    assert not session.drawing.document.models[-1].locked


def test_another_program_reads_a_file_of_the_chosen_objects(window, settle):
    """What is on the clipboard, given back without what this process remembers."""
    session = window.session
    ids = [model.id for model in session.drawing.document]
    session.files.exchange.clipboard.copy(ids)
    settle(session, window.keeper)
    foreign = QMimeData()
    foreign.setData(OBJECTS, QGuiApplication.clipboard().mimeData().data(OBJECTS))
    session.files.new()
    settle(session, window.keeper)
    QGuiApplication.clipboard().setMimeData(foreign)
    window.actions_.run("edit.paste")
    settle(session, window.keeper)
    assert len(names(window)) == 2
    assert session.drawing.history.undo_label == "Paste 2 objects"
    assert not set(ids) & {model.id for model in session.drawing.document}


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 nonsense", b"\0" * 5000])
def test_damaged_objects_are_told(window, settle, content):
    data = QMimeData()
    data.setData(OBJECTS, content)
    QGuiApplication.clipboard().setMimeData(data)
    said = []
    window.session.notices.noticed.connect(said.append)
    window.actions_.run("edit.paste")
    settle(window.session, window.keeper)
    assert [notice.kind for notice in said] == ["error"]
    assert len(names(window)) == 2


def test_what_was_copied_elsewhere_meanwhile_stays_on_the_clipboard(window, settle):
    """The file of the objects comes from a worker, and must not take the place of a later copy."""
    session = window.session
    session.files.exchange.clipboard.copy([session.drawing.document.models[0].id])
    QGuiApplication.clipboard().setText("later")
    settle(session, window.keeper)
    assert QGuiApplication.clipboard().text() == "later"
    assert not QGuiApplication.clipboard().mimeData().hasFormat(OBJECTS)


@pytest.mark.parametrize("kind", ["image/svg+xml", "text/plain"])
def test_a_copied_drawing_is_read_as_ink(window, settle, kind):
    data = QMimeData()
    data.setData(kind, RING)
    QGuiApplication.clipboard().setMimeData(data)
    window.actions_.run("edit.paste")
    settle(window.session, window.keeper)
    assert names(window)[-1] == "Drawing"


def test_nothing_is_copied_where_nothing_is_chosen(make_window):
    window = make_window()
    assert not window.actions_.qaction("edit.copy").isEnabled()
    assert "Draw one first" in window.actions_.qaction("edit.copy").toolTip()
