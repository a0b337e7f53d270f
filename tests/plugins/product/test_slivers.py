"""Meshes for files that know corners by their places: closed, and without edges too short."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from bozzetto_product.shaping.slivers import contracted, moved_apart


def overlapping(count: int, by: float) -> Manifold:
    """Boxes that stand out of one another by little: their union has slivers all round."""
    parts = [Manifold.cube((1, 1, 1)).translate((k, by * k, by * k)) for k in range(count)]
    wider = [part.scale((1.0 + by, 1.0, 1.0)) for part in parts]
    return Manifold.batch_boolean(wider, 0)


def arrays(solid: Manifold) -> tuple[np.ndarray, np.ndarray]:
    mesh = solid.to_mesh64()
    return mesh.vert_properties[:, :3].copy(), mesh.tri_verts.astype(np.intp)


def sides(faces: np.ndarray) -> dict[tuple[int, int], int]:
    found: dict[tuple[int, int], int] = {}
    for a, b, c in faces.tolist():
        for side in ((a, b), (b, c), (c, a)):
            found[side] = found.get(side, 0) + 1
    return found


def is_closed(faces: np.ndarray) -> bool:
    every = sides(faces)
    return set(every.values()) == {1} and all((b, a) in every for a, b in every)


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = vertices.astype(float)[faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def noisy_ball(seed: int, share: float) -> tuple[np.ndarray, np.ndarray]:
    """A ball in which a share of the corners is beside another one, within 1e-6."""
    random = np.random.default_rng(seed)
    vertices, faces = arrays(Manifold.sphere(1.0, 48))
    for a, b in faces[random.random(len(faces)) < share, :2]:
        vertices[a] = vertices[b] + 1e-7 * random.normal(size=3)
    return vertices, faces


@pytest.mark.parametrize("seed", range(7200, 7206))
def test_short_edges_go_and_the_surface_stays_closed(seed: int) -> None:
    vertices, faces = noisy_ball(seed, 0.15)
    made, rest, kept = contracted(vertices, faces, 1e-5)
    assert is_closed(rest)
    assert len(rest) < len(faces)
    beside: dict[int, set[int]] = {}
    for a, b in sides(rest):
        beside.setdefault(a, set()).add(b)
    for a, b in sides(rest):
        if np.linalg.norm(made[a] - made[b]) < 1e-5:
            assert len(beside[a] & beside[b]) > 2
    assert volume(made, rest) == pytest.approx(volume(vertices, faces), rel=1e-4)
    assert (np.diff(kept) > 0).all()
    middles = vertices[faces[kept]].mean(axis=1), made[rest].mean(axis=1)
    np.testing.assert_allclose(*middles, atol=1e-4)


def test_slivers_of_a_union_go() -> None:
    vertices, faces = arrays(overlapping(6, 1e-6))
    made, rest, _ = contracted(vertices, faces, 1e-5)
    assert is_closed(rest)
    assert volume(made, rest) == pytest.approx(6.0, rel=1e-4)
    assert len(rest) < len(faces)


def test_a_tetrahedron_has_no_edge_to_lose() -> None:
    vertices, faces = arrays(Manifold.tetrahedron().scale((1e-7, 1e-7, 1e-7)))
    _, rest, _ = contracted(vertices, faces, 1e-5)
    assert len(rest) == 4
    assert is_closed(rest)


def test_a_ring_of_three_short_edges_about_a_neck_is_not_pinched() -> None:
    """Two tetrahedra over a tiny triangle: without its edges only a point would join them."""
    neck = 1e-7 * np.array([(1, 0, 0), (-0.5, 0.9, 0), (-0.5, -0.9, 0)])
    vertices = np.concatenate((neck, [(0, 0, 1), (0, 0, -1)]))
    faces = np.array([(0, 1, 3), (1, 2, 3), (2, 0, 3), (1, 0, 4), (2, 1, 4), (0, 2, 4)])
    _, rest, _ = contracted(vertices, faces, 1e-5)
    assert is_closed(rest)


@pytest.mark.parametrize("bodies", [2, 5])
def test_corners_at_one_place_are_moved_apart(bodies: int) -> None:
    """The same body several times at one place: all normals are alike."""
    corners, triangles = arrays(Manifold.cube((10, 10, 10)))
    vertices = np.concatenate([corners] * bodies)
    faces = np.concatenate([triangles + k * len(corners) for k in range(bodies)])
    mesh = moved_apart(vertices, faces, 17.0)
    assert len(np.unique(mesh.vertices, axis=0)) == len(vertices)
    assert np.abs(mesh.vertices - vertices).max() < 1e-3


def test_a_mesh_that_touches_nowhere_stays() -> None:
    vertices, faces = arrays(Manifold.sphere(3.0, 24))
    np.testing.assert_array_equal(moved_apart(vertices, faces, 6.0).vertices, np.float32(vertices))
    made, rest, kept = contracted(vertices, faces, 1e-5)
    np.testing.assert_array_equal(made[rest], vertices[faces])
    assert len(kept) == len(faces)
