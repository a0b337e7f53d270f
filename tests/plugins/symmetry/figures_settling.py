"""Figures of ends that settle on what is known, as a Markdown table.

``python -m tests.plugins.symmetry.figures_settling``; seeds from 95000 on, which nothing was tuned
on. ``… 100 12`` takes 12 drawings of each kind from seed 100 on.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Ink
from bozzetto_symmetry.editing.end_snaps import SAME_PLACE
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from bozzetto_symmetry.tools.draw_curve import DrawCurve
from tests.plugins.symmetry import meeting_drawings as m
from tests.plugins.symmetry.meeting_drawings import Line

SEED: Final = 95000
COUNT: Final = 10
"""Drawings of a kind."""


HEADS: Final = (
    "", "ends", "of those that meet something: off as drawn, mm", "off as they settle",
    "settle", "of those that meet nothing: off as drawn, mm", "off as they settle",
    "settle, wrongly",
)  # fmt: skip


@dataclass(frozen=True)
class End:
    """What became of an end.

    Attributes
    ----------
    off : float
        Its distance from the true one, mm.
    meant : bool
        The true one is on something.
    moved : bool
        It settled.
    """

    off: float
    meant: bool
    moved: bool


def ends_of(lines: Sequence[Line], snapping: bool) -> list[End]:
    """Draw lines one by one with the tool, and look at the ends that can be told apart."""
    state = SymmetryState(snapping=snapping)
    draw = DrawCurve()
    for line in lines:
        for stroke in line.strokes:
            state = draw.apply(state, Ink((stroke,)), Context(camera=stroke.camera))
    return judged(state, list(lines))


def judged(state: SymmetryState, lines: list[Line]) -> list[End]:
    """Return what became of the ends of lines that are curves of their own."""
    found: list[End] = []
    for line in lines:
        own = [curve for curve in state.curves if line.strokes[0] in tuple(curve.strokes)]
        if len(own) == 1 and set(own[0].strokes) == set(line.strokes):
            found += _ends(own[0], line, state, lines)
    return found


def _ends(curve: Curve, line: Line, state: SymmetryState, lines: list[Line]) -> list[End]:
    try:
        solved = trace_of(curve, state).curve
        free = trace_of(replace(curve, end_snaps=(), axis=-1), state).curve
    except UserError:
        return []
    if solved is None or free is None or solved.closed or free.closed:
        return []
    both = np.vstack((line.ends, line.ends * MIRROR))
    snaps = state.plane.inverse.points([snap.point for snap in curve.end_snaps] or np.zeros((0, 3)))
    snaps = np.vstack((snaps, snaps * MIRROR))
    found = []
    for number in (1,) if solved.reading == "self" else (0, 1):
        at, now = (each.spline.value(each.spline.range)[number] for each in (free, solved))
        true = both[int(np.argmin(np.linalg.norm(both - at, axis=1)))]
        off = float(np.linalg.norm(now - true))
        moved = bool((np.linalg.norm(snaps - now, axis=1) < SAME_PLACE * state.diagonal).any())
        found.append(End(off, m.meets(true, line, lines, state.size), moved))
    return found


def row(name: str, free: list[End], settled: list[End]) -> str:
    """Return a line of the table."""

    def mean(ends: list[End], meant: bool) -> str:
        off = [end.off for end in ends if end.meant == meant]
        return f"{np.mean(off):.2f}" if off else "–"

    meant = [end.moved for end in settled if end.meant]
    alone = [end.moved for end in settled if not end.meant]
    cells = (
        name, str(len(settled)),
        mean(free, True), mean(settled, True), f"{sum(meant)} of {len(meant)}",
        mean(free, False), mean(settled, False), f"{sum(alone)} of {len(alone)}",
    )  # fmt: skip
    return "| " + " | ".join(cells) + " |"


def main(begin: int = SEED, count: int = COUNT) -> None:
    """Print the table."""
    print(f"| {' | '.join(HEADS)} |")
    print("|" + " --- |" * len(HEADS))
    for noise in (0.5, 1.0):
        for name, made in m.KINDS.items():
            free, settled = [], []
            for seed in range(begin, begin + count):
                lines = made(noise, np.random.default_rng(seed))
                free += ends_of(lines, False)
                settled += ends_of(lines, True)
            print(row(f"{name}, {noise:g} px", free, settled), flush=True)


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
