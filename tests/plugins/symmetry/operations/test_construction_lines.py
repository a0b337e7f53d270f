"""Construction lines: what is drawn through a camera comes back in space."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh
from bozzetto.ink import Stroke
from bozzetto.plugin import Context
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto.view import Camera
from bozzetto_symmetry.model.state import Line, SymmetryState
from bozzetto_symmetry.operations.construction_lines import Straight, axis_of, line_layer, line_of
from bozzetto_symmetry.operations.snap_targets import targets

STATE = SymmetryState()
CORNER = np.array([-100.0, -50.0, -50.0])
CAMERAS = [
    Camera(eye=(400.0, -500.0, 250.0)),
    Camera(eye=(-350.0, -450.0, -150.0), fov_y=60.0),
    Camera(kind="orthographic", eye=(300.0, -500.0, 350.0), height=330.0),
]


def drawn(camera: Camera, begin: np.ndarray, end: np.ndarray, noise: float = 0.0) -> Stroke:
    (first, last), _ = camera.project([begin, end])
    points = first + np.linspace(0, 1, 40)[:, None] * (last - first)
    points += noise * np.random.default_rng(2).normal(size=points.shape)
    return Stroke(*points.T, camera)


def made(stroke: Stroke, state: SymmetryState = STATE, context: Context | None = None) -> Straight:
    context = context or Context()
    return line_of(stroke, state, targets(state, (), context), context)


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_from_a_corner_along_an_axis(camera: Camera, axis: int) -> None:
    end = CORNER + 70.0 * np.eye(3)[axis]
    line = made(drawn(camera, CORNER, end, noise=0.7))
    assert line.axis == axis
    assert line.begin == tuple(CORNER)
    assert np.delete(line.end, axis) == pytest.approx(np.delete(end, axis), abs=1e-9)
    assert line.end[axis] == pytest.approx(end[axis], abs=2.0)


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_sense_of_the_stroke_is_kept(camera: Camera) -> None:
    inside = np.array([20.0, 13.0, 5.0])
    state = STATE.with_node(Line(id="a", begin=tuple(inside), end=(20.0, 13.0, 45.0)))
    # The stroke's start is seen over an edge of the box in one of these views.
    outer = inside + np.array((-60.0, 0.0, 0.0))
    line = made(drawn(camera, outer, inside), state)
    assert line.axis == 0
    assert line.end == tuple(inside)
    assert line.begin == pytest.approx(tuple(outer), abs=1e-4)  # ink is float32


@pytest.mark.parametrize("camera", CAMERAS)
def test_two_known_places_are_joined_in_any_direction(camera: Camera) -> None:
    other = np.array([100.0, -50.0, 50.0])
    line = made(drawn(camera, CORNER, other, noise=1.0))
    assert (line.begin, line.end, line.axis) == (tuple(CORNER), tuple(other), None)
    along_x = np.array([100.0, -50.0, -50.0])
    assert made(drawn(camera, CORNER, along_x)).axis == 0


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_line_along_an_axis_stops_at_what_it_meets(camera: Camera) -> None:
    bar = Line(id="a", begin=(37.0, -30.0, 10.0), end=(37.0, 40.0, 10.0))
    post = Line(id="b", begin=(-50.0, 12.0, 10.0), end=(-50.0, 12.0, -40.0))
    state = replace(STATE, nodes=(bar, post))
    line = made(
        drawn(camera, np.array([-50, 12, 10.0]), np.array([37, 12, 10.0]), noise=1.0), state
    )
    assert line.axis == 0
    assert line.begin == post.begin
    assert line.end == (37.0, 12.0, 10.0)


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_line_starts_on_a_surface_that_is_seen(camera: Camera) -> None:
    table = np.array([[-300, -300, 7], [300, -300, 7], [300, 300, 7], [-300, 300, 7]], np.float32)
    mesh = Mesh(table, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    context = Context(scene=Scene((Layer("table", (Shaded(mesh),)),)))
    wide = replace(STATE, length=2000.0, width=2000.0, height=2000.0)
    begin = np.array([15.0, -12.0, 7.0])
    line = made(drawn(camera, begin, begin + np.array((0.0, 0.0, 30.0))), wide, context)
    assert line.axis == 2
    assert line.begin == pytest.approx(tuple(begin), abs=1e-3)
    assert line.end == pytest.approx((15.0, -12.0, 37.0), abs=1e-3)
    # Along no axis: from place to place of the surface.
    begin, end = np.array([15.0, -12.0, 7.0]), np.array([52.0, 20.0, 7.0])
    line = made(drawn(camera, begin, end), wide, context)
    assert (line.begin, line.end) == (
        pytest.approx(tuple(begin), abs=1e-3),
        pytest.approx(tuple(end), abs=1e-3),
    )


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_line_in_the_air_begins_on_the_wall_that_is_seen_from_inside(camera: Camera) -> None:
    place = np.array([-60.0, 50.0, -10.0])  # on a far wall of every one of these views
    line = made(drawn(camera, place, place + np.array((45.0, 0.0, 0.0))))
    assert line.axis == 0
    assert line.begin == pytest.approx(tuple(place), abs=1e-3)
    slanting = place + np.array((60.0, 0.0, 45.0))
    line = made(drawn(camera, place, slanting))
    assert line.axis is None
    assert line.begin == pytest.approx(tuple(place), abs=1e-3)
    assert line.end == pytest.approx(tuple(slanting), abs=1e-3)


@pytest.mark.parametrize("camera", CAMERAS)
def test_beside_the_box_a_line_begins_on_the_centre_plane(camera: Camera) -> None:
    small = replace(STATE, length=20.0, width=20.0, height=20.0)
    place = np.array([60.0, 0.0, 40.0])
    line = made(drawn(camera, place, place + np.array((0.0, 0.0, 30.0))), small)
    assert line.axis == 2
    assert line.begin == pytest.approx(tuple(place), abs=1e-3)


@pytest.mark.parametrize("camera", CAMERAS)
def test_one_known_end_off_every_axis_lies_in_the_plane_of_the_wall(camera: Camera) -> None:
    held = np.array([-60.0, 10.0, 20.0])
    state = STATE.with_node(Line(id="a", begin=tuple(held), end=(-60.0, 10.0, 60.0)))
    end = held + np.array((55.0, 0.0, -33.0))
    line = made(drawn(camera, held, end), state)
    assert line.begin == tuple(held)
    assert line.axis is None
    # Which wall is behind depends on the view; along it the line keeps one coordinate.
    assert np.abs(np.subtract(line.end, held)).min() < 1e-9
    (seen, wanted), _ = camera.project([line.end, end])
    assert seen == pytest.approx(wanted, abs=1e-3)


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize(("degrees", "taken"), [(0, True), (4, True), (-4, True), (9, False)])
def test_towards_a_vanishing_point_means_within_six_degrees(
    camera: Camera, degrees: float, taken: bool
) -> None:
    (first, last), _ = camera.project([(-30, 0, 0), (30, 0, 0)])
    middle, half = 0.5 * (first + last), 0.5 * (last - first)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    half = np.array([[c, -s], [s, c]]) @ half
    assert axis_of(middle - half, middle + half, camera) == (0 if taken else None)


def test_an_axis_that_is_seen_as_a_point_is_no_direction() -> None:
    front = Camera(eye=(0.0, -500.0, 0.0))
    middle = np.array([600.0, 450.0])
    assert axis_of(middle - np.array((80, 0)), middle + np.array((80, 0)), front) == 0
    assert axis_of(middle - np.array((0, 80)), middle + np.array((0, 80)), front) == 2
    assert axis_of(middle - np.array((50, 50)), middle + np.array((50, 50)), front) is None
    far = np.array([900.0, 600.0])  # depth runs towards the middle of the canvas
    toward = (middle - far) / 6.0
    assert axis_of(far - toward, far + toward, front) == 1


def test_what_is_no_line_is_said_so() -> None:
    camera = CAMERAS[0]
    turn = np.linspace(0, 3, 50)
    bow = Stroke(600 + 200 * np.cos(turn), 450 + 200 * np.sin(turn), camera)
    with pytest.raises(UserError, match="straight"):
        made(bow)
    with pytest.raises(UserError, match="short"):
        made(Stroke([600, 605], [450, 452], camera))
    with pytest.raises(UserError, match="short"):
        made(Stroke([600], [450], camera))
    ring = np.linspace(0, 2 * np.pi, 60)
    with pytest.raises(UserError, match="straight"):
        made(Stroke(600 + 90 * np.cos(ring), 450 + 90 * np.sin(ring), camera))


def test_an_edge_seen_end_on_cannot_be_drawn_along() -> None:
    front = Camera(eye=(0.0, -500.0, 0.0))
    corner, _ = front.project(CORNER)
    past = np.array([600.0, 450.0]) + 0.1 * (np.array([600.0, 450.0]) - corner[0])
    points = corner[0] + np.linspace(0, 1, 30)[:, None] * (past - corner[0])
    with pytest.raises(UserError, match="Turn the view"):
        made(Stroke(*points.T, front))


coordinate = st.floats(-500, 2000, width=32)


@given(
    st.tuples(coordinate, coordinate),
    st.tuples(coordinate, coordinate),
    st.tuples(*[st.floats(-300, 300)] * 3),
    st.sampled_from(["perspective", "orthographic"]),
)
@settings(max_examples=150, deadline=None)
def test_any_straight_stroke_in_any_view_gives_a_line_or_a_reason(begin, end, eye, kind) -> None:  # type: ignore[no-untyped-def]
    if np.linalg.norm(eye) < 1.0:
        return
    camera = Camera(kind=kind, eye=eye)
    xs, ys = np.linspace(begin, end, 20).T
    try:
        line = made(Stroke(xs, ys, camera))
    except UserError:
        return
    assert np.isfinite([line.begin, line.end]).all()
    assert line.begin != line.end
    if line.axis is not None:
        assert np.abs(np.delete(np.subtract(line.end, line.begin), line.axis)).max() < 1e-6


def test_lines_are_shown_and_the_chosen_one_stands_out() -> None:
    lines = (Line(id="a", end=(1.0, 2.0, 3.0)), Line(id="b", end=(0.0, 0.0, 5.0)))
    layer = line_layer(replace(STATE, nodes=lines, selected="b"), lines)
    assert [item.color for item in layer.items] == ["ghost", "accent"]  # type: ignore[union-attr]
    assert layer.items[0].points[1].tolist() == [1.0, 2.0, 3.0]  # type: ignore[union-attr]
