"""Actions: one record feeds menus, keys and the palette."""

from __future__ import annotations

import gc

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMainWindow, QMenu

from bozzetto_app.actions.registry import Action, ActionConflict, ActionRegistry, key_text


@pytest.fixture
def window(qtbot):
    made = QMainWindow()
    qtbot.addWidget(made)
    return made


@pytest.fixture
def registry(window):
    return ActionRegistry(window)


def action(name: str, *, done: list | None = None, **more) -> Action:
    return Action(name, f"&{name}", lambda: (done if done is not None else []).append(name), **more)


def test_a_key_triggers_its_action(qtbot, window, registry):
    done: list[str] = []
    registry.register(action("save", done=done, keys=("Ctrl+S",)))
    with qtbot.waitActive(window):
        window.show()
        window.activateWindow()
    qtbot.keyClick(window, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    assert done == ["save"]


def test_no_two_actions_share_a_key(registry):
    registry.register(action("save", keys=("Ctrl+S",)))
    with pytest.raises(ActionConflict, match="save"):
        registry.register(action("new"), action("search", keys=("F2", "ctrl+s")))
    assert [one.id for one in registry.actions()] == ["save"], "half of it was registered"


def test_two_actions_of_one_call_cannot_share_a_key(registry):
    with pytest.raises(ActionConflict):
        registry.register(action("a", keys=("F",)), action("b", keys=("F",)))


def test_ids_are_unique(registry):
    registry.register(action("save"))
    with pytest.raises(ActionConflict):
        registry.register(action("save"))


def test_an_unknown_key_is_a_mistake(registry):
    with pytest.raises(ActionConflict):
        registry.register(action("a", keys=("NoSuchKey",)))


def test_disposing_frees_id_key_and_menu(window, registry):
    registry.attach(window.menuBar())
    dispose = registry.register(action("save", keys=("Ctrl+S",), menu=("File",)))
    assert [menu.text() for menu in window.menuBar().actions()] == ["File"]
    dispose()
    dispose()
    assert window.menuBar().actions() == []
    registry.register(action("save", keys=("Ctrl+S",), menu=("File",)))


def test_menus_keep_order_and_part_groups(window, registry):
    registry.register(
        action("new", menu=("File",), group="make"),
        action("save", menu=("File",), group="keep"),
        action("open", menu=("File",), group="make"),
        action("zebra", menu=("View", "Shading")),
        action("palette-only"),
    )
    registry.attach(window.menuBar())
    menus = {one.text(): one.menu() for one in window.menuBar().actions()}
    assert list(menus) == ["File", "View"]
    titles = ["-" if one.isSeparator() else one.objectName() for one in menus["File"].actions()]
    assert titles == ["new", "open", "-", "save"]
    (shading,) = menus["View"].actions()
    assert shading.text() == "Shading"
    assert [one.objectName() for one in shading.menu().actions()] == ["zebra"]


def test_submenus_stand_where_they_were_first_named(window, registry):
    registry.attach(window.menuBar())
    registry.register(
        action("front", menu=("View",)),
        action("zebra", menu=("View", "Shading")),
        action("grid", menu=("View",), group="show"),
        action("back", menu=("View",)),
    )
    dispose = registry.register(action("mine", menu=("View", "Kept")))

    def titles():
        (view,) = (one.menu() for one in window.menuBar().actions())
        return ["-" if one.isSeparator() else one.text() for one in view.actions()]

    assert titles() == ["&front", "Shading", "&back", "Kept", "-", "&grid"]
    dispose()
    assert titles() == ["&front", "Shading", "&back", "-", "&grid"]


def test_menus_that_were_filled_anew_do_not_pile_up(qtbot, window, registry):
    registry.attach(window.menuBar())
    for number in range(5):
        registry.register(action(f"a{number}", menu=("File", "Recent")))
    qtbot.waitUntil(lambda: len(window.menuBar().findChildren(QMenu)) == 2)


def test_nothing_is_left_of_menus_that_were_filled_again(window, registry):
    registry.attach(window.menuBar())
    registry.register(action("save", menu=("File",)), action("mesh", menu=("File", "Export")))

    def menus():
        gc.collect()
        return sum(type(thing) is QMenu for thing in gc.get_objects())

    before = menus()
    for _ in range(20):
        registry.register(action("recent", menu=("File",)))()
    assert menus() == before


def test_what_cannot_be_done_is_not_done(registry):
    done: list[str] = []
    can = [False]
    registry.register(action("undo", done=done, enabled=lambda: can[0]))
    registry.run("undo")
    assert done == []
    can[0] = True
    registry.run("undo")
    assert done == ["undo"]


def test_switches_follow_the_program(registry):
    on = [False]
    registry.register(
        Action("grid", "Grid", lambda: on.__setitem__(0, not on[0]), checked=lambda: on[0])
    )
    made = registry.qaction("grid")
    assert made.isCheckable()
    registry.run("grid")
    assert on == [True]
    assert made.isChecked()
    on[0] = False
    registry.refresh()
    assert not made.isChecked()


def test_the_first_key_is_shown(registry):
    assert key_text(action("save", keys=("Ctrl+S", "F2"))) == "Ctrl+S"
    assert key_text(action("save")) == ""
