"""Surfaces of revolution, ruled and plane faces, sewn: closed forms, laws and hostile input."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import (
    Brep,
    BSplineSurface,
    Curve,
    Placement,
    brep_mesh,
    cylinder,
    plane_face,
    ruled_surface,
    sewn,
    surface_of_revolution,
)
from bozzetto.geometry.spline import Spline
from tests.core.geometry.brep.exact_shapes import (
    KNOWN,
    UP,
    ZERO,
    bent_net,
    box,
    circle,
    half_circle,
    polyline,
)

RNG = np.random.default_rng(9)
SQUARE = np.array([(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)], float)
HOLE = SQUARE / 3 + (2, 2, 0)


def on_faces(brep, count=300):
    """Places on all whole faces and the normals there."""
    places, normals = [], []
    for face in brep.faces:
        (u0, u1), (v0, v1) = face.surface.ranges
        u = np.append(RNG.uniform(u0, u1, count), [u0, u1, u0, u1])
        v = np.append(RNG.uniform(v0, v1, count), [v0, v0, v1, v1])
        places.append(face.surface.value(u, v))
        normals.append(face.surface.normals(u, v))
    return np.concatenate(places), np.concatenate(normals)


# -- revolution --------------------------------------------------------------------------------


def test_every_point_of_a_sphere_is_at_its_radius_and_normals_look_out_at_the_poles_too():
    places, normals = on_faces(KNOWN["sphere"].brep)
    assert np.abs(np.linalg.norm(places, axis=1) - 5.0).max() < 1e-14 * 5 * 10
    np.testing.assert_allclose(normals, places / 5.0, atol=1e-11)


def test_every_point_of_a_torus_is_at_its_radius_from_the_ring():
    places, normals = on_faces(KNOWN["torus"].brep)
    out = np.hypot(places[:, 0], places[:, 1])
    assert np.abs(np.hypot(out - 8.0, places[:, 2]) - 2.0).max() < 1e-12
    ring = 8.0 * places[:, :2] / out[:, None]
    expected = np.column_stack((places[:, :2] - ring, places[:, 2])) / 2.0
    np.testing.assert_allclose(normals, expected, atol=1e-11)


@pytest.mark.parametrize("angle", [0.3, pi / 2, 2.0, pi, 4.0, 1.9 * pi, 2 * pi])
def test_a_skew_line_sweeps_a_hyperboloid_of_any_angle(angle):
    line = polyline([(3.0, -4.0, -4.0), (3.0, 4.0, 4.0)])  # skew to the axis, at 3 mm
    found = surface_of_revolution(line, (0, 0, 50), (0, 0, 0.1), angle)
    places, _ = on_faces(found)
    x, y, z = places.T
    assert np.abs((x**2 + y**2 - z**2) - 9.0).max() < 1e-11
    ends = np.array([face.surface.ranges[0] for face in found.faces])
    assert ends.max() - ends.min() == angle
    assert len(found.faces) == (2 if angle > pi else 1)


def test_a_partial_turn_ends_at_its_angle():
    start = np.array([(4.0, 0.0, 1.0)])
    line = polyline([start[0], (4.0, 0.0, 6.0)])
    for angle in (0.7, 2.9, 3.3, 6.0):
        found = surface_of_revolution(line, ZERO, UP, angle)
        ends = np.concatenate([edge.control_points[[0, -1]] for edge in found.edges])
        wanted = (4 * np.cos(angle), 4 * np.sin(angle), 1.0)
        assert np.linalg.norm(ends - wanted, axis=1).min() < 1e-14 * 4 * 10


def test_solids_are_closed_and_look_outward_whichever_way_the_profile_runs():
    for profile in (half_circle(5.0), circle(2.0, (8, 0, 0))):
        for one in (profile, profile.reversed()):
            made = surface_of_revolution(one, ZERO, UP)
            assert made.is_closed
            mesh = brep_mesh(made, 0.1)
            corners = mesh.vertices[mesh.faces].astype(float)
            assert np.linalg.det(corners).sum() > 0


def test_discs_and_rings_are_planes_and_only_poles_are_poles():
    tube, cone, sphere = (KNOWN[name].brep for name in ("tube", "cone", "sphere"))
    assert [len(f.loops) for f in tube.faces if f.surface.is_plane] == [2, 2]
    assert [len(f.loops) for f in cone.faces if f.surface.is_plane] == [1]
    for made, poles in ((tube, 0), (cone, 2), (sphere, 4)):
        assert sum(t.edge is None for f in made.faces for t in f.trims) == poles
    assert len(sphere.vertices[0]) == 2


def test_no_face_meets_itself():
    for name, known in KNOWN.items():
        for face in known.brep.faces:
            own = [trim.edge for trim in face.trims if trim.edge is not None]
            assert len(own) == len(set(own)), name


def test_splitting_a_profile_changes_no_place():
    profile = Curve(
        3, [0] * 4 + [0.4] + [1] * 4, [[1, 0, 0], [6, 0, 0], [6, 0, 8], [2, 0, 9], [3, 0, 14]]
    )
    cut = profile.with_knots(np.sort(np.append(profile.knots, [0.25, 0.4, 0.7, 0.7])))
    one, two = (surface_of_revolution(p, ZERO, UP) for p in (profile, cut))
    u, v = RNG.uniform(0, pi, 200), RNG.uniform(0, 1, 200)
    for first, second in zip(one.faces, two.faces, strict=True):
        np.testing.assert_allclose(
            first.surface.value(u, v), second.surface.value(u, v), atol=1e-13 * 20
        )


def test_a_turned_profile_sweeps_the_turned_solid():
    place = Placement((0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0), 3.0, (10.0, 20.0, -5.0))
    moved = surface_of_revolution(
        half_circle(5.0).placed(place), place.points([ZERO])[0], place.directions([UP])[0]
    )
    for one, two in zip(moved.faces, KNOWN["sphere"].brep.placed(place).faces, strict=True):
        np.testing.assert_allclose(
            one.surface.control_points, two.surface.control_points, atol=1e-12
        )


def test_corners_begin_new_faces_and_smooth_joints_do_not():
    smooth = half_circle(5.0)  # two arcs that run on into each other
    assert len(surface_of_revolution(smooth, ZERO, UP).faces) == 2
    corner = polyline([(5, 0, 0), (6, 0, 3), (5, 0, 6)])
    assert len(surface_of_revolution(corner, ZERO, UP).faces) == 4


@pytest.mark.parametrize(
    ("profile", "point", "axis", "angle", "said"),
    [
        (half_circle(5.0), ZERO, ZERO, 1.0, "no direction"),
        (half_circle(5.0), ZERO, (0, 0, np.inf), 1.0, "no direction"),
        (half_circle(5.0), (0, np.nan, 0), UP, 1.0, "a point and a direction"),
        (half_circle(5.0), ZERO, (0, 1), 1.0, "a point and a direction"),
        (half_circle(5.0), ZERO, UP, 0.0, "angle"),
        (half_circle(5.0), ZERO, UP, 1e-9, "angle"),
        (half_circle(5.0), ZERO, UP, 6.3, "angle"),
        (half_circle(5.0), ZERO, UP, np.nan, "angle"),
        (polyline([(3, 0, 0), (-2, 0, 5)]), ZERO, UP, 1.0, "crosses the axis"),
        (circle(5.0, (3, 0, 0)), ZERO, UP, 2 * pi, "crosses the axis"),
        (polyline([(0, 0, 0), (0, 0, 5)]), ZERO, UP, 2 * pi, "lies on the axis"),
        (polyline([(3, 0, 0), (3, 0, 0)]), ZERO, UP, 2 * pi, "is a point"),
        (polyline([(0, 0, 0), (1e300, 0, 0), (0, 0, 1e300)]), ZERO, UP, 2 * pi, "too far"),
        (
            Curve(1, (0, 0, 1, 1, 2, 2), [(3, 0, 0), (4, 0, 1), (4, 0, 2), (3, 0, 3)]),
            ZERO,
            UP,
            1.0,
            "has a gap",
        ),
    ],
)
def test_what_cannot_be_turned_is_told(profile, point, axis, angle, said):
    with pytest.raises(UserError, match=said):
        surface_of_revolution(profile, point, axis, angle)


def test_a_corner_that_is_given_twice_is_one():
    once = [(0, 0, 0), (3, 0, 0), (3, 0, 5), (0, 0, 5)]
    twice = [once[0], once[1], once[1], once[2], once[3], once[3]]
    one, two = (surface_of_revolution(polyline(p), ZERO, UP) for p in (once, twice))
    assert (len(one.faces), len(two.faces)) == (4, 4)
    assert two.is_closed


@pytest.mark.parametrize("angle", [1e-6, 1e-3, 2 * pi - 1e-6])
def test_angles_near_none_and_near_all_are_turned_through(angle):
    made = surface_of_revolution(polyline([(3, 0, 0), (4, 0, 5)]), ZERO, UP, angle)
    assert made.largest_gap() <= made.tolerance
    assert len(made.rim) == len(made.edges) - (angle > pi)
    assert surface_of_revolution(half_circle(5.0), ZERO, UP, 2 * pi - 1e-12).is_closed


def test_cylinders_between_any_two_points_are_closed_and_of_their_radius():
    rng = np.random.default_rng(31)
    for _ in range(60):
        start = rng.normal(size=3) * 10 ** rng.uniform(-1, 3)
        way = rng.normal(size=3) * rng.integers(0, 2, 3) + (0, 0.3, 0)
        radius = 10 ** rng.uniform(-1, 1) * np.linalg.norm(way)
        made = cylinder(start, start + way, radius)
        assert made.is_closed
        places = brep_mesh(made, 0.2 * radius).vertices - start
        along = way / np.linalg.norm(way)
        beside = np.linalg.norm(places - np.outer(places @ along, along), axis=1)
        near = 1e-5 * radius + 1e-7 * np.linalg.norm(start)
        assert beside.max() == pytest.approx(radius, abs=near)
        assert np.ptp(places @ along) == pytest.approx(np.linalg.norm(way), abs=near)


def test_a_profile_that_passes_through_the_axis_at_one_of_its_points_is_refused():
    with pytest.raises(UserError, match="crosses"):
        surface_of_revolution(polyline([(3, 0, 0), (0, 0, 1), (-3, 0, 2)]), ZERO, UP)


@pytest.mark.parametrize("radius", [0.0, -1.0, np.nan, np.inf])
def test_a_cylinder_needs_a_radius_and_a_height(radius):
    with pytest.raises(UserError, match="radius"):
        cylinder(ZERO, UP, radius)
    with pytest.raises(UserError, match="no direction"):
        cylinder(UP, UP, 1.0)


# -- ruled -------------------------------------------------------------------------------------


def test_a_ruled_surface_runs_straight_between_places_of_equal_parameter():
    first = circle(5.0)
    second = Spline.uniform(RNG.normal(size=(9, 3)) * 8 + (0, 9, 0)).to_curve()
    (face,) = ruled_surface(first, second).faces
    surface = face.surface
    t = RNG.uniform(0, 1, 100)
    np.testing.assert_allclose(surface.value(t, 0 * t), first.value(4 * t), atol=1e-12)
    np.testing.assert_allclose(surface.value(t, 0 * t + 1), second.value(t), atol=1e-12)
    a, b = surface.value(t, 0 * t), surface.value(t, 0 * t + 1)
    across = np.cross(surface.value(t, 0 * t + 0.37) - a, b - a)
    assert np.abs(across).max() < 1e-11


def test_two_circles_and_two_discs_are_a_closed_can():
    low, high = circle(5.0), circle(3.0, (0, 7, 0))
    side = ruled_surface(high, low)
    assert (len(side.faces), len(side.rim)) == (2, 4)
    discs = []
    for height in (0.0, 7.0):
        rim = [side.edges[e] for e in side.rim]
        halves = [edge for edge in rim if np.ptp([*edge.control_points[:, 1], height]) < 1e-9]
        discs.append(plane_face([halves], normal=(0.0, height - 3.5, 0.0)))
    made = sewn([side, *discs])
    assert made.is_closed
    assert len(made.edges) == 6


def test_ends_in_common_are_poles():
    fan = ruled_surface(polyline([ZERO, (5, 0, 0)]), polyline([ZERO, (0, 5, 0)]))
    assert [trim.edge is None for trim in fan.faces[0].trims].count(True) == 1
    assert len(fan.vertices[0]) == 3


def test_two_points_span_nothing():
    with pytest.raises(UserError, match="two points"):
        ruled_surface(polyline([ZERO, ZERO]), polyline([UP, UP]))


def test_a_curve_spans_nothing_with_itself():
    with pytest.raises(UserError, match="itself"):
        ruled_surface(circle(2.0), circle(2.0))


# -- planes ------------------------------------------------------------------------------------


def test_a_plane_face_with_a_hole_has_its_area_whichever_way_outlines_run():
    for outer in (SQUARE, SQUARE[::-1]):
        for inner in (HOLE, HOLE[::-1]):
            made = plane_face([outer, inner], normal=UP)
            np.testing.assert_allclose(made.faces[0].surface.normals([0], [0]), [UP], atol=1e-15)
            mesh = brep_mesh(made)
            corners = mesh.vertices[mesh.faces].astype(float)
            across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            assert 0.5 * across[:, 2].sum() == pytest.approx(81.0 - 9.0)
            assert (across[:, 2] > 0).all()


def test_the_normal_follows_the_outline_unless_it_is_given():
    for outline, up in ((SQUARE, 1.0), (SQUARE[::-1], -1.0)):
        face = plane_face([outline]).faces[0]
        assert face.surface.normals([0], [0])[0, 2] == pytest.approx(up)


def test_corners_keep_their_numbers():
    corners = RNG.normal(size=(3, 3)) * 100
    places, _, _ = plane_face([corners]).vertices
    np.testing.assert_array_equal(np.sort(places, axis=0), np.sort(corners, axis=0))


@pytest.mark.parametrize(
    ("loops", "said"),
    [
        ([], "needs an outline"),
        ([SQUARE[:2]], "three corners"),
        ([SQUARE[:, :2]], "three corners"),
        ([SQUARE * np.nan], "finite"),
        ([np.vstack((SQUARE, SQUARE[:1]))], "apart"),
        ([SQUARE + np.outer([0, 0, 0, 1], UP)], "one plane"),
        ([SQUARE[[0, 2, 1, 3]]], "no area|cross"),
        ([np.vstack((SQUARE[[0, 2, 1]], (-5, 20, 0)))], "cross"),
        ([SQUARE, HOLE + np.array((6, 0, 0))], "cross"),
        ([SQUARE, HOLE + np.array((30, 0, 0))], "cross"),
        ([SQUARE, HOLE, HOLE + np.array((1, 1, 0))], "cross"),
        ([np.outer([0, 1, 3], (1, 1, 1))], "no area"),
        ([SQUARE * 1e-200], "no area"),
        ([SQUARE * 1e200], "too far"),
        ([[polyline(SQUARE)]], "does not close"),
        ([[polyline(SQUARE[:2]), polyline(SQUARE[2:])]], "does not close"),
    ],
)
def test_outlines_that_bound_no_face_are_told(loops, said):
    with pytest.raises(UserError, match=said):
        plane_face(loops)


# -- sewing ------------------------------------------------------------------------------------


def test_a_box_shares_its_edges_and_corners():
    made = box()
    assert (len(made.edges), len(made.vertices[0]), made.is_closed) == (12, 8, True)


def test_the_order_of_faces_does_not_matter():
    parts = [Brep.of_surface(face.surface) for face in box().faces]
    for _ in range(5):
        made = sewn([parts[k] for k in RNG.permutation(6)])
        assert (len(made.edges), made.is_closed) == (12, True)


def test_edges_are_sewn_over_other_ranges_and_the_other_way():
    one = Brep.of_surface(bent_net(3))
    net, weights = one.faces[0].surface.control_points, one.faces[0].surface.weights
    beyond = np.stack((net[-1], net[-1] + (9.0, 0.0, 0.0)))
    across = np.stack((weights[-1], weights[-1]))
    knots = one.faces[0].surface.knots_v
    for flipped in (False, True):
        other = BSplineSurface(
            (1, 2),
            (5.0, 5.0, 8.0, 8.0),
            (knots[-1] - knots[::-1] if flipped else knots) * 7.0 + 1.0,
            beyond[::-1, ::-1] if flipped else beyond,
            across[::-1, ::-1] if flipped else across,
        )
        made = sewn([one, Brep.of_surface(other)])
        assert (len(made.edges), len(made.rim)) == (7, 6)
        assert made.largest_gap() < 1e-12


def test_faces_that_look_apart_are_not_sewn():
    one, two = plane_face([SQUARE]), plane_face([SQUARE * (1, -1, 1)], normal=UP)
    assert len(sewn([one, two]).edges) == 7
    assert len(sewn([one, two.turned_over()]).edges) == 8


def test_sewing_twice_changes_nothing():
    once = box()
    again = sewn([once])
    assert [len(x) for x in (again.edges, again.faces)] == [12, 6]
    for one, two in zip(once.edges, again.edges, strict=True):
        np.testing.assert_array_equal(one.control_points, two.control_points)
