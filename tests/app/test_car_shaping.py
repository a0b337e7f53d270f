"""The body of a car worked on in the real window: edges traced, nodes and tangents dragged."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.scene.display_list import Handle, Lines
from bozzetto.view import Camera
from bozzetto_car.body.build import body_of
from tests.app.seen import layer_items, state
from tests.app.tablet import Stylus
from tests.app.test_car_window import GALLERY, drop, rest


@pytest.fixture
def window(make_window, settle):
    made = make_window("bozzetto.car")
    made.resize(1000, 680)
    settle(made.session, made.keeper)
    made.welcome.hide()
    drop(made, GALLERY / "sedan.json", settle)
    made.session.selection.select(next(iter(made.session.drawing.document)).id)
    rest(made, settle)
    return made


def seen_from(window, azimuth, settle):
    """Look at the car from the right side of the nose, or from elsewhere, free of the sketch."""
    session = window.session
    turn = np.radians(azimuth)
    toward = np.array([-np.cos(turn), np.sin(turn), 0.2])
    eye = np.array([2300.0, 0.0, 700.0]) + 9000.0 * toward
    session.view.set_camera(
        Camera(
            "perspective", tuple(eye.tolist()), (2300.0, 0.0, 700.0), fov_y=26.0,
            viewport=session.view.camera.viewport,
        )
    )  # fmt: skip
    rest(window, settle)


def handle(window, name):
    """Where a handle is on the canvas."""
    (found,) = (
        item for item in shown_now(window, "handles")
        if isinstance(item, Handle) and item.id == name
    )  # fmt: skip
    return window.session.view.camera.project([found.point])[0][0]


def shown_now(window, name):
    session = window.session
    scene = session.scene.visible.under(session.scene.advice)
    return [i for layer in scene.layers if layer.name == name for i in layer.items]


def test_nodes_and_tangents_are_dragged_with_the_pen(window, settle):
    session = window.session
    seen_from(window, 60.0, settle)
    session.toolbox.take_tool("shape")
    rest(window, settle)
    steps = session.drawing.history.position

    # A touch reveals the tangents of a node; it is no step of the history.
    place = handle(window, "node S3.R")
    stylus = Stylus(window.canvas)
    stylus.press(place)
    stylus.lift(place)
    rest(window, settle)
    assert state(window).revealed == "S3.R"
    assert session.drawing.history.position == steps
    tangents = [
        i.id for i in shown_now(window, "handles") if isinstance(i, Handle) and "tangent" in i.id
    ]
    assert len(tangents) == 4
    assert sum(isinstance(i, Lines) for i in shown_now(window, "handles")) == 4
    window.canvas.grab()

    # Drags: the body goes along while the pen is down; two of one handle are one edit.
    edits = len(state(window).edits)
    for _ in range(2):
        start = handle(window, tangents[0])
        stylus.press(start)
        for share in np.linspace(0.1, 1.0, 8):
            stylus.move(start + share * np.array([6.0, -22.0]))
        settle(session, window.keeper)
        assert layer_items(window, "body")
        stylus.lift(start + np.array([6.0, -22.0]))
        rest(window, settle)
    assert len(state(window).edits) == edits + 1
    start = handle(window, "node S3.R")
    stylus.press(start)
    for share in np.linspace(0.1, 1.0, 8):
        stylus.move(start + share * np.array([14.0, 9.0]))
    stylus.lift(start + np.array([14.0, 9.0]))
    rest(window, settle)
    assert len(state(window).edits) == edits + 2
    assert handle(window, "node S3.R") == pytest.approx(start + np.array([14.0, 9.0]), abs=1.5)
    session.drawing.undo()
    rest(window, settle)
    assert len(state(window).edits) == edits + 1


def test_an_edge_is_traced_and_the_eraser_takes_it_back(window, settle):
    session = window.session
    seen_from(window, 60.0, settle)
    session.toolbox.take_tool("trace")
    rest(window, settle)
    edits = len(state(window).edits)
    body = body_of(state(window))
    edge = body.template.edge_names.index("S3.R-B3.R")
    points = body.network.control_points[edge]
    at = np.linspace(0.0, 1.0, 40)[:, None]
    chord = (1 - at) * points[0] + at * points[3]
    path = session.view.camera.project(chord)[0] + 18.0 * np.sin(np.pi * at) * [1.0, 0.0]
    Stylus(window.canvas).draw(path)
    rest(window, settle)
    made = state(window).edits
    assert len(made) == edits + 1
    assert made[-1].edges == ("S3.R-B3.R",)
    assert made[-1].sketch == ""
    after = body_of(state(window)).network.control_points[edge]
    middle = session.view.camera.project([(after[0] + 3 * after[1] + 3 * after[2] + after[3]) / 8])[
        0
    ]
    assert np.linalg.norm(path - middle, axis=1).min() < 3.0
    Stylus(window.canvas, eraser=True).draw(path)
    rest(window, settle)
    assert len(state(window).edits) == edits
