"""Fit the numbers that tell how likely the first reading is the right one.

``python -m tests.plugins.polyhedron.fit_confidence [drawings]`` draws random solids with `SEEDS`,
to which nothing else is fitted, reads them as the program does, and writes
``confidence_tables.py``.

The drawings: a sixth each of upright solids, of slanted ones twice, and of blocks with a pocket, a
boss or a tunnel, all with lines alike; of such blocks, and of upright and slanted solids together,
with hidden lines drawn lightly, 10 % of them wrongly. A corner is off by 0, 0.5, 1 or 2 % of the
diagonal (standard deviation), a quarter each; the program is told that noise wrong by a factor of
1.28. A reading is right if its shape is (``objects.is_right``) and it has the faces of the solid.

The log odds of being right are a sum: of a function of the lead of the first reading (the log odds
of its share), one for each kind of evidence, straight between knots and never falling; and of the
weighted traits of that reading and of the drawing, held within what 98 of 100 drawings have. It is
fitted by the likelihood, with a pull of the functions to the lead itself and of the weights to 0.

Printed is what is said of drawings that a fit has not seen: of each quarter by the fit to the
others.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import bozzetto_polyhedron.reconstruction.confidence_tables as written
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.reconstruction.answers import evidence_of, ranked_readings
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.ranking import (
    DRAWN,
    FEATURES,
    LEAST,
    MOST,
    lead_of,
    traits_of,
)
from bozzetto_polyhedron.reconstruction.readings import lead_over_others
from tests.plugins.polyhedron.fit_ranking import NOISES
from tests.plugins.polyhedron.kept_outcomes import Outcome, kept
from tests.plugins.polyhedron.objects import CAMERA, View, graph_of, is_right, made, view

SEEDS = (*range(30_000, 35_200), *range(50_000, 52_800))
UPRIGHT = ("rectilinear prism", "stairs", "letter prism", "boxes", "notched box")
SLANTED = ("slanted prism", "slanted step", "tapered", "chamfered")
LOOPED = ("looped",)
KINDS = (
    (UPRIGHT, None),
    (SLANTED, None),
    (LOOPED, 0.1),
    (UPRIGHT + SLANTED, 0.1),
    (SLANTED, None),
    (LOOPED, None),
)
"""Solids, and the share of wrong marks of hidden lines; none where all lines are alike."""

KNOTS = (-6.0, -3.0, -1.5, -0.5, 0.5, 1.5, 3.0, 4.5, 6.0)
EVIDENCE = ("plain", "loose", "marked")
BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 1.01)
PARTS = 4
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
class Fit:
    """Log odds at `KNOTS` for each `EVIDENCE`, and limits and weights of all traits, (t, 3)."""

    odds: np.ndarray
    traits: np.ndarray


def outcome(seed: int) -> Outcome | None:
    """Draw a solid and judge the first reading; None where there is no view or no reading."""
    kinds, marks = KINDS[seed % len(KINDS)]
    noise = NOISES[seed // len(KINDS) % len(NOISES)]
    solid = made(seed, kinds)
    seen = view(solid, seed)
    if seen is None:
        return None
    graph, _ = graph_of(seen, noise, seed, marks)
    return judged(graph, np.arange(len(graph.places)), seen, noise)


def judged(
    graph: LineGraph, numbers: np.ndarray | None, seen: View, noise: float, mirrored: bool = True
) -> Outcome | None:
    """Judge the first reading of lines; None where there is none.

    Parameters
    ----------
    graph : LineGraph
    numbers : (n,) array, optional
        The vertex of the solid that each corner is; without where lines are wrong, and so is what
        is read.
    seen : View
    noise : float
        Of the corners, diagonals.
    mirrored : bool
        Whether the mirror image is right as well.
    """
    drawing = drawing_of(graph)
    sight, found = ranked_readings(drawing, CAMERA)
    if not found:
        return None
    first, right = found[0], False
    if numbers is not None:
        shape = np.empty((len(numbers), 3))
        shape[numbers] = np.column_stack((sight.drawing.points, first.depths))
        faces = {
            frozenset(frozenset(int(numbers[corner]) for corner in ring) for ring in face)
            for face in first.faces
        }
        right = faces == seen.solid.face_sets() and is_right(seen, shape, noise, mirrored)
    lead = lead_of(np.array([each.score for each in found]))
    traits = traits_of(first.features, drawing.lines, drawing.noise)
    apart = lead_over_others(sight.drawing, found)
    return Outcome(evidence_of(drawing), lead, traits, right, apart, graph.certainty)


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


def rows_of_traits(names: Sequence[str], traits: np.ndarray) -> list[str]:
    """Return the lines of a module with the numbers of traits, (n, 3), and what they are."""
    return [
        *(
            f'    "{name}": {tuple(float(f"{value:.4g}") for value in row)},'
            for name, row in zip(names, traits, strict=True)
        ),
        "}",
        '"""Of each trait the least and the largest value, and what it adds to the log odds."""\n',
    ]


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
        *rows_of_traits((*FEATURES, *DRAWN), made.traits),
    ]
    return HEADER + "\n".join(lines)


def told(fit: Fit, each: Outcome) -> float:
    """Return what a fit says of a first reading, before ``fit_corrections``."""
    low, high, weights = fit.traits.T
    odds = np.interp(each.lead, KNOTS, fit.odds[EVIDENCE.index(each.evidence)])
    return float(1.0 / (1.0 + np.exp(-odds - np.clip(each.traits, low, high) @ weights)))


def said_unseen(every: Sequence[Outcome]) -> np.ndarray:
    """Return what is said of each drawing by the fit to three quarters without it, (n,)."""
    part = np.random.default_rng(0).permutation(len(every)) % PARTS
    said = np.zeros(len(every))
    for k in range(PARTS):
        fit = fitted([each for each, own in zip(every, part, strict=True) if own != k])
        for number in np.flatnonzero(part == k).tolist():
            said[number] = told(fit, every[number])
    return np.clip(said, LEAST, MOST)


def table_of(said: np.ndarray, right: np.ndarray) -> str:
    """Return a table of how sure of drawings, (n,), a fit was, and how many were right."""
    lines = ["| said | right | drawings |", "| --- | --- | --- |"]
    for low, high in pairwise(BINS):
        here = (said >= low) & (said < high)
        if here.any():
            means = 100.0 * said[here].mean(), 100.0 * right[here].mean()
            lines.append("| {:.1f} % | {:.1f} % | {} |".format(*means, here.sum()))
    return "\n".join(lines)


def held_out(every: Sequence[Outcome]) -> str:
    """Return a table of what is said of drawings that a fit has not seen."""
    said, right = said_unseen(every), np.array([each.right for each in every])
    return table_of(said, right)


def main(count: int) -> None:
    every = list(kept("solids", SEEDS[:count], outcome).values())
    print(f"{len(every)} drawings\n\n{held_out(every)}")
    Path(written.__file__).write_text(text_of(fitted(every)), encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else len(SEEDS))
