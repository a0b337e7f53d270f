"""Curves from ink: what they look like, where they lie, and what is said of them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Placement, closest_on_mesh
from bozzetto.ink import Stroke, distances_to_polyline
from bozzetto.scene import Scene, cast_rays
from bozzetto.view import Camera
from bozzetto_product.model.planes import Plane
from bozzetto_product.projection.ink_curve import curve_from_ink
from bozzetto_product.projection.planes import (
    fitted_plane,
    heights,
    mirror_image,
    plane_standing_on,
    plane_through,
)
from bozzetto_product.projection.sheet_curve import curve_on_sheet
from bozzetto_product.projection.views import seen_at
from tests.plugins.product.drawn_curves import (
    COURSES,
    SHEET,
    drawn,
    on_canvas,
    one_stroke,
    recorded_clusters,
    rough,
    worst_distance,
)

EYE = Camera(eye=(260.0, -380.0, 240.0), fov_y=30.0)


def _swing(start: tuple[float, float], end: tuple[float, float], bend: float = 40.0) -> np.ndarray:
    share = np.linspace(0.0, 1.0, 80)[:, None]
    line = np.array(start) + share * np.subtract(end, start)
    return line + np.array((0.0, bend)) * np.sin(np.pi * share)


@pytest.mark.parametrize("name", ["arc 270°", "hook", "closed ring"])
def test_courses_that_a_principal_direction_cannot_order(name: str) -> None:
    """Seven control points are within six pixels of what was meant, in the median of drawings."""
    course = COURSES[name]
    errors = []
    for seed in range(3000, 3005):
        sheet = curve_on_sheet(drawn(course, seed))
        assert sheet.spline.closed == (name == "closed ring")
        assert len(sheet.spline.control_points) == (10 if sheet.spline.closed else 7)
        errors.append(worst_distance(sheet.spline.sampled(2000) - (500.0, 450.0), course))
    assert np.median(errors) <= 6.0


def test_the_order_of_the_paper_is_kept_for_curves_along_a_line() -> None:
    sheet = curve_on_sheet(drawn(COURSES["arc 60°"], 3000), order="principal")
    assert worst_distance(sheet.spline.sampled(2000) - (500.0, 450.0), COURSES["arc 60°"]) <= 6.0


@pytest.mark.parametrize("kind", ["box", "sphere", "shoe last"])
def test_the_image_of_a_curve_is_its_ink(kind: str) -> None:
    scene = on_canvas(rough(kind))
    ink = _swing((520, 430), (690, 470))
    got = curve_from_ink([one_stroke(ink, EYE)], scene)
    image = seen_at(EYE, got.spline.sampled(1000))
    assert distances_to_polyline(image, ink).max() <= 1.5
    assert distances_to_polyline(ink, image).max() <= 1.5


def test_a_curve_lies_on_the_surface_under_its_ink() -> None:
    mesh = rough("sphere")
    got = curve_from_ink([one_stroke(_swing((560, 430), (660, 460), 10.0), EYE)], on_canvas(mesh))
    off = closest_on_mesh(mesh, got.spline.sampled(100)).distances
    assert off.max() <= 0.3  # of 120 mm, with seven control points
    assert not got.warnings


@pytest.mark.parametrize("seed", range(40, 46))
def test_a_curve_on_a_flat_face_lies_in_it_however_flat_it_is_seen(seed: int) -> None:
    """The depth of a flat face does not waver with the few control points; the ink is kept."""
    random = np.random.default_rng(seed)
    grazing = Camera(eye=(200.0, -400.0, random.uniform(130.0, 260.0)), fov_y=30.0)
    corners = random.uniform((-55.0, -35.0), (55.0, 35.0), (4, 2))
    share = np.linspace(0.0, 1.0, 40)[:, None]
    plan = np.concatenate([a + share * (b - a) for a, b in pairwise(corners)])
    ink = seen_at(grazing, np.column_stack((plan, np.full(len(plan), 30.0))))
    got = curve_from_ink([one_stroke(ink, grazing)], on_canvas(rough("box")))
    assert np.ptp(got.spline.sampled(300)[:, 2]) < 0.01
    assert got.image_error <= 1.5


def test_a_curve_runs_as_it_was_drawn() -> None:
    ink = _swing((520, 430), (690, 470))
    for stroke in (ink, ink[::-1]):
        got = curve_from_ink([one_stroke(stroke, EYE)], on_canvas(rough("sphere")))
        (start,) = seen_at(EYE, got.spline.control_points[:1])
        assert np.linalg.norm(start - stroke[0]) <= 1.5


def test_more_control_points_follow_the_ink_more_closely() -> None:
    ink = drawn(COURSES["hook"], 3001)
    few, many = (curve_from_ink(ink, Scene(), controls=count) for count in (7, 20))
    assert len(many.spline.control_points) == 20
    assert many.ink_error < 0.5 * few.ink_error


def test_a_stroke_that_runs_off_does_not_bend_back() -> None:
    """Beyond the silhouette the depth goes on, for a shape that is 15 % too small."""
    view = Camera(kind="orthographic", eye=(0.0, -600.0, 0.0), height=200.0)
    share = np.linspace(-0.3, 1.08, 200)
    meant = 50.0 * np.column_stack((share, -np.sqrt(1.15**2 - share**2), 0.0 * share))
    got = curve_from_ink(
        [one_stroke(seen_at(view, meant), view)], on_canvas(rough("sphere", (100.0,) * 3))
    )
    assert any("off the surface" in text for text in got.warnings)
    at = got.spline.value(np.linspace(0.0, 1.0, 400))
    off = at[:, 1] - np.interp(at[:, 0], meant[:, 0], meant[:, 1])
    assert np.abs(off - np.median(off[:200])).max() <= 0.2 * 50.0
    assert np.abs(got.spline.derivative(np.linspace(0, 1, 200), 2)[:, 1]).max() <= 6.0 * 50.0


def test_ink_beside_every_surface_faces_the_view_and_says_so() -> None:
    anchor = (30.0, 20.0, 10.0)
    got = curve_from_ink(
        [one_stroke(_swing((60, 60), (200, 90)), EYE)], on_canvas(rough("sphere")), anchor=anchor
    )
    depth = (got.spline.sampled(50) - anchor) @ EYE.axes[2]
    assert np.abs(depth).max() <= 1e-6
    assert len(got.warnings) == 1
    assert "beside every surface" in got.warnings[0]


def test_an_edge_under_the_ink_is_told() -> None:
    """A stroke over the upper front edge of a box, whose place is known."""
    ink = seen_at(EYE, [(0.0, -40.0, -10.0), (0.0, -40.0, 30.0), (0.0, 20.0, 30.0)])
    got = curve_from_ink([one_stroke(ink, EYE)], on_canvas(rough("box")))
    assert len(got.creases) == 1
    assert any("edge" in text for text in got.warnings)
    (seen,) = seen_at(EYE, got.spline.value([got.creases[0]]))
    assert np.linalg.norm(seen - seen_at(EYE, [(0.0, -40.0, 30.0)])[0]) <= 4.0


@pytest.mark.parametrize("beyond", [2.0, 6.0, 15.0])
def test_a_curve_over_an_edge_begins_and_ends_on_the_faces(beyond: float) -> None:
    """However little of the ink is on a face, and however flat it is seen: others end there."""
    low = Camera(eye=(60.0, -300.0, 120.0), fov_y=30.0)
    first, last = (-10.0, -40.0 + beyond, 30.0), (-12.0, -40.0, -20.0)
    ink = seen_at(low, [first, (-10.5, -40.0, 30.0), (-11.0, -40.0, 28.0), last])
    got = curve_from_ink([one_stroke(ink, low)], on_canvas(rough("box")))
    assert np.linalg.norm(got.spline.sampled(2) - (first, last), axis=1).max() <= 1.2


def test_a_curve_on_a_plane_is_in_it_to_the_last_bit() -> None:
    plane = Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    ink = _swing((400, 400), (800, 500))
    got = curve_from_ink([one_stroke(ink, EYE)], on_canvas(rough("box")), plane=plane)
    assert (got.spline.control_points[:, 1] == 0.0).all()
    assert distances_to_polyline(ink, seen_at(EYE, got.spline.sampled(1000))).max() <= 1.5


def test_a_plane_seen_edge_on_is_refused() -> None:
    flat = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    with pytest.raises(UserError, match="edge-on"):
        curve_from_ink([one_stroke(_swing((400, 300), (800, 400)))], Scene(), plane=flat)


def test_ends_near_the_mirror_plane_lie_in_it() -> None:
    mirror = Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    ink = seen_at(SHEET, np.linspace((0.6, -30.0, 20.0), (40.0, -20.0, 0.0), 60))
    got = curve_from_ink([one_stroke(ink)], on_canvas(rough("sphere")), mirror_plane=mirror)
    assert got.spline.control_points[0, 0] == 0.0
    assert got.spline.control_points[-1, 0] > 10.0


def test_ends_that_only_seem_near_the_mirror_plane_stay_on_their_surface() -> None:
    """In a view along the plane's normal all is seen near it; at the outline it is meant."""
    scene = on_canvas(rough("sphere"))
    ahead = SHEET.axes[2]
    mirror = Plane((0.0, 0.0, 0.0), (float(ahead[0]), float(ahead[1]), float(ahead[2])))
    middle = SHEET.project(np.zeros((1, 3)))[0][0]
    ray = cast_rays(scene, SHEET.rays(middle[None] + np.linspace((0, 0), (600, 0), 601)))
    radius = float(np.flatnonzero(ray.hit)[-1])
    for share, is_flat in ((0.5, False), (0.985, True)):
        ink = middle + radius * np.linspace((-0.5, 0.0), (share, 0.0), 60)
        spline = curve_from_ink([one_stroke(ink)], scene, mirror_plane=mirror).spline
        plain = curve_from_ink([one_stroke(ink)], scene).spline
        far = heights(spline.control_points[[0, -1]], mirror)
        assert abs(far[0]) == pytest.approx(abs(heights(plain.control_points[0], mirror)))
        assert (abs(far[1]) < 1e-9) == is_flat


def test_planes_hold_what_they_are_made_of() -> None:
    random = np.random.default_rng(3)
    three = random.normal(size=(3, 3))
    assert np.abs(heights(three, plane_through(three))).max() <= 1e-12
    flat = fitted_plane(random.normal(size=(20, 2)) @ random.normal(size=(2, 3)) + 4.0)
    assert np.isclose(np.linalg.norm(flat.normal), 1.0)
    points = random.normal(size=(9, 3))
    again = mirror_image(mirror_image(points, flat), flat)
    assert np.allclose(again, points, atol=1e-12)
    with pytest.raises(UserError):
        plane_through([(0, 0, 0), (1, 1, 1), (2, 2, 2)])


def test_a_plane_stands_upright_on_the_surface() -> None:
    """On the flat top of a box it is upright, through the first and last place of the ink."""
    ends = np.array([(-20.0, -10.0, 30.0), (30.0, 15.0, 30.0)])
    stroke = one_stroke(seen_at(EYE, np.linspace(*ends, 40)), EYE)
    plane = plane_standing_on(stroke, on_canvas(rough("box")))
    assert abs(plane.normal[2]) <= 1e-6
    assert np.abs(heights(ends, plane)).max() <= 1e-3


def test_a_thousand_times_as_large_is_the_same_curve() -> None:
    ink = _swing((520, 430), (690, 470))
    small = curve_from_ink([one_stroke(ink, EYE)], on_canvas(rough("mouse")))
    large_eye = EYE.moved(Placement(scale=1000.0))
    large = curve_from_ink(
        [one_stroke(ink, large_eye)], on_canvas(rough("mouse", (120e3, 80e3, 60e3)))
    )
    off = np.abs(large.spline.control_points / 1000.0 - small.spline.control_points)
    assert off.max() <= 1e-4  # vertices are of single precision


def test_the_same_ink_twice_gives_the_same_numbers() -> None:
    scene, ink = on_canvas(rough("bottle")), drawn(COURSES["S"], 3002)
    one, other = (curve_from_ink(ink, scene).spline.control_points for _ in range(2))
    assert (one == other).all()


@pytest.mark.parametrize(
    "strokes",
    [
        [],
        [Stroke([5.0], [5.0], SHEET)],
        [Stroke([5.0, 5.0, 5.0], [5.0, 5.0, 5.0], SHEET)],
        [one_stroke(_swing((0, 0), (9, 9))), one_stroke(_swing((0, 0), (9, 9)), EYE)],
    ],
)
def test_what_is_no_curve_is_refused(strokes: list[Stroke]) -> None:
    for order in ("drawn", "principal"):
        with pytest.raises(UserError):
            curve_from_ink(strokes, Scene(), order=order)


def test_recorded_ink_of_many_strokes() -> None:
    clusters = recorded_clusters(12)
    if not clusters:
        pytest.skip("the recorded strokes are not on this machine")
    scene = on_canvas(rough("sphere", (900.0, 900.0, 900.0)))
    eye = Camera(eye=(0.0, -2000.0, 0.0), fov_y=30.0)
    for ink in clusters:
        places = np.vstack(ink)
        size = float(np.ptp(places, axis=0).max())
        middle = 0.5 * (places.max(axis=0) + places.min(axis=0))
        strokes = [one_stroke((600, 450) + 360.0 / size * (one - middle), eye) for one in ink]
        got = curve_from_ink(strokes, scene)
        assert np.isfinite(got.spline.control_points).all()
        assert got.image_error <= 1.5
