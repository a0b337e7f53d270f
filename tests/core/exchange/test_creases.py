"""Vertices divided along creases."""

import numpy as np

from bozzetto.exchange.mesh.creases import divided
from bozzetto.geometry import Mesh, brep_mesh, cylinder

BOX = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
SIDES = np.array(
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
)


def test_a_box_gets_three_vertices_in_every_corner():
    faces = np.concatenate((SIDES[:, [0, 1, 2]], SIDES[:, [0, 2, 3]]))
    vertex, split = divided(Mesh(BOX, faces))
    assert (np.bincount(vertex) == 3).all()
    assert (np.diff(vertex) >= 0).all()
    assert (vertex[split] == faces).all()


def test_a_cylinder_is_divided_along_its_two_circles_only():
    mesh = brep_mesh(cylinder((0, 0, 0), (0, 0, 50), 20.0))
    vertex, split = divided(mesh)
    made = Mesh(mesh.vertices[vertex], split.astype(np.int32))
    normals = made.vertex_normals().astype(float)
    rising = np.abs(normals[:, 2])
    assert ((rising < 1e-3) | (rising > 0.999)).all()
    assert (vertex[split] == mesh.faces).all()


def test_what_is_smooth_stays_as_it_is():
    t = np.linspace(0.0, 1.0, 12)
    x, y = np.meshgrid(t, t)
    places = np.stack((x, y, 0.1 * np.sin(3.0 * x)), axis=-1).reshape(-1, 3)
    at = np.arange(144).reshape(12, 12)
    quads = np.stack((at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]), -1).reshape(-1, 4)
    mesh = Mesh(places, np.concatenate((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]])))
    vertex, split = divided(mesh)
    assert (vertex == np.arange(144)).all()
    assert (split == mesh.faces).all()


def test_an_empty_mesh_has_no_vertices_to_divide():
    vertex, split = divided(Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32)))
    assert len(vertex) == len(split) == 0
