"""The object list: every deed is one call to the session."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from bozzetto.document.model import Document, Model
from bozzetto_app.panels.objects.object_row import ModelRow, UnderlayRow
from bozzetto_app.panels.objects.panel import ObjectsPanel
from bozzetto_app.widgets.swatch import chart
from tests.app import fake_session as fakes
from tests.app.seen import button, words


@pytest.fixture
def panel(qtbot, fake_session):
    made = ObjectsPanel(fake_session)
    qtbot.addWidget(made)
    made.resize(264, 400)
    made.show()
    return made


def rows(panel, kind):
    found = (panel.list.itemWidget(panel.list.item(i)) for i in range(panel.list.count()))
    return [widget for widget in found if isinstance(widget, kind)]


def test_models_and_underlays_are_listed_in_order(panel):
    assert [r.name.text() for r in rows(panel, ModelRow)] == ["Horse", "Saddle", "Rider", "Plinth"]
    assert [r.name.text() for r in rows(panel, UnderlayRow)] == ["Side view.jpg", "Front.png"]
    heading = panel.list.itemWidget(panel.list.item(4))
    assert heading.text() == "Underlays"
    assert not panel.list.item(4).flags() & Qt.ItemFlag.ItemIsSelectable


def test_the_session_decides_what_is_selected(panel, fake_session):
    assert panel.list.currentRow() == 0
    fake_session.selection.id = "m3"
    fake_session.selection.changed.emit()
    assert panel.list.currentRow() == 2
    fake_session.selection.id = None
    fake_session.selection.changed.emit()
    assert panel.list.currentItem() is None
    assert fake_session.calls.named("selection.select") == [], "showing is not asking"


def test_a_click_selects(panel, fake_session):
    place = panel.list.visualItemRect(panel.list.item(1)).center()
    QTest.mouseClick(panel.list.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert fake_session.calls.named("selection.select") == [(("m2",), {})]


def test_a_press_beside_all_rows_changes_nothing(panel, fake_session):
    """The row must not look as if it were no longer chosen while its object is selected."""
    panel.resize(264, 700)
    listed = panel.list
    chosen = [listed.row(item) for item in listed.selectedItems()]
    assert chosen == [listed.currentRow()] == [0]
    below = listed.visualItemRect(listed.item(listed.count() - 1)).bottomLeft() + QPoint(20, 20)
    assert listed.itemAt(below) is None
    for keys in (Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ControlModifier):
        QTest.mouseClick(listed.viewport(), Qt.MouseButton.LeftButton, keys, below)
        assert [listed.row(item) for item in listed.selectedItems()] == chosen
    assert fake_session.calls.named("selection.select") == []


def test_renaming_in_place(panel, fake_session):
    first = rows(panel, ModelRow)[0]
    QTest.mouseDClick(first.name, Qt.MouseButton.LeftButton)
    assert first.editor.isVisible()
    QTest.keyClicks(first.editor, "Pony")
    QTest.keyClick(first.editor, Qt.Key.Key_Return)
    first.editor.clearFocus()
    assert fake_session.calls.named("objects.rename") == [(("m1", "Pony"), {})]
    assert first.name.isVisible()


@pytest.mark.parametrize("typed", ["", "   ", "Horse"])
def test_no_new_name_is_no_renaming(panel, fake_session, typed):
    first = rows(panel, ModelRow)[0]
    first.edit_name()
    first.editor.setText(typed)
    QTest.keyClick(first.editor, Qt.Key.Key_Return)
    assert fake_session.calls.named("objects.rename") == []


def test_escape_gives_renaming_up(panel, fake_session):
    panel.rename_current()
    editor = rows(panel, ModelRow)[0].editor
    QTest.keyClicks(editor, "Pony")
    QTest.keyClick(editor, Qt.Key.Key_Escape)
    assert not editor.isVisible()
    assert fake_session.calls.named("objects.rename") == []
    assert panel.list.hasFocus()  # and not the next button, which Space presses


def test_hiding_and_locking(panel, fake_session):
    horse, _, rider, plinth = rows(panel, ModelRow)
    horse.eye.click()
    rider.eye.click()
    horse.lock.click()
    plinth.lock.click()
    assert fake_session.calls.named("objects.set_visible") == [
        (("m1", False), {}),
        (("m3", True), {}),
    ]
    assert fake_session.calls.named("objects.set_locked") == [
        (("m1", True), {}),
        (("m4", False), {}),
    ]


def test_a_lock_is_seen_without_hovering(panel):
    assert rows(panel, ModelRow)[3].lock.isVisible()


def test_names_tell_what_a_click_would_do(panel):
    horse, _, rider, plinth = rows(panel, ModelRow)
    assert horse.eye.accessibleName() == "Hide Horse"
    assert rider.eye.accessibleName() == "Show Rider"
    assert plinth.lock.accessibleName() == "Unlock Plinth"


def test_colours(panel, fake_session):
    saddle = rows(panel, ModelRow)[1]
    popup = saddle.swatch.open_chart()
    discs = {b.accessibleName(): b for b in popup.findChildren(type(saddle.swatch).__mro__[1])}
    discs["Slate"].click()
    button(saddle.swatch.open_chart(), "Clay").click()
    wanted = dict(chart())["Slate"]
    assert fake_session.calls.named("objects.set_color") == [
        (("m2", wanted), {}),
        (("m2", None), {}),
    ]


def test_deleting_and_duplicating(panel, fake_session):
    button(panel, "Duplicate").click()
    button(panel, "Delete").click()
    panel.list.setCurrentRow(5)
    assert not button(panel, "Duplicate").isEnabled()
    QTest.keyClick(panel.list, Qt.Key.Key_Delete)
    assert fake_session.calls.named("objects.duplicate") == [(("m1",), {})]
    assert fake_session.calls.named("objects.delete") == [(("m1",), {})]
    assert fake_session.calls.named("objects.delete_underlay") == [(("u1",), {})]


def test_the_menu_offers_the_same(panel, fake_session):
    menu = panel.menu_for_current()
    titles = [action.text() for action in menu.actions() if not action.isSeparator()]
    read, *more = "Read this ink as…", "Use as input for", "Delete"
    assert titles == ["Rename", "Duplicate", read, "Hide", "Lock", *more]
    menu.actions()[4].trigger()
    assert fake_session.calls.named("objects.set_visible") == [(("m1", False), {})]
    asked = []
    panel.reading_wanted.connect(asked.append)
    menu.actions()[3].trigger()
    assert asked == ["m1"]


@given(st.integers(0, 3), st.integers(0, 7))
def test_a_dropped_row_lands_in_its_gap(qapp, source, gap):
    """Against the plain list: take it out, put it into the gap between the others."""
    from bozzetto_app.style.icons import FOLDER

    session = fakes.FakeSession(FOLDER)
    panel = ObjectsPanel(session)
    order = [model.id for model in session.drawing.document]
    marked = [*order[:source], None, *order[source + 1 :]]
    marked.insert(min(gap, len(order)), order[source])
    wanted = [name for name in marked if name is not None]
    panel.drop(source, gap, on=False)
    for (name, index), _ in session.calls.named("objects.move_to"):
        order.remove(name)
        order.insert(index, name)
    assert order == wanted
    panel.deleteLater()


def test_an_underlay_can_become_a_sketch_where_one_is_taken(panel, fake_session):
    panel.list.setCurrentRow(5)
    titles = [action.text() for action in panel.menu_for_current().actions()]
    assert titles == ["Align by two places", "Delete"]
    fake_session.pictures.sketch_taker = "Car"
    align, use, _ = panel.menu_for_current().actions()
    align.trigger()
    placing = [name for name, *_ in fake_session.calls.made if name.startswith("placing.")]
    assert placing[-2:] == ["placing.choose", "placing.begin_alignment"]
    assert use.text() == "Use as sketch for Car"
    use.trigger()
    assert fake_session.calls.named("pictures.take_underlay") == [(("u1",), {})]


def test_an_underlays_opacity_is_dragged_as_one_step(panel, fake_session):
    slider = rows(panel, UnderlayRow)[0].opacity
    QTest.mousePress(slider, Qt.MouseButton.LeftButton, pos=QPoint(20, 10))
    QTest.mouseMove(slider, QPoint(30, 10))
    QTest.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=QPoint(30, 10))
    made = fake_session.calls.named("objects.set_underlay_opacity")
    assert len(made) == 2
    assert all(args[0] == "u1" and kwargs == {"dragging": True} for args, kwargs in made)
    assert len(fake_session.calls.named("objects.end_drag")) == 1


def test_rows_stay_while_only_their_content_changes(panel, fake_session):
    before = rows(panel, ModelRow)[0]
    models = fake_session.drawing.document.models
    renamed = (replace(models[0], name="Pony"), *models[1:])
    fake_session.drawing.document = replace(fake_session.drawing.document, models=renamed)
    fake_session.drawing.changed.emit()
    assert rows(panel, ModelRow)[0] is before
    assert before.name.text() == "Pony"


def test_an_empty_sheet_says_so(panel, fake_session):
    fake_session.drawing.document, fake_session.selection.id = Document(), None
    fake_session.drawing.changed.emit()
    assert "Nothing drawn yet." in words(panel)
    assert not button(panel, "Delete").isEnabled()


@pytest.fixture
def crowd(panel, fake_session):
    """The panel with three hundred objects more, all of which have come at once."""
    horse = fake_session.drawing.document.models[0]
    more = [replace(horse, id=f"n{k}", name=f"Colt {k}") for k in range(300)]
    document = fake_session.drawing.document
    fake_session.drawing.document = replace(document, models=(*document.models, *more))
    fake_session.drawing.changed.emit()
    return panel


def test_what_stands_in_hundreds_of_rows_is_made_little_by_little(crowd, qtbot):
    in_sight = crowd.list.viewport().height() // crowd.list.sizeHintForRow(0)
    first = rows(crowd, ModelRow)
    assert in_sight <= len(first) < 100
    assert [row.name.text() for row in first][4:6] == ["Colt 0", "Colt 1"]
    qtbot.waitUntil(lambda: len(rows(crowd, ModelRow)) == 304, timeout=20_000)
    assert [row.name.text() for row in rows(crowd, ModelRow)][4:] == [
        f"Colt {k}" for k in range(300)
    ]
    assert len(rows(crowd, UnderlayRow)) == 2
    told = [crowd.list.item(i).data(Qt.ItemDataRole.AccessibleTextRole) for i in (0, 303, 306)]
    assert told == ["Horse", "Colt 299", "Front.png"]


def test_a_row_that_is_still_to_be_made_can_be_renamed(crowd, fake_session):
    crowd.list.choose(250)
    crowd.rename_current()
    row = crowd.list.itemWidget(crowd.list.item(250))
    QTest.keyClicks(row.editor, "Filly")
    QTest.keyClick(row.editor, Qt.Key.Key_Return)
    assert fake_session.calls.named("objects.rename") == [(("n246", "Filly"), {})]


def test_only_rows_of_what_is_another_are_shown_anew(crowd, fake_session, qtbot, monkeypatch):
    qtbot.waitUntil(lambda: len(rows(crowd, ModelRow)) == 304, timeout=20_000)
    shown = []
    show = ModelRow.show_model

    def noted(row, model, *how):
        shown.append(model.id)
        show(row, model, *how)

    monkeypatch.setattr(ModelRow, "show_model", noted)
    document = fake_session.drawing.document
    fake_session.drawing.document = document.with_model(replace(document.model("n7"), name="Foal"))
    fake_session.drawing.changed.emit()
    assert shown == ["n7"]
    assert "Foal" in [row.name.text() for row in rows(crowd, ModelRow)]


def test_a_long_list_looks_for_no_object_one_by_one(qtbot, fake_session, monkeypatch):
    """A search for each row would take a hundred times as long for ten times as many."""
    models = tuple(
        Model(f"many-{k}", f"Shape {k}", "bozzetto.silhouette", None) for k in range(200)
    )
    fake_session.drawing.document = Document(models)
    panel = ObjectsPanel(fake_session)
    qtbot.addWidget(panel)
    qtbot.waitUntil(lambda: all(
        panel.list.itemWidget(panel.list.item(row)) for row in range(panel.list.count())
    ))  # fmt: skip
    searches = []
    place_of = Document.place_of
    monkeypatch.setattr(
        Document, "place_of", lambda *given: searches.append(given) or place_of(*given)
    )
    fake_session.selection.select("many-150")
    panel.refresh()
    assert len(searches) <= 5
