"""Normals that break at creases, and curvature with a closed form."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry.mesh import Mesh
from bozzetto.scene.renderer.normals import corner_normals, mean_curvature
from tests.core.scene.shapes import box, soup, sphere


def face_normals(mesh):
    corners = mesh.vertices[mesh.faces].astype(float)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return across / np.linalg.norm(across, axis=1, keepdims=True)


def test_the_faces_of_a_box_are_flat():
    mesh = box((2, 3, 4))
    found = corner_normals(mesh)
    expected = np.repeat(face_normals(mesh)[:, None], 3, axis=1)
    np.testing.assert_allclose(found.vectors[found.corners], expected, atol=1e-6)


def test_a_smooth_mesh_shares_one_normal_at_each_vertex():
    mesh = sphere(10, 40)
    found = corner_normals(mesh)
    inner = (np.abs(mesh.vertices[mesh.faces][:, :, 2]) < 9).all(1)
    np.testing.assert_array_equal(found.corners[inner], mesh.faces[inner])
    exact = mesh.vertices[mesh.faces[inner]] / 10
    # the seam of the mesh is open, so its normals lean to one side there
    assert np.linalg.norm(found.vectors[found.corners[inner]] - exact, axis=2).max() < 0.06


def test_a_cylinder_is_smooth_around_and_sharp_at_its_rim():
    angle = np.arange(32) * 2 * np.pi / 32
    ring = np.stack((np.cos(angle), np.sin(angle)), 1)
    low, high = (np.column_stack((ring, np.full(32, z))) for z in (0.0, 1.0))
    i, j = np.arange(32), (np.arange(32) + 1) % 32
    side = np.concatenate((np.stack((i, j, 32 + j), 1), np.stack((i, 32 + j, 32 + i), 1)))
    lid = np.stack((32 + i, 32 + j, np.full(32, 64)), 1)
    mesh = Mesh(np.concatenate((low, high, [(0, 0, 1.0)])), np.concatenate((side, lid)))
    found = corner_normals(mesh)
    around = found.vectors[found.corners[:64]].reshape(-1, 3)
    outwards = mesh.vertices[mesh.faces[:64]].reshape(-1, 3) * (1, 1, 0)
    np.testing.assert_allclose(around, outwards, atol=0.06)
    np.testing.assert_allclose(
        found.vectors[found.corners[64:]], np.broadcast_to((0, 0, 1), (32, 3, 3)), atol=1e-6
    )


def test_normals_that_a_mesh_brings_are_kept():
    mesh = sphere(2, 8, normals=True)
    assert np.shares_memory(corner_normals(mesh).vectors, mesh.normals)


def test_normals_are_of_unit_length_or_zero_even_of_rubbish():
    mesh = soup(4, 200)
    flat = np.concatenate((mesh.faces, [(0, 0, 1), (5, 5, 5)]))
    length = np.linalg.norm(corner_normals(Mesh(mesh.vertices, flat)).vectors, axis=1)
    assert (np.isclose(length, 1, atol=1e-5) | (length == 0)).all()


def test_too_many_faces_at_one_vertex_are_drawn_flat(monkeypatch):
    mesh = box()
    normal = corner_normals(mesh)
    monkeypatch.setattr("bozzetto.scene.renderer.normals.MOST_PAIRS", 1)
    again = corner_normals(box())
    np.testing.assert_allclose(
        again.vectors[again.corners], normal.vectors[normal.corners], atol=1e-6
    )


@pytest.mark.parametrize("radius", [0.01, 3.0, 1e4])
def test_the_curvature_of_a_sphere(radius):
    mesh = sphere(radius, 24, normals=True)
    inner = np.abs(mesh.vertices[:, 2]) < 0.95 * radius
    np.testing.assert_allclose(mean_curvature(mesh)[inner], 1 / radius, rtol=1e-3)
    turned = Mesh(mesh.vertices, mesh.faces, -mesh.normals)
    np.testing.assert_allclose(mean_curvature(turned)[inner], -1 / radius, rtol=1e-3)
