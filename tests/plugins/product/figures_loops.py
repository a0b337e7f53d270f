"""Figures of loops that are found by themselves, as a Markdown table.

``python -m tests.plugins.product.figures_loops``; seeds from 1000 on, which nothing was tuned on.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bozzetto_product.loops.finding import find_loops
from bozzetto_product.network.net import Loop, Net
from tests.plugins.product.drawn_networks import DRAWN, sheet
from tests.plugins.product.held_out_networks import HELD_OUT
from tests.plugins.product.random_networks import cells, faulty, quilt, tube
from tests.plugins.product.sketched_network import Score, Sketch, edge_set

SEEDS = range(1000, 1016)


@dataclass(frozen=True)
class Row:
    """A line of the table; a bound is asked for where one is given."""

    what: str
    measured: float
    asked: str = ""
    kept: bool | None = None

    def __str__(self) -> str:
        kept = {True: "yes", False: "**no**", None: ""}[self.kept]
        return f"| {self.what} | {self.measured:.3g} | {self.asked} | {kept} |"


@dataclass(frozen=True)
class Found:
    """A network with what is found in it."""

    net: Net
    meant: list[frozenset[int]]
    loops: tuple[Loop, ...]
    seconds: float

    @classmethod
    def of(cls, sketch: Sketch) -> Found:
        net = sketch.net()
        start = time.process_time()
        loops = find_loops(net).loops
        seconds = time.process_time() - start
        return cls(net, sketch.truth(net, strict=False), loops, seconds)

    @property
    def score(self) -> Score:
        return Score.of(map(edge_set, self.loops), self.meant)

    def touches(self) -> int:
        """Return how many touches, on or off, make it what is meant; openings may stay closed."""
        candidates = {edge_set(loop): loop for loop in find_loops(self.net).candidates}
        meant = set(self.meant) & set(candidates)
        fixed: list[Loop] = []
        rejected: list[Loop] = []
        while True:
            loops = find_loops(self.net, fixed=fixed, rejected=rejected).loops
            found = {edge_set(loop) for loop in loops}
            missed = [each for each in self.meant if each in meant - found]
            wrong = [each for each in loops if _conflicts(edge_set(each), meant)]
            if missed:
                fixed.append(candidates[missed[0]])
            elif wrong:
                rejected.append(wrong[0])
            else:
                return len(fixed) + len(rejected)


def _conflicts(loop: frozenset[int], meant: set[frozenset[int]]) -> bool:
    """Tell whether a loop that is not meant has an edge that has two of those that are."""
    full = any(sum(edge in each for each in meant) > 1 for edge in loop)
    return loop not in meant and full


def _table(found: Iterable[Found], name: str, asked: bool) -> list[Row]:
    results = list(found)
    scores = [each.score for each in results]
    right, meant, wrong = (
        sum(getattr(each, part) for each in scores) for part in ("right", "meant", "wrong")
    )
    closable = sum(bool(each) for result in results for each in result.meant)
    f1 = float(np.median([each.f1 for each in scores]))
    recall, precision = right / meant, right / (right + wrong)
    touches = sum(each.touches() for each in results) / meant
    bounds = ("≥ 0.92", "≥ 0.85", "≥ 0.93", "≤ 0.3") if asked else ("", "", "", "")
    kept = (f1 >= 0.92, recall >= 0.85, precision >= 0.93, touches <= 0.3)
    told = kept if asked else (None,) * 4
    openings = sum(each.openings for each in scores)
    return [
        Row(
            f"{name} ({len(results)} networks, {meant} surfaces): F1, median",
            f1,
            bounds[0],
            told[0],
        ),
        Row(f"{name}: recall", recall, bounds[1], told[1]),
        Row(f"{name}: recall of those that the joints can close", right / max(1, closable)),
        Row(f"{name}: precision, openings not counted", precision, bounds[2], told[2]),
        Row(f"{name}: openings that were closed, a surface meant", openings / meant),
        Row(f"{name}: touches a surface", touches, bounds[3], told[3]),
    ]


def _name_seed(name: str, number: int) -> int:
    return 1000 + 100 * number + sum(map(ord, name)) % 100


def rows() -> list[Row]:
    """Return the whole table."""
    made: list[Row] = []
    for size in (5, 9, 14):
        sheets = Found.of(sheet(size, size))
        edges, score = len(sheets.net.edges), sheets.score
        share = score.f1 if not score.openings else 0.0
        made.append(Row(f"sheet of {edges} curves: F1", share, "1", share == 1.0))
        made.append(Row("the same, s of processor", sheets.seconds, "< 0.6", sheets.seconds < 0.6))
    teapot = Found.of(DRAWN["teapot"]()).score
    kept = teapot.right == 32 and not teapot.wrong
    made.append(Row("Utah teapot, of 32 patches", teapot.right, "32", kept))
    made += _table([Found.of(make()) for make in DRAWN.values()], "drawn", asked=True)
    unseen = [Found.of(make()) for make in HELD_OUT.values()]
    made += _table(unseen, "drawn, nothing tuned on them", asked=True)
    every = {**DRAWN, **HELD_OUT}
    faults = [
        Found.of(faulty(make(), _name_seed(name, k), noise=0.01, missing=0.03, over=0.15))
        for name, make in every.items()
        for k in range(2)
    ]
    what = "1 % off, 3 % of curves miss a joint, 15 % too long"
    made += _table(faults, what, asked=True)
    rough = [
        Found.of(faulty(make(), _name_seed(name, 5), noise=0.03)) for name, make in every.items()
    ]
    made += _table(rough, "3 % off", asked=True)
    for make in (cells, quilt, tube):
        several = [Found.of(faulty(make(k), k, noise=0.02)) for k in SEEDS]
        made += _table(several, f"{make.__name__}, 2 % off", asked=False)
    return made


if __name__ == "__main__":
    print("| | measured | asked | kept |\n|---|---|---|---|")
    for row in rows():
        print(row, flush=True)
