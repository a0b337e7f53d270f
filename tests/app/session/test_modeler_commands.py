"""Commands of the selected model: menu, keys, history, refusals."""

from __future__ import annotations

import itertools
import threading
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog

from bozzetto.plugin import Command
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import Shaded
from bozzetto_app.actions.dynamic_menus import RESERVED
from tests.adviser import MODELER
from tests.app.tablet import stroke_of


def draw(session, settle, x=300.0):
    session.gestures.stroke_lifted(stroke_of([(x, 300.0), (x + 100.0, 400.0)], session.view.camera))
    settle(session)


@pytest.fixture
def session(make_session, marks, settle):
    made = make_session(MODELER, extra=[marks.package])
    draw(made, settle)
    made.heard.clear()
    return made


def test_a_command_is_one_step_that_can_be_taken_back(session, settle):
    before = session.drawing.document.models[0].state
    steps = session.drawing.history.position
    session.commands.run("flip")
    settle(session)
    after = session.drawing.document.models[0].state
    assert [pair[0][0] for pair in after.marks] == [-pair[0][0] for pair in before.marks]
    assert session.drawing.history.position == steps + 1
    assert session.drawing.history.undo_label == "Flip"
    session.drawing.undo()
    settle(session)
    assert session.drawing.document.models[0].state is before


def test_commands_run_in_the_order_of_the_gestures(session, settle):
    """A command right after a stroke finds the model with that stroke."""
    session.gestures.stroke_lifted(stroke_of([(500.0, 300.0), (600.0, 400.0)], session.view.camera))
    session.commands.run("flip")
    session.commands.run("flip")
    session.commands.run("flip")
    settle(session)
    first, second = session.drawing.document.models[0].state.marks
    assert list(session.drawing.history.entries[-4:]) == ["Mark", "Flip", "Flip", "Flip"]
    assert first[0][0] > 0 > second[0][0]


def test_a_refusal_is_told_and_changes_nothing(session, settle):
    before = session.drawing.document
    session.commands.run("refuse")
    settle(session)
    assert session.drawing.document is before
    assert [n.text for n in session.heard if n.kind == "error"] == [
        "This cannot be done. Do something else."
    ]


def test_a_locked_model_is_not_commanded(session, settle):
    session.objects.set_locked(session.selection.id, True)
    settle(session)
    assert not session.commands.is_enabled("flip")
    before = session.drawing.document
    session.commands.run("flip")
    settle(session)
    assert session.drawing.document is before
    assert "locked" in session.heard[-1].text


def test_what_is_enabled_follows_the_state(session, settle):
    assert session.commands.is_enabled("flip")
    session.drawing.undo()
    settle(session)
    assert not session.commands.is_enabled("flip")
    assert session.commands.is_for_none
    session.drawing.redo()
    settle(session)
    session.selection.select(session.drawing.document.models[0].id)
    settle(session)
    assert session.commands.is_enabled("flip")


def with_seed(marks, monkeypatch):
    """Let a modeler have a command that draws where nothing is drawn."""
    whole = marks.commands

    def seed(state, context):
        return replace(state, marks=(*state.marks, ((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))))

    command = Command("seed", "Seed", "Draws a first mark.", seed, enabled=lambda s: not s.marks)
    monkeypatch.setattr(marks, "commands", lambda: [*whole(), command])


def test_commands_are_there_before_the_first_object(make_session, marks, settle, monkeypatch):
    with_seed(marks, monkeypatch)
    session = make_session(MODELER, extra=[marks.package])
    settle(session)
    commands = session.commands
    assert [one.id for one in commands.commands] == ["flip", "refuse", "seed"]
    assert [commands.is_enabled(one.id) for one in commands.commands] == [False, True, True]
    assert not session.drawing.document.models  # asking leaves nothing behind
    for command in ("refuse", "flip"):
        commands.run(command)
        settle(session)
        assert not session.drawing.document.models
    steps = session.drawing.history.position
    commands.run("seed")
    settle(session)
    (model,) = session.drawing.document.models
    assert model.state.marks == (((0.0, 0.0, 0.0), (1.0, 2.0, 3.0)),)
    assert session.selection.id == model.id
    assert session.drawing.history.position == steps + 1
    assert session.drawing.history.undo_label == "Seed"
    assert not commands.is_enabled("seed")
    assert commands.is_enabled("flip")
    draw(session, settle)
    assert len(session.drawing.document.models[0].state.marks) == 2
    session.drawing.undo()
    session.drawing.undo()
    settle(session)
    assert not session.drawing.document.models
    assert commands.is_enabled("seed")


def test_a_second_object_can_begin_with_a_command(make_session, marks, settle, monkeypatch):
    with_seed(marks, monkeypatch)
    session = make_session(MODELER, extra=[marks.package])
    draw(session, settle)
    session.gestures.commit()  # the next stroke starts a new object
    settle(session)
    session.commands.run("seed")
    settle(session)
    assert len(session.drawing.document.models) == 2
    assert len({model.name for model in session.drawing.document}) == 2


def test_a_command_may_begin_an_object_as_it_is(make_session, marks, settle, monkeypatch):
    whole = marks.commands
    plain = Command("plain", "New", "Begins marks without one.", lambda state, context: state)
    monkeypatch.setattr(marks, "commands", lambda: [*whole(), plain])
    session = make_session(MODELER, extra=[marks.package])
    settle(session)
    for count in (1, 1):  # on the object that it began it changes nothing, and says so
        session.commands.run("plain")
        settle(session)
        assert len(session.drawing.document.models) == count
    assert "done already" in session.heard[-1].text
    session.drawing.undo()
    settle(session)
    assert not session.drawing.document.models


def test_a_command_on_what_is_deleted_meanwhile_begins_nothing(session, settle):
    (model,) = session.drawing.document.models
    session.commands.run("flip")
    session.commands.run("flip")
    session.objects.delete(model.id)
    settle(session)
    assert not session.drawing.document.models
    assert "Flip" not in session.drawing.history.entries


def test_a_modeler_that_fails_to_name_its_commands_is_asked_once(
    make_session, marks, settle, monkeypatch
):
    asked = []

    def commands():
        asked.append(1)
        raise ValueError("no list")

    monkeypatch.setattr(marks, "commands", commands)
    session = make_session(MODELER, extra=[marks.package])
    for x in (300.0, 400.0, 500.0):
        draw(session, settle, x)
    assert len(asked) == 1
    assert len([n for n in session.heard if n.kind == "fault"]) == 1
    assert len(session.drawing.document.models[0].state.marks) == 3


def test_commands_are_asked_and_run_in_workers(make_session, marks, settle, monkeypatch):
    threads, whole = set(), marks.commands

    def commands():
        threads.add(threading.current_thread())
        return whole()

    monkeypatch.setattr(marks, "commands", commands)
    session = make_session(MODELER, extra=[marks.package])
    draw(session, settle)
    session.commands.run("flip")
    settle(session)
    assert threads
    assert threading.main_thread() not in threads


# -- that write a file ---------------------------------------------------------------------------


@pytest.fixture
def with_list(marks, monkeypatch):
    """The modeler, with a command that writes how many marks there are."""
    whole = marks.commands

    def written(state, context):
        return f"{context.file}: {len(state.marks)}".encode()

    made = Command("list", "List", "Writes how many.", written, writes=".txt")
    monkeypatch.setattr(marks, "commands", lambda: [*whole(), made])
    return marks


def test_a_command_that_writes_asks_for_a_place_and_is_no_step(
    make_session, with_list, settle, tmp_path
):
    session = make_session(MODELER, extra=[with_list.package])
    draw(session, settle)
    asked, steps = [], session.drawing.history.position
    session.commands.place_wanted.connect(asked.append)
    session.commands.run("list")
    settle(session)
    assert [command.id for command in asked] == ["list"]
    draw(session, settle, 500.0)
    session.commands.write("list", tmp_path / "marks.txt")
    settle(session)
    assert (tmp_path / "marks.txt").read_text() == "marks: 2"
    assert session.drawing.history.position == steps + 1
    assert session.heard[-1].text == "Saved “marks.txt”."


@pytest.mark.parametrize("chosen", ["marks.txt", "marks", "marks.md"])
def test_the_window_asks_where_the_file_of_a_command_goes(
    make_window, with_list, settle, tmp_path, monkeypatch, chosen
):
    asked = []

    def ask(parent, title, proposal, kinds):
        asked.append((title, kinds))
        return str(tmp_path / chosen), kinds

    monkeypatch.setattr(QFileDialog, "getSaveFileName", staticmethod(ask))
    window = make_window(MODELER, extra=[with_list.package])
    draw(window.session, settle)
    window.actions_.qaction("command.list").trigger()
    settle(window.session)
    assert asked == [("List", "List (*.txt)")]
    (written,) = tmp_path.glob("*.txt")
    assert written.name in ("marks.txt", "marks.md.txt")


# -- in the window -------------------------------------------------------------------------------


@pytest.fixture
def window(make_window, marks, settle):
    made = make_window(MODELER, extra=[marks.package])
    draw(made.session, settle)
    return made


def test_the_key_of_a_command_works_and_a_taken_one_stays_the_programs(window, settle):
    registry = window.actions_
    registry.refresh()
    assert registry.holder("X").id == "command.flip"
    assert registry.holder("F").id == "view.frame"
    assert registry.qaction("command.refuse").shortcuts() == []
    (refuse,) = (a for a in registry.actions() if a.id == "command.refuse")
    assert "F" in refuse.tip
    before = window.session.drawing.document.models[0].state
    window.activateWindow()
    window.canvas.setFocus()
    QTest.keyClick(window.canvas, Qt.Key.Key_X)
    settle(window.session)
    assert window.session.drawing.document.models[0].state is not before
    assert window.session.drawing.history.undo_label == "Flip"


def test_commands_stay_for_the_next_object_and_say_what_they_need(window, settle):
    window.session.selection.select(None)
    settle(window.session)
    registry = window.actions_
    flip = next(a for a in registry.actions() if a.id == "command.flip")
    assert not flip.enabled()
    assert "Draw one first" in flip.why_not()
    window.session.selection.select(window.session.drawing.document.models[0].id)
    settle(window.session)
    flip = next(a for a in registry.actions() if a.id == "command.flip")
    assert flip.enabled()


def test_commands_go_with_their_modeler(window, settle):
    window.session.selection.select(None)
    window.session.toolbox.take_modeler("bozzetto.skin")  # has none
    settle(window.session)
    assert not [a for a in window.actions_.actions() if a.id.startswith("command.")]
    assert window.actions_.holder("X") is None


def test_the_rough_shape_of_a_product_is_chosen_before_its_first_curve(make_window, settle):
    window = make_window("bozzetto.product")
    session = window.session
    session.toolbox.ask_for_tools()
    settle(session)
    ids = [one.id for one in session.commands.commands if session.commands.is_enabled(one.id)]
    assert {"add-sphere", "add-bottle"} <= set(ids)
    window.actions_.run("command.add-sphere")
    settle(session)
    (model,) = session.drawing.document.models
    kinds = [node.kind for node in model.state.nodes if hasattr(node, "kind")]
    assert "sphere" in kinds


def test_what_a_command_begins_stands_beside_what_is_there(make_window, settle):
    window = make_window("bozzetto.product")
    session = window.session
    session.toolbox.ask_for_tools()
    settle(session)
    for count in (1, 2, 3):
        window.actions_.run("command.add-bottle")
        settle(session)
        assert len(session.drawing.document.models) == count
        session.gestures.commit()
        settle(session)
    bench = session.workbench
    boxes = [
        bench.model_scene(model, bench.best_result(model)).of_kinds(Shaded).bounds()
        for model in session.drawing.document
    ]
    for one, other in itertools.combinations(boxes, 2):
        assert (np.maximum(one[0], other[0]) > np.minimum(one[1], other[1])).any()
        assert one[0][2] == pytest.approx(other[0][2])
    assert session.drawing.document.models[0].placement.is_identity


def test_two_commands_with_one_key_leave_it_to_the_first(make_window, marks, settle):
    marks.keys = {"flip": "Shift+J", "refuse": "Shift+J"}
    window = make_window(MODELER, extra=[marks.package])
    draw(window.session, settle)
    assert window.actions_.holder("Shift+J").id == "command.flip"


def test_a_key_that_is_none_is_no_key(make_window, marks, settle):
    marks.keys = {"flip": "Hyper+Nothing", "refuse": "Space"}
    window = make_window(MODELER, extra=[marks.package])
    draw(window.session, settle)
    for name in ("command.flip", "command.refuse"):
        assert window.actions_.qaction(name).shortcuts() == []


def test_no_bundled_modeler_wants_a_key_that_it_cannot_have(make_window):
    """A key that the program or another command holds does something else than the menu says."""
    actions = make_window("bozzetto.silhouette").actions_
    registry = Registry()
    for info in registry.modelers():
        wanted = [
            QKeySequence(command.key).toString(QKeySequence.SequenceFormat.PortableText)
            for command in registry.guarded(info.id).commands()
            if command.key
        ]
        assert len(set(wanted)) == len(wanted), info.id
        held = [one.id for key in wanted if (one := actions.holder(key)) is not None]
        assert [one for one in held if not one.startswith("command.")] == [], info.id
        assert not set(wanted) & set(RESERVED), info.id
