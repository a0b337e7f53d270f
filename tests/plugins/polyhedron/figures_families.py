"""How far the confidence is from how often first readings are right, in five families of drawings.

``python -m tests.plugins.polyhedron.figures_families [drawings]`` prints a Markdown table, and what
a fit to these drawings would say of those among them that it has not seen. The confidence is fitted
to random solids alone; nothing is fitted to these.

The drawings are a fifth each:

* random solids, as those of ``fit_confidence``, from other seeds;
* parts of ``cad_parts.py``, of ``workshop_parts.py``, and of ``machine_parts.py``: half of them
  with lines alike, half with hidden lines drawn lightly, 10 % of them wrongly;
* all these from strokes, two of three with light hidden lines, half of them untidily.

Where lines and corners are given, a corner is off by 0, 0.5, 1 or 2 % of the diagonal. Strokes have
a jitter of 0.5, 1 or 2 %; drawings of them that do not look healthy are left out, and what is read
from wrong lines is wrong. Where hidden lines are light, so is the mirror image.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.solve.line_readings import decided
from tests.plugins.polyhedron import cad_parts
from tests.plugins.polyhedron.figures_confidence import (
    ASKED,
    NAMES,
    bins_of,
    error_of,
    of_edges,
    said,
)
from tests.plugins.polyhedron.fit_confidence import (
    KINDS,
    judged,
    said_unseen,
)
from tests.plugins.polyhedron.fit_ranking import NOISES
from tests.plugins.polyhedron.graph_truth import corner_numbers, is_right
from tests.plugins.polyhedron.hand import SIZE, UNTIDY, Hand, strokes_of
from tests.plugins.polyhedron.kept_outcomes import Outcome, kept
from tests.plugins.polyhedron.machine_parts import MACHINE, machine_part
from tests.plugins.polyhedron.objects import CAMERA, TO_CANVAS, Polyhedron, graph_of, made, view
from tests.plugins.polyhedron.workshop_parts import WORKSHOP, workshop_part

Maker = Callable[[str, int], Polyhedron | None]

FIRST_SEED = 30_000
OTHER = 100_000
"""What is added to the seeds of random solids, so that none is one that the fit knows."""

FAMILIES = ("random", "parts", "workshop", "machine", "strokes")
PARTS: tuple[tuple[tuple[str, ...], Maker], ...] = (
    (tuple(cad_parts.PARTS), cad_parts.part),
    (tuple(WORKSHOP), workshop_part),
    (tuple(MACHINE), machine_part),
)
"""Kinds of parts, and what makes one of a kind by a seed."""

DRAWN: tuple[tuple[tuple[str, ...], Maker], ...] = (
    (("any",), lambda name, seed: made(seed + OTHER)),
    *PARTS,
)
"""What is drawn in strokes."""

WRONG_MARKS = 0.1
JITTERS = (0.01, 0.005, 0.02)
OVERSHOT = 0.3


def family_of(seed: int) -> str:
    """Return the family of a drawing."""
    return FAMILIES[seed % len(FAMILIES)]


def outcome(seed: int) -> Outcome | None:
    """Draw a solid of a family and judge the first reading.

    Returns
    -------
    Outcome or None
        None where there is no solid, no view or no reading, or where the lines of strokes look
        wrong.
    """
    family, number = seed % len(FAMILIES), seed // len(FAMILIES)
    if FAMILIES[family] == "strokes":
        return _of_strokes(seed, number)
    solid: Polyhedron | None
    marks: float | None
    if FAMILIES[family] == "random":
        kinds, marks = KINDS[number % len(KINDS)]
        turn, solid = number // len(KINDS), made(seed + OTHER, kinds)
    else:
        names, make = PARTS[family - 1]
        cycle = number // len(names)
        turn, marks = cycle // 2, (None, WRONG_MARKS)[cycle % 2]
        solid = make(names[number % len(names)], seed)
    seen = None if solid is None else view(solid, seed)
    if seen is None:
        return None
    noise = NOISES[turn % len(NOISES)]
    graph, _ = graph_of(seen, noise, seed, marks)
    return judged(graph, np.arange(len(graph.places)), seen, noise, mirrored=marks is None)


def _of_strokes(seed: int, number: int) -> Outcome | None:
    """Judge the first reading of strokes; `number` counts the drawings from strokes."""
    names, make = DRAWN[number % len(DRAWN)]
    solid = make(names[number // len(DRAWN) % len(names)], seed)
    seen = None if solid is None else view(solid, seed)
    if seen is None:
        return None
    rng = np.random.default_rng((17, seed))
    marked, tidy = rng.random() < 2 / 3, rng.random() < 0.5
    jitter = JITTERS[rng.integers(len(JITTERS))]
    hand = Hand(jitter=jitter) if tidy else replace(UNTIDY, jitter=jitter, overshot=OVERSHOT)
    edges = [(int(a), int(b)) for a, b in seen.solid.edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist() if marked else ()
    strokes = strokes_of(seen.plane * TO_CANVAS, edges, hand, seed, hidden)
    graph = decided(searched(strokes), CAMERA, lambda *_: None).graph
    if graph.health:
        return None
    places = seen.plane * TO_CANVAS * SIZE + 200.0
    numbers = corner_numbers(graph, places) if is_right(graph, places, edges) else None
    return judged(graph, numbers, seen, jitter, mirrored=not marked)


def rows(name: str, right: np.ndarray, told: np.ndarray, merged: bool = True) -> None:
    """Print a row for each bin of what is said; see `bins_of`."""
    for here in bins_of(told) if merged else of_edges(told):
        mean, share, error = (
            100.0 * told[here].mean(),
            100.0 * right[here].mean(),
            error_of(told[here]),
        )
        off = abs(mean - share)
        print(
            f"| {name} | {mean:.1f} % | {share:.1f} % of {here.sum()} | {off:.1f} ± {error:.1f} "
            f"points | {'yes' if off <= ASKED else 'no'} |"
        )


def loss(right: np.ndarray, told: np.ndarray) -> float:
    """Return the mean negative logarithm of what was said of what came."""
    return float(-np.log(np.where(right, told, 1.0 - told)).mean())


def table(found: dict[int, Outcome]) -> None:
    """Print what is said of the outcomes of seeds, and how often they are right."""
    every = list(found.values())
    right = np.array([each.right for each in every], bool)
    told = np.array([said(each) for each in every])
    families = np.array([family_of(seed) for seed in found])
    evidence = np.array([each.evidence for each in every])
    print(f"| drawings | said | right | difference | at most {ASKED:g} points |")
    print("| --- | --- | --- | --- | --- |")
    rows("all drawings, every bin", right, told, merged=False)
    rows("all drawings", right, told)
    for name in FAMILIES:
        rows(name, right[families == name], told[families == name])
    for kind, name in NAMES.items():
        rows(name, right[evidence == kind], told[evidence == kind])
    print(f"\nMean negative log-likelihood of what came: {loss(right, told):.4f}; by fits to three")
    print(f"quarters of these drawings, of the fourth, {loss(right, said_unseen(every)):.4f}.")


def main(count: int) -> None:
    table(kept("families", range(FIRST_SEED, FIRST_SEED + count), outcome))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
