"""Bodies that touch along edges are closed skins, which one edge of four faces does not show."""

from __future__ import annotations

import time
from itertools import pairwise

import manifold3d
import numpy as np
import pytest

from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.mesh.manifold_check import bounds_volume, check_solid, enclosed_volume
from bozzetto.exchange.mesh.touching_edges import apart_at_touching_edges
from bozzetto.geometry import Mesh, Placement, Shapes, Solid, Surface

CORNERS = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)])
SIDES = {
    (-1, 0, 0): (0, 4, 6, 2),
    (1, 0, 0): (1, 3, 7, 5),
    (0, -1, 0): (0, 1, 5, 4),
    (0, 1, 0): (2, 6, 7, 3),
    (0, 0, -1): (0, 2, 3, 1),
    (0, 0, 1): (4, 5, 7, 6),
}


def blocks(cubes) -> Mesh:
    """The skin of cubes of 1 mm, one vertex for each place."""
    filled = {tuple(map(int, cube)) for cube in cubes}
    quads = [
        np.array(cube) + CORNERS[list(side)]
        for cube in sorted(filled)
        for away, side in SIDES.items()
        if tuple(np.add(cube, away).tolist()) not in filled
    ]
    places, at = np.unique(np.concatenate(quads), axis=0, return_inverse=True)
    corners = at.reshape(-1, 4)
    faces = np.concatenate((corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]))
    return Mesh(places.astype(np.float32), faces.astype(np.int32))


def scattered(seed, count=40):
    return np.random.default_rng(seed).integers(0, 5, (count, 3))


def times_of_edges(faces):
    edges = np.sort(np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]


@pytest.mark.parametrize("seed", range(8))
def test_scattered_cubes_are_closed_skins_of_their_volume(seed):
    mesh = blocks(scattered(seed))
    assert times_of_edges(mesh.faces).max() == 4
    assert not bounds_volume(mesh)
    kept, faces = apart_at_touching_edges(mesh.vertices, mesh.faces)
    np.testing.assert_array_equal(kept[faces], mesh.faces)
    apart = Mesh(mesh.vertices[kept], faces)
    assert set(times_of_edges(faces)) == {2}
    assert bounds_volume(apart)
    count = len(np.unique(scattered(seed), axis=0))
    assert enclosed_volume(apart) == pytest.approx(count, rel=1e-6)
    assert check_solid(Solid(apart, "cubes")).volume == pytest.approx(count, rel=1e-6)
    judge = manifold3d.Manifold(
        manifold3d.Mesh(np.array(apart.vertices), np.array(faces, np.uint32))
    )
    assert judge.status() == manifold3d.Error.NoError
    assert judge.volume() == pytest.approx(count, rel=1e-5)


def test_material_stays_together_and_bodies_apart():
    """Two cubes at one edge are two bodies; a ring of cubes about that edge has one skin there."""
    mesh = blocks([(0, 0, 0), (1, 1, 0)])
    kept, _ = apart_at_touching_edges(mesh.vertices, mesh.faces)
    assert len(kept) == 16
    ring = blocks([(0, 0, 0), (1, 1, 0), (0, 0, 1), (1, 1, 1), (0, 1, 1)])
    kept, faces = apart_at_touching_edges(ring.vertices, ring.faces)
    facts = check_solid(Solid(Mesh(ring.vertices[kept], faces), "ring"))
    assert (facts.parts, facts.volume) == (1, pytest.approx(5.0))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_answer_does_not_hang_on_order_place_or_size(seed):
    mesh = blocks(scattered(seed))
    chance = np.random.default_rng(seed)
    plain = apart_at_touching_edges(mesh.vertices, mesh.faces)
    order, names = chance.permutation(len(mesh.faces)), chance.permutation(len(mesh.vertices))
    turned = chance.integers(0, 3, len(order))
    faces = np.stack([np.roll(names[f], t) for f, t in zip(mesh.faces[order], turned, strict=True)])
    angle = 0.7
    c, s = np.cos(angle), np.sin(angle)
    placed = Placement((c, -s, 0, s, c, 0, 0, 0, 1), 1000.0, (3e4, -2e3, 70.0))
    moved = np.empty_like(mesh.vertices)
    moved[names] = placed.points(mesh.vertices)
    other = apart_at_touching_edges(moved, faces.astype(np.int32))
    assert len(other[0]) == len(plain[0])
    assert bounds_volume(Mesh(moved[other[0]], other[1]))


def test_what_is_not_two_sided_everywhere_is_left():
    cube = blocks([(0, 0, 0)])
    assert apart_at_touching_edges(cube.vertices, cube.faces) is None, "nothing touches"
    pair = blocks([(0, 0, 0), (1, 1, 0)])
    for faces in (
        pair.faces[1:],  # a hole
        np.concatenate((pair.faces[:1, ::-1], pair.faces[1:])),  # one turned over
        np.concatenate((pair.faces, pair.faces)),  # everything twice
        np.concatenate((pair.faces, pair.faces[:, ::-1])),  # and inside out
    ):
        assert apart_at_touching_edges(pair.vertices, faces.astype(np.int32)) is None


def test_many_edges_take_time_in_line_with_their_number():
    """Cubes at every second place of a layer, corner to corner."""
    seconds = []
    for side in (20, 40, 80):
        grid = np.argwhere(np.add.outer(np.arange(side), np.arange(side)) % 2 == 0)
        mesh = blocks(np.column_stack((grid, np.zeros(len(grid), int))))
        tries = []
        for _ in range(3):
            begun = time.thread_time()
            kept, _ = apart_at_touching_edges(mesh.vertices, mesh.faces)
            tries.append(time.thread_time() - begun)
        assert len(kept) == 8 * len(grid)
        seconds.append(min(tries))
    assert all(later < 8 * before + 0.05 for before, later in pairwise(seconds))


@pytest.mark.parametrize("ending", ["obj", "stl", "ply", "glb"])
def test_files_of_touching_bodies_are_solids(tmp_path, ending):
    mesh = blocks([(0, 0, 0), (1, 1, 0), (1, 0, 1)])
    export(Shapes(surfaces=(Surface(mesh, "cubes"),)), tmp_path / f"a.{ending}")
    read = read_mesh_file(tmp_path / f"a.{ending}", trusted=True).shapes
    assert not read.surfaces
    assert enclosed_volume(read.solids[0].mesh) == pytest.approx(3.0, rel=1e-5)
    export(read, tmp_path / "again.obj")
    again = read_mesh_file(tmp_path / "again.obj", trusted=True).shapes
    assert len(again.solids) == len(read.solids)
