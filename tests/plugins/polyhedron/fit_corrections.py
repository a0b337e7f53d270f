"""Fit what corrects the confidence for drawings of other kinds than random solids.

``python -m tests.plugins.polyhedron.fit_corrections [drawings]`` goes on from the numbers of
``fit_confidence``. It draws the five families of ``figures_families`` in equal shares with `SEEDS`,
and writes ``confidence_weights.py``: a logistic regression on what random solids say of a first
reading, on its lead over readings of other shapes, and on four traits. Weights are pulled to 0, but
that of the former to 1, so that little is corrected without evidence.

Why: of random solids the next reading is mostly of the same shape, so a small lead says little. Of
parts it is often another one. And no random solid is read as open, or with a part in the air.

Printed is what is said of drawings that a fit has not seen: of each family by the fit to the
others, so that no fit knows the kinds of solids that it is asked about.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

import bozzetto_polyhedron.reconstruction.confidence_weights as written
from bozzetto_polyhedron.reconstruction.ranking import (
    CORRECTED,
    LEAST,
    MOST,
    corrected_traits,
)
from tests.plugins.polyhedron.figures_families import FAMILIES, family_of, loss, outcome
from tests.plugins.polyhedron.fit_confidence import rows_of_traits, table_of
from tests.plugins.polyhedron.kept_outcomes import Outcome, kept

SEEDS = (
    *range(830_000, 830_800),
    *range(900_000, 900_132),
    *range(900_400, 900_618),
    *range(900_800, 900_963),
)
PULL = 1.0
"""Pull of a weight, of unit spread, drawings a squared unit of log odds."""

UNHEARD: dict[str, tuple[float, float]] = {
    "whether it is open": (0.0, 1.0),
    "whether a part hangs nowhere": (0.0, 1.0),
}
"""Limits of traits that fewer than one drawing of a hundred has."""

HEADER = '''\
"""Numbers that correct the confidence; ``python -m tests.plugins.polyhedron.fit_corrections``."""

from __future__ import annotations

from typing import Final

'''


@dataclass(frozen=True, eq=False)
class Corrections:
    """Log odds without traits, and limits and weights of `CORRECTED`, (t, 3)."""

    bias: float
    traits: np.ndarray


def traits_of(each: Outcome) -> np.ndarray:
    """Return what corrects the confidence of a first reading."""
    return corrected_traits(each.lead, each.evidence, each.traits, each.apart)


def fitted(every: Sequence[Outcome]) -> Corrections:
    """Return the corrections under which what came of drawings is likeliest."""
    rows = np.array([traits_of(each) for each in every])
    low, high = np.quantile(rows, (0.01, 0.99), axis=0)
    for name, limits in UNHEARD.items():
        low[CORRECTED.index(name)], high[CORRECTED.index(name)] = limits
    rows = np.clip(rows, low, high)
    spread = np.where(rows.std(axis=0) > 0.0, rows.std(axis=0), 1.0)
    spread[0] = 1.0
    middle = rows.mean(axis=0)
    middle[0] = 0.0
    columns = np.column_stack((np.ones(len(rows)), (rows - middle) / spread))
    right = np.array([each.right for each in every], float)
    start = np.zeros(columns.shape[1])
    start[1] = 1.0

    def unlikely(values: np.ndarray) -> tuple[float, np.ndarray]:
        odds, off = columns @ values, PULL * (values - start)
        off[0] = 0.0
        sum_ = np.logaddexp(0.0, odds).sum() - right @ odds + 0.5 * off @ (values - start)
        return float(sum_), columns.T @ (1.0 / (1.0 + np.exp(-odds)) - right) + off

    found = minimize(unlikely, start, jac=True, method="L-BFGS-B").x
    weights = found[1:] / spread
    return Corrections(float(found[0] - weights @ middle), np.column_stack((low, high, weights)))


def told(made: Corrections, each: Outcome) -> float:
    """Return what is said of a first reading, as ``ranking.confidence_of_first`` does."""
    low, high, weights = made.traits.T
    odds = made.bias + float(weights @ np.clip(traits_of(each), low, high))
    return each.certainty * float(np.clip(1.0 / (1.0 + np.exp(-odds)), LEAST, MOST))


def said_unseen(found: dict[int, Outcome]) -> np.ndarray:
    """Return what is said of each drawing by the fit to the other families, (n,)."""
    said = {}
    for name in FAMILIES:
        fit = fitted([each for seed, each in found.items() if family_of(seed) != name])
        said |= {seed: told(fit, each) for seed, each in found.items() if family_of(seed) == name}
    return np.array([said[seed] for seed in found])


def held_out(found: dict[int, Outcome]) -> str:
    """Return a table of what is said of families that a fit has not seen."""
    said, right = said_unseen(found), np.array([each.right for each in found.values()])
    return f"{table_of(said, right)}\n\nMean negative log-likelihood: {loss(right, said):.4f}."


def text_of(made: Corrections) -> str:
    """Return the module that keeps corrections."""
    lines = [
        f"BIAS: Final = {made.bias:.4g}",
        '"""Log odds that the first answer is right, without what follows."""\n',
        "CORRECTIONS: Final = {",
        *rows_of_traits(CORRECTED, made.traits),
    ]
    return HEADER + "\n".join(lines)


def main(count: int) -> None:
    seeds = SEEDS[:count]
    found = kept("families", seeds, outcome)
    print(f"{len(found)} drawings\n\n{held_out(found)}")
    Path(written.__file__).write_text(text_of(fitted(list(found.values()))), encoding="utf-8")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else len(SEEDS))
