"""Foot points and ray hits on patches, against closed forms and brute force."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry.patches.closest_points import foot_points
from bozzetto.geometry.patches.coons import coons_nets
from bozzetto.geometry.patches.patch import (
    Places,
    extent,
    grid,
    grid_normals,
    normals_at,
    points_at,
)
from bozzetto.geometry.patches.ray_intersections import ray_hits
from tests.core.geometry.body_kit import body
from tests.core.geometry.patches.test_patch import flat_corner, nets, paraboloid

CAR = coons_nets(*body()[:2])


def around(count, seed=0):
    """Points in and around the body, mm."""
    return np.random.default_rng(seed).normal(size=(count, 3)) * [1800, 900, 600] + [2350, 0, 700]


def distances(own, places, points):
    return np.linalg.norm(points_at(own, places) - points, axis=1)


# -- foot points -------------------------------------------------------------------------------


def brute(own, points, count=81):
    """Distances to the nearest of a fine grid of places."""
    at = np.linspace(0, 1, count)
    fine = grid(own, at, at).reshape(-1, 3)
    return np.array([np.linalg.norm(fine - p, axis=1).min() for p in points])


def bent(seed, size):
    """Patches of 100 mm with control points out of place by `size`."""
    rng = np.random.default_rng(seed)
    flat = np.stack(np.meshgrid(*[np.linspace(0, 100, 4)] * 2, [0.0], indexing="ij"), -1)
    return flat.reshape(4, 4, 3) + size * rng.normal(size=(3, 4, 4, 3))


@pytest.mark.parametrize("own", [CAR, coons_nets(*body(3, 1.0)[:2]), bent(1, 10.0), bent(2, 20.0)])
def test_no_place_of_a_fine_grid_is_nearer_than_the_foot(own):
    low, high = extent(own)
    points = np.random.default_rng(1).uniform(2 * low - high, 2 * high - low, (150, 3))
    feet = foot_points(own, points)
    assert (distances(own, feet, points) <= brute(own, points) + 1e-9 * np.abs(own).max()).all()
    assert (feet.parameters >= 0).all()
    assert (feet.parameters <= 1).all()


def test_on_patches_that_wind_nearly_all_feet_are_the_nearest():
    missed = 0
    for seed in range(6):
        own = nets(3, seed=seed)
        points = np.random.default_rng(seed).normal(size=(100, 3)) * 120
        missed += (distances(own, foot_points(own, points), points) > brute(own, points, 41)).sum()
    assert missed <= 6


def test_feet_are_square_to_the_surface_or_on_a_border():
    points = around(300, 4)
    feet = foot_points(CAR, points)
    offset = points - points_at(CAR, feet)
    for axis, tangent in enumerate((points_at(CAR, feet, du=1), points_at(CAR, feet, dv=1))):
        pull = (offset * tangent).sum(1)
        square = np.abs(pull) <= 1e-6 * np.linalg.norm(offset, axis=1) * np.linalg.norm(
            tangent, axis=1
        )
        at = feet.parameters[:, axis]
        assert (square | ((at == 0) & (pull < 0)) | ((at == 1) & (pull > 0))).all()


def test_points_on_the_surface_come_back():
    rng = np.random.default_rng(3)
    places = Places(rng.integers(0, 28, 500), rng.random((500, 2)))
    points = points_at(CAR, places)
    assert distances(CAR, foot_points(CAR, points), points).max() <= 1e-8
    lifted = points + 5.0 * normals_at(CAR, places)
    assert distances(CAR, foot_points(CAR, lifted), lifted).max() <= 5.0 + 1e-9


def test_feet_on_a_paraboloid_are_those_of_its_profile():
    """Of a point on the axis below the focus the foot is the top; beside it, by a cubic."""
    own = paraboloid()
    points = np.array([[0, 0, 3.0], [0.4, 0, 2.0], [0, -0.9, 1.5], [5, 0, 1]])
    feet = points_at(own, foot_points(own, points))
    for point, foot in zip(points, feet, strict=True):
        r, z = np.hypot(*point[:2]), point[2]
        roots = np.roots([2, 0, 2 * z - 1, -r])  # of the slope of the squared distance, halved
        real = np.clip(roots[np.abs(roots.imag) < 1e-9].real, -1, 1)
        best = min(real, key=lambda x: (x - r) ** 2 + (1 - x * x - z) ** 2)
        assert np.hypot(*foot[:2]) == pytest.approx(best, abs=1e-7)
        assert foot[2] == pytest.approx(1 - best**2, abs=1e-7)


def test_a_place_follows_a_small_change_on_its_own_patch():
    rng = np.random.default_rng(6)
    places = Places(rng.integers(0, 28, 100), rng.uniform(0.2, 0.8, (100, 2)))
    points = points_at(CAR, places) + rng.normal(size=(100, 3))
    feet = foot_points(CAR, points, near=places)
    np.testing.assert_array_equal(feet.patches, places.patches)
    assert (distances(CAR, feet, points) <= distances(CAR, places, points)).all()


def test_feet_at_corners_without_a_tangent_plane():
    own = flat_corner()
    points = np.array([[0, -1, 2.0], [0, 0, 0], [0.5, 0.1, -3]])
    feet = points_at(own, foot_points(own, points))
    np.testing.assert_allclose(feet, [[0, 0, 0], [0, 0, 0], [0.5, 0.1, 0]], atol=1e-6)


def test_feet_on_what_has_no_size_and_of_no_points():
    own = np.ones((2, 4, 4, 3))
    np.testing.assert_allclose(points_at(own, foot_points(own, [[3, 4, 5]])), [[1, 1, 1]])
    assert len(foot_points(CAR, np.zeros((0, 3)))) == 0


# -- rays --------------------------------------------------------------------------------------


def test_rays_on_a_paraboloid_by_the_quadratic_formula():
    own = paraboloid(0.2, 0.1)
    rng = np.random.default_rng(2)
    origins = rng.normal(size=(500, 3)) * 3
    directions = rng.uniform(-1, 1, (500, 3)) * [1, 1, 1.5] - origins
    places, found = ray_hits(own, origins, directions)
    for k in range(500):
        (px, py, pz), (dx, dy, dz) = origins[k] - [0.2, 0.1, 1], directions[k]
        roots = np.roots([dx * dx + dy * dy, 2 * (px * dx + py * dy) + dz, px * px + py * py + pz])
        good = [t.real for t in roots if abs(t.imag) < 1e-12 and t.real >= 0
                and (np.abs(origins[k, :2] + t.real * directions[k, :2]) <= 1).all()]  # fmt: skip
        if good:
            assert found[k] == pytest.approx(min(good), abs=1e-6)
            hit = points_at(own, places[[k]])[0]
            np.testing.assert_allclose(hit, origins[k] + found[k] * directions[k], atol=1e-8)
        else:
            assert places.patches[k] == -1
            assert found[k] == np.inf
            assert not places.parameters[k].any()


def test_rays_hit_what_they_are_aimed_at_or_something_before():
    rng = np.random.default_rng(5)
    places = Places(rng.integers(0, 28, 400), rng.random((400, 2)))
    places.parameters[:100] = np.round(places.parameters[:100])  # nodes
    places.parameters[100:200, 0] = np.round(places.parameters[100:200, 0])  # edges
    targets = points_at(CAR, places)
    origins = targets + 6000 * (lambda d: d / np.linalg.norm(d, axis=1)[:, None])(
        normals_at(CAR, places) + 0.3 * rng.normal(size=(400, 3))
    )
    hits, along = ray_hits(CAR, origins, targets - origins)
    rim = along > 1 + 1e-9  # only a ray aimed at the rim itself may slip past it
    assert (hits.patches[~rim] >= 0).all()
    on_rim = np.abs(places.parameters - 0.5).max(axis=1) == 0.5
    assert not (rim & ~on_rim).any()
    assert rim.sum() <= 3
    points = points_at(CAR, hits[~rim])
    expected = origins[~rim] + along[~rim, None] * (targets - origins)[~rim]
    assert np.abs(points - expected).max() <= 1e-5


def triangles_hit(own, origins, directions, divisions):
    """First hits of rays with a fine net of triangles (Möller & Trumbore), lengths of the rays."""
    at = np.linspace(0, 1, divisions + 1)
    g = grid(own, at, at)
    a, b, c, d = g[:, :-1, :-1], g[:, 1:, :-1], g[:, 1:, 1:], g[:, :-1, 1:]
    p = np.concatenate([a.reshape(-1, 3), a.reshape(-1, 3)])
    e = np.concatenate([b.reshape(-1, 3), c.reshape(-1, 3)]) - p
    f = np.concatenate([c.reshape(-1, 3), d.reshape(-1, 3)]) - p
    found = []
    for o, r in zip(origins, directions, strict=True):
        h = np.cross(r, f)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (h * (o - p)).sum(1) / (h * e).sum(1)
            q = np.cross(o - p, e)
            w = (q * r).sum(1) / (h * e).sum(1)
            t = (q * f).sum(1) / (h * e).sum(1)
        good = (s >= 0) & (w >= 0) & (s + w <= 1) & (t >= 0)
        found.append(t[good].min() if good.any() else np.inf)
    return np.array(found)


def test_rays_meet_the_body_where_they_meet_its_triangles():
    origins = np.tile([-3000.0, -4000.0, 2500.0], (80, 1))
    directions = around(80, 8) - origins
    places, found = ray_hits(CAR, origins, directions)
    expected = triangles_hit(CAR, origins, directions, 40)
    same = np.isfinite(found) == np.isfinite(expected)
    assert same.sum() >= 79  # a ray along the outline may pass between them
    both = np.isfinite(found) & np.isfinite(expected)
    near = np.abs(found[both] - expected[both]) * np.linalg.norm(directions[both], axis=1)
    assert np.sort(near)[-3] <= 5.0  # and one along a fold meets it elsewhere
    assert np.median(near) <= 0.05
    assert (places.patches[both] >= 0).all()


def test_rays_that_graze_are_not_missed():
    own = paraboloid()
    heights = 1 - np.array([1e-12, 1e-9, 1e-6, 1e-3])
    origins = np.column_stack((np.full(4, -5.0), np.zeros(4), heights))
    places, found = ray_hits(own, origins, np.tile([1.0, 0, 0], (4, 1)))
    assert (places.patches == 0).all()
    np.testing.assert_allclose(found, 5 - np.sqrt(1 - heights), atol=1e-4)
    missed, _ = ray_hits(own, [[-5, 0, 1 + 1e-6]], [[1.0, 0, 0]])
    assert missed.patches.tolist() == [-1]


def test_nothing_behind_and_no_patches_and_no_rays():
    own = paraboloid()
    places, found = ray_hits(own, [[0, 0, 5]], [[0, 0, 1.0]])
    assert (places.patches[0], found[0]) == (-1, np.inf)
    places, found = ray_hits(np.zeros((0, 4, 4, 3)), [[0, 0, 5]], [[0, 0, 1.0]])
    assert (places.patches[0], found[0]) == (-1, np.inf)
    places, found = ray_hits(own, np.zeros((0, 3)), np.zeros((0, 3)))
    assert len(places) == len(found) == 0


def test_rays_on_degenerate_patches_give_numbers():
    own = np.concatenate((np.zeros((1, 4, 4, 3)), flat_corner(), paraboloid()))
    rng = np.random.default_rng(0)
    origins = rng.normal(size=(200, 3)) * 4
    origins[:5] = 0
    directions = rng.normal(size=(200, 3))
    places, found = ray_hits(own, origins, directions)
    hit = places.patches >= 0
    assert np.isfinite(found[hit]).all()
    assert np.isinf(found[~hit]).all()
    box = extent(own)
    points = points_at(own, places[hit])
    assert (points >= box[0] - 1e-9).all()
    assert (points <= box[1] + 1e-9).all()
    assert np.isfinite(grid_normals(own, [0, 1], [0, 1])).all()
