"""Figures of products that are drawn by hand: what other hands make of the gallery's designs.

Run ``python -m tests.plugins.product.figures_gallery [NAME …]``; it prints a table. Each design is
drawn by hands that tremble in ways that nothing was tuned on, with strokes that miss their ends or
go beyond them. The loops meant are those of the product in the gallery, by the names of their
curves.
"""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np

from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.workbench.workbench import Workbench
from bozzetto_product.model.curves import Curve
from bozzetto_product.report import report_of

DOCS = Path(__file__).parents[3] / "docs"
GALLERY = DOCS / "gallery" / "product"
HANDS = (5001, 5002)

Loops = Counter[frozenset[str]]


def in_docs(name: str) -> ModuleType:
    """Return a module of the folder of the documentation."""
    sys.path.insert(0, str(DOCS))
    try:
        return import_module(name)
    finally:
        sys.path.remove(str(DOCS))


@dataclass(frozen=True)
class Built:
    """A product that was built from a file."""

    loops: Loops
    closed: bool
    angles: tuple[float, ...]
    curves: dict[str, np.ndarray]


def built(path: Path) -> Built:
    """Build a file.

    Loops are sets of names of curves, for where they are cut depends on the hand.
    """
    bench = Workbench(Registry())
    model = bench.sources.from_drawing("bozzetto.product", read_drawing(path), {})
    told = report_of(model.state, bench.solve(model, Job()), Job())
    loops = Counter(frozenset(name.split("/")[0] for name in loop) for loop in told["loops"])
    angles = tuple(edge["angle_deg"] for edge in told["edges"] if edge["smooth"]) or (0.0,)
    curves = {curve.name: curve.spline.sampled(400) for curve in model.state.of_kind(Curve)}
    return Built(loops, told["closed"], angles, curves)


def off_course(curves: dict[str, np.ndarray], meant: dict[str, np.ndarray]) -> list[float]:
    """Return how far each curve is from the course that was meant, mm: its median."""
    return [
        float(np.median(distances_to_course(curves[name], course)))
        for name, course in meant.items()
        if name in curves
    ]


def distances_to_course(points: np.ndarray, course: np.ndarray) -> np.ndarray:
    """Return the distance of each point (n, 3) from a polyline, mm."""
    from scipy.spatial import cKDTree

    steps = np.linspace(0.0, len(course) - 1.0, 20 * len(course))
    fine = np.stack([np.interp(steps, np.arange(len(course)), row) for row in course.T], axis=1)
    return np.asarray(cKDTree(fine).query(points)[0])


def rows(names: Sequence[str]) -> Iterator[tuple[str, str, str, str]]:
    """Yield what is measured, the value, what is asked, and whether it is kept."""
    designs, hand = in_docs("product_designs"), in_docs("product_hand")
    scores: list[float] = []
    for name in names or designs.NAMES:
        product = built(GALLERY / f"{name}.json")
        hand.TREMBLES = 0
        made = getattr(designs, name)()
        size = float(np.linalg.norm(np.ptp(made.corners, axis=0)))
        far = 100.0 * float(np.median(off_course(product.curves, made.meant))) / size
        median, most = np.quantile(product.angles, (0.5, 0.95))
        yield f"{name}: closed", _word(product.closed), "yes", _word(product.closed)
        yield f"{name}: curves, surfaces", f"{len(made.meant)}, {product.loops.total()}", "", ""
        yield f"{name}: curves off their course, of the diagonal", f"{far:.2f} %", "", ""
        yield f"{name}: off smooth, median, p95", f"{median:.2f}°, {most:.1f}°", "", ""
        for number in HANDS:
            scores.append(f1(others(designs, hand, name, number), product.loops))
        row = ", ".join(f"{score:.2f}" for score in scores[-len(HANDS) :])
        yield f"{name} by other hands: F1 of loops", row, "", ""
    score = float(np.median(scores))
    yield "all: F1 of loops, median", f"{score:.2f}", "≥ 0.92", _word(score >= 0.92)


def others(designs: ModuleType, hand: ModuleType, name: str, number: int) -> Loops:
    """Return the loops of a design that another hand drew; none if a step could not be taken."""
    hand.TREMBLES = number
    with tempfile.TemporaryDirectory() as folder:
        path = getattr(designs, name)().write(Path(folder) / "ink.json")
        try:
            return built(path).loops
        except UserError:
            return Counter()
        finally:
            hand.TREMBLES = 0


def f1(found: Loops, meant: Loops) -> float:
    """Return the F1 score of loops."""
    return 2.0 * (found & meant).total() / max(found.total() + meant.total(), 1)


def _word(kept: bool) -> str:
    return "yes" if kept else "no"


if __name__ == "__main__":
    print("| figure | measured | asked | kept |\n|---|---|---|---|")
    for row in rows(sys.argv[1:]):
        print("| " + " | ".join(row) + " |", flush=True)
