"""Fit the weights of the ranking.

``python -m tests.plugins.polyhedron.fit_ranking [drawings]`` draws random solids with seeds below
1000, reads them, and writes ``ranking_weights.py``. The weights maximise the likelihood of the
right reading among all that were found for a drawing, with a pull towards ``START``, most of which
were fitted to CAD parts that are not in this repository. Both halves in turn tell how often the
first reading is right on drawings that the weights were not fitted to; run ``fit_confidence`` then.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import bozzetto_polyhedron.reconstruction.ranking_weights as written
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.ranking import FEATURES
from bozzetto_polyhedron.reconstruction.readings import readings
from tests.plugins.polyhedron.objects import MAKERS, graph_of, is_right, made, view

NOISES = (0.0, 0.005, 0.01, 0.02)
SLANTED = ("slanted prism", "slanted step", "tapered", "chamfered", "looped")
PULL = 0.02
"""Weight of the squared distance from the start, relative to its size."""

START = {
    "square corners": 1.68,
    "square dihedral angles": 1.36,
    "equal lengths in a face": 1.79,
    "square classes": 1.12,
    "depth against width, squared logarithm": -1.34,
    "steepness": -2.76,
    "axis square to all else": 1.5,
    "faces opposite one another": 1.0,
    "frame coverage": 1.33,
    "equal angles in a face": 3.55,
    "mirror plane": 1.98,
    "further mirror planes": 4.26,
    "frame coverage, sixth power": 3.2,
    "stands upright": 0.0,
    "planarity beyond the noise": -0.71,
    "depth residual": 0.08,
    "strict classes": -0.76,
    "open lines": -1.0,
    "through-holes": 0.35,
    "parts that stand out": -0.3,
    "misfit of loose parts": -0.5,
    "parts that hang nowhere": -6.0,
    "gaps of loose parts": -1.0,
    "marks of hidden lines": 0.7,
}

HEADER = '''\
"""Numbers of the ranking; written by ``python -m tests.plugins.polyhedron.fit_ranking``."""

from __future__ import annotations

from typing import Final

WEIGHTS: Final = {
'''


@dataclass(frozen=True, eq=False)
class Example:
    """Readings of one drawing: their features, and which are right."""

    features: np.ndarray
    right: np.ndarray


def example(seed: int) -> Example | None:
    """Draw a solid, read it, and tell the right readings from the wrong ones."""
    kinds = SLANTED if seed % 3 == 0 else tuple(MAKERS)
    seen = view(made(seed, kinds), seed)
    if seen is None:
        return None
    noise = NOISES[seed // 3 % len(NOISES)]
    marks = 0.1 if seed % 5 < 2 else None
    graph, _ = graph_of(seen, noise, seed, marks)
    drawing = drawing_of(graph)
    found = readings(drawing)
    if not found:
        return None
    faces = seen.solid.face_sets()
    shaped = np.array(
        [
            is_right(seen, np.column_stack((drawing.points, each.depths)), noise, marks is None)
            for each in found
        ]
    )
    whole = np.array(
        [
            {frozenset(frozenset(ring) for ring in face) for face in each.faces} == faces
            for each in found
        ]
    )
    right = shaped & whole if (shaped & whole).any() else shaped
    return Example(np.array([each.features for each in found]), right)


def fitted(examples: list[Example]) -> np.ndarray:
    """Return the weights under which right readings are likeliest."""
    start = np.array([START[name] for name in FEATURES])
    size = np.maximum(1.0, np.abs(start))
    useful = [each for each in examples if each.right.any() and not each.right.all()]

    def loss(weights: np.ndarray) -> tuple[float, np.ndarray]:
        off = (weights - start) / size
        total = PULL * len(useful) * 0.1 * float(off @ off)
        slope = PULL * len(useful) * 0.2 * off / size
        for each in useful:
            shares = softmax(each.features @ weights)
            good = float(shares[each.right].sum())
            among = np.where(each.right, shares, 0.0) / good
            total -= np.log(good)
            slope = slope + (shares - among) @ each.features
        return total, slope

    return np.asarray(minimize(loss, start, jac=True, method="L-BFGS-B").x)


def softmax(values: np.ndarray) -> np.ndarray:
    found = np.exp(values - values.max())
    return found / found.sum()


def first_is_right(examples: list[Example], weights: np.ndarray) -> list[bool]:
    """Return for each example whether the reading of the highest score is right."""
    return [bool(each.right[(each.features @ weights).argmax()]) for each in examples]


def main(count: int) -> None:
    examples = [each for seed in range(count) if (each := example(seed)) is not None]
    weights = fitted(examples)
    halves = (examples[::2], examples[1::2])
    right = [first_is_right(b, fitted(a)) for a, b in (halves, halves[::-1])]
    share = np.concatenate(right).mean()
    print(f"{len(examples)} drawings; first one right on the other half: {share:.3f}")
    lines = [f'    "{name}": {weight:.2f},' for name, weight in zip(FEATURES, weights, strict=True)]
    text = HEADER + "\n".join(lines) + '\n}\n"""Weight of each measure."""\n'
    Path(written.__file__).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 900)
