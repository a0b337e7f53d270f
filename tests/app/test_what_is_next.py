"""Every place of the window says the same of what is next, whatever has been done before."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QTabBar

from bozzetto.plugin import NextStep
from bozzetto.plugin.gesture import Tap
from bozzetto.view.navigation import turn
from bozzetto_app.panels.tool_rail import ToolRail
from bozzetto_app.widgets.number_field import NumberField
from tests.app.seen import buttons, part
from tests.app.tablet import Stylus, stroke_of

GALLERY = Path(__file__).parents[2] / "docs" / "gallery" / "car"
SKETCHES = sorted(GALLERY.glob("*.png"))[:2]


@pytest.fixture
def window(make_window):
    made = make_window()
    made.welcome.hide()
    return made


def in_front(window):
    """The title of the panel that lies on the others."""
    (tabs,) = (bar for bar in window.findChildren(QTabBar) if bar.count() and bar.isVisible())
    return tabs.tabText(tabs.currentIndex())


def rail(window):
    return window.findChild(ToolRail)


def check(window):
    """Compare all places with the one answer."""
    session, canvas = window.session, window.canvas
    step, advice = session.hints.step, session.advice.advice
    assert step.sentence
    if part(window, "status-sign").accessibleName() == "Next step":
        assert part(window, "status-words").text() == step.sentence
    if canvas.empty_hint.is_read:
        assert canvas.empty_hint.text == step.sentence
    elif advice is not None and advice.level == "good" and advice.better is None:
        assert canvas.light.said == step.sentence
        assert step.sentence in canvas.light.accessibleName()
    elif advice is not None:
        assert canvas.light.said == advice.message
    tool = session.toolbox.tool
    for panel in window.docks.plugin_panel.findChildren(QLabel, "next-step"):
        # Beside the picture of a point stand the words of that point, whatever is in the hand; it
        # is found in a thread, a moment later.
        of_point = tool != "mark" and panel.text().startswith("Touch: ")
        for _ in range(100):
            if of_point or panel.text() == step.sentence:
                break
            QTest.qWait(20)
            step = session.hints.step  # of a shape that has come meanwhile
        assert of_point or panel.text() == step.sentence
    front = [button for button in buttons(rail(window)) if getattr(button, "is_next", False)]
    pointed = {step.tool for button in front if step.tool in button.behind}
    assert len(front) == len(pointed)
    assert pointed == {step.tool} - {"", tool}
    if step.place is None:
        assert canvas.overlay.next_place is None
    elif canvas.overlay.next_place is not None:
        seen = session.view.camera.project([step.place])[0][0]
        assert np.allclose(canvas.overlay.next_place, seen, atol=1e-6)
    model = session.selection.target(session.toolbox.modeler)
    waits = any(
        one.is_for(session.toolbox.modeler, tool) and one.status in ("unfinished", "failed")
        for one in session.drawing.document.waiting
    )
    if model is not None and not waits:
        fresh = session.workbench.next_step(model, session.workbench.tool(model.modeler, tool))
        assert step.sentence.startswith(fresh.sentence)
        assert (step.place, step.tool, step.panel) == (fresh.place, fresh.tool, fresh.panel)


def curve(session, dice):
    width, height = session.view.camera.viewport
    ends = [(dice.uniform(0.2, 0.8) * width, dice.uniform(0.2, 0.8) * height) for _ in range(4)]
    session.gestures.stroke_lifted(stroke_of(ends, session.view.camera))


def tap(session, dice):
    place = session.hints.step.place
    x, y = dice.uniform(100, 700), dice.uniform(100, 500)
    if place is not None:
        x, y = session.view.camera.project([place])[0][0].tolist()
    session.gestures.tap(Tap(x, y, session.view.camera))


def sample(session, dice):
    info = dice.choice([info for info in session.toolbox.modelers if info.samples])
    session.toolbox.take_modeler(info.id)
    session.files.exchange.import_file(info.samples[-1])


def picture(session, dice):
    session.pictures.take_file(dice.choice(SKETCHES))


def modeler(session, dice):
    session.toolbox.take_modeler(dice.choice(session.toolbox.modelers).id)


def tool(session, dice):
    if session.toolbox.tools:
        session.toolbox.take_tool(dice.choice(session.toolbox.tools).id)


def pose(session, dice):
    model = session.selection.model
    if model is not None and hasattr(model.state, "posing"):
        session.objects.set_parameter("posing", not model.state.posing)


def view(session, dice):
    session.view.set_camera(turn(session.view.camera, dice.uniform(-40, 40), dice.uniform(-9, 9)))


def choose(session, dice):
    models = session.drawing.document.models
    session.selection.select(dice.choice([None, *(model.id for model in models)]))


def undo(session, dice):
    session.drawing.undo()


def redo(session, dice):
    session.drawing.redo()


def enter(session, dice):
    session.gestures.commit()


ACTIONS = (curve, tap, sample, picture, modeler, tool, tool, pose, view, choose, undo, undo, redo,
           enter)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_on_a_random_walk_all_places_agree(window, settle, seed):
    dice = random.Random(seed)
    done = []
    for _ in range(25):
        action = dice.choice(ACTIONS)
        done.append(action.__name__)
        action(window.session, dice)
        settle(window.session, window.keeper)
        try:
            check(window)
        except AssertionError as problem:
            raise AssertionError(f"after {' '.join(done)}: {problem}") from problem


def test_after_a_second_sketch_the_first_mark_of_it_is_asked_for_everywhere(window, settle):
    """What was seen to disagree: light, panel and status line after a second sketch."""
    session = window.session
    session.toolbox.take_modeler("bozzetto.car")
    settle(session, window.keeper)
    session.pictures.take_file(SKETCHES[0])
    settle(session, window.keeper)
    session.gestures.tap(Tap(300.0, 300.0, session.view.camera))
    settle(session, window.keeper)
    check(window)
    assert not session.hints.step.panel
    window.docks.raise_parameters()
    session.pictures.take_file(SKETCHES[1])
    settle(session, window.keeper)
    check(window)
    assert "6 more marks" in session.hints.step.sentence
    assert session.hints.step.panel
    assert in_front(window) == "Car"
    session.toolbox.take_tool("trace")
    settle(session, window.keeper)
    check(window)
    assert session.hints.step.tool == "mark"
    assert "6 more marks" in part(window, "status-words").text()
    (button,) = [each for each in buttons(rail(window)) if getattr(each, "is_next", False)]
    assert button.tool.id == "mark"
    assert button.accessibleDescription() == session.hints.step.sentence


def test_the_panel_is_raised_once(window, settle):
    session = window.session
    session.toolbox.take_modeler("bozzetto.car")
    settle(session, window.keeper)
    session.pictures.take_file(SKETCHES[0])
    settle(session, window.keeper)
    assert in_front(window) == "Car"
    window.docks.raise_parameters()
    session.toolbox.take_tool("trace")
    settle(session, window.keeper)
    assert session.hints.step.panel
    assert in_front(window) == "Parameters"


def test_the_panel_does_not_come_over_the_one_that_has_the_keyboard(window, settle, qtbot):
    session = window.session
    session.toolbox.take_modeler("bozzetto.car")
    settle(session, window.keeper)
    session.pictures.take_file(SKETCHES[0])
    settle(session, window.keeper)
    session.gestures.tap(Tap(300.0, 300.0, session.view.camera))
    settle(session, window.keeper)
    window.docks.raise_parameters()
    window.activateWindow()
    field = window.docks.parameters.findChild(NumberField)
    field.setFocus()
    qtbot.waitUntil(field.hasFocus)
    for has_keyboard, title in ((True, "Parameters"), (False, "Car")):
        if not has_keyboard:
            window.canvas.setFocus()
        for step in (NextStep("Touch."), NextStep("Look.", panel=True)):
            session.hints.step = step
            session.hints.changed.emit()
        assert in_front(window) == title


def test_the_place_is_marked_while_the_pen_is_up(window, settle):
    session, overlay = window.session, window.canvas.overlay
    session.toolbox.take_modeler("bozzetto.car")
    session.files.exchange.import_file(session.registry.info("bozzetto.car").samples[0])
    settle(session, window.keeper)
    check(window)
    assert session.hints.step.place is not None
    before = overlay.next_place
    assert before is not None
    stylus = Stylus(window.canvas)
    stylus.press((500.0, 300.0))
    assert overlay.next_place is None
    stylus.move((560.0, 340.0))
    assert overlay.next_place is None
    window.canvas.hand.cancel()
    assert overlay.next_place == before


@pytest.mark.parametrize("hasty", [False, True])
def test_a_touch_with_the_pen_does_what_is_next_where_that_is_a_touch(window, settle, hasty):
    """Also right after the last line, when nobody knows yet that the lines close."""
    session = window.session
    session.toolbox.take_modeler("bozzetto.polyhedron")
    settle(session)
    front = [(480.0, 320.0), (720.0, 370.0), (720.0, 540.0), (480.0, 490.0)]
    back = [(x + 150.0, y - 110.0) for x, y in front]
    stylus = Stylus(window.canvas)
    for k in range(4):
        for begin, end in ((front[k], front[k - 1]), (front[k], back[k]), (back[k], back[k - 1])):
            stylus.draw(np.linspace(begin, end, 12))
    if not hasty:
        settle(session)
        assert session.hints.step.tool == "turn"
        (model,) = session.drawing.document.models
        assert model.state.nodes[0].choice is None
    stylus.press(front[1])
    stylus.lift(front[1])
    settle(session)
    (model,) = session.drawing.document.models
    assert session.toolbox.tool == "turn"
    assert model.state.nodes[0].choice is not None


def test_a_touch_with_the_pen_says_what_is_missing_where_a_stroke_is_next(window, settle):
    session = window.session
    settle(session)
    stylus = Stylus(window.canvas)
    stylus.press((400.0, 300.0))
    stylus.lift((400.0, 300.0))
    assert "too short" in part(window, "status-words").text()
    assert len(session.drawing.document) == 0


@pytest.mark.parametrize(("modeler", "tool"), [("silhouette", "paint"), ("symmetry", "split")])
def test_a_drawing_tool_that_takes_touches_gets_them(window, settle, modeler, tool):
    """It is asked, and answers that there is nothing on an empty sheet."""
    session = window.session
    session.toolbox.take_modeler(f"bozzetto.{modeler}")
    settle(session)
    session.toolbox.take_tool(tool)
    stylus = Stylus(window.canvas)
    stylus.press((400.0, 300.0))
    stylus.lift((400.0, 300.0))
    settle(session)
    said = part(window, "status-words").text()
    assert "too short" not in said
    assert "There is no" in said


def test_a_touch_with_paint_colours_the_part_under_it(window, settle):
    session = window.session
    settle(session)
    around = np.linspace(0.0, 2.0 * np.pi, 60)
    stylus = Stylus(window.canvas)
    stylus.draw(np.c_[500.0 + 120.0 * np.cos(around), 350.0 + 90.0 * np.sin(around)])
    settle(session)
    session.toolbox.take_tool("paint")
    stylus.press((500.0, 350.0))
    stylus.lift((500.0, 350.0))
    settle(session)
    state = session.drawing.document.models[0].state
    assert state.nodes[0].color == state.paint
