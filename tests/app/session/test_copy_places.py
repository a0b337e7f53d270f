"""Where copies lie: beside what they are copies of, in sight, and in nobody's way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Mesh, Placement, Shapes, Solid
from bozzetto.scene.display_list import Layer, Lines, Scene, Shaded
from bozzetto.view.camera import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_app.session.copy_places import extent_of, step_aside, step_beside

VIEWS = ("front", "back", "left", "right", "top", "bottom", "three-quarter")


def boxes(rng, count, spread=3000.0):
    low = rng.uniform(-spread, spread, (count, 3))
    return [np.array([at, at + 10.0 ** rng.uniform(0.0, 3.5, 3)]) for at in low]


def overlap(one, other):
    return bool(((one[0] < other[1]) & (other[0] < one[1])).all())


@pytest.mark.parametrize("seed", range(40))
def test_a_copy_lies_beside_all_there_is_to_the_right(seed):
    rng = np.random.default_rng(7_000 + seed)
    copied, others = boxes(rng, rng.integers(1, 4)), boxes(rng, rng.integers(0, 30))
    camera = standard_view(Camera(viewport=(900.0, 600.0)), VIEWS[seed % len(VIEWS)])
    step = np.array(step_beside(camera, copied, others))
    assert np.count_nonzero(step) == 1
    # It moves across the sheet to the right, by at least half of the way.
    assert step @ camera.axes[0] >= 0.5 * np.linalg.norm(step)
    around = np.array([np.min(copied, axis=0)[0], np.max(copied, axis=0)[1]])
    for box in (*copied, *others):
        assert not overlap(around + step, box)
    # Nowhere nearer is a free place with room on both sides, but for what the rounding takes.
    axis = int(np.argmax(np.abs(step)))
    width = (around[1] - around[0])[axis]
    assert abs(step[axis]) >= width
    room = 0.2 * max(width, np.ptp(around, axis=0).max() / 10.0)
    for share in np.linspace(0.01, 0.99, 99):
        nearer = around + share * step
        gap = np.zeros(3)
        gap[axis] = room + 0.1 * abs(step[axis])
        wide = np.array([nearer[0] - gap, nearer[1] + gap])
        assert any(overlap(wide, box) for box in (*copied, *others))


def test_cars_come_to_stand_side_by_side_where_the_view_shows_it():
    car = np.array([[0.0, -900.0, 0.0], [4400.0, 900.0, 1450.0]])
    view = Camera(viewport=(900.0, 600.0))
    assert step_beside(standard_view(view, "three-quarter"), [car], [])[0] == 0.0
    x, y, z = step_beside(standard_view(view, "front"), [car], [])
    assert (y, z) == (0.0, 0.0)
    assert abs(x) >= 4400.0


def test_what_has_no_extent_lies_a_little_aside():
    nowhere = np.full((2, 3), np.nan)
    camera = Camera(viewport=(900.0, 600.0))
    assert step_beside(camera, [nowhere], []) is None
    assert step_beside(camera, [np.ones((2, 3))], []) is None
    step = np.array(step_aside(camera))
    seen = camera.project(np.array([np.zeros(3), step]))[0]
    assert 10.0 < np.abs(seen[1] - seen[0]).max() < 60.0
    box = np.array([np.zeros(3), np.ones(3)])
    assert np.array_equal(
        step_beside(camera, [nowhere, box], [nowhere]), step_beside(camera, [box], [])
    )


def test_lines_count_where_there_are_no_surfaces_and_tools_never():
    line = Lines(np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 5.0]]))
    far = Lines(np.array([[0.0, 0.0, 0.0], [90.0, 90.0, 90.0]]))
    layers = (Layer("l", (line,)), Layer("t", (far,), tool="draw"), Layer("c", (far,), chosen=True))
    assert np.array_equal(extent_of(layers), [[0, 0, 0], [3, 4, 5]])
    assert np.isnan(extent_of(())).all()
    assert not len(Scene(layers).of_kinds(Shaded).points())


def block(size):
    import manifold3d

    made = manifold3d.Manifold.cube(size).to_mesh()
    return Shapes(solids=(Solid(Mesh(made.vert_properties[:, :3], made.tri_verts)),))


def test_bodies_that_are_duplicated_one_after_another_never_lie_in_each_other(make_session, settle):
    session = make_session()
    for number, size in enumerate(((400.0, 90.0, 60.0), (50.0, 50.0, 300.0))):
        model = session.workbench.sources.from_shapes("bozzetto.mesh", block(size), f"b{number}")
        at = Placement(offset=(0.0, 200.0 * number, 0.0))
        session.drawing.apply_model("Import", replace(model, placement=at), is_new=True)
    settle(session)
    rng = np.random.default_rng(7_100)
    for step in range(6):
        models = session.drawing.document.models
        chosen = rng.choice(len(models), size=1 + step % 2, replace=False)
        before = len(models)
        session.objects.duplicate(*(models[k].id for k in chosen))
        settle(session)
        assert len(session.drawing.document) == before + len(chosen)
    found = [session.solver.extent(model.id) for model in session.drawing.document]
    assert not any(overlap(a, b) for k, a in enumerate(found) for b in found[:k])


def test_a_copy_of_what_is_hidden_lies_beside_it_too(make_session, settle):
    session = make_session()
    model = session.workbench.sources.from_shapes("bozzetto.mesh", block((40.0, 9.0, 6.0)), "b")
    session.drawing.apply_model("Import", model, is_new=True)
    settle(session)
    (model,) = session.drawing.document.models
    session.objects.set_visible(model.id, False)
    settle(session)
    session.objects.duplicate(model.id)
    settle(session)
    assert not overlap(*(session.solver.extent(each.id) for each in session.drawing.document))


def made_of_two(make_session, settle):
    """A session with two bodies of one modeler, the second of which is selected."""
    session = make_session()
    for number in range(2):
        model = session.workbench.sources.from_shapes(
            "bozzetto.mesh", block((50.0, 50.0, 50.0)), f"b{number}"
        )
        at = Placement(offset=(0.0, 200.0 * number, 0.0))
        session.drawing.apply_model("Import", replace(model, placement=at), is_new=True)
    settle(session)
    return session


def test_undo_of_a_copy_selects_what_it_is_a_copy_of(make_session, settle):
    session = made_of_two(make_session, settle)
    first, second = session.drawing.document.models
    session.selection.select(first.id)
    session.objects.duplicate(first.id)
    copy = session.selection.id
    assert copy not in (first.id, second.id)
    session.drawing.undo()
    assert session.selection.id == first.id
    session.drawing.redo()
    session.drawing.undo()
    assert session.selection.id == first.id


def test_undo_of_what_was_begun_anew_selects_nothing(make_session, settle):
    """Else the next stroke would go into the earlier object."""
    session = made_of_two(make_session, settle)
    session.selection.select(None)
    model = session.workbench.sources.from_shapes("bozzetto.mesh", block((50.0, 50.0, 50.0)), "new")
    session.drawing.apply_model("Draw", model, is_new=True)
    assert session.selection.id == model.id
    session.drawing.undo()
    assert session.selection.id is None


def test_a_model_that_was_deleted_is_not_followed_by_a_choice_at_a_later_undo(make_session, settle):
    session = made_of_two(make_session, settle)
    first, second = session.drawing.document.models
    session.selection.select(first.id)
    session.selection.select(second.id)
    session.objects.delete(second.id)
    assert session.selection.id is None
    session.selection.select(None)
    session.objects.rename(first.id, "other")
    session.drawing.undo()
    assert session.selection.id is None
