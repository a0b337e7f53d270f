"""Normals at the corners of triangles go along with them."""

import numpy as np
import pytest

from bozzetto.exchange.triangle_budget import within_budget
from bozzetto.geometry import CornerNormals, Mesh, Placement, Shapes, Solid


def box():
    """A box whose sides have normals of their own."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    mesh = Mesh(corners, faces)
    return Solid(mesh, normals=CornerNormals(across(mesh), np.repeat(np.arange(12)[:, None], 3, 1)))


def across(mesh):
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


MIRROR = Placement((1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0), 1000.0, (3.0, 4.0, 5.0))
TURN = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0))


@pytest.mark.parametrize("placement", [MIRROR, TURN, Placement()], ids=["mirror", "turn", "none"])
def test_they_stand_on_their_triangles_wherever_these_are(placement):
    placed = box().placed(placement)
    own = placed.normals.vectors[placed.normals.corners]
    assert np.allclose(own, across(placed.mesh)[:, None], atol=1e-6)


def test_turned_over_they_look_to_the_other_side():
    over = box().normals.turned_over()
    mesh = Mesh(box().mesh.vertices, box().mesh.faces[:, ::-1])
    assert np.allclose(over.vectors[over.corners], across(mesh)[:, None], atol=1e-6)


def test_fewer_triangles_have_normals_of_their_own():
    part = box()
    finer = np.concatenate([part.mesh.vertices, part.mesh.vertices + 3.0])
    faces = np.concatenate([part.mesh.faces, part.mesh.faces + 8])
    normals = CornerNormals.of_meshes([part.mesh, part.mesh])
    shapes = Shapes(solids=(Solid(Mesh(finer, faces), normals=normals),))
    assert within_budget(shapes, 30) is shapes
    (fewer,) = within_budget(shapes, 20).solids
    assert fewer.normals is None


def test_they_are_as_many_as_the_corners():
    with pytest.raises(ValueError, match="normal"):
        Solid(box().mesh, normals=CornerNormals(np.zeros((1, 3)), np.zeros((2, 3), int)))
