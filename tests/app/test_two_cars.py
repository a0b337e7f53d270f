"""Two cars in one document: each is marked on its own sketch, and knows nothing of the other."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from bozzetto.plugin.job import Job
from bozzetto.view import Camera
from bozzetto.workbench.export_document import object_shapes
from tests.app.test_car_window import (
    FIRST,
    GALLERY,
    corners,
    drop,
    mark,
    near_first,
    picture_of,
    state,
)

HATCH = json.loads((GALLERY / "hatchback.json").read_text("utf-8"))
OTHER = {**HATCH["views"][0], "image": HATCH["image"]}


@pytest.fixture
def window(make_window, settle):
    made = make_window("bozzetto.car")
    made.resize(900, 620)
    settle(made.session, made.keeper)
    made.welcome.hide()
    return made


def next_object(window, settle):
    """As the status line says: Enter, where no ink waits."""
    window.activateWindow()
    window.canvas.setFocus()
    assert QTest.qWaitForWindowActive(window)  # on X it takes a moment, and keys before are lost
    QTest.keyClick(window.canvas, Qt.Key.Key_Return)
    settle(window.session, window.keeper)


def choose(window, number, settle):
    """Choose an object in the list, and look through its sketch."""
    session = window.session
    session.selection.select(session.drawing.document.models[number].id)
    rest(window, settle)
    window.canvas.views.turn_to_better()
    rest(window, settle)
    assert session.advice.advice.pinned


def rest(window, settle):
    for _ in range(3):
        settle(window.session, window.keeper)


def owners(window, name):
    scene = window.session.scene.visible.under(window.session.scene.live)
    return [layer.owner for layer in scene.layers if layer.name == name and layer.items]


def walk_around(window, settle):
    session = window.session
    eye, target = (-6000.0, -8000.0, 5000.0), (2300.0, 1300.0, 600.0)
    viewport = session.view.camera.viewport
    session.view.set_camera(Camera("perspective", eye, target, fov_y=32.0, viewport=viewport))
    rest(window, settle)


def body_of(window, number):
    session = window.session
    model = session.drawing.document.models[number]
    (work,) = session.workbench.own_shapes(model, Job()).patchworks
    return work.nets


def test_a_second_sketch_after_enter_begins_a_car_beside_the_first(window, settle):
    drop(window, picture_of(FIRST), settle)
    next_object(window, settle)
    drop(window, picture_of(OTHER), settle)
    rest(window, settle)
    one, two = window.session.drawing.document.models
    assert [len(model.state.sketches) for model in (one, two)] == [1, 1]
    assert two.placement.offset[1] > 1500.0 + one.placement.offset[1], "side by side"
    assert owners(window, "sketch") == [two.id], "no other drawing behind or before it"
    seen = corners(window)
    assert ((seen >= -1.0) & (seen <= np.array(window.session.view.camera.viewport) + 1.0)).all()
    walk_around(window, settle)
    assert not owners(window, "sketch")


@pytest.mark.slow
def test_two_cars_marked_in_turn_are_as_each_would_be_alone(window, settle):
    session = window.session
    rows = ((FIRST, picture_of(FIRST)), (OTHER, picture_of(OTHER)))

    def nodes(view):
        wheels = [node for node in view["marks"] if node.startswith("W")]
        return [*wheels, *(node for node in near_first(view["marks"]) if node not in wheels)]

    for view, picture in rows:
        drop(window, picture, settle)
        for node in nodes(view)[:7]:
            mark(window, node, view["marks"][node], settle)
        next_object(window, settle)
    for number in (0, 1, 0, 1):  # in turn, through its own sketch
        view = rows[number][0]
        choose(window, number, settle)
        node = nodes(view)[len(state(window).sketch.marks)]
        model = session.drawing.document.models[number]
        assert owners(window, "sketch") == [model.id], "no other drawing behind or before it"
        assert set(owners(window, "body")) <= {model.id}, "and no other car"
        mark(window, node, view["marks"][node], settle)
        set_now = {m.node: (m.u, m.v) for m in state(window).sketch.marks}
        for name, place in set_now.items():
            assert place == pytest.approx(view["marks"][name], abs=0.75), (number, name)
    together = [body_of(window, number) for number in (0, 1)]
    marked = [model.state for model in session.drawing.document.models]

    walk_around(window, settle)
    assert len(owners(window, "body")) == 2
    made = object_shapes(session.workbench, session.drawing.document.models, Job()).shapes
    boxes = [(work.nets.min((0, 1, 2)), work.nets.max((0, 1, 2))) for work in made.patchworks]
    assert boxes[1][0][1] > boxes[0][1][1], "they do not stand in one another"
    assert len({work.name for work in made.patchworks}) == 2

    # Both are taken back to the last mark and come again, to the last bit.
    steps = session.drawing.history.position
    for _ in range(steps):
        session.drawing.undo()
    rest(window, settle)
    assert not session.drawing.document.models
    for _ in range(steps):
        session.drawing.redo()
    rest(window, settle)
    assert [model.state for model in session.drawing.document.models] == marked

    # Each alone in a document of its own is the same car.
    for number in (0, 1):
        session.workbench.forget_results()
        assert np.array_equal(body_of(window, number), together[number])
    session.objects.delete(session.drawing.document.models[0].id)
    rest(window, settle)
    session.workbench.forget_results()
    assert np.array_equal(body_of(window, 0), together[1])
