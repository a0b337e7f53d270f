"""How far the confidence of first answers is from how often they are right.

``python -m tests.plugins.polyhedron.figures_confidence [drawings] [first seed]`` prints a Markdown
table; seeds from 70,000 on, to which nothing is fitted. The drawings are those of
``fit_confidence``. Unmarked answers are said 2 % lower by the program, for the side from which they
are seen; that is not in these figures.
"""

from __future__ import annotations

import sys
from itertools import pairwise

import numpy as np

from bozzetto_polyhedron.reconstruction.ranking import confidence_of_first
from tests.plugins.polyhedron.fit_confidence import BINS, Outcome, outcome

FIRST_SEED = 70_000
ASKED = 5.0
"""Points."""

NAMES = {
    "plain": "all lines alike",
    "loose": "the same, with loose parts",
    "marked": "hidden lines light",
}


def said(each: Outcome) -> float:
    """Return the confidence of a first reading."""
    told = confidence_of_first(each.lead, each.evidence, each.traits, each.apart)
    return each.certainty * told


def rows(name: str, every: list[Outcome]) -> None:
    """Print a row for each bin of the confidence."""
    for low, high in pairwise(BINS):
        found = [each for each in every if low <= said(each) < high]
        if not found:
            continue
        mean = 100.0 * float(np.mean([said(each) for each in found]))
        right = 100.0 * float(np.mean([each.right for each in found]))
        error = float(np.sqrt(right * (100.0 - right) / len(found)))
        off = abs(mean - right)
        print(
            f"| {name} | {mean:.1f} % | {right:.1f} ± {error:.1f} % of {len(found)} "
            f"| {off:.1f} points | {'yes' if off <= ASKED else 'no'} |"
        )


def main(count: int, first: int) -> None:
    every = [each for seed in range(first, first + count) if (each := outcome(seed)) is not None]
    print(f"| drawings | said | right | difference | at most {ASKED:g} points |")
    print("| --- | --- | --- | --- | --- |")
    rows("all drawings", every)
    for evidence, name in NAMES.items():
        rows(name, [each for each in every if each.evidence == evidence])


if __name__ == "__main__":
    given = [int(each) for each in sys.argv[1:]]
    main(*(given + [2400, FIRST_SEED][len(given) :]))
