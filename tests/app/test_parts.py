"""Parts of an object in the session and the window: steps, choices, previews in their place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document import edit
from bozzetto.geometry import Mesh
from bozzetto.scene import Handle, Layer, Lines, Scene, Shaded
from bozzetto.testing import Pen
from bozzetto_app.session.toolbox import ToolInfo


def circle(session, x, radius=60):
    return Pen(session.camera).circle(x, 360, radius)


@pytest.fixture
def session(make_session, settle):
    """Three outlines beside one another in one object."""
    made = make_session()
    for x in (250, 500, 750):
        made.pen_lifted(circle(made, x))
        settle(made)
    return made


def tree(session):
    return session.parts_of(session.selected)


def ids(session):
    return [part.id for part, _ in tree(session).rows()]


def test_a_choice_is_no_step_of_the_history(session, settle):
    first = ids(session)[0]
    steps, position = session.history.entries, session.history.position
    session.select_part(session.selected, first)
    settle(session)
    assert tree(session).selected == first
    assert session.chosen_part.id == first
    assert (session.history.entries, session.history.position) == (steps, position)
    session.undo()
    settle(session)
    session.redo()
    assert tree(session).selected == first, "the step is there with what was chosen then"


def test_a_choice_is_no_unsaved_work(session, settle, tmp_path):
    session.files.save(tmp_path / "a.bozz")
    settle(session)
    assert not session.is_modified
    session.select_part(session.selected, ids(session)[0])
    settle(session)
    assert not session.is_modified


def test_what_was_undone_can_be_done_again_after_a_choice(session, settle):
    session.undo()
    settle(session)
    session.select_part(session.selected, ids(session)[0])
    session.redo()
    settle(session)
    assert len(ids(session)) == 3


def test_several_things_are_deleted_in_one_step(session, settle):
    model, steps = session.selected_model, session.history.position
    one, two, three = ids(session)
    session.duplicate(model.id)
    settle(session)
    copy = session.document.models[1].id
    session.select(model.id)
    session.delete_several([copy], {model.id: [one, three]}, [])
    settle(session)
    assert len(session.document) == 1
    assert ids(session) == [two]
    assert session.history.position == steps + 2
    assert session.history.undo_label == "Delete what is chosen"
    session.undo()
    settle(session)
    assert len(session.document) == 2
    assert ids(session) == [one, two, three]


def test_nothing_is_deleted_where_one_of_several_is_locked(session, settle):
    model = session.selected
    session.duplicate(model)
    settle(session)
    session.set_locked(session.document.models[1].id, True)
    before = session.document
    session.delete_several([m.id for m in before], {}, [])
    assert session.document is before
    assert "locked" in session.heard[-1].text


def test_a_dissolved_group_leaves_its_parts_where_they_stand(session, settle):
    """Also after the group was moved: silhouettes' groups carry their parts along."""
    from bozzetto.geometry import Placement
    from bozzetto.plugin.job import Job

    model = session.selected
    session.group_parts(model, ids(session)[:2])
    settle(session)
    group = session.chosen_group
    state = session.selected_model.state
    moved = tuple(
        replace(node, pose=Placement(offset=(0.0, 0.0, 40.0))) if node.id == group else node
        for node in state.nodes
    )
    moved_model = replace(session.selected_model, state=replace(state, nodes=moved))
    session.commit("Move", session.document.with_model(moved_model))
    settle(session)
    before = session.workbench.shapes(session.document, Job()).solids[0].mesh
    session.ungroup_chosen()
    settle(session)
    after = session.workbench.shapes(session.document, Job()).solids[0].mesh
    assert session.history.undo_label.startswith("Ungroup")
    assert not tree(session).groups
    assert np.allclose(after.bounds, before.bounds, atol=1e-3)


def test_every_edit_is_one_step_with_its_name(session, settle):
    model = session.selected
    one, two, three = ids(session)
    session.rename_part(model, one, "Body")
    session.set_part_visible(model, one, False)
    session.move_part(model, three, "", 0)
    session.group_parts(model, [one, two])
    session.duplicate_part(model, three)
    session.delete_part(model, two)
    labels = session.history.entries[-6:]
    assert labels[0] == "Rename to “Body”"
    assert labels[1] == "Hide “Body”"
    assert labels[2].startswith("Reorder “")
    assert labels[3] == "Group 2 parts"
    assert labels[4].startswith("Duplicate “")
    assert labels[5].startswith("Delete “")
    for _ in range(6):
        session.undo()
    assert ids(session) == [one, two, three]
    settle(session)


def test_a_slider_of_a_part_is_one_step(session, settle):
    count = len(session.history.entries)
    session.select_part(session.selected, ids(session)[1])
    for value in (1.1, 1.2, 1.3):
        session.set_part_parameter("inflation", value, dragging=True)
    session.end_drag()
    assert len(session.history.entries) == count + 1
    assert session.history.entries[-1] == "Inflation"
    assert [part.inflation for part in tree(session).parts] == [1.0, 1.3, 1.0]
    settle(session)


def test_handles_are_there_with_the_tool_they_belong_to(session, settle):
    def held():
        return {i.id.partition(":")[2] for _, i in session.scene.items() if isinstance(i, Handle)}

    model, (first, *_, last) = session.selected, ids(session)
    assert held() == set()
    session.activate_tool("arrange")
    assert held() == {last}
    session.select_part(model, first)
    settle(session)
    assert held() == {first}
    session.select(None)
    assert held() == set()
    session.select(model)
    assert held() == {first}
    session.activate_tool("draw")
    assert held() == set()


def test_a_locked_object_refuses_edits_but_can_be_looked_at(session):
    model, first = session.selected, ids(session)[0]
    session.set_locked(model, True)
    before = session.document
    session.rename_part(model, first, "Body")
    session.delete_part(model, first)
    session.set_part_parameter("inflation", 2.0)
    assert session.document is before
    assert all("locked" in notice.text for notice in session.heard[-3:])
    session.select_part(model, first)
    assert tree(session).selected == first


def test_parts_that_are_gone_are_no_catastrophe(session):
    before = session.document
    for act in (session.delete_part, session.duplicate_part):
        act(session.selected, "nobody")
    session.delete_part("no model", "nobody")
    assert session.document is before
    assert session.heard[-1].kind == "error"


def test_the_context_brings_the_picture_that_is_traced(session):
    from tests.document_kit import underlay

    assert session.context().underlay is None
    picture = replace(underlay(), visible=True)
    session.edit(edit.add_underlay, picture)
    assert session.context().underlay.pixels is picture.pixels
    session.set_underlay_visible(picture.id, False)
    assert session.context().underlay is None


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


class StandsIn:
    """A tool whose preview takes the place of the shape."""

    id, title, icon, hint, gesture = "stand", "Stand in", "", "Draw.", "ink"

    def preview(self, state, gesture, context):
        line = Lines(np.zeros((2, 3)), color="accent")
        return Scene((Layer("shape", (line,)),))

    def apply(self, state, gesture, context):
        nodes = tuple(replace(node, visible=k > 0) for k, node in enumerate(state.nodes))
        return replace(state, nodes=nodes)


def shapes_seen(session):
    """The layers called shape as a viewport shows them."""
    seen = session.scene.under(session.live_scene)
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

    session.live_changed.connect(look)
    session.scene_changed.connect(look)
    session.pen_moved(circle(session, 400))
    settle(session)
    assert previews[-1], "the preview is shown in place of the shape"
    session.pen_lifted(circle(session, 400))
    settle(session)
    assert set(counts) == {1}
    (after,) = shapes_seen(session)
    assert after is not before
    assert not session.live_scene.layers
    first_solid = previews.index(False, previews.index(True))
    assert not any(previews[first_solid:]), "the preview does not come back"
    assert isinstance(after.items[0], Shaded)


def test_a_gesture_that_only_chooses_is_no_step(session, settle, monkeypatch):
    class Chooses(StandsIn):
        def apply(self, state, gesture, context):
            return replace(state, selected=state.nodes[0].id)

    chooses = Chooses()
    monkeypatch.setattr(session.workbench, "tool", lambda modeler, name: chooses)
    assert tree(session).selected == ids(session)[-1]
    steps = session.history.entries
    session.tapped(10.0, 10.0)
    settle(session)
    assert tree(session).selected == ids(session)[0]
    assert session.history.entries == steps


def test_ink_into_a_moved_object_lies_under_the_pen(session, settle):
    from bozzetto.geometry import Placement

    turned = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 1.0, (0.0, 0.0, 30.0))
    session.set_placement(session.selected, turned)
    settle(session)
    stroke = Pen(session.camera).circle(480, 150, 50)
    session.pen_lifted(stroke)
    settle(session)
    assert len(ids(session)) == 4
    model = session.document.model(session.selected)
    layer = next(layer for layer in session.scene.layers if layer.name == "ink")
    ghosts = np.concatenate([item.points for item in layer.items if isinstance(item, Lines)])
    pixels, _ = session.camera.project(ghosts)
    gaps = np.linalg.norm(stroke.points[:, None] - pixels[None], axis=-1).min(1)
    assert gaps.max() < 0.5, model.placement


def test_the_commands_mean_the_chosen_part_or_else_the_object(session, settle):
    model, (one, two, three) = session.selected, ids(session)
    session.select_part(model, one)
    session.delete_chosen()
    assert ids(session) == [two, three]
    session.duplicate_chosen()
    assert len(ids(session)) == 3
    session.select_part(model, "")
    session.duplicate_chosen()
    assert len(session.document) == 2
    session.select(model)
    session.delete_chosen()
    assert [other.id for other in session.document] != [model]
    assert len(session.document) == 1
    settle(session)
