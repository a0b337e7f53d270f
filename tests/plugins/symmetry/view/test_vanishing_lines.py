"""What depends on the view: which faces are behind, and where edges meet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.scene import Label, Lines
from bozzetto.view import Camera
from bozzetto_symmetry.model.axes import AXES, AXIS_PAINTS
from bozzetto_symmetry.model.box_grid import clip_to_box
from bozzetto_symmetry.model.state import Line, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.view.box import box_layers
from bozzetto_symmetry.view.vanishing_lines import (
    ARM,
    back_faces,
    front_edges,
    seen_from,
    seen_vanishing_point,
    vanishing_marks,
)

STATE = SymmetryState(centre=(10.0, -5.0, 30.0), length=200.0, width=120.0, height=80.0)
EYES = [
    (500, -400, 300),
    (-300, 500, -200),
    (100, 800, 50),
    (0, 0, 700),
    (0, -600, 30),
    (15, 0, 40),
]
VIEWS = [
    Camera(kind=kind, eye=eye, height=300.0)
    for eye in EYES
    for kind in ("perspective", "orthographic")
]


@pytest.mark.parametrize("camera", VIEWS)
def test_lines_of_sight_leave_the_box_through_its_back_faces(camera: Camera) -> None:
    back = back_faces(STATE, camera)
    pixels = np.random.default_rng(2).uniform((0, 0), camera.viewport, (2000, 2))
    origins, ways = camera.rays(pixels)
    begin, end, inside = clip_to_box(origins, ways, STATE.centre, STATE.size)

    def walls(at: np.ndarray, seen: np.ndarray) -> set[tuple[int, int]]:
        share = (origins + at[:, None] * ways - STATE.centre)[seen] / STATE.size
        axes = np.abs(share).argmax(axis=1)
        return {(int(axis), int(np.sign(row[axis]))) for axis, row in zip(axes, share, strict=True)}

    parallel = camera.kind == "orthographic"
    left, entered = walls(end, inside & ((end > 0) | parallel)), begin > 0
    assert left
    assert left <= set(back)
    assert not walls(begin, inside & (entered | parallel)) & set(back)


def test_from_outside_nine_edges_are_in_front_and_from_inside_none() -> None:
    assert len(front_edges(STATE, VIEWS[0])) == 9
    assert len(front_edges(STATE, VIEWS[1])) == 9
    inside = Camera(eye=(15.0, 0.0, 40.0))
    assert len(back_faces(STATE, inside)) == 6
    assert len(front_edges(STATE, inside)) == 0


@pytest.mark.parametrize("camera", VIEWS[::2])
def test_vanishing_points_are_images_of_places_far_away(camera: Camera) -> None:
    for axis in AXES:
        found = seen_vanishing_point(camera, axis)
        depth = camera.axes[2] @ axis
        if found is None:
            continue
        (far,), _ = camera.project(1e12 * np.sign(depth) * axis)
        assert found == pytest.approx(far, abs=1e-4)


def test_vanishing_points_far_from_the_canvas_are_left_out() -> None:
    camera = Camera(eye=(20.0, -600.0, 0.0))
    assert seen_vanishing_point(camera, AXES[0]) is None
    assert seen_vanishing_point(camera, AXES[1]) is not None
    assert seen_vanishing_point(camera, AXES[2]) is None
    assert not vanishing_marks(STATE, Camera(kind="orthographic")).layers


@pytest.mark.parametrize("fov", [20.0, 60.0, 100.0])
def test_marks_are_seen_where_the_axes_vanish(fov: float) -> None:
    camera = Camera(eye=(350.0, -400.0, 200.0), fov_y=fov)
    (layer,) = vanishing_marks(STATE, camera).layers
    crosses = [item for item in layer.items if isinstance(item, Lines)]
    letters = [item for item in layer.items if isinstance(item, Label)]
    assert len(crosses) == len(letters) >= 2
    for cross, letter in zip(crosses, letters, strict=True):
        expected = seen_vanishing_point(camera, AXES["xyz".index(letter.text)])
        assert expected is not None
        ends, _ = camera.project(cross.points)
        assert ends.mean(axis=0) == pytest.approx(expected, abs=0.01)
        assert np.abs(ends - expected) == pytest.approx(ARM, abs=0.01)
        assert camera.project(letter.point)[0][0] == pytest.approx(expected, abs=1e-6)


def test_mirrored_places_run_towards_the_mark_of_a_tilted_plane() -> None:
    plane = CentrePlane((5, 0, 0), (1.0, 1.5, 0.3))
    state = replace(STATE, symmetry="free", free_plane=plane)
    camera = Camera(eye=(350.0, -400.0, 200.0), fov_y=80.0)
    (layer,) = vanishing_marks(state, camera).layers
    (mark,) = (i for i in layer.items if isinstance(i, Label) and i.text not in ("x", "y", "z"))
    (target,), _ = camera.project(mark.point)
    normal = np.asarray(plane.normal)
    for place in np.random.default_rng(4).uniform(-60, 60, (20, 3)):
        twin = place - 2.0 * float((place - plane.point) @ normal) * normal
        (one, other), _ = camera.project([place, twin])
        step, rest = other - one, target - one
        sine = (step[0] * rest[1] - step[1] * rest[0]) / np.linalg.norm(step) / np.linalg.norm(rest)
        assert abs(sine) < 1e-6


@pytest.mark.parametrize("camera", VIEWS)
def test_lengthened_edges_go_on_along_their_axis_and_nearly_meet(camera: Camera) -> None:
    scene = seen_from(replace(STATE, vanishing=True), camera)
    assert all(
        np.isfinite(item.points).all() for _, item in scene.items() if isinstance(item, Lines)
    )
    (layer,) = (layer for layer in scene.layers if layer.name == "vanishing lines")
    bundles = [i for i in layer.items if isinstance(i, Lines) and i.color in AXIS_PAINTS]
    assert len(bundles) == 3
    for bundle in bundles:
        lines = [np.asarray(bundle.points[piece], float) for piece in bundle.pieces()]
        ways = np.array([line[-1] - line[0] for line in lines])
        axis = int(np.abs(ways[0]).argmax())
        assert np.abs(np.delete(ways, axis, axis=1)).max() < 1e-3 * np.abs(ways).max()
        place = seen_vanishing_point(camera, AXES[axis])
        if place is None:
            continue
        for line in lines:
            seen, _ = camera.project(line)
            rest = np.linalg.norm(seen - place, axis=1)
            assert rest[-1] <= 0.04 * rest[0] + 0.5


@pytest.mark.parametrize("camera", VIEWS)
def test_the_grids_go_on_along_the_faces_behind_and_fade(camera: Camera) -> None:
    scene = seen_from(replace(STATE, vanishing=True), camera)
    (layer,) = (layer for layer in scene.layers if layer.name == "vanishing lines")
    grids = [i for i in layer.items if isinstance(i, Lines) and i.color not in AXIS_PAINTS]
    back = back_faces(STATE, camera)
    assert len(grids) == len(back)
    for grid, (axis, sense) in zip(grids, back, strict=True):
        points = np.asarray(grid.points, float)
        face = STATE.centre[axis] + 0.5 * sense * STATE.size[axis]
        assert points[:, axis] == pytest.approx(face)
        aside = (np.abs(points - STATE.centre) / STATE.size).max(axis=1) - 0.5
        assert (np.asarray(grid.width)[aside > 1.4999] < 1e-3).all()
        assert (np.asarray(grid.width)[aside < 1e-6] > 0.5).all()


def test_nothing_is_lengthened_that_nobody_asked_for() -> None:
    drawn = STATE.with_node(Line(id="l"))
    names = {layer.name for layer in seen_from(drawn, VIEWS[0]).layers}
    assert names == {"front edges", "back walls"}
    names = {layer.name for layer in seen_from(replace(drawn, grid=False), VIEWS[0]).layers}
    assert names == {"front edges"}


def test_before_the_first_stroke_the_box_is_there() -> None:
    own = {layer.name for layer in box_layers(STATE) if not layer.tool}
    names = [layer.name for layer in seen_from(STATE, VIEWS[0]).layers]
    assert own < set(names)
    assert len(names) == len(set(names))
