"""Submenus that follow the recent documents and the kept views."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtWidgets import QInputDialog

from bozzetto_app.actions.dynamic_menus import RECENT, recent_titles
from bozzetto_app.dialogs.palette_entries import entries_of
from bozzetto_app.settings import settings


def submenu(window, *titles):
    """Entries of a menu by their plain titles, "-" for a hairline."""
    actions = window.menuWidget().findChild(object, "menus").actions()
    for title in titles:
        found = [one for one in actions if one.text().replace("&", "") == title]
        if not found:
            return {}
        actions = found[0].menu().actions()
    return {"-" if one.isSeparator() else one.text(): one for one in actions}


def test_documents_of_one_name_are_told_apart_by_their_folders():
    paths = [Path("/a/horse.bozz"), Path("/b/horse.bozz"), Path("/b/fish.bozz")]
    assert recent_titles(paths) == ["horse (a)", "horse (b)", "fish"]


@pytest.fixture
def window(make_window):
    return make_window()


MOST_ROWS = 16
"""Entries of a menu that are still looked through, and fit on a small screen."""


@pytest.mark.parametrize("modeler", ["silhouette", "symmetry", "car", "product", "polyhedron"])
def test_a_modelers_commands_are_few_in_every_menu(window, settle, modeler):
    session = window.session
    session.toolbox.take_modeler(f"bozzetto.{modeler}")
    settle(session)
    title = session.registry.info(f"bozzetto.{modeler}").title
    whole = submenu(window, "Object", title)
    deeper = {
        name: submenu(window, "Object", title, name) for name, one in whole.items() if one.menu()
    }
    assert all(0 < len(rows) <= MOST_ROWS for rows in (whole, *deeper.values()))
    listed = {name for rows in (whole, *deeper.values()) for name in rows} - set(deeper)
    assert listed == {command.title for command in session.commands.commands}


def remember(window, *paths):
    for path in paths:
        path.write_bytes(b"")
    settings().setValue("recent/files", [str(path) for path in paths])
    window.session.files.recent_changed.emit()


def test_recent_documents_are_listed_and_open(window, tmp_path, monkeypatch):
    assert submenu(window, "File", "Open recent") == {}
    horse, odd = tmp_path / "horse.bozz", tmp_path / "salt & pepper.bozz"
    remember(window, horse, odd)
    opened = []
    monkeypatch.setattr(window.session.files, "open_safely", opened.append)
    found = submenu(window, "File", "Open recent")
    assert list(found) == ["&1 horse", "&2 salt && pepper"]
    found["&2 salt && pepper"].trigger()
    assert opened == [odd]
    remember(window, odd)
    assert list(submenu(window, "File", "Open recent")) == ["&1 salt && pepper"]


def test_clearing_the_list_empties_the_menu(window, tmp_path):
    remember(window, tmp_path / "horse.bozz")
    window.dialogs.open_preferences()
    (dialog,) = (one for one in window.children() if one.objectName() == "preferences")
    dialog.recent.click()
    assert submenu(window, "File", "Open recent") == {}
    dialog.close()


def test_the_palette_lists_a_recent_document_once(window, tmp_path):
    path = tmp_path / "horse.bozz"
    remember(window, path)
    entries = entries_of(
        window.actions_,
        window.session,
        recent=[path],
        open_document=print,
        focus_parameter=print,
    )
    ids = [entry.id for entry in entries if "horse" in entry.title]
    assert ids == [f"document {path}"]
    assert any(action.id.startswith(RECENT) for action in window.actions_.actions())


def test_a_view_is_kept_shown_again_and_forgotten(window, qtbot, settle):
    session = window.session
    window.canvas.views.look("right")
    kept = session.view.camera
    window.actions_.run("view.keep")
    (dialog,) = window.findChildren(QInputDialog)
    assert dialog.textValue() == "View 1"
    dialog.setTextValue("Nose & ears")
    dialog.accept()
    assert [view.name for view in session.drawing.document.views] == ["Nose & ears"]
    assert session.drawing.history.undo_label == "Keep view “Nose & ears”"
    window.canvas.views.look("top")
    assert session.view.camera != kept
    found = submenu(window, "View", "Kept views")
    found["Nose && ears"].trigger()
    assert session.view.camera == kept
    submenu(window, "View", "Kept views", "Forget")["Nose && ears"].trigger()
    assert session.drawing.document.views == ()
    session.drawing.undo()
    assert "Nose && ears" in submenu(window, "View", "Kept views")


def test_a_kept_view_fits_a_sheet_of_another_size(window, qtbot):
    window.actions_.run("view.keep")
    (dialog,) = window.findChildren(QInputDialog)
    dialog.accept()
    window.resize(900, 700)
    qtbot.waitUntil(lambda: window.session.view.camera.viewport[0] == window.canvas.width())
    submenu(window, "View", "Kept views")["View 1"].trigger()
    assert window.session.view.camera.viewport == (window.canvas.width(), window.canvas.height())
