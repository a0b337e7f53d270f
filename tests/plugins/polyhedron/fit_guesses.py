"""Fit the numbers that tell how likely guessed hidden lines are those that were meant.

``python -m tests.plugins.polyhedron.fit_guesses [drawings]`` draws the visible lines of solids by a
simulated hand, guesses the hidden ones, and writes ``guess_numbers.py``: a logistic regression over
what is known of a guess (``guess_certainty.guess_traits``), with a pull of the weights to 0. The
confidence of an answer is multiplied by it, so it is fitted to be the factor that is missing: of
all guesses, the first answer to the completed drawing is right or not.

The families are those of ``fit_certainty``, every other random solid a prism. Half of the drawings
have 1 % of jitter, half 2 %. Half are seen from any side, half from one that leaves few corners to
be guessed: people do not draw from behind what they want to show.

``BOZZETTO_OUTCOMES`` names a folder in which what came of drawings is kept, as for the confidence.

Printed is what is said of first guesses that a fit has not seen: of each quarter by the fit to the
others.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import bozzetto_polyhedron.reconstruction.guess_numbers as written
from bozzetto.ink import Stroke
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.guess_numbers import TRAITS
from bozzetto_polyhedron.reconstruction.hidden_lines import hidden_lines
from bozzetto_polyhedron.solve.completion import completed
from bozzetto_polyhedron.solve.line_readings import decided
from tests.plugins.polyhedron.figures_end_to_end import is_whole
from tests.plugins.polyhedron.figures_hidden_lines import PRISMS, is_told, visible_lines
from tests.plugins.polyhedron.fit_certainty import FAMILIES, PARTS, Fit
from tests.plugins.polyhedron.fit_confidence import rows_of_traits, table_of
from tests.plugins.polyhedron.graph_truth import corner_numbers, is_right
from tests.plugins.polyhedron.hand import SIZE, Hand, strokes_of
from tests.plugins.polyhedron.kept_outcomes import digest
from tests.plugins.polyhedron.objects import CAMERA, TO_CANVAS, Polyhedron, View, made, view

SEEDS = range(600_000, 600_290)
JITTERS = (0.01, 0.02)
VIEWS = 8
"""Sides from which one is chosen that leaves few corners to be guessed."""

PULL = 6.0
"""Pull of the weight of a trait, of unit spread, to 0."""

HEADER = '''\
"""Numbers of guesses; written by ``python -m tests.plugins.polyhedron.fit_guesses``."""

from __future__ import annotations

from typing import Final

'''


@dataclass(frozen=True, eq=False)
class Guess:
    """One guess: its traits, what is said of the first answer to it, and whether that is right."""

    drawing: int
    place: int
    traits: np.ndarray
    confidence: float
    right: bool


def solid_of(seed: int) -> Polyhedron | None:
    """Return a solid of a family."""
    names, make = FAMILIES[seed % len(FAMILIES)]
    number = seed // len(FAMILIES)
    if seed % len(FAMILIES) == 0 and number % 2:
        return made(seed, PRISMS)
    return make(names[number % len(names)], seed)


def seen_from(solid: Polyhedron, seed: int) -> View | None:
    """Return a view of a solid: any, or of several the first that tells what is hidden."""
    for number in range(1 if seed % 2 == 0 else VIEWS):
        seen = view(solid, 1000 * number + seed)
        if seen is not None and (seed % 2 == 0 or number == VIEWS - 1 or is_told(seen)):
            return seen
    return None


def drawing(seed: int) -> tuple[View, tuple[Stroke, ...]] | None:
    """Draw the visible lines of a solid; None where there is no solid or no view."""
    solid = solid_of(seed)
    seen = None if solid is None else seen_from(solid, seed)
    if seen is None:
        return None
    jitter = JITTERS[seed // 7 % len(JITTERS)]
    places, lines = visible_lines(seen)
    return seen, strokes_of(places, lines, Hand(jitter=jitter, wobble=0.6 * jitter), seed)


def guesses_of(seed: int) -> list[Guess]:
    """Draw a solid, guess its hidden lines, and judge each guess."""
    drawn = drawing(seed)
    return [] if drawn is None else judged(seed, *drawn, drawn[0].plane * TO_CANVAS * SIZE + 200.0)


def judged(seed: int, seen: View, strokes: tuple[Stroke, ...], places: np.ndarray) -> list[Guess]:
    """Return the guesses for a drawing whose solid has its corners at places, px."""
    edges = [(int(a), int(b)) for a, b in seen.solid.edges]
    found = []
    for place, guess in enumerate(hidden_lines(searched(strokes, only_visible=True).graph, CAMERA)):
        live = decided(searched(completed(strokes, guess)), CAMERA, lambda *_: None)
        answer = answers_of(live.graph, CAMERA)[0]
        right = is_right(live.graph, places, edges) and is_whole(
            answer, corner_numbers(live.graph, places), seen, live.graph
        )
        found.append(Guess(seed, place, guess.traits, answer.confidence, bool(right)))
    return found


def kept(seeds: Sequence[int]) -> list[Guess]:
    """Return guesses for the drawings of some seeds, those kept on disk where there are any."""
    folder = os.environ.get("BOZZETTO_OUTCOMES")
    if not folder:
        return [each for seed in seeds for each in guesses_of(seed)]
    path = Path(folder) / f"guesses-{digest()}.jsonl"
    lines = path.read_text().splitlines() if path.exists() else []
    known = {int(seed): rows for seed, rows in map(json.loads, lines)}
    with path.open("a") as file:
        for seed in seeds:
            if seed not in known:
                known[seed] = [
                    [each.place, each.traits.tolist(), each.confidence, each.right]
                    for each in guesses_of(seed)
                ]
                file.write(json.dumps([seed, known[seed]]) + "\n")
                file.flush()
    return [
        Guess(seed, place, np.array(traits), confidence, right)
        for seed in seeds
        for place, traits, confidence, right in known[seed]
    ]


def fitted(every: Sequence[Guess]) -> Fit:
    """Return the log odds and weights under which what came of guesses is likeliest.

    A guess is right with the probability certainty(traits) times what is said of its answer.
    """
    low, high = np.quantile([each.traits for each in every], (0.01, 0.99), axis=0)
    held = np.clip([each.traits for each in every], low, high)
    middle, spread = held.mean(axis=0), np.where(high > low, held.std(axis=0), 1.0)
    rows = np.column_stack((np.ones(len(held)), (held - middle) / spread))
    right = np.array([each.right for each in every], float)
    said = np.array([each.confidence for each in every])
    pull = np.array([0.0, *(PULL for _ in low)])

    def loss(values: np.ndarray) -> tuple[float, np.ndarray]:
        certain = 1.0 / (1.0 + np.exp(-(rows @ values)))
        share = np.clip(certain * said, 1e-9, 1.0 - 1e-9)
        unlikely = -(right * np.log(share) + (1.0 - right) * np.log(1.0 - share)).sum()
        slope = ((1.0 - right) / (1.0 - share) - right / share) * said * certain * (1.0 - certain)
        return float(unlikely + 0.5 * (pull * values) @ values), rows.T @ slope + pull * values

    found = minimize(loss, np.zeros(rows.shape[1]), jac=True, method="L-BFGS-B").x
    weights = found[1:] / spread
    return Fit(float(found[0] - weights @ middle), np.column_stack((low, high, weights)))


def told(fit: Fit, each: Guess) -> float:
    """Return what is said of a guess: its certainty by a fit, times that of its answer."""
    low, high, weights = fit.traits.T
    odds = fit.odds + float(weights @ np.clip(each.traits, low, high))
    return each.confidence / (1.0 + float(np.exp(-odds)))


def said_unseen(every: Sequence[Guess]) -> np.ndarray:
    """Return what is said of each guess by the fit to three quarters of drawings without it."""
    seeds = sorted({each.drawing for each in every})
    shuffled = np.random.default_rng(0).permutation(len(seeds)) % PARTS
    part = dict(zip(seeds, shuffled.tolist(), strict=True))
    said = np.zeros(len(every))
    for k in range(PARTS):
        fit = fitted([each for each in every if part[each.drawing] != k])
        for number, each in enumerate(every):
            if part[each.drawing] == k:
                said[number] = told(fit, each)
    return said


def text_of(fit: Fit) -> str:
    """Return the module that keeps a fit."""
    lines = [
        f"LOG_ODDS: Final = {fit.odds:.4g}",
        '"""Log odds that a guess is right, without its traits."""\n',
        "TRAITS: Final = {",
        *rows_of_traits(TRAITS, fit.traits),
    ]
    return HEADER + "\n".join(lines)


def main(count: int) -> None:
    every = kept(SEEDS[:count])
    first = np.array([each.place == 0 for each in every])
    right = np.array([each.right for each in every])
    said = said_unseen(every)
    print(f"{len(every)} guesses, {first.sum()} of them the first\n")
    print(table_of(said[first], right[first]))
    Path(written.__file__).write_text(text_of(fitted(every)), encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else len(SEEDS))
