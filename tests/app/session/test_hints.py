"""What comes next: asked of the tool in the hand, as the model is now."""

from __future__ import annotations

import pytest

from bozzetto.plugin import NextStep
from bozzetto.plugin.gesture import Drag
from tests import adviser
from tests.adviser import MODELER
from tests.app.tablet import stroke_of


@pytest.fixture
def session(make_session, marks, settle, monkeypatch):
    def next_step(tool, state):
        marks.expected += 1
        return NextStep(marks.words(state))

    marks.expected = 0
    marks.words = lambda state: f"{len(state.marks)} marks. Draw another."
    monkeypatch.setattr(adviser.DrawMark, "next_step", next_step)
    made = make_session(MODELER, extra=[marks.package])
    settle(made)
    return made


@pytest.fixture
def draw(settle):
    def one(session, x=300.0):
        session.gestures.stroke_lifted(stroke_of([(x, 300.0), (400.0, 400.0)], session.view.camera))
        settle(session)

    return one


def test_before_anything_is_drawn_the_tools_own_hint_stands(session, marks):
    assert session.hints.step.sentence == "Draw a mark."
    assert marks.expected == 0


def test_the_hint_follows_strokes_commands_and_the_history(session, draw, settle):
    draw(session)
    assert session.hints.step.sentence == "1 marks. Draw another."
    draw(session, 320.0)
    assert session.hints.step.sentence == "2 marks. Draw another."
    session.drawing.undo()
    settle(session)
    assert session.hints.step.sentence == "1 marks. Draw another."
    session.drawing.redo()
    settle(session)
    assert session.hints.step.sentence == "2 marks. Draw another."
    session.commands.run("flip")
    settle(session)
    assert session.hints.step.sentence == "2 marks. Draw another."


def test_without_a_model_the_tools_own_hint_is_back(session, draw, settle):
    draw(session)
    session.selection.select(None)
    settle(session)
    assert session.hints.step.sentence == "Draw a mark."


def test_the_same_state_is_asked_about_once(session, draw, settle, marks):
    draw(session)
    asked = marks.expected
    session.selection.select(session.selection.id)
    session.objects.set_visible(session.selection.id, False)
    settle(session)
    session.objects.set_visible(session.drawing.document.models[0].id, True)
    settle(session)
    assert marks.expected <= asked + 1


@pytest.mark.parametrize("words", [lambda state: 42, lambda state: 1 / 0])
def test_a_fault_is_told_once_and_drawing_goes_on(session, draw, marks, words):
    marks.words = words
    for x in (300.0, 320.0, 340.0):
        draw(session, x)
    assert [notice.kind for notice in session.heard].count("fault") == 1
    assert len(session.drawing.document.models[0].state.marks) == 3


def test_a_tool_with_nothing_special_to_say_leaves_room_for_what_else_can_be_done(
    session, marks, draw
):
    marks.words = lambda state: "Draw a mark."
    draw(session)
    assert session.hints.step.sentence.startswith("Draw a mark. ")
    assert "Enter starts a new object." in session.hints.step.sentence


def test_after_a_drag_of_a_handle_the_tool_in_the_hand_still_speaks(make_window, settle):
    """A joint's drag goes to *Arrange*, whatever tool is in the hand."""
    window = make_window()
    session = window.session
    session.files.exchange.import_file(session.toolbox.modelers[0].samples[1])
    settle(session, window.keeper)
    session.objects.set_parameter("posing", True)
    settle(session, window.keeper)
    assert session.toolbox.tool == "draw"
    assert "joint" in session.hints.step.sentence
    assert "outline" not in session.hints.step.sentence
    layers = [layer for layer in session.scene.visible.layers if layer.name == "joints"]
    handle = next(item for layer in layers for item in layer.items if hasattr(item, "tip"))
    x, y = session.view.camera.project([handle.point])[0][0]
    path = stroke_of([(x, y), (x + 15.0, y + 15.0)], session.view.camera)
    session.gestures.handle_released(Drag(handle.id, path))
    settle(session)
    assert session.drawing.history.undo_label == "Arrange"
    assert session.toolbox.tool == "draw"
    assert "joint" in session.hints.step.sentence


def test_before_anything_is_drawn_a_tool_that_needs_something_says_so(make_window, settle):
    """Every tool, of every bundled modeler, says what it says of the object that it would begin."""
    window = make_window()
    session = window.session
    pointed = {}
    for info in session.toolbox.modelers:
        session.toolbox.take_modeler(info.id)
        settle(session)
        for tool in session.toolbox.tools[1:]:
            session.toolbox.take_tool(tool.id)
            settle(session)
            begun = session.workbench.create(info.id, session.gestures.context.now())
            told = session.workbench.next_step(begun, session.workbench.tool(info.id, tool.id))
            assert session.hints.step.sentence == told.sentence
            assert session.hints.step.place is None
            pointed[info.id, tool.id] = session.hints.step.tool
    assert not session.drawing.document.models
    for needy in ("silhouette cut", "symmetry join", "product fillet", "polyhedron hinge"):
        modeler, tool = needy.split()
        assert pointed[f"bozzetto.{modeler}", tool] == "draw"
    assert not pointed["bozzetto.symmetry", "line"]


def test_a_fault_before_anything_is_drawn_is_told_once(make_session, marks, settle, monkeypatch):
    class Wipe(adviser.DrawMark):
        id, title = "wipe", "Wipe"

        def next_step(self, state):
            raise ZeroDivisionError

    monkeypatch.setattr(adviser.Marks, "tools", lambda modeler: (adviser.DrawMark(), Wipe()))
    session = make_session(MODELER, extra=[marks.package])
    settle(session)
    for tool in ("wipe", "draw", "wipe"):
        session.toolbox.take_tool(tool)
        settle(session)
    assert [notice.kind for notice in session.heard].count("fault") == 1
    assert session.hints.step.sentence == Wipe.hint
