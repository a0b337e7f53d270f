"""Closest places on meshes against planes and edges taken one by one, and against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.geometry import Mesh
from bozzetto.geometry.mesh_places import closest_on_mesh, face_normals
from bozzetto.ink.curves.nearest import distances_to_polyline
from tests.core.scene.shapes import box, soup, sphere


def distance_to_triangle(points, a, b, c):
    """Distance from the plane where the foot lies between the edges, else from the edges."""
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    height = (points - a) @ normal
    foot = points - height[:, None] * normal
    sides = [np.cross(q - p, foot - p) @ normal for p, q in ((a, b), (b, c), (c, a))]
    border = distances_to_polyline(points, np.stack((a, b, c, a)))
    return np.where(np.min(sides, axis=0) >= 0.0, np.abs(height), border)


@given(st.integers(0, 10**6), st.integers(1, 200), st.sampled_from([0.1, 12.0, 1000.0]))
@settings(max_examples=25, deadline=None)
def test_no_triangle_is_closer(seed, count, spread):
    mesh = soup(seed, count)
    points = np.random.default_rng(seed).uniform(-spread, spread, (30, 3))
    found = closest_on_mesh(mesh, points)
    corners = mesh.vertices[mesh.faces].astype(float)
    oracle = np.min([distance_to_triangle(points, *each) for each in corners], axis=0)
    np.testing.assert_allclose(found.distances, oracle, rtol=1e-7, atol=1e-9)
    away = np.linalg.norm(found.points(mesh) - points, axis=1)
    np.testing.assert_allclose(away, oracle, rtol=1e-7, atol=1e-9)
    assert (found.weights >= 0).all()
    np.testing.assert_allclose(found.weights.sum(axis=1), 1.0, atol=1e-12)


def test_a_place_on_the_mesh_is_its_own_closest():
    mesh = sphere(40.0)
    random = np.random.default_rng(4)
    faces = random.integers(200, len(mesh.faces) - 200, 100)
    weights = random.dirichlet((1, 1, 1), 100)
    points = np.einsum("nc,ncx->nx", weights, mesh.vertices[mesh.faces[faces]].astype(float))
    found = closest_on_mesh(mesh, points)
    assert found.distances.max() < 1e-9
    np.testing.assert_array_equal(found.faces, faces)
    np.testing.assert_allclose(found.weights, weights, atol=1e-9)


def test_only_faces_that_look_the_same_way_count():
    plate = box((40.0, 40.0, 1.0))
    points = np.array([(3.0, 4.0, -0.4), (5.0, 1.0, -3.0)])  # nearer to the bottom
    up = np.tile((0.0, 0.0, 1.0), (2, 1))
    assert (closest_on_mesh(plate, points).points(plate)[:, 2] == -0.5).all()
    top = closest_on_mesh(plate, points, up)
    np.testing.assert_allclose(top.points(plate), [(3, 4, 0.5), (5, 1, 0.5)], atol=1e-12)
    np.testing.assert_allclose(top.distances, [0.9, 3.5], atol=1e-12)
    np.testing.assert_array_equal(face_normals(plate, top.faces), up)


@pytest.mark.parametrize(("within", "height"), [(0.5, -0.5), (0.8, 0.5)])
def test_faces_that_look_the_same_way_are_looked_for_within_a_distance(within, height):
    plate = box((40.0, 40.0, 1.0))
    points, up = np.array([(3.0, 4.0, -0.2)]), np.array([(0.0, 0.0, 1.0)])
    found = closest_on_mesh(plate, points, up, within)
    assert found.points(plate)[0] == pytest.approx((3.0, 4.0, height), abs=1e-6)


@pytest.mark.parametrize("count", [1, 5, 2000])
def test_however_many_are_asked_for_each_has_the_same_answer(count):
    """One point, few and many begin with different bounds."""
    mesh = soup(3, 3000)
    points = np.random.default_rng(1).uniform(-12.0, 12.0, (2000, 3))
    whole = closest_on_mesh(mesh, points)
    for begin in range(0, 2000, 400):
        part = closest_on_mesh(mesh, points[begin : begin + count])
        assert np.array_equal(part.distances, whole.distances[begin : begin + count])


def test_where_no_face_looks_the_same_way_all_count():
    sheet = Mesh([(0, 0, 0), (9, 0, 0), (0, 9, 0)], [(0, 1, 2)])
    found = closest_on_mesh(sheet, [(1, 1, 2)], [(0, 0, -1)])
    assert found.distances[0] == pytest.approx(2.0)


def test_faces_without_area_and_empty_meshes():
    flat = Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2), (1, 1, 1)])
    found = closest_on_mesh(flat, [(1.5, 1, 0), (5, 0, 0)], [(0, 0, 1), (0, 0, 1)])
    np.testing.assert_allclose(found.distances, [1.0, 3.0])
    assert (face_normals(flat, [0, 1]) == 0).all()
    assert closest_on_mesh(flat, np.zeros((0, 3))).distances.shape == (0,)
    with pytest.raises(ValueError, match="empty mesh"):
        closest_on_mesh(Mesh(np.zeros((0, 3)), np.zeros((0, 3))), [(0, 0, 0)])
