"""Known places under the pen, against a search over dense samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Curve as ShapeCurve
from bozzetto.geometry.spline import Spline
from bozzetto.plugin import Context
from bozzetto.view import Camera
from bozzetto_symmetry.fitting.space_curve import SpaceCurve, across
from bozzetto_symmetry.model.state import Group, Line, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.operations.snap_targets import Targets, nearest_target, polyline, targets

STATE = SymmetryState(centre=(10.0, -5.0, 30.0))
LINE = Line(id="l", name="Line 1", begin=(-60.0, 20.0, 0.0), end=(70.0, 33.0, 41.0))
SIDE = np.array([[-60, 20, 5], [-20, 45, 30], [30, 15, 40], [60, 30, 10], [80, 25, 5.0]])
PAIR = SpaceCurve("pair", Spline.uniform(SIDE))
BOW = SpaceCurve("self", across(np.array([[40, 0, 10], [40, 9, 10], [10, 25, 20], [-30, 30, 5.0]])))
CAMERAS = [
    Camera(eye=(400.0, -500.0, 200.0)),
    Camera(kind="orthographic", eye=(-300.0, -500.0, 350.0), height=300.0),
    Camera(eye=(20.0, -10.0, 40.0), target=(100.0, 60.0, 10.0), fov_y=70.0),  # within the box
]


def known(state: SymmetryState = STATE, context: Context | None = None) -> Targets:
    return targets(state, [PAIR, BOW], context or Context())


def test_all_ends_are_known_on_both_sides() -> None:
    state = replace(STATE, nodes=(LINE,))
    all_known = known(state)
    ends = [kind == "end" for kind in all_known.point_kinds]
    found = {tuple(point) for point in all_known.points[ends].tolist()}
    middle = state.plane.point[1]
    for x, y, z in (SIDE[0], SIDE[-1], BOW.spline.control_points[-1]):
        assert {(x, middle + y, z), (x, middle - y, z)} <= found
    assert {LINE.begin, LINE.end} <= found
    assert len(found) == 4 + 2 + 2


def test_the_crossing_is_on_the_plane() -> None:
    found = known()
    place = found.points[found.point_kinds.index("crossing")]
    assert place[1] == STATE.plane.point[1]
    assert place == pytest.approx(np.array([40.0, -5.0, 10.0]))


def test_hidden_lines_are_not_known() -> None:
    group = Group(id="g", name="Group", visible=False)
    for nodes in ((replace(LINE, visible=False),), (replace(LINE, within="g"), group)):
        assert "line" not in known(replace(STATE, nodes=nodes)).segment_kinds


def test_a_closed_curve_has_no_ends() -> None:
    turn = np.arange(8) * np.pi / 4.0
    ring = np.column_stack((20 * np.cos(turn), 30 + 5 * np.sin(turn), 20 * np.sin(turn)))
    loop = SpaceCurve("pair", Spline.uniform(ring, closed=True))
    assert set(targets(STATE, [loop], Context()).point_kinds) == {"corner"}


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_nearest_place_against_dense_samples(camera: Camera) -> None:
    found = known(replace(STATE, nodes=(LINE,)))
    share = np.linspace(0.0, 1.0, 400)[:, None]
    steps = found.ends - found.begins
    dense = (found.begins[:, None] + share * steps[:, None]).reshape(-1, 3)
    seen, _ = camera.project(dense)
    corners, _ = camera.project(found.points)
    hits, random = 0, np.random.default_rng(5)
    ahead = seen[np.isfinite(seen).all(axis=1) & (np.abs(seen) < 3000).all(axis=1)]
    for pen in random.choice(ahead, 150) + 9.0 * random.normal(size=(150, 2)):
        place = nearest_target(pen, camera, found, 12.0)
        gap = float(np.nanmin(np.linalg.norm(seen - pen, axis=1)))
        to_point = float(np.nanmin(np.linalg.norm(corners - pen, axis=1)))
        if place is None:
            assert gap > 11.5
            continue
        hits += 1
        assert place.pixels <= 12.0
        (at,), _ = camera.project(place.point)
        assert np.linalg.norm(at - pen) == pytest.approx(place.pixels, abs=1e-6)
        if place.kind in ("end", "corner", "crossing"):
            assert place.pixels <= to_point + 0.5
        else:
            assert to_point > 12.0
            assert place.pixels <= gap + 0.6
            assert np.linalg.norm(dense - place.point, axis=1).min() < 0.5
    assert 50 < hits < 150


def test_points_win_over_what_they_end() -> None:
    camera, placed = CAMERAS[0], SIDE[0] + np.array([0.0, -5.0, 0.0])
    (pixel,), _ = camera.project(placed)
    place = nearest_target(pixel + np.array([3.0, 4.0]), camera, known(), 6.0)
    assert place is not None
    assert place.kind == "end"
    assert place.pixels == pytest.approx(5.0)
    assert np.array(place.point) == pytest.approx(placed, abs=1e-12)


def test_of_two_places_behind_one_another_the_nearer_is_meant() -> None:
    camera = Camera(kind="orthographic", eye=(10.0, -500.0, 30.0), target=(10.0, 0.0, 30.0))
    (pixel,), _ = camera.project((110.0, 0.0, 80.0))
    place = nearest_target(pixel, camera, known(), 6.0)
    assert place is not None
    assert place.point == (110.0, -55.0, 80.0)


def test_an_edge_that_runs_behind_the_eye_can_be_touched() -> None:
    camera = CAMERAS[2]
    # A place of a lower edge of the box whose other end is behind the eye.
    (pixel,), _ = camera.project((60.0, 45.0, -20.0))
    place = nearest_target(pixel, camera, known(), 2.0)
    assert place is not None
    assert place.kind == "edge"
    assert place.point == pytest.approx((60.0, 45.0, -20.0), abs=1e-6)


def test_nothing_behind_the_eye_is_touched() -> None:
    camera = Camera(eye=(0.0, 900.0, 0.0), target=(0.0, 1500.0, 0.0))
    pens = np.random.default_rng(6).uniform((0, 0), camera.viewport, (50, 2))
    assert all(nearest_target(pen, camera, known(), 40.0) is None for pen in pens)


def test_curves_lie_in_the_model_s_frame() -> None:
    plane = CentrePlane((10, 0, 0), (1.0, 1.0, 0.2))
    state = replace(STATE, symmetry="free", free_plane=plane)
    found = known(state)
    ends = found.points[[kind == "end" for kind in found.point_kinds]]
    normal = np.asarray(plane.normal)
    heights = (ends - plane.point) @ normal
    assert heights.sum() == pytest.approx(0.0, abs=1e-9)
    assert heights == pytest.approx([20, 25, -20, -25, -30, 30])


def test_curves_of_other_models_are_known() -> None:
    # A quarter of a circle, exact as a rational curve.
    corner = np.array([[50.0, 0, 0], [50, 50, 0], [0, 50, 0]])
    arc = ShapeCurve(2, np.array([0, 0, 0, 1, 1, 1.0]), corner, np.array([1, np.sqrt(0.5), 1]))
    places = polyline(arc)
    assert np.linalg.norm(places, axis=1) == pytest.approx(50.0, abs=1e-12)
    found = targets(STATE, (), Context(curves=(arc,)))
    assert found.point_kinds[-2:] == ("end", "end")
    assert found.points[-2:] == pytest.approx(corner[[0, 2]])
    straight = ShapeCurve(1, np.array([0, 0, 1, 2, 2.0]), corner)
    assert polyline(straight) == pytest.approx(corner)


def test_the_centre_plane_can_be_begun_from_its_rim() -> None:
    camera = CAMERAS[0]
    (pixel,), _ = camera.project((-40.0, -5.0, -20.0))
    place = nearest_target(pixel, camera, known(), 3.0)
    assert place is not None
    assert place.kind == "edge"
    assert place.point == pytest.approx((-40.0, -5.0, -20.0), abs=1e-9)
