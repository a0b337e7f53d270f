"""Shapes as the input of another modeler."""

from __future__ import annotations

import pytest

from tests.adviser import MODELER
from tests.app.tablet import circle, stroke_of


def draw(session, settle, points):
    session.gestures.stroke_lifted(stroke_of(points, session.view.camera))
    settle(session)


@pytest.fixture
def session(make_session, marks, settle):
    made = make_session(MODELER, extra=[marks.package])
    draw(made, settle, [(300.0, 300.0), (400.0, 400.0)])
    made.heard.clear()
    return made


def test_curves_of_one_model_start_another_in_one_step(session, settle):
    first, steps = session.drawing.document.models[0], session.drawing.history.position
    session.shapes.use_chosen(MODELER)
    settle(session)
    assert len(session.drawing.document) == 2
    second = session.drawing.document.models[1]
    assert second.state.marks == first.state.marks
    assert second.name != first.name
    assert session.selection.id == second.id
    shown = [model.visible for model in session.drawing.document]
    assert shown == [False, True]  # the copy stands in its place
    assert session.drawing.history.position == steps + 1
    session.drawing.undo()
    settle(session)
    assert tuple(session.drawing.document.models) == (first,)


def test_shapes_come_where_they_stand(session, settle):
    from bozzetto.geometry import Placement

    model = session.drawing.document.models[0]
    session.objects.set_placement(model.id, Placement(offset=(7.0, 0.0, 0.0)))
    session.shapes.use_chosen(MODELER)
    settle(session)
    (before,), (after,) = model.state.marks, session.drawing.document.models[1].state.marks
    assert after[0][0] == pytest.approx(before[0][0] + 7.0)


def test_what_is_of_no_use_is_refused_in_words(session, settle):
    session.toolbox.take_modeler("bozzetto.silhouette")
    session.selection.select(None)
    settle(session)
    draw(session, settle, circle())
    count = len(session.drawing.document)
    session.shapes.use_chosen(MODELER)
    settle(session)
    assert len(session.drawing.document) == count
    assert session.heard[-1].text == "There are no curves in it. Choose another object."


def test_nothing_chosen_is_said(session, settle):
    session.selection.select(None)
    session.shapes.use_chosen(MODELER)
    settle(session)
    assert "Choose an object" in session.heard[-1].text


def test_only_the_chosen_part_is_taken(make_session, settle):
    """Of a silhouette of two parts far apart, the mesh of one."""
    session = make_session()
    for x in (300.0, 700.0):
        draw(session, settle, circle(x, 360, 90))
    model = session.selection.model
    _, second = session.parts.of(model.id).parts
    session.parts.select(model.id, second.id)
    session.shapes.use_chosen("bozzetto.mesh")
    settle(session)
    assert [m.modeler for m in session.drawing.document] == ["bozzetto.silhouette", "bozzetto.mesh"]
    (mesh,) = session.drawing.document.models[1].state.meshes
    assert mesh.bounds[0, 0] > 0  # the right one alone
    assert session.drawing.document.models[0] is not None
    assert len(session.parts.of(model.id).parts) == 2


def test_curves_are_there_for_the_next_gesture(session, settle):
    draw(session, settle, [(500.0, 300.0), (600.0, 400.0)])
    assert session.selection.model.state.seen == 1
    assert len(session.gestures.context.now().curves) == 2
    session.objects.set_visible(session.selection.id, False)
    assert session.gestures.context.now().curves == ()


def test_facts_of_a_watched_drawing_reach_the_new_model(session, settle, qtbot):
    from bozzetto.ink import Strokes
    from bozzetto.ink.drawing import Drawing
    from bozzetto_app.session.stroke_replay import StrokeReplay

    session.selection.select(None)
    stroke = stroke_of([(300.0, 300.0), (350.0, 350.0), (400.0, 400.0)], session.view.camera)
    drawing = Drawing(Strokes((stroke,)), session.view.camera, facts={"box": 42.0})
    replay = StrokeReplay(session, drawing, speed=1000.0)
    with qtbot.waitSignal(replay.finished, timeout=20_000):
        replay.start()
    settle(session)
    assert session.drawing.document.models[-1].state.box == 42.0
    assert session.gestures.context.facts == {}
