"""Curves in a drawing plane and on surfaces of other objects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document.storage.state_codec import decode_state, encode_state
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Ink, Tap
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto_symmetry.commands import all_commands
from bozzetto_symmetry.model.canvas import DrawingPlane, LaidInk
from bozzetto_symmetry.model.state import Curve, EndSnap, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.tools.draw_curve import DrawCurve
from bozzetto_symmetry.tools.plane import SetPlane
from bozzetto_symmetry.view.drawing_plane import PLANE_HANDLE
from tests.plugins.symmetry import scenes as s

VIEW = s.camera(35, 25, pixels=800.0)
CONTEXT = Context(camera=VIEW)
S = np.linspace(0.0, 1.0, 300)
LEVEL = DrawingPlane((0.0, 0.0, 15.0), (0.0, 0.0, 1.0))
SECTION = DrawingPlane((10.0, 0.0, 0.0), (1.0, 0.0, 0.0))
AT = SymmetryState(lay="plane", drawing_plane=LEVEL, snapping=False)


def ink(curve: s.Array, noise: float = 0.0, closed: bool = False) -> Ink:
    random = np.random.default_rng(3)
    pixels = s.drawn(curve, VIEW, noise=noise, random=random, closed=closed)
    return Ink((Stroke(pixels[:, 0], pixels[:, 1], VIEW),))


def trace(state: SymmetryState) -> Trace:
    assert state.chosen is not None
    return trace_of(state.chosen, state)


def draw(state: SymmetryState, curve: s.Array, context: Context = CONTEXT, **hand) -> SymmetryState:
    return DrawCurve().apply(state, ink(curve, **hand), context)


SIDE = np.column_stack((-60 + 120 * S, 20 + 10 * np.sin(4 * S), np.full(300, 15.0)))
ARCH = np.column_stack((np.full(300, 10.0), -40 + 80 * S, 20 * np.sin(np.pi * S)))


@pytest.mark.parametrize(("noise", "most"), [(0.0, 0.05), (1.0, 2.5)])
def test_one_side_makes_a_curve_of_a_plane_and_its_image(noise: float, most: float) -> None:
    made = trace(draw(AT, SIDE, noise=noise))
    assert made.reading == "pair"
    assert s.distances(made.points, SIDE).max() < most
    assert np.abs(made.points[:, 2] - 15.0).max() < 1e-4


def test_a_section_drawn_over_the_centre_plane_is_its_own_mirror_image() -> None:
    state = replace(AT, drawing_plane=SECTION)
    made = trace(draw(state, ARCH, noise=1.0))
    assert made.reading == "self"
    assert s.distances(made.points, ARCH).max() < 1.5
    np.testing.assert_allclose(made.points[::-1] * MIRROR, made.points, atol=1e-9)
    round_ = 2 * np.pi * S[:-1] + 1.0
    ring = np.column_stack((np.full(299, 10.0), 30 * np.cos(round_), 20 * np.sin(round_)))
    made = trace(draw(state, ring, noise=0.5, closed=True))
    assert made.curve is not None
    assert made.curve.closed
    assert made.reading == "self"
    assert s.distances(made.points, ring, closed=True).max() < 1.0


def test_in_the_centre_plane_it_is_a_curve_in_that() -> None:
    curve = np.column_stack((-60 + 120 * S, 0 * S, 30 * np.sin(3 * S)))
    made = trace(draw(replace(AT, drawing_plane=DrawingPlane()), curve))
    assert made.reading == "plane"
    assert (made.points[:, 1] == 0.0).all()
    assert s.distances(made.points, curve).max() < 0.05


def test_the_told_uncertainty_is_that_of_a_hand() -> None:
    ratios = []
    for seed in range(12):
        random = np.random.default_rng(600 + seed)
        pixels = s.drawn(SIDE, VIEW, noise=1.0, random=random)
        state = DrawCurve().apply(AT, Ink((Stroke(pixels[:, 0], pixels[:, 1], VIEW),)), CONTEXT)
        made = trace(state)
        inner = made.points[20:-20]
        ratios.append(np.mean((s.distances(inner, SIDE) / made.sigma[20:-20]) ** 2))
    assert 0.7 < np.sqrt(np.mean(ratios)) < 1.3


def test_a_plane_seen_edge_on_is_refused_in_words() -> None:
    eye = np.asarray(VIEW.eye)
    edge = DrawingPlane((0.0, 0.0, 0.0), tuple(np.cross(eye, (0.0, 0.0, 1.0))))
    with pytest.raises(UserError, match="edge-on"):
        draw(replace(AT, drawing_plane=edge), SIDE)
    with pytest.raises(UserError, match="Plane"):
        draw(replace(AT, drawing_plane=None), SIDE)


# -- the plane -----------------------------------------------------------------------------------


def touch(state: SymmetryState, place: tuple[float, ...]) -> SymmetryState:
    (seen,), _ = VIEW.project([place])
    return SetPlane().apply(state, Tap(float(seen[0]), float(seen[1]), VIEW), CONTEXT)


def test_touches_make_a_plane_of_the_box_through_two_and_through_three_places() -> None:
    corner, far, third = (100.0, 50.0, 50.0), (-100.0, 50.0, -50.0), (100.0, -50.0, -50.0)
    state = SymmetryState()
    normals = []
    for place in (corner, far, third):
        state = touch(state, place)
        plane = state.drawing_plane
        assert plane is not None
        known = (corner, far, third)[: len(state.plane_places)]
        off = (np.asarray(known) - plane.point) @ np.asarray(plane.normal)
        assert np.abs(off).max() < 1e-6
        normals.append(plane.normal)
    assert sorted(np.abs(normals[0])) == [0.0, 0.0, 1.0]
    assert (np.abs(normals[1]) < 1e-12).any()
    assert state.lay == "plane"
    assert len(touch(state, corner).plane_places) == 1


def test_a_touched_end_holds_the_tangent_of_its_curve() -> None:
    drawn_curve = draw(AT, SIDE)
    made = trace(drawn_curve).curve
    assert made is not None
    end = made.spline.value(made.spline.range[1:])[0]
    plane = touch(drawn_curve, tuple(end)).drawing_plane
    assert plane is not None
    way = made.spline.derivative(made.spline.range[1:])[0]
    assert abs(float(way @ np.asarray(plane.normal))) < 1e-6 * np.linalg.norm(way)


def test_nothing_under_the_pen_is_told() -> None:
    with pytest.raises(UserError, match="nothing here"):
        SetPlane().apply(SymmetryState(), Tap(3.0, 3.0, VIEW), CONTEXT)


def test_its_handle_moves_it_along_its_normal() -> None:
    (begin, end), _ = VIEW.project([(0.0, 0.0, 15.0), (0.0, 0.0, 35.0)])
    path = Stroke(np.array((begin[0], end[0])), np.array((begin[1], end[1])), VIEW)
    moved = SetPlane().apply(AT, Drag(PLANE_HANDLE, path, shift=True), CONTEXT)
    assert moved.drawing_plane is not None
    assert moved.drawing_plane.point == pytest.approx((0.0, 0.0, 35.0), abs=1e-4)
    assert moved.drawing_plane.normal == LEVEL.normal


# -- surfaces ------------------------------------------------------------------------------------


def bump() -> Mesh:
    """A smooth hill over the whole box, symmetric about y = 0."""
    x, y = np.meshgrid(np.linspace(-120, 120, 121), np.linspace(-80, 80, 81), indexing="ij")
    z = hill(x, y)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (number[i, j].ravel() for i, j in (
        (slice(-1), slice(-1)), (slice(1, None), slice(-1)),
        (slice(1, None), slice(1, None)), (slice(-1), slice(1, None))))  # fmt: skip
    faces = np.concatenate((np.stack((a, b, c), 1), np.stack((a, c, d), 1))).astype(np.int32)
    return Mesh(np.column_stack((x.ravel(), y.ravel(), z.ravel())).astype(np.float32), faces)


def hill(x: s.Array, y: s.Array) -> s.Array:
    return np.asarray(40.0 * np.exp(-((x / 70.0) ** 2) - (y / 45.0) ** 2) - 30.0)


SEEN = Context(camera=VIEW, scene=Scene((Layer("body", (Shaded(bump()),), owner="other"),)))
LAID = SymmetryState(lay="surface", snapping=False)
ON_HILL = np.column_stack((-50 + 100 * S, 15 + 10 * S, hill(-50 + 100 * S, 15 + 10 * S)))


def test_a_curve_on_a_surface_lies_on_it_and_so_does_its_image() -> None:
    state = draw(LAID, ON_HILL, SEEN)
    assert state.chosen is not None
    assert isinstance(state.chosen.canvas, LaidInk)
    assert state.chosen.canvas.places.model == "other"
    made = trace(state)
    assert made.reading == "pair"
    for points in (made.points, made.points * MIRROR):
        assert np.abs(points[:, 2] - hill(points[:, 0], points[:, 1])).max() < 0.3
    assert s.distances(made.points, ON_HILL).max() < 0.5


def test_an_image_beside_the_surface_is_told() -> None:
    assert trace(draw(LAID, ON_HILL, SEEN)).warnings == ()
    aside = replace(LAID, symmetry="free", free_plane=CentrePlane((0.0, 12.0, 0.0)))
    (told,) = trace(draw(aside, ON_HILL, SEEN)).warnings
    assert "not symmetric there" in told


def test_beside_every_surface_it_is_told() -> None:
    with pytest.raises(UserError, match="no surface"):
        draw(LAID, ON_HILL)
    half = ON_HILL + np.outer(S > 0.3, (0.0, 0.0, 300.0))
    with pytest.raises(UserError, match="leaves the surface"):
        draw(LAID, half, SEEN)


def test_keys_lead_from_space_to_surfaces_and_back_and_x_reads_the_ink_freely() -> None:
    run = {command.id: command.run for command in all_commands()}
    ways = [SymmetryState()]
    for _ in range(2):
        ways.append(run["new-curves-lie"](ways[-1], CONTEXT))
    assert [state.lay for state in ways] == ["space", "surface", "space"]
    state = draw(AT, SIDE)
    freed = run["switch-reading"](state, CONTEXT)
    assert freed.chosen is not None
    assert freed.chosen.canvas is None
    assert freed.chosen.strokes == state.chosen.strokes  # type: ignore[union-attr]


def test_laid_ink_checks_itself() -> None:
    state = draw(LAID, ON_HILL, SEEN)
    laid = state.chosen.canvas  # type: ignore[union-attr]
    assert isinstance(laid, LaidInk)
    with pytest.raises(ValueError, match="one point"):
        LaidInk(laid.places, laid.points[:-1], laid.normals)
    assert Curve(canvas=laid).canvas is laid


def test_it_is_saved_with_its_plane_its_surface_and_what_its_ends_snapped_to() -> None:
    snap = EndSnap(0, 1, (1.0, 2.0, 3.0), (0.0, 1.0, 0.0))
    state = draw(replace(LAID, drawing_plane=LEVEL), ON_HILL, SEEN)
    state = draw(replace(state, lay="plane"), SIDE)
    assert state.chosen is not None
    state = state.with_node(replace(state.chosen, end_snaps=(snap,), axis=2))
    again = decode_state(SymmetryState, encode_state(state))
    laid, flat = again.curves
    assert flat.end_snaps == (snap,)
    assert flat.axis == 2
    assert flat.canvas == LEVEL
    assert isinstance(laid.canvas, LaidInk)
    before = [trace_of(curve, state).points for curve in state.curves]
    after = [trace_of(curve, again).points for curve in again.curves]
    for one, other in zip(before, after, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)
