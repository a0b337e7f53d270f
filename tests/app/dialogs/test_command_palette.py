"""The command palette: found and run with the keyboard alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMainWindow

from bozzetto_app.actions.registry import Action, ActionRegistry
from bozzetto_app.dialogs.command_palette import FOUND, CommandPalette
from bozzetto_app.dialogs.palette_entries import entries_of
from tests.app import fake_session as fakes
from tests.app.seen import words


@pytest.fixture
def done():
    return []


@pytest.fixture
def window(qtbot):
    made = QMainWindow()
    made.resize(1280, 800)
    qtbot.addWidget(made)
    made.show()
    return made


@pytest.fixture
def registry(window, done):
    made = ActionRegistry(window)
    made.register(
        Action(
            "file.save", "&Save", lambda: done.append("save"), keys=("Ctrl+S",), menu=("&File",)
        ),
        Action("file.save_as", "Save &as…", lambda: done.append("as"), menu=("&File",)),
        Action("edit.undo", "Undo", lambda: done.append("undo"), enabled=lambda: False),
    )
    return made


@pytest.fixture
def palette(qtbot, registry, fake_session, window, done):
    made = CommandPalette(
        registry,
        fake_session,
        window,
        recent=lambda: [Path("/x/Rocking horse.bozz")],
        open_document=lambda path: done.append(path),
        focus_parameter=lambda name: done.append(name),
    )
    qtbot.addWidget(made)
    made.open_over(window)
    return made


def titles(palette):
    return [palette.list.item(i).data(FOUND).entry.title for i in range(palette.list.count())]


def find_and_run(palette, typed, *, down=0):
    QTest.keyClicks(palette.field, typed)
    for _ in range(down):
        QTest.keyClick(palette.field, Qt.Key.Key_Down)
    QTest.keyClick(palette.field, Qt.Key.Key_Return)


def test_a_command_by_its_first_letters(palette, done):
    find_and_run(palette, "sa")
    assert done == ["save"]
    assert not palette.isVisible()


def test_the_next_one_by_the_arrow(palette, done):
    find_and_run(palette, "save", down=1)
    assert done == ["as"]


def test_tools_objects_parameters_modelers_and_documents(palette, done, fake_session, window):
    for typed in ("skeleton", "plinth", "tolerance", "polyhedron", "rocking"):
        palette.open_over(window)
        find_and_run(palette, typed)
    assert fake_session.calls.named("toolbox.take_tool") == [(("skeleton",), {})]
    assert fake_session.calls.named("selection.select") == [(("m4",), {})]
    assert fake_session.calls.named("toolbox.take_modeler") == [(("bozzetto.polyhedron",), {})]
    assert done == ["tolerance", Path("/x/Rocking horse.bozz")]


def test_what_stands_in_a_submenu_is_found_by_its_words(palette, registry, window, done):
    registry.register(
        Action(
            "object.use.box",
            "Box",
            lambda: done.append("use"),
            menu=("&Object", "U&se as input for"),
        )
    )
    palette.open_over(window)
    find_and_run(palette, "use as input box")
    assert done == ["use"]


def test_the_kind_can_be_typed_too(palette):
    QTest.keyClicks(palette.field, "object horse")
    assert titles(palette)[0] == "Horse"


def test_what_cannot_be_done_is_shown_last_not_run_and_says_why(palette, registry, done):
    said = []
    registry.refused.connect(said.append)
    QTest.keyClicks(palette.field, "undo")
    assert titles(palette) == ["Undo"]
    QTest.keyClick(palette.field, Qt.Key.Key_Return)
    assert done == []
    assert said == ["“Undo” cannot be done now."]
    assert not palette.isVisible()


def test_what_was_used_comes_first_even_after_a_restart(
    qtbot, palette, registry, fake_session, window
):
    find_and_run(palette, "save as")
    again = CommandPalette(registry, fake_session, window)
    qtbot.addWidget(again)
    again.open_over(window)
    assert titles(again)[0] == "Save as…"


def test_keys_stand_beside_the_names(palette):
    QTest.keyClicks(palette.field, "save")
    item = palette.list.item(0)
    assert item.data(FOUND).entry.key == "Ctrl+S"
    assert item.data(Qt.ItemDataRole.AccessibleTextRole) == "Save, File, Ctrl+S"


def test_the_arrows_go_round(palette):
    QTest.keyClick(palette.field, Qt.Key.Key_Up)
    assert palette.list.currentRow() == palette.list.count() - 1
    QTest.keyClick(palette.field, Qt.Key.Key_Down)
    assert palette.list.currentRow() == 0


def test_escape_closes_and_nothing_happens(palette, done):
    QTest.keyClick(palette.field, Qt.Key.Key_Escape)
    assert not palette.isVisible()
    assert done == []


def test_nothing_found_is_said(palette, done):
    QTest.keyClicks(palette.field, "qqq")
    assert "Nothing has that name." in words(palette)
    QTest.keyClick(palette.field, Qt.Key.Key_Return)
    assert done == []


def test_it_fits_a_narrow_window(qtbot, palette, window):
    window.resize(480, 640)
    palette.open_over(window)
    assert palette.width() <= 480 - 32


def test_tools_have_the_keys_of_the_rail(registry, fake_session):
    fake_session.toolbox.tools = tuple(
        fakes.ToolInfo(f"t{k}", f"T{k}", None, "") for k in range(11)
    )
    nothing = {"open_document": print, "focus_parameter": print}
    found = entries_of(registry, fake_session, recent=(), **nothing)
    assert [entry.key for entry in found if entry.id.startswith("tool ")] == [*"1234567890", ""]


def test_what_comes_while_it_is_open_is_found_too(palette, registry, done):
    """A modeler names its commands only after its plugin is imported."""
    QTest.keyClicks(palette.field, "ave")
    QTest.keyClick(palette.field, Qt.Key.Key_Down)
    chosen = palette.list.currentItem().data(FOUND).entry.id
    registry.register(Action("car.new", "Pave the road", lambda: done.append("road")))
    registry.refresh()
    assert "Pave the road" in titles(palette)
    assert palette.list.currentItem().data(FOUND).entry.id == chosen
    assert palette.field.text() == "ave"
