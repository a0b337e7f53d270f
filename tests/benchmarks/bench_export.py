"""A solid of 50,000 triangles to every format of meshes, beside trimesh where it is installed."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from bozzetto.exchange.export import export
from bozzetto.exchange.formats import writers
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import Shapes, Solid
from tests.benchmarks.timing import Row, in_turn, median_ms

TRIANGLES = 50_000


def ball(triangles: int) -> Mesh:
    """A closed bumpy ball: rings between two poles."""
    around = round(np.sqrt(triangles))
    rings = triangles // (2 * around)
    u = np.pi * np.arange(1, rings + 1)[:, None] / (rings + 1)
    v = 2 * np.pi * np.arange(around)[None, :] / around
    r = 50 * (1 + 0.1 * np.sin(5 * v) * np.sin(u) ** 3)
    rows = np.stack((r * np.sin(u) * np.cos(v), r * np.sin(u) * np.sin(v), r * np.cos(u)), -1)
    points = np.vstack((rows.reshape(-1, 3), [[0, 0, 50], [0, 0, -50]]))
    here = np.arange((rings - 1) * around)
    beside = here // around * around + (here + 1) % around
    first, last = np.arange(around), (rings - 1) * around + np.arange(around)
    north = np.full(around, len(points) - 2)
    faces = np.vstack((
        np.stack((here, here + around, beside), 1),
        np.stack((beside, here + around, beside + around), 1),
        np.stack((north, first, np.roll(first, -1)), 1),
        np.stack((north + 1, np.roll(last, -1), last), 1),
    ))  # fmt: skip
    return Mesh(points.astype(np.float32), faces.astype(np.int32))


def by_trimesh(mesh: Mesh, target: Path) -> Callable[[], object] | None:
    """The same export by trimesh; None where it, the format, or what that needs is missing."""
    try:
        import trimesh

        if target.suffix.removeprefix(".") not in trimesh.available_formats():
            return None
        other = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
        other.export(target)
    except ModuleNotFoundError:
        return None
    return lambda: other.export(target)


def rows(triangles: int = TRIANGLES) -> Iterator[Row]:
    """One row for every format: checked, written whole, brought to the disk."""
    mesh = ball(triangles)
    shapes = Shapes(solids=(Solid(mesh, "Ball"),))
    with tempfile.TemporaryDirectory() as folder:
        for chosen in writers("mesh"):
            target = Path(folder, f"ball{chosen.endings[0]}")
            beside = Path(folder, f"other{chosen.endings[0]}")
            what = f"export of {len(mesh.faces):,} triangles, {chosen.title}"
            other = by_trimesh(mesh, beside)
            if other is None:
                yield Row("export", what, median_ms(lambda t=target: export(shapes, t)))
                continue
            ours, theirs = in_turn(lambda t=target: export(shapes, t), other)
            size = (path.stat().st_size / 1e6 for path in (target, beside))
            yield Row(
                "export", f"{what}, {next(size):.1f} MB", ours,
                alternative=f"trimesh, unchecked, {next(size):.1f} MB", other=theirs,
            )  # fmt: skip
