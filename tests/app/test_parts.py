"""Parts of an object in the session and the window: steps, choices, previews in their place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document import edit
from bozzetto.geometry import Mesh
from bozzetto.plugin import Tool
from bozzetto.plugin.gesture import Tap
from bozzetto.scene import Handle, Layer, Lines, Scene, Shaded
from bozzetto.testing import Pen
from bozzetto_app.session.tool_groups import ToolInfo


def circle(session, x, radius=60):
    return Pen(session.view.camera).circle(x, 360, radius)


@pytest.fixture
def session(make_session, settle):
    """Three outlines beside one another in one object."""
    made = make_session()
    for x in (250, 500, 750):
        made.gestures.stroke_lifted(circle(made, x))
        settle(made)
    return made


def tree(session):
    return session.parts.of(session.selection.id)


def ids(session):
    return [part.id for part, _ in tree(session).rows()]


def test_a_choice_is_no_step_of_the_history(session, settle):
    first = ids(session)[0]
    steps, position = session.drawing.history.entries, session.drawing.history.position
    session.parts.select(session.selection.id, first)
    settle(session)
    assert tree(session).selected == first
    assert session.parts.chosen.id == first
    assert (session.drawing.history.entries, session.drawing.history.position) == (steps, position)
    session.drawing.undo()
    settle(session)
    session.drawing.redo()
    assert tree(session).selected == first, "the step is there with what was chosen then"


def test_a_choice_is_no_unsaved_work(session, settle, tmp_path):
    session.files.save(tmp_path / "a.bozz")
    settle(session)
    assert not session.drawing.is_modified
    session.parts.select(session.selection.id, ids(session)[0])
    settle(session)
    assert not session.drawing.is_modified


def test_what_was_undone_can_be_done_again_after_a_choice(session, settle):
    session.drawing.undo()
    settle(session)
    session.parts.select(session.selection.id, ids(session)[0])
    session.drawing.redo()
    settle(session)
    assert len(ids(session)) == 3


def test_several_things_are_deleted_in_one_step(session, settle):
    model, steps = session.selection.model, session.drawing.history.position
    one, two, three = ids(session)
    session.objects.duplicate(model.id)
    settle(session)
    copy = session.drawing.document.models[1].id
    session.selection.select(model.id)
    session.parts.delete_several([copy], {model.id: [one, three]}, [])
    settle(session)
    assert len(session.drawing.document) == 1
    assert ids(session) == [two]
    assert session.drawing.history.position == steps + 2
    assert session.drawing.history.undo_label == "Delete what is chosen"
    session.drawing.undo()
    settle(session)
    assert len(session.drawing.document) == 2
    assert ids(session) == [one, two, three]


def test_nothing_is_deleted_where_one_of_several_is_locked(session, settle):
    model = session.selection.id
    session.objects.duplicate(model)
    settle(session)
    session.objects.set_locked(session.drawing.document.models[1].id, True)
    before = session.drawing.document
    session.parts.delete_several([m.id for m in before], {}, [])
    assert session.drawing.document is before
    assert "locked" in session.heard[-1].text


def test_a_dissolved_group_leaves_its_parts_where_they_stand(session, settle):
    """Also after the group was moved: silhouettes' groups carry their parts along."""
    from bozzetto.geometry import Placement
    from bozzetto.plugin.job import Job

    model = session.selection.id
    session.parts.group(model, ids(session)[:2])
    settle(session)
    group = session.parts.chosen_group
    state = session.selection.model.state
    moved = tuple(
        replace(node, pose=Placement(offset=(0.0, 0.0, 40.0))) if node.id == group else node
        for node in state.nodes
    )
    moved_model = replace(session.selection.model, state=replace(state, nodes=moved))
    session.drawing.commit("Move", session.drawing.document.with_model(moved_model))
    settle(session)
    before = session.workbench.shapes(session.drawing.document, Job()).solids[0].mesh
    session.parts.ungroup_chosen()
    settle(session)
    after = session.workbench.shapes(session.drawing.document, Job()).solids[0].mesh
    assert session.drawing.history.undo_label.startswith("Ungroup")
    assert not tree(session).groups
    assert np.allclose(after.bounds, before.bounds, atol=1e-3)


def test_every_edit_is_one_step_with_its_name(session, settle):
    model = session.selection.id
    one, two, three = ids(session)
    session.parts.rename(model, one, "Body")
    session.parts.set_visible(model, one, False)
    session.parts.move(model, three, "", 0)
    session.parts.group(model, [one, two])
    session.parts.duplicate(model, three)
    session.parts.delete(model, two)
    labels = session.drawing.history.entries[-6:]
    assert labels[0] == "Rename to “Body”"
    assert labels[1] == "Hide “Body”"
    assert labels[2].startswith("Reorder “")
    assert labels[3] == "Group 2 parts"
    assert labels[4].startswith("Duplicate “")
    assert labels[5].startswith("Delete “")
    for _ in range(6):
        session.drawing.undo()
    assert ids(session) == [one, two, three]
    settle(session)


def test_a_slider_of_a_part_is_one_step(session, settle):
    count = len(session.drawing.history.entries)
    session.parts.select(session.selection.id, ids(session)[1])
    for value in (1.1, 1.2, 1.3):
        session.parts.set_parameter("inflation", value, dragging=True)
    session.objects.end_drag()
    assert len(session.drawing.history.entries) == count + 1
    assert session.drawing.history.entries[-1] == "Inflation"
    assert [part.inflation for part in tree(session).parts] == [1.0, 1.3, 1.0]
    settle(session)


def test_handles_are_there_with_the_tool_they_belong_to(session, settle):
    def held():
        return {
            i.id.partition(":")[2]
            for _, i in session.scene.visible.items()
            if isinstance(i, Handle)
        }

    model, (first, *_, last) = session.selection.id, ids(session)
    assert held() == set()
    session.toolbox.take_tool("arrange")
    assert held() == {last}
    session.parts.select(model, first)
    settle(session)
    assert held() == {first}
    session.selection.select(None)
    assert held() == set()
    session.selection.select(model)
    assert held() == {first}
    session.toolbox.take_tool("draw")
    assert held() == set()


def test_a_locked_object_refuses_edits_but_can_be_looked_at(session):
    model, first = session.selection.id, ids(session)[0]
    session.objects.set_locked(model, True)
    before = session.drawing.document
    session.parts.rename(model, first, "Body")
    session.parts.delete(model, first)
    session.parts.set_parameter("inflation", 2.0)
    assert session.drawing.document is before
    assert all("locked" in notice.text for notice in session.heard[-3:])
    session.parts.select(model, first)
    assert tree(session).selected == first


def test_parts_that_are_gone_are_no_catastrophe(session):
    before = session.drawing.document
    for act in (session.parts.delete, session.parts.duplicate):
        act(session.selection.id, "nobody")
    session.parts.delete("no model", "nobody")
    assert session.drawing.document is before
    assert session.heard[-1].kind == "error"


def test_the_context_brings_the_picture_that_is_traced(session):
    from tests.document_kit import underlay

    assert session.gestures.context.now().underlay is None
    picture = replace(underlay(), visible=True)
    session.objects.edit(edit.add_underlay, picture)
    assert session.gestures.context.now().underlay.pixels is picture.pixels
    session.objects.set_underlay_visible(picture.id, False)
    assert session.gestures.context.now().underlay is None


# -- gestures -------------------------------------------------------------------------------------


def test_drags_go_to_the_tool_in_the_hand_or_else_to_the_first(session):
    box = session.toolbox
    box.tools = tuple(
        ToolInfo(name, name, None, "", kind)
        for name, kind in (("draw", "ink"), ("arrange", "drag"), ("pose", "drag"))
    )
    for active, drags, taps in (
        ("draw", "arrange", "draw"),
        ("arrange", "arrange", "arrange"),
        ("pose", "pose", "pose"),
    ):
        box.tool = active
        assert box.tool_for("drag") == drags
        assert box.tool_for("tap") == taps


def triangle(size, name="shape", owner="m"):
    mesh = Mesh(np.float32(size) * np.eye(3, dtype=np.float32), [[0, 1, 2]])
    return Layer(name, (Shaded(mesh),), owner)


def test_a_layer_stands_in_for_that_of_its_name_and_owner():
    own = Scene((triangle(1), Layer("ink", (), "m"), triangle(2, owner="other")))
    live = Scene((triangle(3), triangle(4, "extra"), Layer("refused")))
    seen = own.under(live)
    assert [layer.name for layer in seen.layers] == ["ink", "shape", "shape", "extra", "refused"]
    assert seen.layers[1] is own.layers[2]
    assert own.under(Scene((replace(live.layers[0], owner=""),))).layers[:3] == own.layers
    assert own.under(Scene()).layers == own.layers


class StandsIn(Tool):
    """A tool whose preview takes the place of the shape."""

    id, title, icon, hint, gesture = "stand", "Stand in", "", "Draw.", "ink"

    def preview(self, state, gesture, context):
        line = Lines(np.zeros((2, 3)), color="accent")
        return Scene((Layer("shape", (line,)),))

    def draw(self, state, gesture, context):
        nodes = tuple(replace(node, visible=k > 0) for k, node in enumerate(state.nodes))
        return replace(state, nodes=nodes)


def shapes_seen(session):
    """The layers called shape as a viewport shows them."""
    seen = session.scene.visible.under(session.scene.live)
    return [layer for layer in seen.layers if layer.name == "shape"]


def test_a_preview_stands_in_until_the_new_shape_is_there(session, settle, monkeypatch):
    """Looked at whenever something changes: there is always exactly one shape."""
    tool = StandsIn()
    monkeypatch.setattr(session.workbench, "tool", lambda modeler, name: tool)
    (before,) = shapes_seen(session)
    counts, previews = [], []

    def look():
        layers = shapes_seen(session)
        counts.append(len(layers))
        previews.append(isinstance(layers[0].items[0], Lines))

    session.scene.live_changed.connect(look)
    session.scene.changed.connect(look)
    session.gestures.stroke_moved(circle(session, 400))
    settle(session)
    assert previews[-1], "the preview is shown in place of the shape"
    session.gestures.stroke_lifted(circle(session, 400))
    settle(session)
    assert set(counts) == {1}
    (after,) = shapes_seen(session)
    assert after is not before
    assert not session.scene.live.layers
    first_solid = previews.index(False, previews.index(True))
    assert not any(previews[first_solid:]), "the preview does not come back"
    assert isinstance(after.items[0], Shaded)


def test_a_gesture_that_only_chooses_is_no_step(session, settle, monkeypatch):
    class Chooses(StandsIn):
        def tap(self, state, gesture, context):
            return replace(state, selected=state.nodes[0].id)

    chooses = Chooses()
    monkeypatch.setattr(session.workbench, "tool", lambda modeler, name: chooses)
    assert tree(session).selected == ids(session)[-1]
    steps = session.drawing.history.entries
    session.gestures.tap(Tap(10.0, 10.0, session.view.camera))
    settle(session)
    assert tree(session).selected == ids(session)[0]
    assert session.drawing.history.entries == steps


def test_ink_into_a_moved_object_lies_under_the_pen(session, settle):
    from bozzetto.geometry import Placement

    turned = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 1.0, (0.0, 0.0, 30.0))
    session.objects.set_placement(session.selection.id, turned)
    settle(session)
    stroke = Pen(session.view.camera).circle(480, 150, 50)
    session.gestures.stroke_lifted(stroke)
    settle(session)
    assert len(ids(session)) == 4
    model = session.drawing.document.model(session.selection.id)
    layer = next(layer for layer in session.scene.visible.layers if layer.name == "ink")
    ghosts = np.concatenate([item.points for item in layer.items if isinstance(item, Lines)])
    pixels, _ = session.view.camera.project(ghosts)
    gaps = np.linalg.norm(stroke.points[:, None] - pixels[None], axis=-1).min(1)
    assert gaps.max() < 0.5, model.placement


def test_the_commands_mean_the_chosen_part_or_else_the_object(session, settle):
    model, (one, two, three) = session.selection.id, ids(session)
    session.parts.select(model, one)
    session.parts.delete_chosen()
    assert ids(session) == [two, three]
    session.parts.duplicate_chosen()
    assert len(ids(session)) == 3
    session.parts.select(model, "")
    session.parts.duplicate_chosen()
    assert len(session.drawing.document) == 2
    session.selection.select(model)
    session.parts.delete_chosen()
    assert [other.id for other in session.drawing.document] != [model]
    assert len(session.drawing.document) == 1
    settle(session)
