"""From strokes of a simulated hand to exact solids.

    python -m tests.plugins.polyhedron.figures_end_to_end [--count 200] [--views 2]

Random solids, and CAD-like parts in some views each, from seeds that nothing was tuned on, are
drawn with 1 % of jitter, hidden edges lightly; untidily are 15 % of the lines traced over, 10 % in
two pieces and 30 % of the ends overshot. What comes out is right if its corners are those of the
solid and not of its mirror image, its faces are the faces of the solid, its planes are exact, and
its triangles bound one volume.

The second table is what is said of first answers to drawings that look healthy, and how often they
are right, wrong graphs among them.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from bozzetto.errors import UserError
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Solid
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.solid.exact import exact_body
from bozzetto_polyhedron.solid.hand_over import mesh_of
from bozzetto_polyhedron.solve.line_readings import decided
from tests.plugins.polyhedron.cad_parts import PARTS, part
from tests.plugins.polyhedron.fit_confidence import BINS
from tests.plugins.polyhedron.graph_truth import corner_numbers
from tests.plugins.polyhedron.graph_truth import is_right as is_right_graph
from tests.plugins.polyhedron.hand import SIZE, UNTIDY, Hand, strokes_of
from tests.plugins.polyhedron.machine_parts import MACHINE, machine_part
from tests.plugins.polyhedron.objects import (
    CAMERA,
    TO_CANVAS,
    Polyhedron,
    View,
    in_eye_frame,
    is_right,
    made,
    view,
)
from tests.plugins.polyhedron.workshop_parts import WORKSHOP, workshop_part

EXACT = 1e-9
"""Distance of a vertex from its planes, as share of the size."""

NOISE = 0.01


@dataclass
class Outcome:
    """How the drawing of one solid went."""

    orthogonal: bool
    graph: bool = False
    seconds: float = 0.0
    refused: bool = False
    findings: int = 0
    right: list[bool] = field(default_factory=list)
    confidence: float = 0.0

    @property
    def first(self) -> bool:
        """Whether the first answer is right."""
        return self.right[:1] == [True]


def outcome_of(solid: Polyhedron, seed: int, hand: Hand) -> Outcome | None:
    """Return how the drawing of a solid from a side by chance went; None without such a side."""
    seen = view(solid, seed)
    if seen is None:
        return None
    edges = [(int(a), int(b)) for a, b in solid.edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist()
    strokes = strokes_of(seen.plane * TO_CANVAS, edges, hand, seed, hidden)
    found = Outcome(solid.orthogonal)
    began = time.process_time()
    graph = decided(searched(strokes), CAMERA, lambda *_: None).graph
    answers = answers_of(graph, CAMERA)
    found.seconds = time.process_time() - began
    found.findings = len(graph.health)
    found.confidence = answers[0].confidence
    places = seen.plane * TO_CANVAS * SIZE + 200.0
    found.graph = is_right_graph(graph, places, edges)
    if found.graph:
        numbers = corner_numbers(graph, places)
        found.right = [is_whole(answer, numbers, seen, graph) for answer in answers[:3]]
    return found


def is_whole(answer: Answer, numbers: np.ndarray, seen: View, graph: LineGraph) -> bool:
    """Whether an answer becomes the exact solid; `numbers` are the solid's for its corners."""
    shape = np.empty_like(answer.vertices)
    shape[numbers] = in_eye_frame(answer.vertices, CAMERA)
    faces = {
        frozenset(frozenset(int(numbers[v]) for v in ring) for ring in rings)
        for rings in answer.faces
    }
    if faces != seen.solid.face_sets() or not is_right(seen, shape, NOISE, mirrored=False):
        return False
    try:
        body = exact_body(answer, noise=graph.noise / CAMERA.pixels_per_mm, camera=CAMERA)
    except UserError:
        return False
    size = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    for normal, offset, rings in zip(body.normals, body.offsets, body.faces, strict=True):
        corners = body.vertices[[v for ring in rings for v in ring]]
        if np.abs(corners @ normal - offset).max() > EXACT * size:
            return False
    try:
        check_solid(Solid(mesh_of(body)))
    except UserError:
        return False
    return body.closed


def share(values: list[bool]) -> str:
    return f"{100 * np.mean(values):.0f} % of {len(values)}" if values else "none"


def outcomes(
    names: Collection[str],
    maker: Callable[[str, int], Polyhedron | None],
    seeds: Collection[int],
    hand: Hand,
) -> list[Outcome]:
    """Draw what a maker makes of each name and seed."""
    return [
        each
        for name in names
        for seed in seeds
        if (solid := maker(name, seed)) is not None
        and (each := outcome_of(solid, seed, hand)) is not None
    ]


def print_confidence(found: list[Outcome]) -> None:
    """Print what is said of first answers to healthy drawings, and how often they are right."""
    print("| said | right | drawings |\n| --- | --- | --- |")
    for low, high in pairwise(BINS):
        here = [each for each in found if not each.findings and low <= each.confidence < high]
        if here:
            said = np.mean([each.confidence for each in here])
            right = np.mean([each.first for each in here])
            print(f"| {100 * said:.1f} % | {100 * right:.1f} % | {len(here)} |")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=50_000)
    parser.add_argument("--views", type=int, default=2)
    parser.add_argument("--jitter", type=float, default=NOISE)
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.count)
    views = range(asked.first, asked.first + asked.views)
    clean = Hand(jitter=asked.jitter)
    untidy = replace(UNTIDY, jitter=asked.jitter, overshot=0.3)
    every = {
        "random": outcomes(("any",), lambda _, seed: made(seed), seeds, clean),
        "parts": outcomes(PARTS, part, views, clean),
        "workshop, untidy": outcomes(WORKSHOP, workshop_part, views, untidy),
        "machine": outcomes(MACHINE, machine_part, views, clean),
        "machine, untidy": outcomes(MACHINE, machine_part, views, untidy),
    }
    print("| drawings | graph right | exact solid, first answer | among three |")
    print("| --- | --- | --- | --- |")
    for word, found in every.items():
        for kind in (True, False):
            these = [each for each in found if each.orthogonal is kind]
            first = share([each.first for each in these])
            three = share([any(each.right) for each in these])
            graphs = share([each.graph for each in these])
            name = f"{word}, {'orthogonal' if kind else 'oblique'}"
            print(f"| {name} | {graphs} | {first} | {three} |")
    found = [each for those in every.values() for each in those]
    healthy = [each.graph for each in found if not each.findings]
    print(f"\nHealthy graphs that are right: {share(healthy)}.")
    told = [bool(each.findings) for each in found if not each.graph]
    print(f"Wrong graphs that are told: {share(told)}.")
    seconds = [each.seconds for each in found]
    print(f"Time: median {np.median(seconds):.2f} s, worst {max(seconds):.2f} s.\n")
    print_confidence(found)


if __name__ == "__main__":
    main()
