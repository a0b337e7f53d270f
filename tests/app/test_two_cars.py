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
from bozzetto_app.canvas.overlay.cube_geometry import seen_faces
from bozzetto_app.panels.objects.part_row import PartRow
from bozzetto_app.panels.properties.place_form import PlaceForm
from tests.app.test_car_window import (
    FIRST,
    GALLERY,
    corners,
    drop,
    guide,
    mark,
    near_first,
    picture_of,
    rest,
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


def test_two_cars_are_put_in_their_places_by_hand(window, settle):
    """Typed in the form; the drag of a field is one step; sketch and marks go along."""
    session = window.session
    drop(window, picture_of(FIRST), settle)
    mark(window, "C1", FIRST["marks"]["C1"], settle)
    next_object(window, settle)
    drop(window, picture_of(OTHER), settle)
    one, two = session.drawing.document.models
    before = two.placement
    choose(window, 1, settle)
    place = window.findChild(PlaceForm)
    deep = place.axes[1]
    assert deep.value() == pytest.approx(before.offset[1], abs=1e-6), "it shows where it stands"

    steps = session.drawing.history.position
    typed(deep, "4000")
    typed(place.turn, "90")
    rest(window, settle)
    moved = session.drawing.document.model(two.id).placement
    assert moved.offset == (before.offset[0], 4000.0, before.offset[2])
    assert moved.rotation == (0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    assert session.drawing.document.model(one.id) is one, "the other stays"
    assert session.drawing.history.position == steps + 2
    window.canvas.views.turn_to_better()
    rest(window, settle)
    assert session.advice.advice.pinned, "its sketch is seen from where it stands now"
    assert owners(window, "sketch") == [two.id]

    for value in (4100.0, 4200.0, 4300.0):
        deep.edited.emit(value, True)
    deep.drag_ended.emit()
    rest(window, settle)
    assert session.drawing.document.model(two.id).placement.offset[1] == 4300.0
    assert session.drawing.history.position == steps + 3
    for _ in range(3):
        session.drawing.undo()
    assert session.drawing.document.model(two.id).placement == before
    rest(window, settle)
    assert deep.value() == pytest.approx(before.offset[1], abs=1e-6)

    session.objects.set_locked(two.id, True)
    assert not place.isEnabled()


def test_a_second_sketch_of_a_car_works_like_the_first(window, settle):
    """It is marked at once; who meant another car is told what to press."""
    session = window.session
    drop(window, picture_of(FIRST), settle)
    mark(window, "C1", FIRST["marks"]["C1"], settle)
    said = []
    session.notices.noticed.connect(lambda notice: said.append(notice.text))
    drop(window, picture_of(OTHER), settle)
    rest(window, settle)
    (model,) = session.drawing.document.models
    assert len(model.state.sketches) == 2
    assert model.state.sketch is model.state.sketches[1]
    assert session.toolbox.tool == "mark"
    assert session.advice.advice.pinned
    assert "front wheel" in session.hints.step.sentence
    assert any(model.name in words and "Enter" in words for words in said)


def test_the_ring_of_the_next_point_is_drawn_through_the_sketch_only(window, settle):
    session, overlay = window.session, window.canvas.overlay
    drop(window, picture_of(FIRST), settle)
    marks = FIRST["marks"]
    side = "R" if "S1.R" in marks else "L"
    for node in (f"WF.{side}", f"WR.{side}", *near_first(marks)[:5]):
        mark(window, node, marks[node], settle)
    rest(window, settle)
    assert session.hints.step.place is not None
    assert overlay.next_place is not None
    walk_around(window, settle)
    assert overlay.next_place is None, "from elsewhere it would ring a place in the air"
    window.canvas.views.turn_to_better()
    rest(window, settle)
    assert overlay.next_place is not None


def test_the_row_of_a_sketch_has_opacity_lock_and_eye(window, settle):
    session = window.session
    drop(window, picture_of(FIRST), settle)
    (row,) = window.findChildren(PartRow)
    steps = session.drawing.history.position
    for value in (0.7, 0.5, 0.3):
        row.opacity.slid.emit(value, True)
    row.opacity.drag_ended.emit()
    rest(window, settle)
    assert state(window).sketch.opacity == 0.3
    assert session.drawing.history.position == steps + 1, "a drag is one step"
    row.lock.click()
    rest(window, settle)
    assert state(window).sketch.locked
    assert "Unlock" in row.lock.accessibleName()
    mark(window, "C1", FIRST["marks"]["C1"], settle)
    assert not state(window).sketch.marks, "a locked sketch keeps its marks"
    row.lock.click()
    rest(window, settle)
    mark(window, "C1", FIRST["marks"]["C1"], settle)
    assert len(state(window).sketch.marks) == 1
    row.eye.click()
    rest(window, settle)
    assert not state(window).sketch.visible


def test_a_template_is_chosen_by_its_picture(window, settle, qtbot):
    drop(window, picture_of(FIRST), settle)
    panel = guide(window)
    qtbot.waitUntil(lambda: not panel.busy, timeout=20_000)
    assert panel.templates.isVisible()
    buttons = panel.templates.buttons
    assert [name for name, button in buttons.items() if button.isChecked()] == ["sedan"]
    buttons["minivan"].click()
    rest(window, settle)
    assert state(window).template == "minivan"
    qtbot.waitUntil(lambda: not panel.busy, timeout=20_000)
    assert [name for name, button in buttons.items() if button.isChecked()] == ["minivan"]
    mark(window, "C1", FIRST["marks"]["C1"], settle)
    qtbot.waitUntil(lambda: not panel.busy, timeout=20_000)
    assert not panel.templates.isVisible(), "then the room is for the points"


@pytest.mark.parametrize(
    ("name", "outward"),
    [
        ("front", (-1.0, 0.0, 0.0)),
        ("back", (1.0, 0.0, 0.0)),
        ("left", (0.0, -1.0, 0.0)),
        ("right", (0.0, 1.0, 0.0)),
    ],
)
def test_views_are_named_from_the_cars_own_sides(window, settle, qtbot, name, outward):
    """The nose is at x = 0 and the car's right is y: so says its page."""
    session, views = window.session, window.canvas.views
    drop(window, picture_of(FIRST), settle)
    views.look(name)
    qtbot.waitUntil(lambda: not window.canvas.motion.is_running, timeout=3000)
    forward = session.view.camera.axes[2]
    assert forward == pytest.approx(-np.array(outward), abs=1e-9)
    (seen,) = seen_faces(session.view.camera)
    assert window.canvas.cube.label_of(seen.face) == name, "the cube says the same"

    # A car that was turned has its nose elsewhere: then sides are the world's.
    model = session.selection.model
    session.objects.set_placement(model.id, model.placement.headed(90.0))
    assert not views.sides
    assert window.canvas.cube.label_of(seen.face) == seen.face.name


def typed(field, text):
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)
    QTest.keyClick(field, Qt.Key.Key_Return)


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
