"""Lines added to solids in any view: boxes on boxes, pockets, sheets, joints; and the eraser."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from bozzetto.plugin import Ink
from bozzetto.testing import Pen, Shell
from bozzetto.view import turn
from bozzetto_polyhedron.model.changes import Added, Join
from bozzetto_polyhedron.model.state import Body
from bozzetto_polyhedron.solid.triangulation import genus_of, volume_of
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.tools.draw_lines import DrawLines
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.shell_bodies import MODELER, body, changed, with_box
from tests.plugins.polyhedron.test_exact_planes import off_planes


@pytest.fixture
def box(shell) -> Shell:
    return with_box(shell, seed=9400, turned=(12.0, -9.0))


def top(made) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return a corner of the face that looks up most, two sides of it, and its normal."""
    number = int(np.argmax(made.normals[:, 2]))
    a, b, _, d = made.vertices[list(made.faces[number][0])]
    return a, b - a, d - a, made.normals[number]


def box_lines(made, low=(0.3, 0.3), high=(0.7, 0.7), height=30.0) -> list[np.ndarray]:
    """Return the twelve lines of a box that stands on that face, at shares of its sides."""
    corner, along, across, normal = top(made)
    ring = [corner + s * along + t * across
            for s, t in (low, (high[0], low[1]), high, (low[0], high[1]))]  # fmt: skip
    far = [point + height * normal for point in ring]
    lines = []
    for k in range(4):
        after = (k + 1) % 4
        lines += [(ring[k], ring[after]), (ring[k], far[k]), (far[k], far[after])]
    return [np.array(line) for line in lines]


def draw(shell: Shell, lines, jitter: float = 1.0, seed: int = 1) -> None:
    rng = np.random.default_rng(seed)
    pen = Pen(shell.camera, tremor=0.3 * jitter, seed=seed)
    for line in lines:
        places = shell.camera.project(np.asarray(line))[0]
        shell.draw(pen.along(places + jitter * rng.normal(size=(2, 2))), tool="draw")


def ordered(lines: list[np.ndarray]) -> list[np.ndarray]:
    """Return the lines of a box as people draw them: what lies on the face first."""
    return [lines[k] for start in range(3) for k in range(start, 12, 3)]


SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    "turned",
    [
        (12.0, -9.0),
        pytest.param((215.0, 4.0), marks=SLOW),
        pytest.param((-70.0, 15.0), marks=SLOW),
    ],
)
def test_a_box_drawn_on_a_box_joins_it(box, turned):
    box.camera = turn(VIEW, *turned)
    before = body(box)
    lines = box_lines(before)
    draw(box, ordered(lines))
    made = body(box)
    _, along, across, _ = top(before)
    wanted = 0.16 * np.linalg.norm(np.cross(along, across)) * 30.0
    assert len(box.state.of_kind(Body)) == 1
    assert len(made.faces) == 11
    assert genus_of(made) == 0
    assert off_planes(made) < 1e-9
    assert volume_of(made) - volume_of(before) == pytest.approx(wanted, rel=0.15)
    (brep,) = box.shapes().breps
    assert brep.is_closed


def test_a_box_drawn_into_a_box_is_cut_out(box):
    before = body(box)
    draw(box, ordered(box_lines(before, height=-20.0)))
    made = body(box)
    if changed(box).lines.size:  # lines that show the far side may close otherwise
        pytest.fail("the pocket did not close")
    assert volume_of(made) < volume_of(before)
    assert len(made.faces) == 11


def test_a_box_in_the_corner_of_a_face_shares_its_planes(box):
    before = body(box)
    draw(box, ordered(box_lines(before, (0.0, 0.0), (0.5, 0.5))))
    made = body(box)
    assert len(made.faces) == 9  # the two outer walls go on
    assert off_planes(made) < 1e-9


def test_the_last_line_shows_what_it_will_make(box):
    lines = ordered(box_lines(body(box)))
    draw(box, lines[:-1])
    places = box.camera.project(lines[-1])[0]
    shown = box.preview(Ink((Pen(box.camera).along(places),)), tool=DrawLines())
    solid = next(layer for layer in shown.layers if layer.name == "solid")
    draw(box, lines[-1:], jitter=0.0)
    assert len(body(box).faces) == 11
    assert solid.items[0].mesh.vertices[:, 2].max() > top(body(box))[0][2] - 1e-3


def test_two_views_make_one_box(box):
    before = body(box)
    lines = ordered(box_lines(before))
    draw(box, lines[:8])
    assert len(changed(box).lines) == 8
    box.camera = turn(box.camera, 25.0, 5.0)
    draw(box, lines[8:], seed=2)
    assert len(box.state.of_kind(Added)) == 2
    assert len(body(box).faces) == 11
    assert len(changed(box).lines) == 0


def test_lines_that_do_not_close_stay_and_are_told(box):
    draw(box, ordered(box_lines(body(box)))[:3])
    cautions = MODELER.cautions(box.state, box.solve())
    assert any("3 added lines bound no solid yet" in each.message for each in cautions)
    assert "added" in {layer.name for layer in box.scene().layers}
    box.undo()
    assert len(changed(box).lines) == 2


def test_the_eraser_takes_an_added_line_away_in_any_view(box):
    lines = ordered(box_lines(body(box)))
    draw(box, lines)
    assert len(body(box).faces) == 11
    box.camera = turn(box.camera, -20.0, 6.0)
    places = box.camera.project(lines[-1])[0]
    box.draw(Pen(box.camera).along(places), tool="erase")
    assert len(body(box).faces) == 6
    assert len(box.state.of_kind(Added)[0].strokes) == 11


@pytest.mark.slow
def test_a_file_keeps_added_lines(box):
    draw(box, ordered(box_lines(body(box))))
    before = volume_of(body(box))
    box.save()
    box.reopen()
    assert volume_of(body(box)) == before


def test_a_stroke_beside_all_solids_begins_a_new_body(box):
    places = [(40.0, 40.0), (160.0, 60.0)]
    box.draw(Pen(box.camera).along(places), tool="draw")
    assert len(box.state.of_kind(Body)) == 2
    assert not box.state.of_kind(Added)


@pytest.fixture
def two(shell) -> Shell:
    """Two boxes beside one another on the sheet."""
    solid = OBJECTS["box"]
    shell.open("bozzetto.polyhedron")
    shell.camera = VIEW
    for number, at in enumerate(((-55.0, 0.0, 40.0), (55.0, 0.0, 40.0))):
        shell.draw(
            *strokes_of(fitted(solid, 50.0, at), solid.edges, jitter=0.5, seed=9410 + number)
        )
        shell.run("next-answer")
        shell.run("new-body")
    shell.put(replace(shell.state, selected="n1"))
    return shell


def facing(made, other) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of the face of a box that looks at a place."""
    toward = other - made.vertices.mean(axis=0)
    number = int(np.argmax(made.normals @ (toward / np.linalg.norm(toward))))
    return made.vertices[list(made.faces[number][0])], made.normals[number]


def test_strokes_from_corner_to_corner_bridge_two_solids(two):
    one, other = body(two, "n1"), body(two, "n2")
    near, _ = facing(one, other.vertices.mean(axis=0))
    far, _ = facing(other, one.vertices.mean(axis=0))
    two.camera = turn(VIEW, 8.0, 3.0)
    away = np.linalg.norm(near[:, None] - far[None], axis=2)
    partner = far[linear_sum_assignment(away)[1]]
    draw(two, [np.array(pair) for pair in zip(near, partner, strict=True)], jitter=0.0)
    made = body(two)
    assert len(two.state.of_kind(Join)) == 1
    assert volume_of(made) > volume_of(one) + volume_of(other)
    assert genus_of(made) == 0
    assert len(two.shapes().breps) == 1
    machine = moving(two.state)
    assert list(machine.numbers) == ["n1"]
    assert machine.number_of("n2") == 0
    assert len(machine.machine.rest.places) == 1
    volume = machine.machine.assembly.masses[0] / two.state.node("n1").density * 1e9
    assert volume == pytest.approx(volume_of(made), rel=1e-9)


def test_a_stroke_to_a_corner_brings_the_other_solid_there(box):
    """The depth of a second drawing is not known: a stroke from face to corner tells it."""
    first = body(box)
    corner, along, across, _ = top(first)
    size = 0.4 * min(np.linalg.norm(along), np.linalg.norm(across))
    standing = fitted(OBJECTS["box"], size)
    low = standing.min(axis=0)
    standing = standing - (*standing[:, :2].mean(axis=0), low[2]) + corner + 0.5 * (along + across)
    box.run("new-body")
    box.draw(*strokes_of(standing, OBJECTS["box"].edges, camera=box.camera, seed=9420))
    box.run("next-answer")
    box.put(replace(box.state, selected="n1"))
    second = body(box, "n2")
    assert len(box.shapes().breps) == 2
    low = second.vertices[second.vertices[:, 2] < second.vertices[:, 2].mean()]
    foot = low[np.argmin((low - box.camera.eye) @ box.camera.axes[2])]
    draw(box, [np.array((corner + 0.2 * along + 0.1 * across, foot))], jitter=0.0)
    assert len(box.state.of_kind(Join)) == 1
    made = body(box)
    assert volume_of(made) == pytest.approx(volume_of(first) + volume_of(second), rel=1e-6)
    assert len(made.faces) == 11
    assert len(box.shapes().breps) == 1
    box.undo()
    assert len(box.shapes().breps) == 2
