"""How full the squares of texture coordinates are: ``python -m tests.core.exchange.figures_uvs``.

The drawings of the gallery and all samples, and the outlines of `tests.fidelity`, at 64 cells. What
lies on what, and how far apart charts are, is seen in a picture of 1,024 texels along the side.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.cli.output import workbench
from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_drawing, read_mesh_file
from bozzetto.exchange.mesh.polygons import is_degenerate
from bozzetto.geometry.atlas.unwrapping import unwrapped_together
from bozzetto.plugin import Job
from tests.core.exchange.atlas_pictures import drawn_out, least_gap, overlapping
from tests.fidelity import FOLDERS

ROOT: Final = Path(__file__).parents[3]
SIDE: Final = 1024
MODELERS: Final = ("car", "polyhedron", "product", "silhouette")
"""Those whose drawings have surfaces."""

Meshes = list[tuple[Array, NDArray[Any]]]


class Found(NamedTuple):
    """What was measured of one square.

    `bound` is how full it can be: the longest edge fits along the diagonal at best, and the mesh
    stays as it is.
    """

    charts: int
    full: float
    bound: float
    stretch: float
    overlapping: int
    gap: float
    seconds: float


def gallery() -> Iterator[tuple[str, Path]]:
    """Yield modelers and their drawings: those of the gallery, and the samples that differ."""
    for modeler in MODELERS:
        folders = (
            ROOT / "docs" / "gallery" / ("" if modeler == "silhouette" else modeler),
            ROOT / "plugins" / f"bozzetto_{modeler}" / "samples",
        )
        drawings = {path.stem: path for folder in folders for path in folder.glob("*.json")}
        for _, path in sorted(drawings.items()):
            yield modeler, path


def outlines() -> Iterator[tuple[str, Path]]:
    """Yield the outlines of `tests.fidelity`."""
    for path in dict(sorted((p.stem, p) for f in FOLDERS for p in f.glob("*.svg"))).values():
        yield "silhouette", path


def meshes_of(modeler: str, path: Path, values: dict[str, object]) -> Meshes:
    """Return the meshes that a modeler makes of a drawing."""
    bench: Any = workbench()
    model = bench.sources.from_drawing(
        bench.registry.resolve(modeler), read_drawing(path, trusted=True), values
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "a.glb"  # as triangles
        export(bench.shapes((model,), Job()), file)
        shapes = read_mesh_file(file, trusted=True).shapes
    return [
        (part.mesh.vertices.astype(float), part.mesh.faces[~is_degenerate(part.mesh.faces)])
        for part in shapes.meshes()
    ]


def measured(meshes: Meshes) -> Found:
    """Lay meshes out, and measure what came of it."""
    start = time.process_time()
    laid = unwrapped_together(meshes)
    seconds = time.process_time() - start
    corners = np.concatenate([one.corners for one in laid])
    chart = np.concatenate([one.chart for one in laid])
    full = float(np.abs(np.cross(*np.moveaxis(np.diff(corners, axis=1), 1, 0))).sum()) / 2.0
    longest = max(
        float(np.linalg.norm(np.roll(v[f], 1, axis=1) - v[f], axis=2).max(initial=0.0))
        for v, f in meshes
    )
    surface = full * laid[0].side ** 2
    stretch = np.concatenate([
        drawn_out(v, f, one.corners * one.side)
        for (v, f), one in zip(meshes, laid, strict=True) if len(f)
    ])  # fmt: skip
    size = np.concatenate([
        np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1)
        for v, f in meshes if len(f)
    ])  # fmt: skip
    seen = np.isfinite(stretch).all(axis=1)
    worst = np.maximum(stretch[seen, 0], 1.0 / np.maximum(stretch[seen, 1], 1e-9))
    order = np.argsort(worst)
    upto = np.cumsum(size[seen][order]) / size[seen].sum()
    return Found(
        int(chart.max()) + 1, full, min(1.0, 2.0 * surface / longest**2),
        float(worst[order][np.searchsorted(upto, 0.99)]), overlapping(corners, chart, SIDE),
        least_gap(corners, chart, SIDE), seconds,
    )  # fmt: skip


def row(name: str, found: Sequence[Found]) -> str:
    """Return a row of the table."""
    full = np.array([one.full for one in found])
    charts = [one.charts for one in found]
    seconds = [one.seconds for one in found]
    could = sum(one.bound >= 0.8 for one in found)
    return (
        f"| {name} | {len(found)} | {np.median(charts):.0f} / {max(charts)} | "
        f"{full.min():.2f} / {np.median(full):.2f} / {full.max():.2f} | "
        f"{(full >= 0.8).sum()} of {could} | "
        f"{np.median([one.stretch for one in found]):.2f} / "
        f"{max(one.stretch for one in found):.2f} | "
        f"{sum(one.overlapping for one in found)} | {min(one.gap for one in found):.1f} | "
        f"{np.median(seconds):.1f} / {max(seconds):.1f} s |"
    )


def main() -> None:
    """Print the table."""
    print(
        "| Drawings | How many | Charts, median / most | Full, least / median / most "
        "| From .80, of those that could | Drawn out in 99 % of the area, median / most "
        "| Texels with two charts | Least gap, texels | Processor time, median / most |"
    )
    print("|" + " --- |" * 9)
    for name, drawings, values in (
        ("gallery and samples", gallery(), {}),
        ("outlines", outlines(), {"resolution": 64}),
    ):
        found = []
        for modeler, path in drawings:
            found.append(measured(meshes_of(modeler, path, dict(values))))
            print(path.stem, found[-1], file=sys.stderr, flush=True)
        print(row(name, found), flush=True)


if __name__ == "__main__":
    main()
