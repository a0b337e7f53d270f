"""Products from the first stroke to a file, by strokes that a pen makes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import distances_to_polyline
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import Pen, Shell, same
from bozzetto.view import with_kind
from bozzetto.view.navigation import pan, zoom
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.rough_shapes import FollowedShape, RoughShape
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.report import border_of
from tests.plugins.product.pen_strokes import (
    FRONT,
    TOP_EDGES,
    draw_along,
    draw_rectangle,
    straight,
)

PEN = Pen(tremor=0.4, seed=2024)

MIDDLE = (0.0, 0.0, 60.0)


@pytest.fixture
def shell(tmp_path: Path) -> Shell:
    made = Shell(Registry(), tmp_path)
    made.open("bozzetto.product")
    return made


def drawn(shell: Shell) -> Shell:
    draw_rectangle(shell, PEN)
    return shell


def touch(shell: Shell, place: tuple[float, float, float]) -> None:
    x, y = FRONT.project(np.array([place]))[0][0]
    shell.tap(float(x), float(y), tool="loop")


def test_four_strokes_on_a_box_are_four_joined_curves_and_a_surface(shell: Shell) -> None:
    state = drawn(shell).state
    assert len(state.of_kind(Curve)) == len(state.joints) == 4
    (patch,) = state.of_kind(Patch)
    assert len(patch.boundary) == 4
    ends = {tuple(c.spline.control_points[k]) for c in state.of_kind(Curve) for k in (0, -1)}
    assert len(ends) == 4  # ends that are joined are the very same
    (surface,) = shell.shapes().surfaces
    assert surface.exact is not None
    area = 0.5 * np.linalg.norm(
        np.cross(*(surface.mesh.vertices[surface.mesh.faces[:, k]]
                   - surface.mesh.vertices[surface.mesh.faces[:, 0]] for k in (1, 2))), axis=1
    ).sum()  # fmt: skip
    assert area == pytest.approx(100 * 60, rel=0.02)


def test_the_same_strokes_give_the_same_product(tmp_path: Path) -> None:
    made = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        shell = Shell(Registry(), tmp_path / folder)
        shell.open("bozzetto.product")
        made.append(drawn(shell))
    one, two = (made_one.state for made_one in made)
    assert one.joints == two.joints
    assert [p.boundary for p in one.of_kind(Patch)] == [p.boundary for p in two.of_kind(Patch)]
    for first, second in zip(one.of_kind(Curve), two.of_kind(Curve), strict=True):
        assert (first.spline.control_points == second.spline.control_points).all()


def test_undo_takes_the_last_curve_and_its_surface_back(shell: Shell) -> None:
    after = drawn(shell).state
    assert shell.undo()
    assert not shell.state.of_kind(Patch)
    assert len(shell.state.of_kind(Curve)) == 3
    assert shell.redo()
    assert same(shell.state, after)


def test_a_saved_product_opens_as_it_was(shell: Shell) -> None:
    before = drawn(shell).state
    assert not shell.reopen()
    assert same(shell.state, before)


def test_a_stroke_over_the_last_curve_belongs_to_it(shell: Shell) -> None:
    shell.camera = FRONT
    start, end = TOP_EDGES[0]
    draw_along(shell, PEN, straight(start, end))
    draw_along(shell, PEN.but(seed=7), straight((-45.0, -30.0, 60.0), (40.0, -30.0, 60.0)))
    (curve,) = shell.state.of_kind(Curve)
    assert len(curve.strokes) == 2


def test_a_touch_switches_a_surface_off_and_on_again(shell: Shell) -> None:
    drawn(shell)
    touch(shell, MIDDLE)
    assert not shell.state.of_kind(Patch)
    draw_along(shell, PEN, straight((-20.0, -15.0, 60.0), (20.0, -15.0, 60.0)))
    assert not shell.state.of_kind(Patch)  # what was switched off stays so while the network grows
    touch(shell, MIDDLE)
    (patch,) = shell.state.of_kind(Patch)
    assert patch.confirmed
    assert not shell.state.rejected


def test_a_curve_across_makes_two_surfaces_of_one(shell: Shell) -> None:
    drawn(shell)
    draw_along(shell, PEN, straight((0.0, -30.0, 60.0), (0.0, 30.0, 60.0)))
    assert len(shell.state.of_kind(Patch)) == 2
    assert any(0.0 < m.at < 1.0 for joint in shell.state.joints for m in joint.meetings)


def test_what_is_drawn_over_a_curve_bends_it_and_the_surface_follows(shell: Shell) -> None:
    drawn(shell)
    bow = straight(*TOP_EDGES[0])
    bow[:, 1] -= 6.0 * np.sin(np.linspace(0.0, np.pi, len(bow)))
    draw_along(shell, PEN, bow, tool="modify")
    assert len(shell.state.joints) == 4
    border = shell.state.of_kind(Curve)[0].spline
    seen, wanted = FRONT.project(border.sampled(200))[0], FRONT.project(bow)[0]
    assert distances_to_polyline(wanted, seen).max() < 4.0
    (surface,) = shell.shapes().surfaces
    vertices = surface.mesh.vertices[border_of(surface.mesh)].astype(float)
    gaps = np.linalg.norm(border.value(border.foot_points(vertices)) - vertices, axis=1)
    assert (gaps < 1e-4).sum() > 10


def test_a_joint_that_is_dragged_takes_its_curves_along(shell: Shell) -> None:
    drawn(shell)
    handle = next(h for h in shell.handles() if h.id.startswith("joint"))
    at = FRONT.project(np.array([handle.point]))[0][0]
    pen = PEN.but(camera=FRONT, tremor=0.0)
    shell.drag(handle.id, pen.along([at, at - np.array((0.0, 25.0))]))
    moved = next(h for h in shell.handles() if h.id == handle.id)
    assert np.linalg.norm(np.subtract(moved.point, handle.point)) > 5.0
    ends = {tuple(c.spline.control_points[k]) for c in shell.state.of_kind(Curve) for k in (0, -1)}
    assert len(ends) == 4
    assert len(shell.state.of_kind(Patch)) == 1


def test_the_eraser_takes_a_curve_and_its_surface(shell: Shell) -> None:
    drawn(shell)
    pixels = FRONT.project(straight(*TOP_EDGES[0]))[0]
    shell.draw(PEN.but(camera=FRONT).along(pixels), tool="erase")
    assert len(shell.state.of_kind(Curve)) == 3
    assert not shell.state.of_kind(Patch)
    with pytest.raises(UserError):
        shell.draw(PEN.but(camera=FRONT).along([(5.0, 5.0), (60.0, 5.0)]), tool="erase")


def test_curves_stay_when_the_rough_shape_is_removed(shell: Shell) -> None:
    before = drawn(shell).state.of_kind(Curve)
    shell.run("remove-rough")
    assert not shell.state.of_kind(RoughShape)
    assert same(shell.state.of_kind(Curve), before)


def test_a_mirrored_curve_is_drawn_once_and_handed_over_twice(shell: Shell) -> None:
    shell.camera = FRONT
    shell.set(mirror=True)
    draw_along(shell, PEN, straight((-40.0, 0.0, 60.0), (-40.0, -30.0, 60.0)))
    draw_along(shell, PEN, straight((-40.0, -30.0, 60.0), (40.0, -30.0, 60.0)))
    draw_along(shell, PEN, straight((40.0, -30.0, 60.0), (40.0, 0.0, 60.0)))
    assert all(curve.mirrored for curve in shell.state.of_kind(Curve))
    curves = shell.shapes().curves
    assert len(curves) == 6
    for one, image in zip(curves[::2], curves[1::2], strict=True):
        assert (image.control_points == one.control_points * (1.0, -1.0, 1.0)).all()
    (surface,) = shell.shapes().surfaces
    vertices = {tuple(row) for row in surface.mesh.vertices.tolist()}
    assert np.allclose(surface.mesh.bounds[0, 1], -surface.mesh.bounds[1, 1])
    assert len(vertices) == len(surface.mesh.vertices)


def test_two_products_in_one_document_are_apart(shell: Shell) -> None:
    first = drawn(shell).model
    shell.open("bozzetto.product")
    draw_along(shell, PEN, straight((-20.0, -10.0, 60.0), (20.0, -10.0, 60.0)))
    assert len(shell.state.of_kind(Curve)) == 1
    assert same(shell.document.model(first.id).state, first.state)


def test_a_product_on_another_model_follows_it(shell: Shell) -> None:
    shell.open("bozzetto.silhouette")
    shell.camera = FRONT
    shell.draw(PEN.but(camera=FRONT).circle(600.0, 450.0, 220.0))
    source = shell.model
    shell.use("bozzetto.product")
    assert [part.source for part in shell.state.of_kind(FollowedShape)] == [source.id]
    pen = PEN.but(camera=FRONT)
    shell.draw(pen.along([(520.0, 430.0), (600.0, 400.0), (680.0, 430.0)]), tool="draw")
    (curve,) = shell.state.of_kind(Curve)
    assert curve.laid is not None
    before = shell.solve().curves[0].spline.control_points
    moved = source.placement.__class__(offset=(0.0, 0.0, 25.0))
    kept = shell.document.model(source.id)
    shell.history.apply("move", shell.document.with_model(replace(kept, placement=moved)))
    after = shell.solve().curves[0].spline.control_points
    assert np.allclose(after - before, (0.0, 0.0, 25.0), atol=1e-3)
    shell.run("remove-rough")  # the curve stays where it has gone with the other model
    assert not shell.state.of_kind(FollowedShape)
    assert shell.model.sources == ()
    left = shell.solve().curves[0].spline.control_points
    assert np.allclose(left, after, atol=1e-3)
    further = source.placement.__class__(offset=(0.0, 0.0, 90.0))
    kept = shell.document.model(source.id)
    shell.history.apply("move", shell.document.with_model(replace(kept, placement=further)))
    assert np.array_equal(shell.solve().curves[0].spline.control_points, left)


def test_what_was_guessed_of_a_curve_is_said_until_it_is_drawn_over(shell: Shell) -> None:
    beside = [(90.0, -10.0, 60.0), (130.0, -10.0, 60.0)]  # the box ends at 60
    draw_along(shell, PEN, straight(*beside))
    (curve,) = shell.state.of_kind(Curve)
    assert "beside every surface" in curve.told[0]
    modeler = ProductModeler()
    (draw, *_) = modeler.tools()
    assert draw.next_step(shell.state).sentence == curve.told[0]
    cautions = modeler.cautions(shell.state, shell.solve())
    assert any(curve.told[0] in caution.message for caution in cautions)
    draw_along(shell, PEN, straight(*np.add(beside, (0.0, 2.0, 0.0))), tool="modify")
    (curve,) = shell.state.of_kind(Curve)
    assert curve.told == ()


def test_a_curve_on_a_face_leaves_nothing_to_say(shell: Shell) -> None:
    draw_along(shell, PEN, straight((-40.0, -10.0, 60.0), (40.0, 10.0, 60.0)))
    assert shell.state.of_kind(Curve)[0].told == ()


SIDES = {
    "front": ((0.0, -40.0, 30.0), (40.0, 0.0, 0.0), (0.0, 0.0, 18.0)),
    "right": ((60.0, 0.0, 30.0), (0.0, 28.0, 0.0), (0.0, 0.0, 18.0)),
    "top": ((0.0, 0.0, 60.0), (45.0, 0.0, 0.0), (0.0, 28.0, 0.0)),
}
"""Sides of the box: their middles, and half the sides of rectangles on them."""


@pytest.mark.parametrize("side", SIDES)
def test_a_single_surface_faces_away_from_what_it_was_drawn_on(shell: Shell, side: str) -> None:
    """Pressure swells it away from the shape; on the front it went into it, back side outward."""
    middle, across, along = map(np.array, SIDES[side])
    corners = [middle + a * across + b * along for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    shell.camera = FRONT
    for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
        draw_along(shell, PEN, straight(start, end))
    out = np.array({"front": (0, -1, 0), "right": (1, 0, 0), "top": (0, 0, 1)}[side], float)
    (surface,) = shell.shapes().surfaces
    mesh = surface.mesh
    assert (mesh.vertex_normals() @ out).min() > 0.5
    (patch,) = shell.state.of_kind(Patch)
    shell.put(shell.state.with_node(replace(patch, pressure=1.0)))
    (swollen,) = shell.shapes().surfaces
    assert (swollen.mesh.vertices @ out).max() > (mesh.vertices @ out).max() + 1.0


def test_a_stroke_over_the_last_curve_belongs_to_it_in_an_enlarged_view(shell: Shell) -> None:
    seen = with_kind(FRONT, "orthographic")
    first, again = (straight((x, -30.0, 60.0), (50.0, -30.0, 60.0)) for x in (-50.0, -47.0))
    shell.camera = seen
    shell.draw(PEN.but(camera=seen).along(seen.project(first)[0]), tool="draw")
    shell.camera = zoom(pan(seen, 60.0, -30.0), 1.8, (500.0, 400.0))
    near = PEN.but(camera=shell.camera, seed=7)
    shell.draw(near.along(shell.camera.project(again)[0]), tool="draw")
    (curve,) = shell.state.of_kind(Curve)
    assert len(curve.strokes) == 2
    at = curve.spline.sampled(50)
    assert np.abs(at[:, 1:] - (-30.0, 60.0)).max() < 1.0
