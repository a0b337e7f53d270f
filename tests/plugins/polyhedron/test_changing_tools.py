"""Circles on faces, chamfers, mirrors and copies by the pen: exact, typed, dragged, undone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import brep_mesh
from bozzetto.plugin import Drag, Tap
from bozzetto.testing import Pen, Shell
from bozzetto_polyhedron.drawing_on.cylinders import round_edges, walls_of
from bozzetto_polyhedron.model.changes import Chamfer, Copies, Mirror, Push
from bozzetto_polyhedron.model.state import Body, Measure
from bozzetto_polyhedron.solid.face_rings import edges_of, tangents
from bozzetto_polyhedron.solid.triangulation import genus_of, volume_of
from bozzetto_polyhedron.tools.chamfer import ChamferTool
from bozzetto_polyhedron.tools.mirror import MirrorTool
from bozzetto_polyhedron.tools.push import PushLoop
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.shell_bodies import MODELER, body, changed, facing, with_box
from tests.plugins.polyhedron.test_exact_planes import off_planes


@pytest.fixture
def box(shell) -> Shell:
    return with_box(shell, seed=9500)


def draw_circle(shell: Shell, radius: float = 15.0, corners: int = 90) -> np.ndarray:
    """Draw a circle, or a polygon, about the middle of the face that looks at the eye most."""
    made, number = body(shell), facing(shell)
    middle = made.vertices[list(made.faces[number][0])].mean(axis=0)
    at = np.linspace(0.0, 2.0 * np.pi, corners + 1)
    across = tangents(made.normals[number])
    ring = middle + radius * np.column_stack((np.cos(at), np.sin(at))) @ across
    pen = Pen(shell.camera, tremor=0.4, seed=9501)
    shell.draw(pen.along(shell.camera.project(ring)[0]), tool="loop")
    return middle


def tap(shell: Shell, point: np.ndarray, tool: str) -> None:
    (x, y), _ = shell.camera.project(point[None])[0][0], None
    shell.tap(float(x), float(y), tool=tool)


def seen_edge(shell: Shell) -> np.ndarray:
    """Return the ends of the edge whose two faces both look at the eye most."""
    made = body(shell)
    sight = made.normals @ shell.camera.axes[2]
    best = min(
        [edge for edge in edges_of(made.faces).tolist() if tuple(edge) not in around(shell)],
        key=lambda edge: sum(
            sight[k]
            for k, face in enumerate(made.faces)
            if any(set(edge) <= set(ring) for ring in face)
        ),
    )
    return made.vertices[best]


def around(shell: Shell) -> frozenset:
    """Return the edges of cylinders."""
    made = changed(shell)
    return round_edges(made.body, made.circles)


# -- circles -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["hole", "through", "boss"])
def test_a_circle_is_an_exact_cylinder(box, kind):
    before = volume_of(body(box))
    middle = draw_circle(box)
    (push,) = box.state.of_kind(Push)
    assert push.outline == "circle"
    box.set(diameter=24.0)
    box.set(
        **{"hole": {"depth": -10.0}, "through": {"through": True}, "boss": {"depth": 10.0}}[kind]
    )
    made = changed(box)
    walls, cut = walls_of(made.body, made.circles)
    assert (len(walls), cut) == (1, 0)
    assert walls[0].hollow == (kind != "boss")
    (brep,) = box.shapes().breps
    assert brep.is_closed
    assert sum(not face.surface.is_plane for face in brep.faces) >= 1
    corners = (mesh := brep_mesh(brep, 0.002)).vertices.astype(float)[mesh.faces]
    volume = np.einsum("tk,tk->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    low, high = walls[0].heights
    sign = 1.0 if kind == "boss" else -1.0
    assert volume - before == pytest.approx(sign * np.pi * 144.0 * (high - low), rel=5e-3)
    assert np.linalg.norm(walls[0].circle.center - middle) < 1.5


def test_a_hexagon_stays_a_hexagon(box):
    draw_circle(box, corners=6)
    (push,) = box.state.of_kind(Push)
    assert push.outline == "drawn"
    assert len(body(box).faces) == 6 + 7


def test_edges_between_the_sides_of_a_cylinder_are_not_shown(box):
    draw_circle(box)
    solid = next(layer for layer in box.scene().layers if layer.name == "solid")
    lines = [item for item in solid.items if hasattr(item, "starts")]
    assert sum(len(item.starts) for item in lines) == 12 + 2 * 48


def test_a_circle_that_is_cut_is_told(box):
    draw_circle(box)
    box.set(depth=-10.0)
    made, number = body(box), facing(box)
    middle = made.vertices[list(made.faces[number][0])].mean(axis=0)
    across = tangents(made.normals[number])
    ring = middle + np.array([(-5, -25), (5, -25), (5, 25), (-5, 25)]) @ across
    places = box.camera.project(np.concatenate((ring, ring[:1])))[0]
    box.draw(Pen(box.camera).along(places), tool="loop")
    box.set(through=True)
    told = [caution.message for caution in MODELER.cautions(box.state, box.solve())]
    assert any("cut by something else" in each for each in told)
    assert box.shapes().breps[0].is_closed


# -- chamfers ------------------------------------------------------------------------------------


def test_a_touch_bevels_an_edge_and_its_dot_widens_it(box):
    before = volume_of(body(box))
    ends = seen_edge(box)
    tap(box, ends.mean(axis=0), "chamfer")
    (chamfer,) = box.state.of_kind(Chamfer)
    length = float(np.linalg.norm(ends[1] - ends[0]))
    assert len(body(box).faces) == 7
    assert volume_of(body(box)) == pytest.approx(before - 0.5 * chamfer.width**2 * length)
    (handle,) = box.handles()
    seen = box.camera.project(np.array([handle.point, ends.mean(axis=0)]))[0]
    box.drag(handle.id, Pen(box.camera).along([seen[0], 2.0 * seen[0] - seen[1]]))
    wider = box.state.of_kind(Chamfer)[0].width
    assert wider == pytest.approx(2.0 * chamfer.width, rel=1e-3)
    box.undo()
    assert box.state.of_kind(Chamfer)[0].width == chamfer.width
    box.undo()
    assert len(body(box).faces) == 6


def test_a_drag_shows_the_chamfer_as_it_would_be_and_refuses_what_is_too_wide(box):
    ends = seen_edge(box)
    tap(box, ends.mean(axis=0), "chamfer")
    (handle,) = box.handles()
    seen = box.camera.project(np.array([handle.point, ends.mean(axis=0)]))[0]
    small = Pen(box.camera).along([seen[0], 1.5 * seen[0] - 0.5 * seen[1]])
    scene = box.preview(Drag(handle.id, small), tool=PushLoop())
    assert "solid" in {layer.name for layer in scene.layers}
    far = Pen(box.camera).along([seen[0], seen[0] + 40.0 * (seen[0] - seen[1])])
    with pytest.raises(UserError, match="wider than its face"):
        box.drag(handle.id, far)
    assert len(body(box).faces) == 7


def test_a_chamfer_keeps_its_edge_when_a_length_is_typed(box):
    ends = seen_edge(box)
    tap(box, ends.mean(axis=0), "chamfer")
    made = body(box)
    bevel = made.normals[np.abs(made.normals).max(axis=1) < 0.9][0]
    near = np.linalg.norm(made.vertices[edges_of(made.faces)].mean(axis=1) - ends.mean(0), axis=1)
    for line in edges_of(made.faces)[np.argsort(-near)]:
        try:
            tap(box, made.vertices[line].mean(axis=0), "dimension")
            break
        except UserError:
            continue
    (measure,) = box.state.of_kind(Measure)
    box.set(length=1.6 * measure.length)
    after = body(box)
    assert len(after.faces) == 7
    assert np.abs(after.normals - bevel).max(axis=1).min() < 1e-9


def test_a_touch_beside_all_edges_is_refused(box):
    with pytest.raises(UserError, match="no edge here"):
        box.tap(10.0, 10.0, tool="chamfer")
    made = body(box)
    with pytest.raises(UserError, match="edge"):
        tap(box, made.vertices[list(made.faces[facing(box)][0])].mean(axis=0), "chamfer")


def test_the_rim_of_a_circle_has_no_chamfer(box):
    draw_circle(box, radius=25.0)
    made = body(box)
    cap = set(made.faces[-1][0])
    rim = next(edge for edge in sorted(around(box)) if set(edge) <= cap)
    edge = made.vertices[list(rim)]
    with pytest.raises(UserError, match="straight edge"):
        tap(box, edge.mean(axis=0), "chamfer")


@pytest.mark.parametrize("tool", [ChamferTool(), MirrorTool()])
def test_a_pen_near_the_sheet_shows_what_a_touch_would_make(box, tool):
    point = seen_edge(box).mean(axis=0)
    if tool.id == "mirror":
        made = body(box)
        point = made.vertices[list(made.faces[facing(box)][0])].mean(axis=0)
    x, y = (float(value) for value in box.camera.project(point[None])[0][0])
    before = box.state
    shown = box.preview(Tap(x, y, box.camera), tool=tool)
    assert box.state is before
    box.tap(x, y, tool=tool.id)
    made = next(layer for layer in box.scene().layers if layer.name == "solid")
    preview = next(layer for layer in shown.layers if layer.name == "solid")
    assert (preview.items[0].mesh.vertices == made.items[0].mesh.vertices).all()


# -- mirrors and copies --------------------------------------------------------------------------


def test_a_touch_on_a_face_mirrors_the_body_with_its_holes(box):
    draw_circle(box)
    box.set(through=True)
    made = body(box)
    size = volume_of(made)
    other = int(np.argsort(made.normals[:6] @ box.camera.axes[2])[1])
    middle = made.vertices[list(made.faces[other][0])].mean(axis=0)
    tap(box, middle, "mirror")
    (mirror,) = box.state.of_kind(Mirror)
    whole = changed(box)
    assert volume_of(whole.body) == pytest.approx(2.0 * size, rel=1e-9)
    assert genus_of(whole.body) == 2
    assert off_planes(whole.body) < 1e-9
    assert len(walls_of(whole.body, whole.circles)[0]) == 2
    assert box.shapes().breps[0].is_closed
    box.put(box.state.with_node(replace(mirror, keeps="image")))
    assert volume_of(body(box)) == pytest.approx(size, rel=1e-9)
    box.undo()
    box.undo()
    assert volume_of(body(box)) == size


def test_a_stroke_puts_copies_along_an_axis(box):
    made = body(box)
    start = made.vertices[np.argmax(made.vertices @ box.camera.axes[0])]
    axis = np.array([1.0, 0.0, 0.0])
    line = np.array([start, start + 260.0 * axis])
    places = box.camera.project(line)[0]
    box.draw(Pen(box.camera, tremor=0.3, seed=3).along(places), tool="copies")
    (copies,) = box.state.of_kind(Copies)
    box.set(count=3)
    whole = body(box)
    assert volume_of(whole) == pytest.approx(3.0 * volume_of(made), rel=1e-9)
    span = np.ptp(whole.vertices, axis=0) - np.ptp(made.vertices, axis=0)
    assert span[0] == pytest.approx(260.0, rel=0.03)
    assert np.abs(span[1:]).max() < 1e-9
    assert len(box.shapes().breps) == 3
    assert all(brep.is_closed for brep in box.shapes().breps)
    box.undo()
    box.undo()
    assert not box.state.of_kind(Copies)
    assert copies.count >= 2


def test_copies_that_overlap_are_one(box):
    made = body(box)
    start = made.vertices[np.argmax(made.vertices @ box.camera.axes[0])]
    width = np.ptp(made.vertices[:, 0])
    places = box.camera.project(np.array([start, start + 0.5 * width * np.eye(3)[0]]))[0]
    box.draw(Pen(box.camera).along(places), tool="copies")
    box.set(count=2)
    assert len(body(box).faces) == 6
    assert len(box.shapes().breps) == 1


def test_a_stroke_beside_the_body_copies_nothing(box):
    with pytest.raises(UserError, match="begins on no body"):
        box.draw(Pen(box.camera).along([(20.0, 20.0), (200.0, 40.0)]), tool="copies")


def test_changes_follow_a_body_that_was_moved(box):
    tap(box, seen_edge(box).mean(axis=0), "chamfer")
    draw_circle(box)
    before = volume_of(body(box))
    box.run("ground")
    assert volume_of(body(box)) == pytest.approx(before, rel=1e-9)
    tap(box, seen_edge(box).mean(axis=0), "chamfer")
    assert len(box.state.of_kind(Chamfer)) == 2
    assert volume_of(body(box)) < before
    assert box.shapes().breps[0].is_closed


def test_a_change_whose_face_is_gone_is_left_out_and_told(box):
    draw_circle(box)
    tap(box, seen_edge(box).mean(axis=0), "chamfer")
    (chamfer,) = box.state.of_kind(Chamfer)
    box.put(box.state.with_node(replace(chamfer, width=1e4)))
    told = [caution.message for caution in MODELER.cautions(box.state, box.solve())]
    assert any("Chamfer 1 is left out" in each for each in told)
    assert len(body(box).faces) == 6 + 49
    assert len(box.state.of_kind(Body)) == 1


# -- right angles, face by face ------------------------------------------------------------------


def test_a_face_that_is_touched_keeps_its_slant_and_the_others_their_right_angles(shell):
    """A box with one slightly slanted wall: squared with the others, or left as it was drawn."""
    solid = OBJECTS["box"]
    vertices = fitted(solid)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    slanted = vertices.copy()
    wall = vertices[:, 0] == high[0]
    slanted[wall & (vertices[:, 2] == high[2]), 0] -= 0.05 * (high[2] - low[2])
    shell.open("bozzetto.polyhedron")
    shell.camera = VIEW
    shell.draw(*strokes_of(slanted, solid.edges))
    shell.run("next-answer")
    made = body(shell)
    assert not slants(made)
    number = int(np.argmax(made.normals[:, 0]))
    point = made.vertices[list(made.faces[number][0])].mean(axis=0)
    tap(shell, point, "slant")
    after = body(shell)
    assert number in slants(after)
    assert off_planes(after) < 1e-9
    assert any("told to" in each for each in after.told)
    others = [k for k in range(6) if abs(after.normals[k] @ after.normals[number]) < 0.5]
    assert not slants(after, others)
    tap(shell, point, "slant")
    assert not slants(body(shell))


def slants(made, faces=range(6)) -> list[int]:
    """Return the faces that are neither parallel nor at right angles to some other one."""
    cosines = np.abs(made.normals[list(faces)] @ made.normals[list(faces)].T)
    oblique = (cosines > 1e-9) & (cosines < 1.0 - 1e-9)
    return [face for face, row in zip(faces, oblique, strict=True) if row.any()]
