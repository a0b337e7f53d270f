"""Shapes as the input of another modeler."""

from __future__ import annotations

import pytest

from tests.adviser import MODELER
from tests.app.tablet import circle, stroke_of


def draw(session, settle, points):
    session.pen_lifted(stroke_of(points, session.camera))
    settle(session)


@pytest.fixture
def session(make_session, marks, settle):
    made = make_session(MODELER, extra=[marks.package])
    draw(made, settle, [(300.0, 300.0), (400.0, 400.0)])
    made.heard.clear()
    return made


def test_curves_of_one_model_start_another_in_one_step(session, settle):
    first, steps = session.document.models[0], session.history.position
    session.using.use_chosen(MODELER)
    settle(session)
    assert len(session.document) == 2
    second = session.document.models[1]
    assert second.state.marks == first.state.marks
    assert second.name != first.name
    assert session.selected == second.id
    assert session.history.position == steps + 1
    session.undo()
    settle(session)
    assert tuple(session.document.models) == (first,)


def test_shapes_come_where_they_stand(session, settle):
    from bozzetto.geometry import Placement

    model = session.document.models[0]
    session.set_placement(model.id, Placement(offset=(7.0, 0.0, 0.0)))
    session.using.use_chosen(MODELER)
    settle(session)
    (before,), (after,) = model.state.marks, session.document.models[1].state.marks
    assert after[0][0] == pytest.approx(before[0][0] + 7.0)


def test_what_is_of_no_use_is_refused_in_words(session, settle):
    session.activate_modeler("bozzetto.silhouette")
    session.select(None)
    settle(session)
    draw(session, settle, circle())
    count = len(session.document)
    session.using.use_chosen(MODELER)
    settle(session)
    assert len(session.document) == count
    assert session.heard[-1].text == "There are no curves in it. Choose another object."


def test_nothing_chosen_is_said(session, settle):
    session.select(None)
    session.using.use_chosen(MODELER)
    settle(session)
    assert "Choose an object" in session.heard[-1].text


def test_only_the_chosen_part_is_taken(make_session, settle):
    """Of a silhouette of two parts far apart, the mesh of one."""
    session = make_session()
    for x in (300.0, 700.0):
        draw(session, settle, circle(x, 360, 90))
    model = session.selected_model
    _, second = session.parts_of(model.id).parts
    session.select_part(model.id, second.id)
    session.using.use_chosen("bozzetto.mesh")
    settle(session)
    assert [m.modeler for m in session.document] == ["bozzetto.silhouette", "bozzetto.mesh"]
    (mesh,) = session.document.models[1].state.meshes
    assert mesh.bounds[0, 0] > 0  # the right one alone
    assert session.document.models[0] is not None
    assert len(session.parts_of(model.id).parts) == 2


def test_curves_are_there_for_the_next_gesture(session, settle):
    draw(session, settle, [(500.0, 300.0), (600.0, 400.0)])
    assert session.selected_model.state.seen == 1
    assert len(session.context().curves) == 2
    session.set_visible(session.selected, False)
    assert session.context().curves == ()


def test_facts_of_a_watched_drawing_reach_the_new_model(session, settle, qtbot):
    from bozzetto.ink import Strokes
    from bozzetto.ink.drawing import Drawing
    from bozzetto_app.session.replay import Replay

    session.select(None)
    stroke = stroke_of([(300.0, 300.0), (350.0, 350.0), (400.0, 400.0)], session.camera)
    drawing = Drawing(Strokes((stroke,)), session.camera, extra={"box": 42.0})
    replay = Replay(session, drawing, speed=1000.0)
    with qtbot.waitSignal(replay.finished, timeout=20_000):
        replay.start()
    settle(session)
    assert session.document.models[-1].state.box == 42.0
    assert session.facts == {}
