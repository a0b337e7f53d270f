"""Loops on faces: drawn in another view, dragged in and out, cut through."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.parameters import idle_parameters, valued_fields
from bozzetto.testing import Pen, Shell
from bozzetto_polyhedron.model.changes import Push
from bozzetto_polyhedron.solid.triangulation import genus_of, volume_of
from tests.plugins.polyhedron.shell_bodies import body, facing, with_box


@pytest.fixture
def box(shell) -> Shell:
    return with_box(shell, seed=9300)


def face_on_top(shell: Shell) -> np.ndarray:
    """Return the corners of the face that looks at the eye most, mm."""
    made = body(shell)
    return made.vertices[list(made.faces[facing(shell)][0])]


def loop(shell: Shell, share: float = 0.4, corner: bool = False) -> None:
    """Draw a smaller copy of that face about its middle."""
    corners = face_on_top(shell)
    middle = corners.mean(axis=0)
    ring = middle + share * (corners - middle)
    places = shell.camera.project(np.concatenate((ring, ring[:1])))[0]
    shell.draw(Pen(shell.camera).along(places), tool="loop")


def test_a_loop_becomes_a_boss_and_a_pocket_of_the_same_volume(box):
    base = volume_of(body(box))
    loop(box)
    (push,) = box.state.of_kind(Push)
    boss = volume_of(body(box)) - base
    assert boss > 0.0
    box.set(depth=-push.depth)
    assert volume_of(body(box)) - base == pytest.approx(-boss, rel=1e-9)
    box.set(depth=0.0)
    assert volume_of(body(box)) == pytest.approx(base, rel=1e-12)


def test_through_is_a_tunnel_with_exact_planes(box):
    loop(box)
    box.set(through=True)
    made = body(box)
    assert genus_of(made) == 1
    for rings, normal, offset in zip(made.faces, made.normals, made.offsets, strict=True):
        points = made.vertices[[corner for ring in rings for corner in ring]]
        assert np.abs(points @ normal - offset).max() < 1e-9
    (brep,) = box.shapes().breps
    assert brep.is_closed


@pytest.mark.parametrize(
    ("meanwhile", "value"), [({"through": True}, {"depth": 31.0}), ({}, {"diameter": 17.0})]
)
def test_what_is_said_to_change_nothing_changes_nothing(box, meanwhile, value):
    loop(box)
    box.set(**meanwhile)
    push = box.state.of_kind(Push)[0]
    assert set(value) <= set(idle_parameters(valued_fields(push)))
    before = body(box).vertices
    box.set(**value)
    assert body(box).vertices == pytest.approx(before, abs=0.0)


def test_its_dot_is_dragged_along_the_normal(box):
    loop(box)
    box.set(depth=0.0)
    (handle,) = box.handles()
    normal = np.cross(*(np.diff(face_on_top(box)[:3], axis=0)))
    normal /= np.linalg.norm(normal)
    for depth in (12.0, -12.0):
        there = np.array([handle.point, np.add(handle.point, depth * normal)])
        box.drag(handle.id, Pen(box.camera).along(box.camera.project(there)[0]))
        assert box.state.of_kind(Push)[0].depth == pytest.approx(depth, rel=1e-3)
    box.undo()
    assert box.state.of_kind(Push)[0].depth == pytest.approx(12.0, rel=1e-3)


def test_four_strokes_make_a_loop(box):
    corners = face_on_top(box)
    ring = corners.mean(axis=0) + 0.4 * (corners - corners.mean(axis=0))
    places = box.camera.project(ring)[0]
    pen = Pen(box.camera)
    sides = [pen.along([places[k], places[(k + 1) % 4]]) for k in range(4)]
    box.draw(*sides, tool="loop")
    assert len(box.state.of_kind(Push)) == 1
    assert len(body(box).faces) == 11


def test_a_loop_beside_the_body_and_one_without_a_body_are_refused(box):
    with pytest.raises(UserError):
        box.draw(Pen(box.camera).circle(60.0, 60.0, 30.0), tool="loop")
    box.open("bozzetto.polyhedron")
    with pytest.raises(UserError, match="no solid to draw on"):
        box.draw(Pen(box.camera).circle(600.0, 450.0, 30.0), tool="loop")


def test_a_file_and_the_ground_keep_the_loop(box):
    loop(box)
    before = volume_of(body(box))
    box.save()
    box.reopen()
    assert volume_of(body(box)) == before
    box.run("ground")
    assert volume_of(body(box)) == pytest.approx(before, rel=1e-9)


@pytest.mark.parametrize("bow", [0.0, 1.5, 12.0, 40.0])
def test_a_line_that_does_not_close_on_a_face_is_no_circle(box, bow):
    corners = face_on_top(box)
    places = box.camera.project(corners.mean(axis=0)[None])[0][0] + np.outer(
        np.linspace(-40.0, 40.0, 30), (1.0, 0.4)
    )
    places[:, 1] += bow * np.sin(np.linspace(0.0, np.pi, 30))
    with pytest.raises(UserError, match="close"):
        box.draw(Pen(box.camera).along(places), tool="loop")
    assert box.state.of_kind(Push) == ()
