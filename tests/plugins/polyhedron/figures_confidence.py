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
from tests.plugins.polyhedron.fit_confidence import BINS, outcome
from tests.plugins.polyhedron.kept_outcomes import Outcome, kept

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


def error_of(told: np.ndarray) -> float:
    """Return the standard error of how many of drawings, of which so much is said, are right.

    In points.
    """
    return 100.0 * float(np.sqrt((told * (1.0 - told)).sum())) / len(told)


def of_edges(told: np.ndarray) -> list[np.ndarray]:
    """Return which drawings are in each of `BINS`, (n,) bool, those without any left out."""
    found = [(told >= low) & (told < high) for low, high in pairwise(BINS)]
    return [here for here in found if here.any()]


def bins_of(told: np.ndarray) -> list[np.ndarray]:
    """Return `of_edges`, and bins that show nothing put together with the next one.

    A bin shows nothing where its standard error is above what is asked. What is left at the end is
    put together with the bin below it.
    """
    found: list[np.ndarray] = []
    for here in of_edges(told):
        if found and error_of(told[found[-1]]) > ASKED:
            found[-1] = found[-1] | here
        else:
            found.append(here)
    if len(found) > 1 and error_of(told[found[-1]]) > ASKED:
        found[-2:] = [found[-2] | found[-1]]
    return found


def rows(name: str, every: list[Outcome], merged: bool = True) -> None:
    """Print a row for each bin of the confidence; see `bins_of`."""
    told = np.array([said(each) for each in every])
    right = np.array([each.right for each in every], bool)
    for here in bins_of(told) if merged else of_edges(told):
        mean, share = 100.0 * told[here].mean(), 100.0 * right[here].mean()
        off = abs(mean - share)
        print(
            f"| {name} | {mean:.1f} % | {share:.1f} % of {here.sum()} | {off:.1f} "
            f"± {error_of(told[here]):.1f} points | {'yes' if off <= ASKED else 'no'} |"
        )


def main(count: int, first: int) -> None:
    every = list(kept("solids", range(first, first + count), outcome).values())
    print(f"| drawings | said | right | difference | at most {ASKED:g} points |")
    print("| --- | --- | --- | --- | --- |")
    rows("all drawings, every bin", every, merged=False)
    rows("all drawings", every)
    for evidence, name in NAMES.items():
        rows(name, [each for each in every if each.evidence == evidence])


if __name__ == "__main__":
    given = [int(each) for each in sys.argv[1:]]
    main(*(given + [2400, FIRST_SEED][len(given) :]))
