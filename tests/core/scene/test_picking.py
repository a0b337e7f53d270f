"""Ray casting against closed forms, and against a slow cast by signed volumes."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.geometry.mesh import Mesh
from bozzetto.scene import Layer, Lines, Scene, Shaded
from bozzetto.scene.picking import cast_rays, place_on_lines
from bozzetto.view.camera import Camera, Rays
from tests.core.scene.shapes import box, scene_of, soup, sphere


def rays_of(seed, count, spread=12.0):
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return Rays(random.uniform(-spread, spread, (count, 3)), directions)


def cast_by_volumes(mesh, rays):
    """Distance by orientation tests on tetrahedra: no formula shared with the program."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    found = []
    for origin, direction in zip(*rays, strict=True):
        tip = origin + direction * 1000.0

        def volume(p, q, r, s):
            return np.linalg.det(np.stack(np.broadcast_arrays(q - p, r - p, s - p), 1))

        sides = [volume(origin, tip, a, b), volume(origin, tip, b, c), volume(origin, tip, c, a)]
        through = (np.min(sides, 0) >= 0) | (np.max(sides, 0) <= 0)
        above, below = volume(origin, a, b, c), volume(tip, a, b, c)
        through &= above * below < 0
        at = above[through] / (above[through] - below[through]) * 1000.0
        found.append(at.min() if len(at) else np.inf)
    return np.array(found)


@given(st.integers(0, 10**6), st.integers(1, 400))
@settings(max_examples=20, deadline=None)
def test_agrees_with_a_cast_by_signed_volumes(seed, count):
    mesh, rays = soup(seed, count), rays_of(seed + 1, 60)
    hits = cast_rays(scene_of(Shaded(mesh)), rays)
    np.testing.assert_allclose(hits.distance, cast_by_volumes(mesh, rays), rtol=1e-7)


def test_a_box_is_hit_where_its_planes_are():
    scene = scene_of(Shaded(box()))
    hits = cast_rays(scene, Rays(np.array([[0.3, -5.0, 0.4]]), np.array([[0.0, 1.0, 0.0]])))
    assert hits.distance[0] == pytest.approx(4.0)
    np.testing.assert_allclose(hits.points[0], (0.3, -1.0, 0.4), atol=1e-12)
    np.testing.assert_allclose(hits.normals[0], (0.0, -1.0, 0.0), atol=1e-12)
    assert hits.owners == ("m",)


def test_from_inside_the_far_side_is_hit_and_its_normal_faces_the_eye():
    hits = cast_rays(
        scene_of(Shaded(box())), Rays(np.zeros((2, 3)), np.array([[0, 0, 1.0], [1.0, 0, 0]]))
    )
    np.testing.assert_allclose(hits.distance, 1.0)
    np.testing.assert_allclose(hits.normals, [(0, 0, -1), (-1, 0, 0)], atol=1e-12)


def test_no_ray_slips_through_shared_edges_and_corners():
    """Rays at every lattice place of a fine sheet: on edges, on vertices, and between."""
    side = np.linspace(-1, 1, 21)
    x, y = np.meshgrid(side, side)
    vertices = np.column_stack((x.ravel(), y.ravel(), 0.1 * np.sin(3 * x.ravel()))).astype("f4")
    i = (np.arange(20)[:, None] * 21 + np.arange(20)).ravel()
    faces = np.concatenate((np.c_[i, i + 1, i + 22], np.c_[i, i + 22, i + 21]))
    x, y = np.meshgrid(*[vertices[:21, 0].astype(float)[1:-1]] * 2)
    fine = np.column_stack((x.ravel(), y.ravel(), np.full(x.size, 5.0)))
    middle = fine + np.array((0.05, 0.0, 0.0))
    origins = np.concatenate((fine, middle, fine + np.array((0.05, 0.05, 0.0))))
    hits = cast_rays(
        scene_of(Shaded(Mesh(vertices, faces))),
        Rays(origins, np.tile((0.0, 0.0, -1.0), (len(origins), 1))),
    )
    assert hits.hit.all()


def test_rays_in_a_plane_and_broken_rays_and_flat_faces_hit_nothing():
    flat = Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 0, 0)], [(0, 1, 2), (0, 3, 0)])
    sheet = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    rays = Rays(
        np.array([[-1, 0.2, 0], [0.2, 0.2, 1], [np.nan, 0, 0], [0.2, 0.2, 1], [0.5, 0, 1.0]]),
        np.array([[1, 0, 0], [0, 0, 0], [0, 0, 1], [0, 0, np.inf], [0, 0, 1.0]]),
    )
    hits = cast_rays(scene_of(Shaded(flat), Shaded(sheet)), rays)
    assert not hits.hit.any()
    assert np.isnan(hits.points).all()
    assert hits.owners == ("",) * 5


def test_what_cannot_be_picked_is_looked_through():
    near, far = box(center=(0, -10, 0)), box(center=(0, 10, 0))
    ray = Rays(np.array([[0.0, -50.0, 0.0]]), np.array([[0.0, 1.0, 0.0]]))
    for ghost in (Shaded(near, pickable=False), Shaded(near, opacity=0.0)):
        assert cast_rays(scene_of(ghost, Shaded(far)), ray).distance[0] == pytest.approx(59)
    both = Scene(
        (Layer("a", (Shaded(far),), "far"), Layer("b", (Shaded(near, opacity=0.3),), "near"))
    )
    hits = cast_rays(both, ray)
    assert hits.owners == ("near",)
    assert hits.distance[0] == pytest.approx(39)


def test_nothing_to_hit():
    empty = Mesh(np.zeros((0, 3)), np.zeros((0, 3)))
    rays = rays_of(0, 3)
    assert not cast_rays(Scene(), rays).hit.any()
    assert not cast_rays(scene_of(Shaded(empty)), rays).hit.any()
    assert cast_rays(scene_of(Shaded(box())), Rays(np.zeros((0, 3)), np.zeros((0, 3)))).owners == ()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
def test_distance_to_a_sphere_at_any_scale(scale):
    rays = rays_of(3, 200, 0.3)
    origins = rays.origins * scale
    along = np.einsum("ij,ij->i", origins, rays.directions)
    exact = -along + np.sqrt(along**2 - (origins**2).sum(1) + scale**2)
    hits = cast_rays(scene_of(Shaded(sphere(scale))), Rays(origins, rays.directions))
    np.testing.assert_allclose(hits.distance, exact, rtol=3e-3)
    assert (hits.distance <= exact * (1 + 1e-6)).all(), "chords lie inside the sphere"


def test_the_tree_of_a_mesh_dies_with_it():
    mesh = soup(1, 20)
    cast_rays(scene_of(Shaded(mesh)), rays_of(1, 5))
    gone = weakref.ref(mesh)
    del mesh
    gc.collect()
    assert gone() is None


def test_the_tree_of_a_mesh_holds_each_corner_once():
    """Trees are kept with every mesh that is shown: they are not to hold what they do not use."""
    from bozzetto.geometry.bvh import tree_of

    mesh = sphere()
    tree = tree_of(mesh)
    for part in (tree.corner, tree.edge1, tree.edge2):
        owner = part if part.base is None else part.base
        assert owner.nbytes == 24 * len(mesh.faces)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000), kind=st.sampled_from(["perspective", "orthographic"]))
def test_the_place_on_a_line_is_the_nearest_of_many_that_were_tried(seed, kind):
    random = np.random.default_rng(seed)
    camera = Camera(kind=kind, height=60.0)
    points = random.uniform(-25.0, 25.0, (12, 3)).astype(np.float32)
    lines = Lines(points, starts=np.array([0, 5, 6], np.int32))
    scene = Scene((Layer("curves", (lines,)),))
    pixel = tuple(random.uniform(0.0, camera.viewport))
    shares = np.linspace(0.0, 1.0, 400)[:, None]
    pairs = [(k, k + 1) for k in range(11) if k + 1 not in (5, 6)]
    tried = np.concatenate([(1 - shares) * points[a] + shares * points[b] for a, b in pairs])
    gaps = np.linalg.norm(camera.project(tried)[0] - pixel, axis=1)
    found = place_on_lines(scene, camera, pixel, 1e9)
    gap = np.linalg.norm(camera.project([found])[0][0] - pixel)
    assert gap <= gaps.min() + 1e-6
    assert np.linalg.norm(tried - found, axis=1).min() < 0.2  # it lies on one of them
    assert place_on_lines(scene, camera, pixel, gap - 1e-6) is None


def test_lines_that_are_not_seen_have_no_place():
    camera = Camera()
    behind = 2.0 * np.asarray(camera.eye) - np.asarray(camera.target)
    away = Lines(np.array([behind, behind + 1.0]))
    clear = Lines(np.array([(-5.0, 0.0, 0.0), (5.0, 0.0, 0.0)]), opacity=0.0)
    middle = (0.5 * camera.viewport[0], 0.5 * camera.viewport[1])
    for scene in (
        Scene(),
        Scene(
            (
                Layer(
                    "none",
                    (away, clear, Lines(np.zeros((1, 3)))),
                ),
            )
        ),
    ):
        assert place_on_lines(scene, camera, middle, 1e9) is None
