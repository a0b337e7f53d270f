"""How true the solids are to the drawings: ``python -m tests.fidelity [NAME …] [--write]``.

Every outline in ``tests/data/silhouettes``, and in the folder ``../shared/data/silhouettes``
beside the repository where there is one, is built by the command line itself into an STL
file. The file is read here by hand and measured by means that share no code with the
modeler: vertices merged by their bits, edges and Euler's formula counted, the shadow by
manifold3d, areas, distances and inscribed circles by shapely. Ink is measured against the
outline it was drawn after. With ``--write`` the tables go into ``docs/fidelity.md``.
"""

from __future__ import annotations

import argparse
import itertools
import os
import re
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bozzetto_app.__main__ import ONE_THREAD

for name in ONE_THREAD:  # as the program itself has it; read when numpy is imported
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
from numpy.typing import NDArray  # noqa: E402

from bozzetto.cli import main as cli  # noqa: E402

ROOT = Path(__file__).parents[1]
FOLDERS = (
    ROOT.parent / "shared" / "data" / "silhouettes",
    ROOT / "tests" / "data" / "silhouettes",
)
"""Where outlines are; of two with one name the first counts."""
DOCUMENT = ROOT / "docs" / "fidelity.md"

DENSIFY = 1e-3
"""Spacing of the points of which distances are taken, as a share of the diagonal."""
INSCRIBED = 1e-3
"""Tolerance of the inscribed circle, as a share of the diagonal."""
TRIALS = 2
"""Solids timed for each resolution; the faster one counts."""

SURFACES = {"convolution": "", "variational": "Interpolate exactly", "inflation": "Inflate"}
"""Kinds of surface, and the heading of the summary of those that are not the default."""

_HAIRS = itertools.count(1)

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """A drawing, and the outline that its solid shall have."""

    name: str
    drawing: Path
    outline: Path

    @property
    def is_ink(self) -> bool:
        """Whether it was drawn by hand."""
        return self.drawing != self.outline


@dataclass(frozen=True)
class Found:
    """What was measured of one solid; lengths as shares, times in ms."""

    name: str
    iou: float
    hausdorff: float
    genus: int
    holes: int
    components: int
    bodies: int
    watertight: bool
    volume: float
    thickness: float
    asymmetry: float
    ms_64: float
    ms_128: float

    @property
    def is_right(self) -> bool:
        """Closed, not inside out, and with the topology of the drawing."""
        topology = (self.genus, self.components) == (self.holes, self.bodies)
        return self.watertight and self.volume > 0.0 and topology

    def cells(self) -> tuple[str, ...]:
        """The row as text."""
        return (
            self.name,
            f"{self.iou:.4f}",
            f"{100 * self.hausdorff:.2f} %",
            f"{self.genus} / {self.holes}",
            f"{self.components} / {self.bodies}",
            "yes" if self.watertight and self.volume > 0.0 else "**no**",
            f"{self.thickness:.2f}",
            f"{100 * self.asymmetry:.2f} %",
            f"{self.ms_64:.0f}",
            f"{self.ms_128:.0f}",
        )


HEADINGS = (
    "Outline", "IoU", "Hausdorff / diagonal", "Genus / holes", "Bodies / drawn", "Watertight",
    "Half thickness / inscribed radius", "Asymmetry", "ms at 64", "ms at 128",
)  # fmt: skip


# -- what there is ---------------------------------------------------------------------------------


def cases(folders: Iterable[Path] = FOLDERS) -> list[Case]:
    """All drawings, clean outlines before ink, by name."""
    found: dict[str, Case] = {}
    for folder in folders:
        for path in sorted(folder.glob("*.svg")):
            found.setdefault(path.stem, Case(path.stem, path, path))
        for path in sorted([*folder.glob("ink/*.json"), *folder.glob("*.ink.json")]):
            stem = path.name.removesuffix(".json").removesuffix(".ink")
            outline = path.with_name(f"{stem}.svg")
            if outline.is_file():
                found.setdefault(f"{stem}, ink", Case(f"{stem}, ink", path, outline))
    return sorted(found.values(), key=lambda case: (case.is_ink, case.name))


def rings_of(path: Path) -> list[Points]:
    """Rings of an SVG's first path (M, L and Z only) in the front view: z upwards."""
    found = re.search(r' d="([^"]+)"', path.read_text(encoding="utf-8"))
    if found is None or re.search(r"[^MLZmz\d\s,.eE+-]", found.group(1)):
        raise ValueError(f"{path.name}: a path of straight lines was expected")
    rings = []
    for part in re.findall(r"M([^MZz]+)", found.group(1)):
        numbers = [float(text) for text in re.findall(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?", part)]
        rings.append(np.array(numbers).reshape(-1, 2) * [1.0, -1.0])
    return rings


# -- the solid as others see it --------------------------------------------------------------------


def read_stl(path: Path) -> tuple[Points, NDArray[np.int64]]:
    """Vertices and faces of a binary STL; corners of the same bits are one vertex."""
    data = path.read_bytes()
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    count = int.from_bytes(data[80:84], "little")
    if len(data) != 84 + count * record.itemsize:
        raise ValueError(f"{path.name}: {count} triangles were promised")
    corners = np.frombuffer(data, record, offset=84)["corners"].reshape(-1, 3)
    vertices, faces = np.unique(corners + np.float32(0.0), axis=0, return_inverse=True)
    return vertices.astype(np.float64), faces.reshape(-1, 3).astype(np.int64)


def is_closed(faces: NDArray[np.int64]) -> bool:
    """Whether every edge is run along once in each direction."""
    first, second = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    span = int(faces.max()) + 1
    along, against = np.sort(first * span + second), np.sort(second * span + first)
    return bool(np.array_equal(along, against) and (np.diff(along) > 0).all())


def topology(faces: NDArray[np.int64]) -> tuple[int, int]:
    """Handles and bodies of a closed surface, by Euler's formula."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    vertices = int(faces.max()) + 1
    a, b = faces[:, [0, 1, 1, 2]].reshape(-1, 2).T
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(vertices, vertices))
    bodies = int(connected_components(graph, directed=False)[0])
    return bodies - (vertices - len(faces) // 2) // 2, bodies


def volume(vertices: Points, faces: NDArray[np.int64]) -> float:
    """By the divergence theorem; negative when the surface is inside out."""
    a, b, c = (vertices - vertices[0])[faces].transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum() / 6.0)


def even_odd(rings: Iterable[Points]) -> Any:
    """The region that rings enclose by the even-odd rule."""
    import shapely

    region = shapely.Polygon()
    for ring in rings:
        region = region.symmetric_difference(shapely.make_valid(shapely.Polygon(ring)))
    return region


def shadow(vertices: Points, faces: NDArray[np.int64]) -> Any:
    """The exact projection along y."""
    import manifold3d

    seen = np.ascontiguousarray(vertices[:, [0, 2, 1]] * [1.0, 1.0, -1.0])
    solid = manifold3d.Manifold(manifold3d.Mesh64(seen, faces.astype(np.uint64)))
    return even_odd(solid.project().to_polygons())


def hausdorff(one: Any, other: Any, spacing: float) -> float:
    """Largest distance from the border of either region to that of the other."""
    import shapely

    worst = 0.0
    for a, b in ((one.boundary, other.boundary), (other.boundary, one.boundary)):
        shapely.prepare(b)
        points = shapely.points(shapely.get_coordinates(shapely.segmentize(a, spacing)))
        worst = max(worst, float(shapely.distance(b, points).max()))
    return worst


def asymmetry(vertices: Points) -> float:
    """Largest distance from a vertex mirrored at y = 0 to the nearest one, over the depth."""
    from scipy.spatial import cKDTree

    gap, _ = cKDTree(vertices).query(vertices * [1.0, -1.0, 1.0])
    return float(gap.max() / np.ptp(vertices[:, 1]))


# -- measuring -------------------------------------------------------------------------------------


def measured(case: Case, folder: Path, surface: str = "convolution") -> Found | None:
    """Build a case by the command line and measure its file; None where it was refused."""
    import shapely

    target = folder / "solid.stl"
    target.unlink(missing_ok=True)
    kind = ["--set", f"surface={surface}"]
    if cli.main(["build", "silhouette", str(case.drawing), "-o", str(target), *kind]) != 0:
        return None
    vertices, faces = read_stl(target)
    drawn = even_odd(rings_of(case.outline))
    seen = shadow(vertices, faces)
    low_x, low_y, high_x, high_y = drawn.bounds
    diagonal = float(np.hypot(high_x - low_x, high_y - low_y))
    bodies = shapely.get_parts(drawn)
    inscribed = max(
        shapely.maximum_inscribed_circle(body, INSCRIBED * diagonal).length for body in bodies
    )
    genus, components = topology(faces)
    return Found(
        name=case.name,
        iou=drawn.intersection(seen).area / drawn.union(seen).area,
        hausdorff=hausdorff(drawn, seen, DENSIFY * diagonal) / diagonal,
        genus=genus,
        holes=sum(len(body.interiors) for body in bodies),
        components=components,
        bodies=len(bodies),
        watertight=is_closed(faces),
        volume=volume(vertices, faces),
        thickness=0.5 * float(np.ptp(vertices[:, 1])) / inscribed,
        asymmetry=asymmetry(vertices),
        ms_64=solve_ms(case.drawing, "preview", surface),
        ms_128=solve_ms(case.drawing, "final", surface),
    )


def solve_ms(drawing: Path, quality: Any, surface: str) -> float:
    """Processor time from the outline to the solid, ms: others use this machine, too."""
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.ink import Stroke, Strokes
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench

    bench = Workbench(Registry())
    ink = read_drawing(drawing)
    times = []
    for _ in range(TRIALS):
        # What was solved before is remembered; a hair to the side is another drawing.
        hair = 1e-3 * next(_HAIRS)
        aside = Strokes([Stroke(s.x + hair, s.y, s.camera, tool=s.tool) for s in ink.strokes])
        model = bench.sources.from_drawing(
            "bozzetto.silhouette", replace(ink, strokes=aside), {"surface": surface}
        )
        begun = time.process_time()
        bench.solve(model, Job(quality=quality))
        times.append(1000.0 * (time.process_time() - begun))
    return min(times)


# -- saying it -------------------------------------------------------------------------------------


def summary(found: Sequence[Found], *, ink: bool, refused: int) -> list[tuple[str, str, str]]:
    """Rows (figure, measured, wanted) over all outlines, or over all ink."""
    iou = np.array([one.iou for one in found])
    far = np.array([one.hausdorff for one in found])
    thick = [one.thickness for one in found]
    total = len(found) + refused
    right = sum(one.is_right for one in found) / total
    rows = [
        ("drawings", str(total), ""),
        ("refused", str(refused), "0"),
        ("closed, topology as drawn", f"{100 * right:.1f} %", "≥ 90 %" if ink else "≥ 95 %"),
        ("IoU, median", f"{np.median(iou):.4f}", "≥ 0.975" if ink else "≥ 0.992"),
        ("IoU, worst", f"{iou.min():.4f}", "≥ 0.95" if ink else "≥ 0.97"),
        ("Hausdorff, median", f"{100 * np.median(far):.2f} %", "" if ink else "≤ 0.8 %"),
        ("Hausdorff, worst", f"{100 * far.max():.2f} %", ""),
        (
            "half thickness / inscribed radius",
            f"{min(thick):.2f} … {max(thick):.2f}",
            "" if ink else "0.8 … 1.15",
        ),
        ("asymmetry, worst", f"{100 * max(one.asymmetry for one in found):.3f} %", "≤ 0.1 %"),
        ("outline to solid, 64 cells, median", f"{np.median([f.ms_64 for f in found]):.0f} ms", ""),
        (
            "outline to solid, 128 cells, median",
            f"{np.median([f.ms_128 for f in found]):.0f} ms",
            "",
        ),
    ]
    return rows


def table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = ["| " + " | ".join(headings) + " |", "|" + " --- |" * len(headings)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def page(found: dict[str, dict[Case, Found | None]]) -> str:
    """The document, from what was found for each kind of surface."""
    parts = [
        "# Fidelity",
        "Made by `python -m tests.fidelity --write`; do not edit the tables. Every outline is "
        "built by `bozzetto build silhouette … -o ….stl` at the default resolution; the STL "
        "file is read by hand and measured by means that share no code with the modeler. "
        "*IoU* is the overlap of the solid's exact shadow with the drawn polygon, *Hausdorff* "
        "the largest distance between their borders. Times are processor time from the outline "
        f"to the checked solid, the better of {TRIALS}, of the machine that made this page.",
    ]
    for ink, title in ((False, "Outlines"), (True, "Ink, against the outline it was drawn after")):
        some = {case: one for case, one in found["convolution"].items() if case.is_ink == ink}
        good = [one for one in some.values() if one is not None]
        if not good:
            continue
        refused = len(some) - len(good)
        parts += [f"## {title}", table(("Figure", "Measured", "Wanted"), summary(
            good, ink=ink, refused=refused))]  # fmt: skip
        rows = [
            one.cells() if one else (case.name, "refused", *[""] * (len(HEADINGS) - 2))
            for case, one in some.items()
        ]
        parts.append(table(HEADINGS, rows))
    for surface, title in SURFACES.items():
        outlines = [one for case, one in found.get(surface, {}).items() if not case.is_ink]
        good = [one for one in outlines if one is not None]
        if title and good:
            refused = len(outlines) - len(good)
            rows = summary(good, ink=False, refused=refused)
            parts += [
                f"## Outlines, surface “{title}”",
                table(("Figure", "Measured", "Wanted"), rows),
            ]
    return "\n\n".join(parts) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print, and write if asked to."""
    known = {case.name: case for case in cases()}
    parser = argparse.ArgumentParser(prog="python -m tests.fidelity")
    parser.add_argument("names", nargs="*", metavar="NAME", help="outlines; all when not given")
    parser.add_argument("--write", action="store_true", help="write docs/fidelity.md")
    options = parser.parse_args(arguments)
    unknown = set(options.names) - set(known)
    if unknown:
        parser.error(f"no outline {', '.join(sorted(unknown))}")
    if options.write and options.names:
        parser.error("--write goes with all outlines")
    found: dict[str, dict[Case, Found | None]] = {surface: {} for surface in SURFACES}
    with tempfile.TemporaryDirectory() as folder:
        for name in options.names or known:
            for surface in SURFACES:
                found[surface][known[name]] = measured(known[name], Path(folder), surface)
            print(f"… {name}", file=sys.stderr, flush=True)
    text = page(found)
    print(text)
    if options.write:
        DOCUMENT.write_text(text, encoding="utf-8")
    every = [one for cases in found.values() for one in cases.values()]
    return 0 if all(one is not None and one.is_right for one in every) else 1


if __name__ == "__main__":
    sys.exit(main())
