"""Fit the numbers that tell how likely lines and corners are those that were meant.

``python -m tests.plugins.polyhedron.fit_certainty [drawings]`` draws solids of five families in
strokes, by a simulated hand, finds their lines as the program does, and writes
``certainty_numbers.py``: a logistic regression over what is known of a draft
(``graph.certainty.line_traits``), with a pull of the weights to 0.

The families are a fifth each: random solids, parts of ``cad_parts.py``, ``workshop_parts.py``,
``machine_parts.py``, and ``fine_parts.py``. A third of the drawings have a jitter of 0.5 %, of 1 %
and of 2 % each; two of three have light hidden lines, half of them are untidy.

Printed is what is said of drawings that a fit has not seen: of each quarter by the fit to the
others.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import bozzetto_polyhedron.graph.certainty_numbers as written
from bozzetto.ink import Stroke
from bozzetto_polyhedron.graph.build import size_of
from bozzetto_polyhedron.graph.certainty import line_traits
from bozzetto_polyhedron.graph.certainty_numbers import TRAITS
from bozzetto_polyhedron.graph.live import LiveGraph, searched
from bozzetto_polyhedron.graph.second_reading import closest_other
from bozzetto_polyhedron.solve.line_readings import decided
from tests.plugins.polyhedron import cad_parts
from tests.plugins.polyhedron.fine_parts import FINE, fine_part
from tests.plugins.polyhedron.fit_confidence import rows_of_traits, table_of
from tests.plugins.polyhedron.graph_truth import is_right
from tests.plugins.polyhedron.hand import SIZE, UNTIDY, Hand, strokes_of
from tests.plugins.polyhedron.machine_parts import MACHINE, machine_part
from tests.plugins.polyhedron.objects import CAMERA, TO_CANVAS, View, made, view
from tests.plugins.polyhedron.workshop_parts import WORKSHOP, workshop_part

SEEDS = range(300_000, 301_500)
FAMILIES = (
    (("any",), lambda _, seed: made(seed)),
    (tuple(cad_parts.PARTS), cad_parts.part),
    (tuple(WORKSHOP), workshop_part),
    (tuple(MACHINE), machine_part),
    (tuple(FINE), fine_part),
)
"""Kinds of solids, and what makes one of a kind by a seed."""

JITTERS = (0.01, 0.005, 0.02)
OVERSHOT = 0.3
PARTS = 4
PULL = 4.0
"""Pull of the weight of a trait, of unit spread, to 0."""

HEADER = '''\
"""Numbers of the certainty; written by ``python -m tests.plugins.polyhedron.fit_certainty``."""

from __future__ import annotations

from typing import Final

'''


@dataclass(frozen=True, eq=False)
class Lines:
    """The lines of one drawing: what is known of them, and whether they are right."""

    traits: np.ndarray
    right: bool


@dataclass(frozen=True, eq=False)
class Fit:
    """Log odds without traits, and limits and weights of all traits, (t, 3)."""

    odds: float
    traits: np.ndarray


def drawing(seed: int) -> tuple[View, tuple[Stroke, ...], float, bool] | None:
    """Draw a solid of a family; None where there is no solid or no view.

    Returns
    -------
    View
    tuple of Stroke
    float
        Jitter of the hand.
    bool
        Whether hidden lines are light.
    """
    names, make = FAMILIES[seed % len(FAMILIES)]
    solid = make(names[seed // len(FAMILIES) % len(names)], seed)
    seen = None if solid is None else view(solid, seed)
    if seen is None:
        return None
    rng = np.random.default_rng((23, seed))
    marked, tidy = bool(rng.random() < 2 / 3), rng.random() < 0.5
    jitter = JITTERS[rng.integers(len(JITTERS))]
    hand = Hand(jitter=jitter) if tidy else replace(UNTIDY, jitter=jitter, overshot=OVERSHOT)
    edges = [(int(a), int(b)) for a, b in seen.solid.edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist() if marked else ()
    return seen, strokes_of(seen.plane * TO_CANVAS, edges, hand, seed, hidden), jitter, marked


def are_right(live: LiveGraph, seen: View) -> bool:
    """Whether lines and corners are those of the solid that was seen."""
    edges = [(int(a), int(b)) for a, b in seen.solid.edges]
    return is_right(live.graph, seen.plane * TO_CANVAS * SIZE + 200.0, edges)


def lines_of(seed: int) -> Lines | None:
    """Draw a solid and judge its lines; None where there is nothing to judge."""
    drawn = drawing(seed)
    if drawn is None:
        return None
    seen, strokes, _, _ = drawn
    live = decided(searched(strokes), CAMERA, lambda *_: None)
    if live.draft is None:
        return None
    cost, _ = closest_other(live.draft)
    traits = line_traits(live.graph, live.draft, cost, size_of(strokes))
    return Lines(traits, are_right(live, seen))


def fitted(every: Sequence[Lines]) -> Fit:
    """Return the log odds and weights under which what came of drawings is likeliest."""
    low, high = np.quantile([each.traits for each in every], (0.01, 0.99), axis=0)
    held = np.clip([each.traits for each in every], low, high)
    middle, spread = held.mean(axis=0), np.where(high > low, held.std(axis=0), 1.0)
    rows = np.column_stack((np.ones(len(held)), (held - middle) / spread))
    right = np.array([each.right for each in every], float)
    pull = np.array([0.0, *(PULL for _ in low)])

    def loss(values: np.ndarray) -> tuple[float, np.ndarray]:
        odds = rows @ values
        unlikely = np.logaddexp(0.0, odds).sum() - right @ odds + 0.5 * (pull * values) @ values
        return float(unlikely), rows.T @ (1.0 / (1.0 + np.exp(-odds)) - right) + pull * values

    found = minimize(loss, np.zeros(rows.shape[1]), jac=True, method="L-BFGS-B").x
    weights = found[1:] / spread
    return Fit(float(found[0] - weights @ middle), np.column_stack((low, high, weights)))


def told(fit: Fit, each: Lines) -> float:
    """Return what a fit says of lines, as ``graph.certainty.certainty_of`` does."""
    low, high, weights = fit.traits.T
    odds = fit.odds + float(weights @ np.clip(each.traits, low, high))
    return float(1.0 / (1.0 + np.exp(-odds)))


def said_unseen(every: Sequence[Lines]) -> np.ndarray:
    """Return what is said of each drawing by the fit to three quarters without it, (n,)."""
    part = np.random.default_rng(0).permutation(len(every)) % PARTS
    said = np.zeros(len(every))
    for k in range(PARTS):
        fit = fitted([each for each, own in zip(every, part, strict=True) if own != k])
        for number in np.flatnonzero(part == k).tolist():
            said[number] = told(fit, every[number])
    return said


def held_out(every: Sequence[Lines]) -> str:
    """Return a table of what is said of drawings that a fit has not seen."""
    said, right = said_unseen(every), np.array([each.right for each in every])
    return table_of(said, right)


def text_of(fit: Fit) -> str:
    """Return the module that keeps a fit."""
    lines = [
        f"LOG_ODDS: Final = {fit.odds:.4g}",
        '"""Log odds that lines are right, without their traits."""\n',
        "TRAITS: Final = {",
        *rows_of_traits(TRAITS, fit.traits),
    ]
    return HEADER + "\n".join(lines)


def main(count: int) -> None:
    every = [each for seed in SEEDS[:count] if (each := lines_of(seed)) is not None]
    print(f"{len(every)} drawings\n\n{held_out(every)}")
    Path(written.__file__).write_text(text_of(fitted(every)), encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else len(SEEDS))
