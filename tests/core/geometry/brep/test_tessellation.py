"""Triangles of exact shapes: closed along every edge, near the surface, outward."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import shapely
from scipy.spatial import cKDTree

from bozzetto.errors import UserError
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import (
    Brep,
    BSplineSurface,
    Curve,
    Face,
    ParameterCurve,
    Solid,
    Trim,
    brep_mesh,
    plane_face,
    sewn,
    shaded_brep,
    surface_of_revolution,
)
from bozzetto.geometry.brep import tessellation
from bozzetto.geometry.brep.brep import signed_area
from bozzetto.geometry.brep.shared_sides import FaceTriangles, with_single_sides
from bozzetto.geometry.brep.tessellation import face_meshes
from bozzetto.geometry.brep.triangulation import triangulated
from tests.core.geometry.brep.exact_shapes import KNOWN, UP, ZERO, bent_net, box, circle

TOLERANCES = (0.3, 0.02)


def sides_of(triangles):
    """Directed sides, and how many triangles run each."""
    sides = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    return np.unique(sides, axis=0, return_counts=True)


def rim_of(triangles):
    """Directed sides that no triangle runs back; no side may be run twice in one sense."""
    sides, counts = sides_of(triangles)
    assert (counts == 1).all()
    there = {tuple(side) for side in sides.tolist()}
    return {side for side in there if side[::-1] not in there}


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_solids_are_watertight_near_and_of_their_genus(name, tolerance):
    known = KNOWN[name]
    mesh = brep_mesh(known.brep, tolerance)
    facts = check_solid(Solid(mesh))
    assert (facts.genus, facts.parts) == (known.genus, 1)
    assert abs(facts.volume - known.volume) <= tolerance * known.area


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_triangles_of_a_sphere_and_a_torus_are_within_the_tolerance(tolerance):
    shares = np.random.default_rng(2).dirichlet((1, 1, 1), 40)
    for name, far in (
        ("sphere", lambda p: np.linalg.norm(p, axis=-1) - 5.0),
        ("torus", lambda p: np.hypot(np.hypot(p[..., 0], p[..., 1]) - 8.0, p[..., 2]) - 2.0),
    ):
        mesh = brep_mesh(KNOWN[name].brep, tolerance)
        corners = mesh.vertices[mesh.faces].astype(float)
        inside = np.einsum("sk,tkd->std", shares, corners)
        assert np.abs(far(corners)).max() < 1e-5
        off = np.abs(far(inside)).max()
        assert 0.2 * tolerance < off <= 1.05 * tolerance


def test_a_tenth_of_the_tolerance_takes_about_ten_times_the_triangles():
    counts = [len(brep_mesh(KNOWN["torus"].brep, t).faces) for t in (0.3, 0.03)]
    for coarse, fine in pairwise(counts):
        assert 5 <= fine / coarse <= 20


def test_planes_take_no_more_triangles_than_they_must():
    assert len(brep_mesh(box()).faces) == 12


def test_shown_triangles_are_the_same_with_exact_normals():
    brep = KNOWN["sphere"].brep
    shown, closed = shaded_brep(brep, 0.1), brep_mesh(brep, 0.1)
    np.testing.assert_array_equal(shown.vertices[shown.faces], closed.vertices[closed.faces])
    np.testing.assert_allclose(shown.normals, shown.vertices / 5.0, atol=1e-6)


def test_faces_by_themselves_are_the_parts_of_the_whole():
    brep = KNOWN["tube"].brep
    whole, parts = brep_mesh(brep, 0.1), face_meshes(brep, 0.1)
    assert sum(len(part.faces) for part in parts) == len(whole.faces)
    joined = np.concatenate([part.vertices[part.faces] for part in parts])
    np.testing.assert_array_equal(joined, whole.vertices[whole.faces])


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan])
def test_a_tolerance_is_above_zero(tolerance):
    with pytest.raises(UserError, match="above zero"):
        brep_mesh(box(), tolerance)


def test_no_tolerance_asks_for_more_cells_than_a_face_may_have(monkeypatch):
    monkeypatch.setattr(tessellation, "MOST_CELLS", 200)
    monkeypatch.setattr(tessellation, "MOST_DIVISIONS", 32)
    mesh = brep_mesh(KNOWN["sphere"].brep, 1e-6)
    assert check_solid(Solid(mesh)).volume == pytest.approx(KNOWN["sphere"].volume, rel=0.05)
    assert len(mesh.faces) < 5_000


def bunched_profile(seed):
    """A profile from pole to pole, whose parameter runs unevenly."""
    rng = np.random.default_rng(seed)
    heights = np.sort(rng.uniform(0, 9, 7))
    out = rng.uniform(1, 6, 7) * rng.choice([0.05, 1.0], 7)
    out[[0, -1]] = 0.0
    points = np.column_stack((out, np.zeros(7), heights))
    knots = np.concatenate((np.zeros(4), np.sort(rng.uniform(0, 1, 3)) ** 3, np.ones(4)))
    return Curve(3, knots, points, rng.uniform(0.2, 3.0, 7))


@pytest.mark.parametrize("tolerance", [100.0, 1.0, 0.3])
def test_solids_of_uneven_profiles_close_at_every_tolerance(tolerance):
    for seed in range(3):
        brep = surface_of_revolution(bunched_profile(seed), ZERO, UP)
        mesh = brep_mesh(brep, tolerance)
        assert rim_of(mesh.faces) == set()


def test_a_face_that_meets_itself_closes_along_its_seam():
    ring = circle(5.0)
    net = np.stack((ring.control_points, ring.control_points + np.array((0.0, 7.0, 0.0))), axis=1)
    weights = np.stack((ring.weights, ring.weights), axis=1)
    surface = BSplineSurface((2, 1), ring.knots, (0, 0, 1, 1), net, weights)
    tube = sewn([Brep.of_surface(surface)])
    assert (len(tube.edges), len(tube.rim)) == (3, 2)
    for tolerance in (0.5, 0.01):
        rim = rim_of(brep_mesh(tube, tolerance).faces)
        starts, ends = zip(*rim, strict=True)
        assert sorted(starts) == sorted(ends)
        assert len(set(starts)) == len(starts)


def test_diagonals_of_two_faces_with_the_same_corners_are_not_one_side():
    """Two saddles over one square, one up and one down, close to a pillow."""
    ends = np.array([[(0, 0, 0), (0, 9, 3)], [(9, 0, 3), (9, 9, 0)]], float)
    lower, upper = ends * (1, 1, 1), ends.copy()
    knots = np.array((0.0, 0.0, 0.0, 1.0, 1.0, 1.0))
    nets = []
    for net, rise in ((lower, -2.0), (upper, 2.0)):
        middle_u, middle_v = net.mean(axis=0), net.mean(axis=1)
        rows = np.array([
            [net[0, 0], middle_v[0], net[0, 1]],
            [middle_u[0], net.mean(axis=(0, 1)) + np.array((0, 0, rise)), middle_u[1]],
            [net[1, 0], middle_v[1], net[1, 1]],
        ])  # fmt: skip
        nets.append(BSplineSurface((2, 2), knots, knots, rows))
    pillow = sewn([Brep.of_surface(nets[0]).turned_over(), Brep.of_surface(nets[1])])
    assert pillow.is_closed
    for tolerance in (50.0, 0.5, 0.05):
        assert rim_of(brep_mesh(pillow, tolerance).faces) == set()


def test_a_side_that_two_faces_share_inside_is_halved_in_one():
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    flat = BSplineSurface(
        (1, 1), (0, 0, 1, 1), (0, 0, 1, 1), [[(0, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 0)]]
    )
    names = np.arange(4)
    up = FaceTriangles(square, names, np.array([(0, 1, 2), (0, 2, 3)]))
    down = FaceTriangles(square, names, np.array([(0, 2, 1), (0, 3, 2)]))
    vertices, faces = with_single_sides(np.eye(4, 3), [up, down], [flat, flat])
    every = np.concatenate([face.vertices[face.triangles] for face in faces])
    assert rim_of(every) == set()
    assert [len(face.triangles) for face in faces] == [2, 4]
    np.testing.assert_array_equal(vertices[4:], [(0.5, 0.5, 0.0)])


# -- trimmed at random -------------------------------------------------------------------------


def wobbly_ring(rng, middle, radius, count):
    """A closed smooth ring round a place, in the unit square."""
    turn = np.sort(rng.uniform(0, 2 * np.pi, count))
    reach = radius * rng.uniform(0.45, 1.0, count)
    ring = middle + reach[:, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
    return ring if signed_area(ring) > 0 else ring[::-1]


def trimmed(seed):
    """A saddle within a random polygon with holes; None where the polygon crosses itself."""
    rng = np.random.default_rng(seed)
    corners = np.array([(0, 0, 0), (0, 30, 4), (30, 0, 5), (30, 30, -6)], float)
    corners[:, 2] *= rng.uniform(-2, 2)
    net = corners.reshape(2, 2, 3)
    surface = BSplineSurface((1, 1), (0, 0, 1, 1), (0, 0, 1, 1), net)
    rings = [wobbly_ring(rng, (0.5, 0.5), 0.48, int(rng.integers(4, 14)))]
    for _ in range(int(rng.integers(0, 4))):
        hole = wobbly_ring(rng, rng.uniform(0.3, 0.7, 2), rng.uniform(0.02, 0.12), 7)[::-1]
        if shapely.Polygon(rings[0], [*rings[1:], hole]).is_valid:
            rings.append(hole)
    if not shapely.Polygon(rings[0], rings[1:]).is_valid:
        return None
    edges, loops = [], []
    for ring in rings:
        loop = []
        for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            # On a bilinear surface a straight line in u and v is a parabola, exactly.
            ends = surface.value(*np.stack((a, 0.5 * (a + b), b)).T)
            inner = 2.0 * ends[1] - 0.5 * (ends[0] + ends[2])
            loop.append(Trim(len(edges), True, ParameterCurve.line(a, b, (0.0, 1.0))))
            edges.append(Curve(2, np.repeat((0.0, 1.0), 3), np.stack((ends[0], inner, ends[2]))))
        loops.append(tuple(loop))
    return Brep(tuple(edges), (Face(surface, tuple(loops)),))


@pytest.mark.parametrize("seeds", [range(12), pytest.param(range(12, 300), marks=pytest.mark.slow)])
def test_random_trimmed_faces_close_along_every_edge(seeds):
    breps = [brep for brep in map(trimmed, seeds) if brep is not None]
    assert len(breps) >= 0.75 * len(seeds)
    for brep in breps:
        mesh = brep_mesh(brep, 0.05)
        rim = rim_of(mesh.faces)
        starts, ends = zip(*sorted(rim), strict=True)
        assert sorted(starts) == sorted(ends)  # closed rings
        loops = brep.faces[0].loops
        assert euler(mesh.faces) == 2 - len(loops)
        polygon = shapely.Polygon(*rings_of(brep))
        flat = flat_places(brep, mesh)[mesh.faces]
        ab, ac = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
        areas = 0.5 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
        assert areas.min() > -1e-7  # none is folded over
        assert areas.sum() == pytest.approx(polygon.area, rel=1e-5)


def euler(faces):
    sides = np.sort(np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    return len(np.unique(faces)) - len(np.unique(sides, axis=0)) + len(faces)


def rings_of(brep):
    loops = [[trim.ends[0] for trim in loop] for loop in brep.faces[0].loops]
    return loops[0], loops[1:]


def flat_places(brep, mesh):
    """u and v of vertices: x and y of this surface are those, times 30."""
    return mesh.vertices[:, :2].astype(float) / 30.0


def test_holes_of_every_size_in_a_bent_face_keep_the_tolerance():
    for seed in range(5):
        brep = trimmed(seed)
        if brep is None:
            continue
        surface = brep.faces[0].surface
        mesh = brep_mesh(brep, 0.05)
        middles = mesh.vertices[mesh.faces].astype(float).mean(axis=1)
        on = surface.value(*(middles[:, :2] / 30.0).T)
        assert np.abs(on[:, 2] - middles[:, 2]).max() <= 0.05 * 1.5


# -- the triangulation alone -------------------------------------------------------------------


def area(points, triangles):
    a, b, c = points[triangles].transpose(1, 0, 2)
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def test_a_comb_thinner_than_a_cell_is_triangulated_whole():
    teeth = np.concatenate([[(k, 0.0), (k + 0.05, 8.0)] for k in range(9)])
    ring = np.vstack((teeth, [(8.5, -1.0), (0.0, -1.0)]))[::-1]
    points, triangles = triangulated([ring], (9, 9))
    every = np.vstack((ring, points))
    assert area(every, triangles).sum() == pytest.approx(signed_area(ring))
    assert area(every, triangles).min() > -1e-12


def test_rings_that_cross_still_close():
    bow = np.array([(0, 0), (4, 4), (4, 0), (0, 4.1)], float)
    _, triangles = triangulated([bow], (0, 0))
    assert len(rim_of(triangles)) == 4


def test_a_disc_in_a_plate_is_round_within_the_tolerance():
    knots = (0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4)
    flat = np.array(
        [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)], float
    )
    weights = (1, 2**-0.5) * 4 + (1,)
    ring = Curve(2, knots, np.column_stack((3 * flat, np.zeros(9))), weights, closed=True)
    plate = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
    mesh = brep_mesh(plane_face([plate, [ring]]), 0.01)
    total = area(mesh.vertices[:, :2].astype(float), mesh.faces).sum()
    assert 0.0 <= total - (324 - np.pi * 9) <= 0.01 * 2 * np.pi * 3


def test_bent_faces_of_any_degree_are_near():
    for seed in range(2):
        surface = bent_net(seed)
        (u0, u1), (v0, v1) = surface.ranges
        mesh = brep_mesh(Brep.of_surface(surface), 0.02)
        u, v = np.meshgrid(np.linspace(u0, u1, 60), np.linspace(v0, v1, 60))
        places = surface.value(u.ravel(), v.ravel())
        corners = mesh.vertices[mesh.faces].astype(float)
        shares = np.array([(i, j, 6 - i - j) for i in range(7) for j in range(7 - i)]) / 6
        dense = np.einsum("sk,tkd->std", shares, corners).reshape(-1, 3)
        far, _ = cKDTree(dense).query(places)
        spacing = np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1).max() / 6
        assert far.max() <= 0.02 + spacing
