"""Fit the numbers that tell how likely the first reading is the right one.

``python -m tests.plugins.polyhedron.fit_confidence [drawings]`` draws solids with `SEEDS`, to which
nothing else is fitted, reads them as the program does, and writes ``confidence_tables.py``.

The drawings are a fifth each:

* random solids (``objects.py``): a sixth each of upright ones, of slanted ones twice, and of blocks
  with a pocket, a boss or a tunnel, all with lines alike; of such blocks, and of upright and
  slanted ones together, with hidden lines drawn lightly, 10 % of them wrongly;
* parts of ``cad_parts.py``, of ``workshop_parts.py``, and of ``machine_parts.py``: half of them
  with lines alike, half with light hidden lines as above;
* all these from strokes, two of three with light hidden lines, half of them untidily.

Where lines and corners are given, a corner is off by 0, 0.5, 1 or 2 % of the diagonal (standard
deviation), a quarter each; the program is told that noise wrong by a factor of 1.28. Strokes have a
jitter of 0.5, 1 or 2 %; drawings of them that do not look healthy are left out, and wrong lines are
wrong readings. A reading is right if its shape is (``objects.is_right``) and it has the faces of
the solid; where hidden lines are light, its mirror image is wrong.

The log odds of being right are a sum: of a function of the lead of the first reading (the log odds
of its share), one for each kind of evidence, straight between knots and never falling; and of the
weighted traits of that reading and of the drawing, held within what 98 of 100 drawings have. It is
fitted by the likelihood, with a pull of the functions to the lead itself and of the weights to 0.

Printed is what is said of drawings that a fit has not seen: of each quarter by the fit to the
others.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import bozzetto_polyhedron.reconstruction.confidence_tables as written
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.reconstruction.answers import evidence_of, ranked_readings
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.ranking import (
    DRAWN,
    FEATURES,
    Evidence,
    lead_of,
    traits_of,
)
from bozzetto_polyhedron.solve.line_readings import decided
from tests.plugins.polyhedron import cad_parts
from tests.plugins.polyhedron.fit_ranking import NOISES
from tests.plugins.polyhedron.graph_truth import corner_numbers
from tests.plugins.polyhedron.graph_truth import is_right as is_right_graph
from tests.plugins.polyhedron.hand import SIZE, UNTIDY, Hand, strokes_of
from tests.plugins.polyhedron.machine_parts import MACHINE, machine_part
from tests.plugins.polyhedron.objects import (
    CAMERA,
    TO_CANVAS,
    Polyhedron,
    View,
    graph_of,
    is_right,
    made,
    view,
)
from tests.plugins.polyhedron.workshop_parts import WORKSHOP, workshop_part

Maker = Callable[[str, int], Polyhedron | None]

SEEDS = (*range(30_000, 35_200), *range(50_000, 52_800))
UPRIGHT = ("rectilinear prism", "stairs", "letter prism", "boxes", "notched box")
SLANTED = ("slanted prism", "slanted step", "tapered", "chamfered")
LOOPED = ("looped",)
KINDS: tuple[tuple[tuple[str, ...], float | None], ...] = (
    (UPRIGHT, None),
    (SLANTED, None),
    (LOOPED, 0.1),
    (UPRIGHT + SLANTED, 0.1),
    (SLANTED, None),
    (LOOPED, None),
)
"""Random solids, and the share of wrong marks of hidden lines; none where lines are alike."""

PARTS: tuple[tuple[tuple[str, ...], Maker], ...] = (
    (tuple(cad_parts.PARTS), cad_parts.part),
    (tuple(WORKSHOP), workshop_part),
    (tuple(MACHINE), machine_part),
)
"""Kinds of parts, and what makes one of a kind by a seed."""

FAMILIES = ("random", "parts", "workshop", "machine", "strokes")
WRONG_MARKS = 0.1
JITTERS = (0.01, 0.005, 0.02)
OVERSHOT = 0.3

KNOTS = (-6.0, -3.0, -1.5, -0.5, 0.5, 1.5, 3.0, 4.5, 6.0)
EVIDENCE: tuple[Evidence, ...] = ("plain", "loose", "marked")
BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 1.01)
QUARTERS = 4
STEADY = 2.0
"""Pull of the steps of the functions to those of the lead, drawings a squared unit of log odds."""

PULL = 20.0
"""Pull of the weight of a trait, of unit spread, to 0."""

HEADER = '''\
"""Numbers of the confidence; written by ``python -m tests.plugins.polyhedron.fit_confidence``."""

from __future__ import annotations

from typing import Final

'''


@dataclass(frozen=True, eq=False)
class Outcome:
    """The first reading of one drawing: its lead and traits, and whether it is right."""

    evidence: Evidence
    lead: float
    traits: np.ndarray
    right: bool


@dataclass(frozen=True, eq=False)
class Fit:
    """Log odds at `KNOTS` for each `EVIDENCE`, and limits and weights of all traits, (t, 3)."""

    odds: np.ndarray
    traits: np.ndarray


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
    if FAMILIES[family] == "random":
        kinds, marks = KINDS[number % len(KINDS)]
        turn, solid = number // len(KINDS), made(seed, kinds)
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
    return _judged(graph, np.arange(len(graph.places)), seen, noise)


def _of_strokes(seed: int, number: int) -> Outcome | None:
    """Judge the first reading of strokes; `number` counts the drawings from strokes."""
    sources: tuple[tuple[tuple[str, ...], Maker], ...] = (
        (("any",), lambda name, seed: made(seed)),
        *PARTS,
    )
    (names, make), number = sources[number % len(sources)], number // len(sources)
    solid = make(names[number % len(names)], seed)
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
    numbers = corner_numbers(graph, places) if is_right_graph(graph, places, edges) else None
    return _judged(graph, numbers, seen, jitter)


def _judged(
    graph: LineGraph, numbers: np.ndarray | None, seen: View, noise: float
) -> Outcome | None:
    """Judge the first reading of lines; None where there is none.

    Parameters
    ----------
    graph : LineGraph
    camera : Camera
    numbers : (n,) array, optional
        The vertex of the solid that each corner is; without where lines are wrong.
    seen : View
    noise : float
        Of the corners, diagonals.
    """
    drawing = drawing_of(graph)
    sight, found = ranked_readings(drawing, CAMERA)
    if not found:
        return None
    first, evidence = found[0], evidence_of(drawing)
    right = False
    if numbers is not None:
        shape = np.empty((len(numbers), 3))
        shape[numbers] = np.column_stack((sight.drawing.points, first.depths))
        faces = {
            frozenset(frozenset(int(numbers[corner]) for corner in ring) for ring in face)
            for face in first.faces
        }
        right = faces == seen.solid.face_sets()
        right = right and is_right(seen, shape, noise, mirrored=evidence != "marked")
    lead = lead_of(np.array([each.score for each in found]))
    traits = traits_of(first.features, len(drawing.lines), drawing.noise)
    return Outcome(evidence, lead, traits, right)


def fitted(every: Sequence[Outcome]) -> Fit:
    """Return the log odds and weights under which what came of drawings is likeliest."""
    knots = np.array(KNOTS)
    hats = np.array([np.interp([o.lead for o in every], knots, row) for row in np.eye(len(knots))])
    of_kind = np.array([[each.evidence == name for each in every] for name in EVIDENCE])
    rising = np.tril(np.ones((len(knots), len(knots))))
    steps = np.hstack([(hats.T * kind[:, None]) @ rising for kind in of_kind])
    low, high = np.quantile([each.traits for each in every], (0.01, 0.99), axis=0)
    held = np.clip([each.traits for each in every], low, high)
    middle, spread = held.mean(axis=0), np.where(high > low, held.std(axis=0), 1.0)
    rows = np.hstack((steps, (held - middle) / spread))
    right = np.array([each.right for each in every], float)
    own = np.tile(np.diff(knots, prepend=0.0), len(EVIDENCE))
    start = np.concatenate((own, np.zeros(len(low))))
    pull = np.concatenate((np.full(len(own), STEADY), np.full(len(low), PULL)))

    def loss(values: np.ndarray) -> tuple[float, np.ndarray]:
        odds, off = rows @ values, values - start
        unlikely = np.logaddexp(0.0, odds).sum() - right @ odds + 0.5 * (pull * off) @ off
        return float(unlikely), rows.T @ (1.0 / (1.0 + np.exp(-odds)) - right) + pull * off

    first = np.arange(len(own)) % len(knots) == 0
    bounds = [(None if free else 0.0, None) for free in first] + [(None, None)] * len(low)
    found = minimize(loss, start, jac=True, method="L-BFGS-B", bounds=bounds).x
    weights = found[len(own) :] / spread
    odds = found[: len(own)].reshape(len(EVIDENCE), -1) @ rising.T - weights @ middle
    return Fit(odds, np.column_stack((low, high, weights)))


def text_of(made: Fit) -> str:
    """Return the module that keeps a fit."""
    lines = [
        f"LEADS: Final = {KNOTS}",
        '"""Log odds of the share of the first answer at which `LOG_ODDS` stand."""\n',
        "LOG_ODDS: Final = {",
        *(
            f'    "{name}": {tuple(round(float(value), 3) for value in row)},'
            for name, row in zip(EVIDENCE, made.odds, strict=True)
        ),
        "}",
        '"""Log odds that the first answer is right, by `Evidence`, without its traits."""\n',
        "TRAITS: Final = {",
        *(
            f'    "{name}": {tuple(float(f"{value:.4g}") for value in row)},'
            for name, row in zip((*FEATURES, *DRAWN), made.traits, strict=True)
        ),
        "}",
        '"""Of each trait the least and the largest value, and what it adds to the log odds."""\n',
    ]
    return HEADER + "\n".join(lines)


def told(fit: Fit, each: Outcome) -> float:
    """Return what a fit says of a first reading, as ``ranking.confidence_of_first`` does."""
    low, high, weights = fit.traits.T
    odds = np.interp(each.lead, KNOTS, fit.odds[EVIDENCE.index(each.evidence)])
    return float(1.0 / (1.0 + np.exp(-odds - np.clip(each.traits, low, high) @ weights)))


def held_out(every: Sequence[Outcome]) -> str:
    """Return a table of what is said of each drawing by the fit to three quarters without it."""
    part = np.random.default_rng(0).permutation(len(every)) % QUARTERS
    said, right = np.zeros(len(every)), np.array([each.right for each in every])
    for k in range(QUARTERS):
        fit = fitted([each for each, own in zip(every, part, strict=True) if own != k])
        for number in np.flatnonzero(part == k).tolist():
            said[number] = told(fit, every[number])
    lines = ["| said | right | drawings |", "| --- | --- | --- |"]
    for low, high in pairwise(BINS):
        here = (said >= low) & (said < high)
        if here.any():
            means = 100.0 * said[here].mean(), 100.0 * right[here].mean()
            lines.append("| {:.1f} % | {:.1f} % | {} |".format(*means, here.sum()))
    return "\n".join(lines)


def main(count: int) -> None:
    every = [each for seed in SEEDS[:count] if (each := outcome(seed)) is not None]
    print(f"{len(every)} drawings\n\n{held_out(every)}")
    Path(written.__file__).write_text(text_of(fitted(every)), encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else len(SEEDS))
