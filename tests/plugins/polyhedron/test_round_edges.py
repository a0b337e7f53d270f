"""Edges rounded with a radius: exact cylinders, typed, dragged, kept; flat where they are cut."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import brep_mesh
from bozzetto.testing import Pen, Shell
from bozzetto_polyhedron.drawing_on.chamfer import chamfered, faces_at_edge, room_at_edge
from bozzetto_polyhedron.drawing_on.circles import SIDES
from bozzetto_polyhedron.drawing_on.cylinders import (
    brep_with_cylinders,
    round_edges,
    smooth_edges,
    walls_of,
)
from bozzetto_polyhedron.drawing_on.rounded_edges import (
    half_angle,
    largest_radius,
    rounded_edge,
    rounded_edge_of,
)
from bozzetto_polyhedron.model.changes import Fillet
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.solid.exact import exact_body
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import volume_of
from tests.plugins.polyhedron.figures_drawing_on import volume_beside_arc
from tests.plugins.polyhedron.shell_bodies import body, changed, with_box
from tests.plugins.polyhedron.test_exact_planes import off_planes
from tests.plugins.polyhedron.true_bodies import all_bodies, frustum


@pytest.fixture
def box(shell) -> Shell:
    return with_box(shell, seed=9600)


def exact(true) -> PlanarBody:
    return exact_body(Answer(true.vertices, true.faces, 1.0, 0.0, True), noise=0.0)


def true_body(name: str) -> PlanarBody:
    return exact(next(each for each in all_bodies() if each.name == name))


def edge_at(made: PlanarBody, convex: bool = True) -> tuple[int, int]:
    """Return the first upright edge whose faces meet at an outer or an inner angle."""
    for one, two in edges_of(made.faces).tolist():
        along = made.vertices[two] - made.vertices[one]
        if abs(along[2]) < 1e-9:
            continue
        first, second = faces_at_edge(made, (one, two))
        beside = [k for k, face in enumerate(made.faces) if {one, two} <= set(face[0])]
        if ((first + second) @ made.normals[beside].sum(axis=0) < 0) == convex:
            return one, two
    raise AssertionError("no such edge")


def exact_volume(made: PlanarBody, circles) -> float:
    mesh = brep_mesh(brep_with_cylinders(made, circles), 1e-4)
    corners = mesh.vertices.astype(float)[mesh.faces]
    return float(np.einsum("tk,tk->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)


@pytest.mark.parametrize(("name", "convex"), [("box", True), ("L", True), ("L", False)])
def test_an_edge_is_cut_or_filled_by_what_is_beside_its_arc(name, convex):
    made = true_body(name)
    edge = edge_at(made, convex)
    radius = 0.25 * largest_radius(made, edge)
    after, arc = rounded_edge(made, edge, radius)
    length = float(np.linalg.norm(np.subtract(*made.vertices[list(edge)])))
    beside = (1.0 - 0.25 * np.pi) * radius**2 * length
    gained = exact_volume(after, [arc]) - volume_of(made)
    assert gained == pytest.approx(-beside if convex else beside, rel=2e-3)
    assert off_planes(after) < 1e-9
    walls, cut = walls_of(after, [arc])
    assert (len(walls), cut) == (1, 0)
    brep = brep_with_cylinders(after, [arc])
    assert brep.is_closed
    assert sum(not face.surface.is_plane for face in brep.faces) == 1
    assert len(brep.faces) == len(made.faces) + 1


def test_an_arc_touches_both_faces_and_ends_obliquely_as_an_ellipse():
    made = exact(frustum(3))
    for edge in edges_of(made.faces).tolist():
        pair = (int(edge[0]), int(edge[1]))
        radius = 0.2 * largest_radius(made, pair)
        after, arc = rounded_edge(made, pair, radius)
        brep = brep_with_cylinders(after, [arc])
        assert brep.is_closed
        round_faces = [face for face in brep.faces if not face.surface.is_plane]
        assert round_faces
        for face in round_faces:
            low, high = (np.array(span) for span in face.surface.ranges)
            u, v = np.meshgrid(np.linspace(*low, 7), np.linspace(*high, 5))
            spokes = face.surface.value(u.ravel(), v.ravel()).reshape(-1, 3) - arc.center
            away = np.linalg.norm(spokes - np.outer(spokes @ arc.axis, arc.axis), axis=1)
            assert away == pytest.approx(radius, rel=1e-12)
        beside = [made.normals[k] for k, face in enumerate(made.faces) if set(pair) <= set(face[0])]
        offsets = [
            made.offsets[k] for k, face in enumerate(made.faces) if set(pair) <= set(face[0])
        ]
        for normal, offset in zip(beside, offsets, strict=True):
            assert abs(offset - normal @ arc.center) == pytest.approx(radius, rel=1e-9)


@pytest.mark.parametrize("width", [0.1, 0.3])
def test_an_arc_that_ends_in_two_faces_is_exact_in_both(width: float) -> None:
    """The end of an upright edge is bevelled, and the radius reaches past the bevel."""
    box = true_body("box")
    one, two = edge_at(box)
    top = max((one, two), key=lambda v: box.vertices[v][2])
    over = next(e for e in edges_of(box.faces).tolist() if top in e and {one, two} - set(e))
    radius = 0.6 * largest_radius(box, (one, two))
    made = chamfered(box, (over[0], over[1]), width * radius)
    below = box.vertices[one if top == two else two]
    edge = next(
        (int(a), int(b))
        for a, b in edges_of(made.faces)
        if np.abs((made.vertices[[a, b]] - below)[:, :2]).max() < 1e-9
    )
    after, arc = rounded_edge(made, edge, radius)
    walls, cut = walls_of(after, [arc])
    assert (len(walls), cut) == (1, 0)
    assert sorted(len(end) for end in walls[0].ends) == [1, 2]
    for place in walls[0].places.values():
        spoke = place - arc.center
        away = np.linalg.norm(spoke - (spoke @ arc.axis) * arc.axis)
        assert away == pytest.approx(radius, rel=1e-12)
    brep = brep_with_cylinders(after, [arc])
    assert brep.is_closed
    change = volume_beside_arc(made, edge, radius)
    assert exact_volume(after, [arc]) == pytest.approx(volume_of(made) + change, rel=1e-6)


def test_a_radius_without_room_is_refused_with_the_largest_one():
    made = true_body("box")
    edge = edge_at(made)
    most = room_at_edge(made, edge) * np.tan(half_angle(made, edge))
    with pytest.raises(UserError, match=f"less than {most:.4g} mm"):
        rounded_edge(made, edge, most)
    for radius in (0.0, -1.0, np.nan):
        with pytest.raises(UserError, match="above zero"):
            rounded_edge(made, edge, radius)


def test_strips_that_something_else_cuts_stay_flat():
    made = true_body("box")
    edge = edge_at(made)
    after, arc = rounded_edge(made, edge, 0.2 * largest_radius(made, edge))
    assert rounded_edge_of(after, arc, range(3)) is None
    other = next(
        e
        for e in edges_of(after.faces).tolist()
        if tuple(e) not in round_edges(after, [arc]) and not set(e) & set(edge)
    )
    both, second = rounded_edge(after, (other[0], other[1]), arc.radius)
    walls, cut = walls_of(both, [arc, second])
    assert len(walls) + cut == 2
    assert brep_with_cylinders(both, [arc, second]).is_closed


def test_a_touch_rounds_an_edge_and_its_radius_is_typed_dragged_and_kept(box):
    before = volume_of(body(box))
    made = body(box)
    sight = made.normals @ box.camera.axes[2]
    edge = min(
        edges_of(made.faces).tolist(),
        key=lambda e: sum(sight[k] for k, f in enumerate(made.faces) if set(e) <= set(f[0])),
    )
    (x, y) = box.camera.project(made.vertices[edge].mean(axis=0)[None])[0][0]
    box.tap(float(x), float(y), tool="round")
    (fillet,) = box.state.of_kind(Fillet)
    assert fillet.radius > 0.0
    box.set(radius=8.0)
    arc = changed(box).circles[0]
    assert arc.radius == pytest.approx(8.0, rel=1e-12)
    assert arc.sides == SIDES // 4
    assert len(smooth_edges(body(box), [arc])) == arc.sides - 1
    (brep,) = box.shapes().breps
    assert brep.is_closed
    smaller = volume_of(body(box))
    assert smaller < before
    (handle,) = box.handles()
    into = np.subtract(handle.point, made.vertices[edge].mean(axis=0))
    there = np.array([handle.point, np.add(handle.point, into)])
    box.drag(handle.id, Pen(box.camera).along(box.camera.project(there)[0]))
    assert box.state.of_kind(Fillet)[0].radius == pytest.approx(16.0, rel=1e-3)
    box.undo()
    box.save()
    box.reopen()
    assert volume_of(body(box)) == smaller
