"""The symmetry modeler in the real window, as somebody meets it who draws for the first time."""

from __future__ import annotations

import time

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel

from bozzetto.scene.display_list import Handle, Lines, Shaded
from bozzetto.view.navigation import turn
from bozzetto_app.panels.properties.report import Figures
from tests.app.seen import layer_items, state, words
from tests.app.tablet import Stylus
from tests.app.test_responsiveness import GENEROUS, Pulse

CTRL = Qt.KeyboardModifier.ControlModifier
MIRROR = np.array([1.0, -1.0, 1.0])
ALONG = np.linspace(0.0, 1.0, 160)
RAIL = np.column_stack(
    (-80.0 + 160.0 * ALONG, 30.0 + 10.0 * np.sin(np.pi * ALONG), 40.0 + 40.0 * np.sin(3.0 * ALONG))
)
"""One side, in a box of 200 × 100 × 100 mm that stands on the ground."""

ACROSS = np.column_stack(
    (60.0 * np.cos(3.0 * (ALONG - 0.5)), 45.0 * np.sin(3.0 * (ALONG - 0.5)), 60.0 + 20.0 * ALONG**0)
)


@pytest.fixture
def window(make_window, settle):
    made = make_window("bozzetto.symmetry")
    made.canvas.views.look("three-quarter")
    made.canvas.views.fit()
    settle(made.session, made.keeper)
    return made


@pytest.fixture
def draw(settle):
    def with_pen(window, curve, *, lift=True, eraser=False, step=2):
        pixels, _ = window.session.view.camera.project(curve)
        stylus = Stylus(window.canvas, eraser=eraser)
        stylus.draw(pixels[::step], lift=lift)
        if lift:
            settle(window.session, window.keeper)
        return stylus, pixels

    return with_pen


@pytest.fixture
def pair(window, draw):
    draw(window, RAIL)
    draw(window, RAIL * MIRROR)
    return window


def report(window, number=-1):
    return window.session.solver.report["curves"][number]


def press(window, keys, settle, modifier=Qt.KeyboardModifier.NoModifier):
    window.activateWindow()
    window.canvas.setFocus()
    QTest.keyClick(window.canvas, keys, modifier)
    settle(window.session, window.keeper)


def away(points, curve):
    """How far places are from a curve, mm."""
    return np.linalg.norm(np.asarray(points)[:, None] - curve, axis=2).min(axis=1)


# -- before the first stroke -------------------------------------------------------------------


def test_an_empty_sheet_leads_to_the_first_stroke(make_window, settle):
    window = make_window()
    session, light = window.session, window.canvas.light
    assert window.canvas.empty_hint.text == "Draw a closed outline."
    session.toolbox.take_modeler("bozzetto.symmetry")
    window.resize(1024, 700)
    settle(session)
    assert "mirror image" in window.canvas.empty_hint.text, "what this modeler wants"
    (edges,) = [i for i in layer_items(window, "box") if isinstance(i, Lines)]
    assert edges.points[:, 2].min() == 0.0, "it stands on the ground"
    assert len(session.drawing.document) == 0
    assert light.advice.level == "good", "a new sheet is seen from where one draws best"
    window.actions_.run("view.front")
    settle(session)
    assert light.advice.level != "good"
    assert light.advice.message.startswith(light.words), "whole words, beside the samples"
    assert not light.words.endswith("…")
    assert light.button.isVisible()
    press(window, Qt.Key.Key_T, settle)
    assert light.advice.level == "good"
    session.toolbox.take_modeler("bozzetto.silhouette")
    assert window.canvas.empty_hint.text == "Draw a closed outline."


# -- drawing -----------------------------------------------------------------------------------


def test_both_sides_become_a_curve_in_space(window, draw, settle, qtbot):
    session = window.session
    first, camera = session.hints.step.sentence, session.view.camera
    window.canvas.motion.reduced = False
    draw(window, RAIL)
    assert not window.canvas.motion.is_running, "the other side is aimed at a sheet that stands"
    assert session.view.camera == camera
    assert "draw its mirror image" in session.hints.step.sentence.lower()
    # It grows while the second side is drawn.
    stylus, _ = draw(window, (RAIL * MIRROR)[:110], lift=False)
    qtbot.waitUntil(lambda: len(layer_items(window, "heat")) == 2, timeout=5000)
    qtbot.wait(50)
    near, far = layer_items(window, "heat")
    assert np.median(away(near.points, RAIL)) < 2.0
    assert np.allclose(far.points, near.points * MIRROR, atol=1e-3)
    (rungs,) = layer_items(window, "ghost")
    ends = rungs.points.reshape(-1, 2, 3)
    assert np.allclose(ends[:, 0] * MIRROR, ends[:, 1], atol=1e-3)
    for place in session.view.camera.project((RAIL * MIRROR)[110:])[0]:
        stylus.move(place)
    stylus.lift(place)
    settle(session, window.keeper)
    # It is one curve with its image.
    assert report(window)["reading"] == "pair"
    assert np.median(away(report(window)["points"], RAIL)) < 0.5
    near, far = layer_items(window, "curves")
    assert np.allclose(far.points, near.points * MIRROR, atol=1e-3)
    assert session.hints.step.sentence.startswith("Left and right belong together.")
    # Taken back, each in its turn, and what is expected with it.
    press(window, Qt.Key.Key_Z, settle, CTRL)
    assert "draw its mirror image" in session.hints.step.sentence.lower()
    press(window, Qt.Key.Key_Z, settle, CTRL)
    assert session.hints.step.sentence == first
    session.toolbox.take_tool("split")
    settle(session)
    assert session.hints.step.sentence.startswith("Draw a short stroke across a curve")
    session.drawing.redo()
    session.drawing.redo()
    settle(session)
    planes = [i for i in layer_items(window, "plane") if isinstance(i, Shaded)]
    assert len(planes) == 1, "no second, empty box"
    session.toolbox.take_tool("draw")
    draw(window, ACROSS)
    assert len(session.drawing.document) == 1
    assert len(state(window).curves) == 2
    session.toolbox.take_modeler("bozzetto.silhouette")
    settle(session)
    assert window.canvas.empty_hint.text == "", "the sheet is not empty"


def test_warnings_and_impossible_readings_reach_the_person(window, draw, settle):
    session = window.session
    draw(window, RAIL)
    draw(window, (RAIL * MIRROR)[:100])
    session.parts.set_parameter("reading", "pair")
    settle(session)
    warnings = report(window)["warnings"]
    assert warnings
    assert session.hints.step.sentence.startswith(warnings[0])
    words = [label.text() for label in window.docks.parameters.findChildren(QLabel)]
    assert warnings[0] in words
    session.parts.set_parameter("reading", "self")
    settle(session)
    assert session.hints.step.sentence.startswith(
        (*report(window)["warnings"], "A curve across")[0]
    )


def test_keys_take_the_curve_for_something_else(pair, draw, settle):
    session = pair.session
    before, steps = state(pair), session.drawing.history.position
    press(pair, Qt.Key.Key_X, settle)
    assert report(pair)["reading"] != "pair"
    assert session.drawing.history.position == steps + 1
    session.drawing.undo()
    settle(session)
    assert state(pair) == before
    assert report(pair)["reading"] == "pair"
    draw(pair, ACROSS)
    press(pair, Qt.Key.Key_C, settle)
    refused = [n.text for n in session.heard if n.kind == "error"]
    assert state(pair).curves[-1].other or "no other way" in refused[-1]


# -- changing ----------------------------------------------------------------------------------


def test_modify_split_and_eraser_are_steps_that_can_be_taken_back(pair, draw, settle):
    session = pair.session
    states = [state(pair)]
    session.toolbox.take_tool("modify")
    higher = RAIL + np.outer(np.sin(np.pi * ALONG), (0.0, 0.0, 6.0))
    draw(pair, higher[40:120])
    assert len(state(pair).curves[0].edits) == 1
    states.append(state(pair))
    session.toolbox.take_tool("split")
    middle = session.view.camera.project(higher[80:81])[0][0]
    Stylus(pair.canvas).draw([middle + np.array((0.0, d)) for d in np.linspace(-16.0, 16.0, 12)])
    settle(session, pair.keeper)
    assert len(state(pair).curves) == 2
    states.append(state(pair))
    session.toolbox.take_tool("draw")
    draw(pair, RAIL[130:], eraser=True)
    assert state(pair) != states[-1]
    states.append(state(pair))
    for before in states[-2::-1]:
        session.drawing.undo()
        settle(session)
        assert state(pair) == before
    for after in states[1:]:
        session.drawing.redo()
        settle(session)
        assert state(pair) == after


@pytest.mark.slow
def test_a_face_of_the_box_is_dragged(pair, settle):
    session = pair.session
    session.toolbox.take_tool("box")
    settle(session)
    (held,) = [
        i for i in layer_items(pair, "box handles") if isinstance(i, Handle) and i.id == "x+"
    ]
    ends, _ = session.view.camera.project([held.point, np.add(held.point, (40.0, 0.0, 0.0))])
    Stylus(pair.canvas).draw(ends[0] + np.linspace(0.0, 1.0, 20)[:, None] * (ends[1] - ends[0]))
    settle(session, pair.keeper)
    assert state(pair).length == 240.0
    assert report(pair)["reading"] == "pair"


# -- lists, forms, files -----------------------------------------------------------------------


def test_curves_stand_in_the_list_and_the_chosen_one_in_the_form(pair, draw, settle):
    draw(pair, ACROSS)
    session = pair.session
    tree = session.parts.of(session.selection.id)
    assert [part.name for part in tree.parts] == ["Curve 1", "Curve 2"]
    for part, name, other in (("n1", "Curve 1", "Curve 2"), ("n2", "Curve 2", "Curve 1")):
        session.parts.select(session.selection.id, part)
        settle(session)
        said = words(pair.docks.parameters.findChild(Figures))
        assert name in said
        assert other not in said
        assert "Read as" in said
    page = pair.docks.parameters.widget()
    assert page.width() <= pair.docks.parameters.viewport().width(), "nothing is cut off"
    lines = len(layer_items(pair, "curves"))
    session.parts.set_visible(session.selection.id, "n1", False)
    settle(session)
    assert len(layer_items(pair, "curves")) == lines - 2


def test_a_drawing_is_saved_comes_back_and_is_handed_over(pair, settle, tmp_path):
    session = pair.session
    before, told = state(pair), report(pair)
    session.files.save(tmp_path / "mouse.bozz")
    settle(session)
    session.files.new()
    settle(session)
    session.files.open_safely(tmp_path / "mouse.bozz")
    settle(session, pair.keeper)
    assert state(pair) == before
    assert report(pair) == told
    assert session.hints.step.sentence.startswith("Left and right belong together.")
    for name, mark in (("out.step", "B_SPLINE_CURVE"), ("out.svg", "<path")):
        session.files.exchange.export(tmp_path / name)
        settle(session)
        assert (tmp_path / name).read_text().count(mark) >= 2


# -- in time -----------------------------------------------------------------------------------


def usual_frame(window):
    """Seconds that painting the sheet takes; without a GPU they are the machine's."""
    found = []
    for _ in range(10):
        begun = time.perf_counter()
        window.canvas.viewports.current.widget.update()
        QApplication.processEvents()
        found.append(time.perf_counter() - begun)
    return float(np.median(found))


@pytest.mark.quiet
def test_the_window_is_free_while_curves_are_drawn(window, draw, settle):
    """Pauses from the moment the pen is lifted until the curve is shown."""
    draw(window, RAIL)  # what is made once is made
    pulse = Pulse()
    found, machine = [], 0.0
    frame = usual_frame(window)
    for curve in (RAIL * MIRROR, RAIL - (0.0, 0.0, 20.0), (RAIL - (0.0, 0.0, 20.0)) * MIRROR):
        stylus, pixels = draw(window, curve, lift=False)
        stylus.lift(pixels[-1])
        found.append(pulse.during(lambda: window.session.busy, least=0.1))
        machine = max(machine, pulse.machine.longest)
        settle(window.session)
    pauses = np.concatenate(found)
    assert np.percentile(pauses, 95) < 0.050 + machine + frame
    assert pauses.max() < GENEROUS + machine + frame


@pytest.mark.slow
def test_a_turning_view_is_advised_at_most_ten_times_a_second(pair, settle, qtbot):
    asked = []
    pair.session.advice.changed.connect(lambda: asked.append(time.perf_counter()))
    begun = time.perf_counter()
    while time.perf_counter() - begun < 0.6:
        pair.session.view.set_camera(turn(pair.session.view.camera, 0.5, 0.0))
        qtbot.wait(5)
    settle(pair.session)
    assert 2 <= len(asked) <= (asked[-1] - begun) / 0.1 + 1.5


def test_ends_that_nearly_meet_do_and_it_is_told_undone_and_suspended(window, draw, settle):
    post = np.column_stack((-40.0 + 70.0 * ALONG, 40.0 - 10.0 * ALONG, 20.0 + 70.0 * ALONG))
    rail = np.column_stack((30.0 + 55.0 * ALONG, 30.0 + 0.0 * ALONG, 90.0 - 60.0 * ALONG**2))
    rail += np.array((0.0, 0.9, 0.4))  # its end is drawn 3 px beside

    def ends():
        entries = window.session.solver.report["curves"]
        return [np.asarray(entry["points"])[[0, -1]] for entry in entries]

    for curve in (post, rail):
        draw(window, curve)
        draw(window, curve * MIRROR)
    one, other = ends()
    both = [np.linalg.norm(a - b * side) for a in one for b in other for side in (MIRROR, 1.0)]
    assert min(both) < 1e-6
    assert report(window)["settled"] == 1
    assert report(window, 0)["settled"] == 1, "the first one comes to meet it"
    assert "One end settled" in window.session.hints.step.sentence
    press(window, Qt.Key.Key_Z, settle, CTRL)
    press(window, Qt.Key.Key_Z, settle, CTRL)
    assert len(window.session.solver.report["curves"]) == 1
    assert report(window)["settled"] == 0, "it is where it was drawn"
    press(window, Qt.Key.Key_M, settle)
    draw(window, rail)
    draw(window, rail * MIRROR)
    one, other = ends()
    both = [np.linalg.norm(a - b * side) for a in one for b in other for side in (MIRROR, 1.0)]
    assert min(both) > 0.1
    assert report(window)["settled"] == report(window, 0)["settled"] == 0
