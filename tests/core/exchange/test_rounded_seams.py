"""Bodies of other programs whose seams are closed but for rounding."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.mesh.polygons import is_degenerate, weld, weld_rounded
from bozzetto.geometry import Mesh, Placement, Shapes, Surface


def globe(gap: float = 0.0, around: int = 16, rings: int = 12) -> Mesh:
    """A ball as three.js makes it: the first and the last meridian at nearly the same place."""
    u = np.linspace(0.0, 2 * np.pi - gap, around + 1)
    v = np.linspace(0.0, np.pi, rings + 1)
    a, b = np.meshgrid(u, v)
    points = 50.0 * np.stack([np.cos(a) * np.sin(b), np.sin(a) * np.sin(b), np.cos(b)], 2)
    at = lambda i, j: i * (around + 1) + j  # noqa: E731
    faces = []
    for i in range(rings):
        for j in range(around):
            if i > 0:
                faces.append((at(i, j), at(i + 1, j), at(i, j + 1)))
            if i < rings - 1:
                faces.append((at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)))
    return Mesh(points.reshape(-1, 3).astype(np.float32), np.array(faces, np.int32))


@pytest.mark.parametrize("ending", ["stl", "glb", "obj", "ply"])
@pytest.mark.parametrize("turn", [False, True])
def test_a_globe_is_a_solid(tmp_path, ending, turn):
    c, s = np.cos(0.5), np.sin(0.5)
    placement = Placement((c, -s, 0, s, c, 0, 0, 0, 1), 1.0, (300.0, -20.0, 7.0))
    shapes = Shapes(surfaces=(Surface(globe(), "globe"),))
    export(shapes.placed(placement) if turn else shapes, tmp_path / f"a.{ending}")
    read = read_mesh_file(tmp_path / f"a.{ending}", trusted=True).shapes
    assert len(read.solids) == 1
    assert len(np.unique(read.solids[0].mesh.faces)) == 16 * 11 + 2


@pytest.mark.parametrize("gap", [1e-4, 1e-2])
def test_a_globe_with_a_slit_stays_open(tmp_path, gap):
    export(Shapes(surfaces=(Surface(globe(gap), "globe"),)), tmp_path / "a.stl")
    read = read_mesh_file(tmp_path / "a.stl", trusted=True).shapes
    assert len(read.surfaces) == 1
    assert not read.solids


def test_only_borders_are_joined():
    """Two sheets nearer than rounding have their insides apart, and their borders together."""
    mesh = globe()
    kept, faces = weld_rounded(mesh.vertices, *weld(mesh.vertices, mesh.faces))
    assert len(np.unique(faces)) == 16 * 11 + 2
    assert not is_degenerate(faces).any()
    np.testing.assert_allclose(mesh.vertices[kept][faces], mesh.vertices[mesh.faces], atol=1e-4)
    exact, _ = weld(mesh.vertices, mesh.faces)
    assert len(exact) > len(kept)


def test_many_borders_at_one_place_take_no_time():
    import time

    random = np.random.default_rng(914_000)
    count = 60_000
    points = (random.normal(size=(3 * count, 3)) * 1e-7 + 1.0).astype(np.float32)
    start = time.process_time()
    weld_rounded(points, *weld(points, np.arange(3 * count).reshape(-1, 3)))
    assert time.process_time() - start < 10.0


@pytest.mark.parametrize("seed", range(914_100, 914_112))
def test_borders_within_rounding_are_joined_wherever_they_are(seed):
    """Against all pairs: what is within rounding is joined, what is far from all others is not."""
    random = np.random.default_rng(seed)
    size = 10.0 ** float(random.integers(-3, 6))
    corners = size * random.choice([-1.0, -0.5, 0.25, 1.0], size=(24, 3))
    points = corners[random.integers(0, 24, 90)] + size * random.normal(0.0, 1e-6, (90, 3))
    points = points.astype(np.float32)
    kept, exact = weld(points, np.arange(90).reshape(-1, 3))
    _, faces = weld_rounded(points, kept, exact)
    apart = np.abs(points[:, None].astype(float) - points).max(axis=2)
    one = faces.ravel()[:, None] == faces.ravel()
    rounding = 1e-6 * float(np.abs(points).max())
    assert one[apart <= rounding].all()
    assert not one[apart > 0.01 * size].any()
