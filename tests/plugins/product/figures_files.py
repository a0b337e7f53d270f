"""Figures of networks through the door of files, as a Markdown table.

``python -m tests.plugins.product.figures_files``; seeds from 6000 on, which nothing was tuned on. A
surface counts as found if it has the very curves that are meant; openings that were closed count
against precision here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from bozzetto.plugin import Job
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.modeler import ProductModeler
from tests.plugins.product.drawn_networks import DRAWN
from tests.plugins.product.held_out_networks import HELD_OUT
from tests.plugins.product.random_networks import faulty
from tests.plugins.product.sketched_network import Sketch
from tests.plugins.product.test_rough_files import facts, octants, turned

POINTS = 25
IMAGE = "_image"


def points_of(sketch: Sketch) -> dict[str, np.ndarray]:
    """Return points along each curve, and along its mirror image as a curve of its own."""
    found = {}
    for curve in sketch.built()[0]:
        row = curve.spline.sampled(2 * POINTS if curve.spline.closed else POINTS)
        if curve.spline.closed:
            row = np.vstack((row, row[:1]))
        found[_name(curve.id, False)] = row
        if curve.mirrored:
            found[_name(curve.id, True)] = row * [1.0, -1.0, 1.0]
    return found


def _name(curve: str, mirrored: bool) -> str:
    return curve.replace("/", "_").replace(" ", "_") + IMAGE * mirrored


def meant(sketch: Sketch) -> Counter:
    """Return the curves of each surface that is meant."""
    net = sketch.net()
    return Counter(
        frozenset(_name(net.edges[e].curve, net.edges[e].mirrored) for e in edges)
        for edges in sketch.truth(net, strict=False)
        if edges
    )


def found(curves: dict[str, np.ndarray]) -> Counter:
    """Return the curves of each surface that is found."""
    state = product_of_network(facts(curves))
    names = {curve.id: curve.name for curve in state.of_kind(Curve)}
    patches = state.of_kind(Patch)
    return Counter(frozenset(names[run.curve] for run in each.boundary) for each in patches)


def networks(name: str, change: Callable[[Sketch, int], dict[str, np.ndarray]]) -> list[str]:
    """Return the rows of all drawn networks with one fault."""
    right = wanted = there = 0
    scores = []
    for number, make in enumerate([*DRAWN.values(), *HELD_OUT.values()]):
        sketch = make()
        truth, told = meant(sketch), found(change(sketch, 6000 + number))
        hits = (truth & told).total()
        right, wanted, there = right + hits, wanted + truth.total(), there + told.total()
        scores.append(2.0 * hits / max(1, truth.total() + told.total()))
    return [
        row(f"{name}: F1, median", f"{np.median(scores):.3f}", "≥ 0.92", np.median(scores) >= 0.92),
        row(f"{name}: recall", f"{right / wanted:.3f}", "≥ 0.85", right / wanted >= 0.85),
        row(f"{name}: precision, openings counted", f"{right / there:.3f}", "", None),
    ]


def row(what: str, measured: str, asked: str, kept: bool | None) -> str:
    """Return a line of the table."""
    return f"| {what} | {measured} | {asked} | {'' if kept is None else 'yes' if kept else 'no'} |"


def trembling(sketch: Sketch, seed: int) -> dict[str, np.ndarray]:
    """Return the points of a network, each of them off by 0.1 % of the diagonal."""
    random = np.random.default_rng(seed)
    curves = points_of(sketch)
    size = float(np.linalg.norm(np.ptp(np.vstack(list(curves.values())), axis=0)))
    return {n: p + random.normal(scale=1e-3 * size, size=p.shape) for n, p in curves.items()}


def by_hand(sketch: Sketch, seed: int) -> dict[str, np.ndarray]:
    """Return the points of a network with faults of a hand."""
    return points_of(faulty(sketch, seed, noise=0.01, missing=0.03, over=0.15))


def smoothness(name: str, change: Callable[[np.ndarray], np.ndarray]) -> str:
    """Return the row of the largest angle over the edges of an ellipsoid."""
    modeler = ProductModeler()
    state = product_of_network(facts({k: change(p) for k, p in octants().items()}))
    told = modeler.report(state, modeler.solve(state, Job()), Job())
    worst = max(edge["angle_deg"] for edge in told["edges"])
    return row(f"ellipsoid of eight surfaces, {name}", f"{worst:.3f}°", "≤ 0.05°", worst <= 0.05)


def surfaces(name: str, change: Callable[[Sketch, int], dict[str, np.ndarray]]) -> list[str]:
    """Return the rows of surfaces that fold, and of gaps that are told where none is meant."""
    modeler = ProductModeler()
    count = without = creased = gaps = warned = 0
    sketches = [make() for make in (*DRAWN.values(), *HELD_OUT.values())]
    for number, sketch in enumerate(sketches):
        state = product_of_network(facts(change(sketch, 6000 + number)))
        result = modeler.solve(state, Job())
        told = modeler.report(state, result, Job())["gaps"]
        count += len(result.patches)
        without += sum(one.fill is None for one in result.patches)
        creased += sum(bool(one.creased) for one in result.patches)
        gaps, warned = gaps + len(told), warned + bool(told)
    share = 100.0 * without / count
    return [
        row(f"{name}: of {count} surfaces fold", f"{share:.1f} %", "≤ 1 %", share <= 1.0),
        row(
            f"{name}: more that get creases, so as not to",
            f"{100 * creased / count:.1f} %",
            "",
            None,
        ),
        row(
            f"{name}: gaps told where none is meant, in {len(sketches)} networks",
            f"{gaps} in {warned}",
            "0",
            gaps == 0,
        ),
    ]


def main() -> None:
    """Print the table."""
    print("| Figure | Measured | Asked | Kept |\n|---|---|---|---|")
    lines = [
        *networks("exact", lambda sketch, _: points_of(sketch)),
        *surfaces("exact", lambda sketch, _: points_of(sketch)),
        *networks("points off by 0.1 %", trembling),
        *surfaces("points off by 0.1 %", trembling),
        *networks("1 % off, 3 % miss a joint, 15 % too long", by_hand),
        smoothness("exact", lambda points: points),
        smoothness("turned, three digits", lambda points: (points @ turned(6000)).round(3)),
    ]
    print("\n".join(lines))


if __name__ == "__main__":
    main()
