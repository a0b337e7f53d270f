"""Figures of the product modeler end to end: networks in files, speed, what is handed over.

Run ``python -m tests.plugins.product.figures_product``; it prints a table.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from bozzetto.plugin import Job
from bozzetto_product import modeler
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.model.curves import Curve
from bozzetto_product.operations.curve_edits import move_joint
from bozzetto_product.operations.meetings import meeting_place, splines_of
from tests.plugins.product.shaver import bent, shaver

SAMPLE = Path(modeler.__file__).parent / "samples" / "mouse.json"

UP = np.array((0.0, 0.0, 1.0))
"""mm."""

Row = tuple[str, str, str, bool]


def rows() -> Iterator[Row]:
    """Yield what is measured, the value, what is asked, and whether it is kept."""
    product = modeler.ProductModeler()
    facts = json.loads(SAMPLE.read_text())
    opened, state = _timed(lambda: product_of_network(facts))
    first, result = _timed(lambda: product.solve(state, Job()))
    told: dict[str, Any] = dict(product.report(state, result, Job()))
    smooth = np.array([edge["angle_deg"] for edge in told["edges"] if edge["smooth"]])
    p95 = float(np.quantile(smooth, 0.95))
    off = max(patch["boundary_error_mm"] for patch in told["patches"])
    quality = float(np.median([patch["quality_p5"] for patch in told["patches"]]))
    loops = len(told["loops"])
    yield "Mouse: loops found", f"{loops} of 15", "15", loops == 15
    yield "Mouse: closed", str(told["closed"]), "True", bool(told["closed"])
    yield "Mouse: smooth edges, p95", f"{p95:.3f}°", "≤ 0.05°", p95 <= 0.05
    yield "Mouse: smooth edges, worst", f"{smooth.max():.3f}°", "", True
    yield "Mouse: border off the curves", f"{off:.1e} mm", "≤ 1e-3 mm", off <= 1e-3
    yield "Mouse: 2 r / R, 5th percentile, median", f"{quality:.2f}", "≥ 0.5", quality >= 0.5
    yield "Mouse: file read, loops found", f"{opened:.2f} s", "≤ 1 s", opened <= 1.0
    yield "Mouse: first solve", f"{first:.2f} s", "", True
    joint = state.joints[0]
    place = meeting_place(splines_of(state), joint.meetings[0], state.symmetry)
    edited = move_joint(state, joint.id, place + UP)
    again, _ = _timed(lambda: product.solve(edited, Job()))
    yield "Mouse: solved again after an edit", f"{again:.2f} s", "≤ 0.5 s", again <= 0.5
    further = move_joint(state, joint.id, place + 2.0 * UP)
    live, _ = _timed(lambda: product.solve(further, Job("preview")))
    yield "Mouse: preview of a drag", f"{live:.2f} s", "", True
    handed, shapes = _timed(lambda: product.shapes(state, result))
    exact = shapes.solids[0].exact if shapes.solids else None
    closed = exact is not None and exact.is_closed
    gap = exact.largest_gap() if exact is not None else np.inf
    yield (
        "Mouse: exact shell closed, largest gap",
        f"{gap:.1e} mm",
        "≤ 1e-6",
        gap <= 1e-6 and closed,
    )
    yield "Mouse: handed over", f"{handed:.2f} s", "", True
    points = [c.spline.control_points for c in state.of_kind(Curve) if c.spline is not None]
    yield "Mouse: control points of all curves", str(sum(map(len, points))), "", True


def shaver_rows() -> Iterator[Row]:
    """Yield the speed of a product of the size of the shaver in Kara & Shimada's chapter."""
    product = modeler.ProductModeler()
    state = shaver()
    first, result = _timed(lambda: product.solve(state, Job()))
    name = f"Shaver, {len(result.filled)} surfaces"
    yield f"{name}: first solve", f"{first:.2f} s", "≤ 1 s", first <= 1.0
    spent, kept = [], []
    for step in range(1, 8):
        edited = bent(state, "upper-6", 0.01 * step)
        again, after = _timed(lambda edited=edited: product.solve(edited, Job()))
        same = {id(one.fill) for one in result.filled} & {id(one.fill) for one in after.filled}
        spent.append(again)
        kept.append(len(same))
    again = float(np.quantile(spent, 0.95))
    yield f"{name}: solved again after an edit, p95", f"{again:.2f} s", "≤ 0.5 s", again <= 0.5
    yield f"{name}: of these kept", str(min(kept)), "", True


def _timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return seconds of the processor, which other programs do not lengthen, and the answer."""
    start = time.process_time()
    answer = work()
    return time.process_time() - start, answer


def main() -> None:
    """Print the table."""
    print("| Figure | Measured | Asked | Kept |\n|---|---|---|---|")
    for what, value, asked, kept in (*rows(), *shaver_rows()):
        verdict = ("yes" if kept else "no") if asked else ""
        print(f"| {what} | {value} | {asked} | {verdict} |")


if __name__ == "__main__":
    main()
