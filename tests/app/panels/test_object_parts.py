"""Parts in the object list: rows under their model, and every deed one call to the session."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PySide6.QtCore import QItemSelectionModel, Qt
from PySide6.QtTest import QTest

from bozzetto.errors import UserError
from bozzetto_app.panels.objects.panel import ObjectsPanel
from bozzetto_app.panels.objects.rows import entries_of, place_of_drop
from tests.app import fake_session as fakes
from tests.app.seen import button


@pytest.fixture
def panel(qtbot, fake_session):
    fake_session.trees["m1"] = fakes.horse_parts()
    made = ObjectsPanel(fake_session)
    qtbot.addWidget(made)
    made.resize(264, 500)
    made.show()
    return made


def names(panel):
    widgets = (panel.list.itemWidget(panel.list.item(i)) for i in range(panel.list.count()))
    return [widget.name.text() if hasattr(widget, "name") else widget.text() for widget in widgets]


def row_of(panel, name):
    return names(panel).index(name)


def widget(panel, name):
    return panel.list.itemWidget(panel.list.item(row_of(panel, name)))


HORSE = ["Horse", "Body", "Head", "Legs", "Left leg", "Right leg", "Saddle pit", "Flank"]
OTHERS = ["Saddle", "Rider", "Plinth", "Underlays", "Side view.jpg", "Front.png"]


def test_the_selected_models_parts_stand_under_it(panel, fake_session):
    assert names(panel) == HORSE + OTHERS
    assert panel.list.currentRow() == row_of(panel, "Head")
    fake_session.selection.id = "m2"
    fake_session.selection.changed.emit()
    assert names(panel) == ["Horse", *OTHERS]
    assert panel.list.currentRow() == row_of(panel, "Saddle")


def test_a_lone_part_is_listed_only_when_asked_for(panel, fake_session):
    tree = fake_session.trees["m1"]
    fake_session.trees["m1"] = replace(tree, parts=tree.parts[:1], selected="n1")
    fake_session.drawing.changed.emit()
    assert names(panel) == ["Horse", *OTHERS]
    widget(panel, "Horse").fold.click()
    assert names(panel) == ["Horse", "Body", *OTHERS]


def test_folding(panel, fake_session):
    widget(panel, "Legs").fold.click()
    assert names(panel) == [n for n in HORSE if n not in ("Left leg", "Right leg")] + OTHERS
    widget(panel, "Horse").fold.click()
    assert names(panel) == ["Horse", *OTHERS]
    assert panel.list.currentRow() == 0, "the chosen part is not listed: its model is"
    QTest.keyClick(panel.list, Qt.Key.Key_Right)
    assert names(panel)[1:3] == ["Body", "Head"]
    fake_session.trees["m1"] = fake_session.trees["m1"].chosen("g1")
    fake_session.drawing.changed.emit()
    QTest.keyClick(panel.list, Qt.Key.Key_Right)
    assert "Left leg" in names(panel)
    QTest.keyClick(panel.list, Qt.Key.Key_Left)
    assert "Left leg" not in names(panel)


def test_arrows_are_only_where_something_is_folded(panel):
    shown = [name for name in HORSE + OTHERS[:3] if widget(panel, name).fold.isVisible()]
    assert shown == ["Horse", "Legs"]


def test_choosing(panel, fake_session):
    place = panel.list.visualItemRect(panel.list.item(row_of(panel, "Flank"))).center()
    QTest.mouseClick(panel.list.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert set(map(str, fake_session.calls.named("parts.select"))) == {str((("m1", "n6"), {}))}
    fake_session.calls.made.clear()
    place = panel.list.visualItemRect(panel.list.item(0)).center()
    QTest.mouseClick(panel.list.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert (("m1", ""), {}) in fake_session.calls.named("parts.select"), "the model as a whole"


def test_what_is_drawn_takes_the_choice_from_the_others(panel, fake_session):
    tree = fake_session.trees["m1"]
    for name in ("n1", "n2", "n1"):
        fake_session.trees["m1"] = tree.chosen(name)
        fake_session.drawing.changed.emit()
        chosen = [panel.list.row(item) for item in panel.list.selectedItems()]
        assert chosen == [panel.list.currentRow()]
        (title,) = (part.name for part in tree.parts if part.id == name)
        assert panel.list.itemWidget(panel.list.currentItem()) is widget(panel, title)


def test_rows_say_what_their_parts_do(panel):
    texts = [panel.list.item(row).data(Qt.ItemDataRole.AccessibleTextRole) for row in range(8)]
    assert texts == ["Horse", "Body, Add", "Head, merge", "Legs, Add", "Left leg, Add",
                     "Right leg, Add", "Saddle pit, Carve", "Flank, intersect"]  # fmt: skip
    assert widget(panel, "Right leg").eye.accessibleName() == "Show Right leg"
    assert widget(panel, "Legs").fold.accessibleName() == "Fold the parts of Legs"


def test_deeds(panel, fake_session):
    calls = fake_session.calls
    widget(panel, "Right leg").eye.click()
    assert calls.named("parts.set_visible") == [(("m1", "n4", True), {})]
    panel.rename_current()
    editor = widget(panel, "Head").editor
    editor.setText("Skull")
    QTest.keyClick(editor, Qt.Key.Key_Return)
    assert calls.named("parts.rename") == [(("m1", "n2", "Skull"), {})]
    button(panel, "Duplicate").click()
    assert calls.named("parts.duplicate") == [(("m1", "n2"), {})]
    QTest.keyClick(panel.list, Qt.Key.Key_Delete)
    assert calls.named("parts.delete") == [(("m1", "n2"), {})]
    assert calls.named("objects.delete") == []


def test_several_rows_become_a_group(panel, fake_session):
    select = QItemSelectionModel.SelectionFlag.Select
    for name in ("Body", "Saddle"):
        panel.list.setCurrentItem(panel.list.item(row_of(panel, name)), select)
    panel.list.setCurrentItem(panel.list.item(row_of(panel, "Flank")), select)
    QTest.keyClick(panel.list, Qt.Key.Key_G, Qt.KeyboardModifier.ControlModifier)
    assert fake_session.calls.named("parts.group") == [(("m1", ["n1", "n2", "n6"]), {})]


def test_del_takes_all_chosen_rows_out_at_once(panel, fake_session):
    select = QItemSelectionModel.SelectionFlag.Select
    for name in ("Body", "Saddle", "Front.png"):
        panel.list.setCurrentItem(panel.list.item(row_of(panel, name)), select)
    panel.list.setCurrentItem(panel.list.item(row_of(panel, "Flank")), select)
    QTest.keyClick(panel.list, Qt.Key.Key_Delete)
    assert fake_session.calls.named("parts.delete_several") == [
        ((["m2"], {"m1": ["n1", "n2", "n6"]}, ["u2"]), {})
    ]
    for name in ("delete", "delete_part", "delete_underlay"):
        assert fake_session.calls.named(name) == []


def test_a_group_can_be_dissolved_from_its_menu(panel, fake_session):
    panel.list.choose(row_of(panel, "Legs"))
    menu = panel.menu_for_current()
    next(action for action in menu.actions() if action.text() == "Ungroup").trigger()
    assert fake_session.calls.named("parts.ungroup") == [(("m1", "g1"), {})]


def test_the_menu_offers_the_modelers_that_take_shapes(panel, fake_session):
    menu = panel.menu_for_current()
    uses = next(a.menu() for a in menu.actions() if a.text() == "Use as input for")
    assert [action.text() for action in uses.actions()] == ["Mesh", "Symmetry"]
    uses.actions()[1].trigger()
    assert fake_session.calls.named("shapes.use") == [
        (("bozzetto.symmetry", ["m1"], {"m1": ["n2"]}), {})
    ]


def test_the_menu_of_a_part(panel, fake_session):
    menu = panel.menu_for_current()
    titles = [action.text() for action in menu.actions() if not action.isSeparator()]
    assert titles == ["Rename", "Duplicate", "Group", "Hide", "Use as input for", "Delete"]
    next(action for action in menu.actions() if action.text() == "Group").trigger()
    next(action for action in menu.actions() if action.text() == "Hide").trigger()
    assert fake_session.calls.named("parts.group") == [(("m1", ["n2"]), {})]
    assert fake_session.calls.named("parts.set_visible") == [(("m1", "n2", False), {})]


def test_rows_stay_while_others_come_and_go(panel, fake_session):
    kept = [widget(panel, name) for name in ("Horse", "Body", "Flank", "Plinth")]
    fake_session.trees["m1"] = fake_session.trees["m1"].without("g1").moved("n6", "", 0)
    fake_session.drawing.changed.emit()
    assert names(panel)[:5] == ["Horse", "Flank", "Body", "Head", "Saddle pit"]
    assert [widget(panel, name) for name in ("Horse", "Plinth")] == [kept[0], kept[3]]


def test_tab_goes_through_the_rows_in_their_order(panel, qapp):
    """Whatever came in between: eye after eye, downwards."""
    eyes = [widget(panel, name).eye for name in HORSE]
    found, here = [], panel.list.nextInFocusChain()
    while here is not panel.list and len(found) < 500:
        found.append(here)
        here = here.nextInFocusChain()
    assert [eye for eye in found if eye in eyes] == eyes


def test_names_are_aligned(panel):
    """What is one level deeper stands one step to the right; signs stand in one column."""

    def left(name):
        label = widget(panel, name).name
        return label.mapTo(panel.list, label.rect().topLeft()).x()

    steps = [left("Body") - left("Horse"), left("Left leg") - left("Legs")]
    assert steps[0] == steps[1] > 0
    assert left("Body") == left("Head") == left("Legs") == left("Flank")
    right = {widget(panel, n).eye.mapTo(panel.list, widget(panel, n).eye.rect().topRight()).x()
             for n in HORSE}  # fmt: skip
    assert len(right) == 1


# -- where a part lands -------------------------------------------------------------------------


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(1, 7), st.integers(0, 14), st.booleans())
def test_a_dropped_part_lands_where_it_was_let_go(source, target, on):
    """Against the list itself: after the move the row stands in the gap it was put into."""
    tree = fakes.horse_parts()
    session_of = {"m1": tree}
    document = fakes.FakeSession(Path()).drawing.document
    entries = list(entries_of(document, lambda model: session_of.get(model.id), lambda _: True, ()))
    if target >= len(entries) and on:
        return
    part = entries[source].id
    goal = place_of_drop(entries, tree, source, target, on)
    if goal is None:
        return
    group, at = goal
    inside = {inner.id for inner in tree.family(part)}
    if group in inside:
        with pytest.raises(UserError):
            tree.moved(part, group, at)
        return
    moved = tree.moved(part, group, at)
    if on:
        where = "" if entries[target].kind == "model" else entries[target].id
        assert moved.part(part).within == where
        assert moved.within(where)[-1].id == part
        return
    before = [entry.id for entry in entries[1:8]]
    rows = [other.id for other, _ in moved.rows()]
    above = [i for i in before[: target - 1] if i not in inside]
    below = [i for i in before[target - 1 :] if i not in inside]
    assert [i for i in rows if i not in inside] == above + below
    assert rows.index(part) == len(above)


def test_nothing_is_moved_that_is_dropped_where_it_is(fake_session):
    tree = fakes.horse_parts()
    document = fake_session.drawing.document
    trees = {"m1": tree}
    entries = list(entries_of(document, lambda model: trees.get(model.id), lambda _: True, ()))
    gaps = ((1, 1), (1, 2), (2, 3), (4, 4), (1, 12))
    rows = ((1, 9), (3, 3), (1, 2))
    for source, target, on in (*((*g, False) for g in gaps), *((*r, True) for r in rows)):
        assert place_of_drop(entries, tree, source, target, on) is None, (source, target, on)
