"""Followers in the window: made, shown live, unlinked, frozen, duplicated and refused."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec import structs
from PySide6.QtCore import QTimer

from bozzetto.document.model import Document
from bozzetto.geometry import Placement
from bozzetto_app.panels.objects.panel import ObjectsPanel
from bozzetto_app.panels.objects.rows import link_words
from tests import plugin_package
from tests.app.seen import button
from tests.app.tablet import circle, stroke_of
from tests.linked_boxes import MODELER, BoxState

boxes = plugin_package.fixture_of("tests.linked_boxes", "Boxes")


@pytest.fixture
def session(make_session, boxes, settle):
    """A cube “Body”, and “Boxes” that follows it."""
    made = make_session(MODELER, extra=[boxes.package])
    made.drawing.show(Document(), None)
    body = made.workbench.new_model(MODELER, BoxState(10.0), "Body")
    made.drawing.commit("Add", Document((body,)))
    made.selection.select(body.id)
    made.shapes.use_chosen(MODELER)
    settle(made)
    made.heard.clear()
    return made


def two(session):
    return session.drawing.document.models[0], session.drawing.document.models[1]


def shown_size(session, model):
    """How large what is shown of a model is, along x."""
    points = [
        item.mesh.vertices
        for layer in session.solver.layers()
        if layer.owner == model.id
        for item in layer.items
    ]
    return float(np.ptp(np.concatenate(points)[:, 0])) if points else None


def words(session, model):
    return link_words(session.drawing.document.model(model.id), session.drawing.document)


def test_using_an_object_makes_a_follower_in_one_step(session):
    body, follower = two(session)
    assert follower.followed == (body.id,)
    assert session.drawing.history.undo_label == "Follow “Body”"
    assert (words(session, follower), words(session, body)) == ("follows “Body”", "")
    assert shown_size(session, follower) == 15.0


@pytest.mark.parametrize("replaces", [True, False])
def test_what_is_replaced_is_hidden_in_the_same_step_and_followed_all_the_same(
    make_session, boxes, settle, monkeypatch, replaces
):
    session = make_session(MODELER, extra=[boxes.package])
    told = structs.replace(session.registry.info(MODELER), replaces=replaces)
    monkeypatch.setattr(session.registry, "info", lambda _: told)
    session.drawing.show(Document(), None)
    body = session.workbench.new_model(MODELER, BoxState(10.0), "Body")
    session.drawing.commit("Add", Document((body,)))
    session.selection.select(body.id)
    session.shapes.use_chosen(MODELER)
    settle(session)
    first, follower = two(session)
    assert first.visible != replaces
    assert shown_size(session, follower) == 15.0
    session.drawing.undo()
    settle(session)
    assert [model.visible for model in session.drawing.document] == [True]


def test_followers_are_solved_again_when_the_source_changes_moves_or_is_hidden(session, settle):
    body, follower = two(session)
    session.selection.select(body.id)
    session.objects.set_parameter("edge", 20.0)
    settle(session)
    assert shown_size(session, follower) == 30.0
    session.objects.set_visible(body.id, False)
    session.objects.set_parameter("edge", 40.0)
    settle(session)
    assert (shown_size(session, body), shown_size(session, follower)) == (None, 60.0)
    session.objects.set_placement(body.id, Placement(scale=2.0))
    settle(session)
    assert shown_size(session, follower) == 120.0
    for _ in range(4):
        session.drawing.undo()
    settle(session)
    assert shown_size(session, follower) == 15.0
    session.drawing.go_to(len(session.drawing.history.entries) - 1)
    settle(session)
    assert shown_size(session, follower) == 120.0


def test_a_deleted_source_is_kept_and_told_and_undo_links_again(session, settle, boxes):
    body, follower = two(session)
    boxes.solved.clear()
    session.objects.delete(body.id)
    settle(session)
    assert shown_size(session, follower) == 15.0
    assert words(session, follower) == "keeps “Body” as it was"
    assert session.heard[-1].text == "“Boxes” keeps “Body” as it was. Undo links them again."
    assert boxes.solved == []  # it has the result that it had
    session.drawing.undo()
    settle(session)
    assert words(session, follower) == "follows “Body”"
    session.selection.select(body.id)
    session.objects.set_parameter("edge", 30.0)
    settle(session)
    assert shown_size(session, follower) == 45.0


def test_unlinking_keeps_the_shape_and_linking_again_takes_the_new_one(session, settle):
    body, follower = two(session)
    session.selection.select(follower.id)
    session.objects.unlink_selected()
    session.selection.select(body.id)
    session.objects.set_parameter("edge", 30.0)
    settle(session)
    assert shown_size(session, follower) == 15.0
    session.selection.select(follower.id)
    session.objects.unlink_selected()
    settle(session)
    assert shown_size(session, follower) == 45.0


def test_a_circle_is_refused_where_it_would_be_made(session, settle):
    body, follower = two(session)
    session.selection.select(body.id)
    steps = session.drawing.history.position
    settle(session)
    session.commands.run("follow_all")
    settle(session)
    assert "“Body” cannot follow itself" in session.heard[-1].text
    assert session.drawing.history.position == steps
    assert two(session) == (body, follower)


def test_ink_that_would_make_a_circle_waits_with_the_reason(session, settle):
    body, follower = two(session)
    session.selection.select(body.id)
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    settle(session)
    assert two(session) == (body, follower)
    (ink,) = session.drawing.document.waiting
    assert (ink.status, "cannot follow itself" in ink.reason) == ("refused", True)


def test_a_tool_makes_links_to_what_is_seen(session, settle):
    body, follower = two(session)
    session.selection.select(None)
    session.gestures.stroke_lifted(stroke_of(circle(), session.view.camera))
    settle(session)
    made = session.drawing.document.models[2]
    assert made.followed == (body.id, follower.id)
    assert shown_size(session, made) == 22.5


def test_a_source_without_a_solution_is_told_for_both(session, settle):
    body, follower = two(session)
    session.selection.select(body.id)
    session.objects.set_parameter("wrong", True)
    settle(session)
    told = [notice.text for notice in session.heard if notice.kind == "error"]
    assert sorted(told) == [
        "This box is wrong. Make it right.",
        "“Boxes” follows “Body”. This box is wrong. Make it right.",
    ]
    session.heard.clear()
    session.objects.set_parameter("wrong", False)
    session.objects.set_parameter("edge", 20.0)
    settle(session)
    assert [notice for notice in session.heard if notice.kind == "error"] == []
    assert shown_size(session, follower) == 30.0


def test_the_figures_of_a_follower_are_those_of_its_newest_result(
    session, settle, boxes, monkeypatch
):
    def report(self, state, result, job):
        return {"width": float(np.ptp(result[-1].vertices[:, 0]))}

    monkeypatch.setattr(type(boxes), "report", report)
    body, follower = two(session)
    for edge in (10.0, 20.0):
        session.selection.select(body.id)
        session.objects.set_parameter("edge", edge)
        session.selection.select(follower.id)
        settle(session)
        assert session.solver.report == {"width": 1.5 * edge}


def test_the_panel_shows_the_link_and_duplicates_what_is_chosen(session, settle, qtbot):
    panel = ObjectsPanel(session)
    qtbot.addWidget(panel)
    rows = [panel.list.itemWidget(panel.list.item(row)) for row in range(2)]
    assert [row.link.accessibleName() for row in rows] == ["", "follows “Body”"]
    assert rows[1].link.isVisibleTo(panel)
    assert not rows[0].link.isVisibleTo(panel)
    panel.list.choose(1)
    said = [action.text() for action in panel.menu_for_current().actions()]
    assert "Unlink" in said
    assert "Link again" not in said
    panel.list.selectAll()
    button(panel, "Duplicate").click()
    settle(session)
    body, body_copy, follower, copy = session.drawing.document.models
    assert (follower.sources, copy.sources) == ((body.id,), (body_copy.id,))
    session.selection.select(body_copy.id)
    session.objects.set_parameter("edge", 40.0)
    settle(session)
    assert (shown_size(session, follower), shown_size(session, copy)) == (15.0, 60.0)
    session.objects.unlink(copy.id)
    panel.list.choose(3)
    said = [action.text() for action in panel.menu_for_current().actions()]
    assert "Link again" in said
    assert "Unlink" not in said


def test_a_source_that_is_deleted_meanwhile_is_not_followed(session, settle):
    body, follower = two(session)
    session.shapes.use(MODELER, [body.id], {})
    session.objects.delete(body.id)
    settle(session)
    assert [model.id for model in session.drawing.document] == [follower.id]
    assert "no longer there" in session.heard[-1].text


def test_parts_are_copied_and_the_whole_is_followed(make_session, settle):
    session = make_session("bozzetto.symmetry")
    samples = session.registry.info("bozzetto.symmetry").samples
    session.files.exchange.import_file(next(path for path in samples if path.stem == "boat"))
    settle(session)
    boat = session.selection.model
    part = session.parts.of(boat.id).parts[0].id
    session.shapes.use("bozzetto.skin", [boat.id], {boat.id: [part]})
    settle(session)
    copy = session.selection.model
    assert copy.sources == ()
    assert len(copy.state.points)
    assert session.heard[-1].text.startswith("Parts are copied, not followed.")
    session.shapes.use("bozzetto.skin", [boat.id], {})
    settle(session)
    assert session.selection.model.sources == (boat.id,)
    assert session.solver.shown(session.selection.id).linked


def test_a_slider_on_the_source_shows_a_follower_for_every_value(session, settle, qtbot):
    """Values come as fast as the window takes them; each is shown of both, and in order."""
    body, follower = two(session)
    session.selection.select(body.id)
    seen = {body.id: [], follower.id: []}
    session.solver.changed.connect(
        lambda model_id, _: seen[model_id].append(
            shown_size(session, session.drawing.document.model(model_id))
        )
    )
    values = [20.0 + number for number in range(20)]
    for value in values:
        session.objects.set_parameter("edge", value, dragging=True)
        qtbot.waitUntil(
            lambda value=value: (
                seen[follower.id][-1:] == [1.5 * value] and seen[body.id][-1:] == [value]
            )
        )
    session.objects.end_drag()
    settle(session)
    assert list(dict.fromkeys(seen[follower.id])) == [1.5 * value for value in values]
    assert session.drawing.history.undo_label == "Edge"


@pytest.mark.slow
def test_followers_of_a_dragged_source_have_their_turns(session, settle, qtbot):
    """A chain of five at 60 values a second: the last one gets as many frames as the first."""
    for _ in range(3):
        session.selection.select(session.drawing.document.models[-1].id)
        session.shapes.use_chosen(MODELER)
        settle(session)
    models = session.drawing.document.models
    frames = dict.fromkeys((model.id for model in models), 0)

    def count(model_id, _):
        frames[model_id] += 1

    session.selection.select(models[0].id)
    session.solver.changed.connect(count)
    values = iter(range(120))
    timer = QTimer(interval=16)

    def tick():
        value = next(values, None)
        if value is None:
            timer.stop()
        else:
            session.objects.set_parameter("edge", 20.0 + 0.5 * value, dragging=True)

    timer.timeout.connect(tick)
    timer.start()
    qtbot.waitUntil(lambda: not timer.isActive(), timeout=60_000)
    shown = [frames[model.id] for model in models]
    session.objects.end_drag()
    settle(session)
    assert min(shown) >= 0.5 * max(shown)
    assert min(shown) >= 20
