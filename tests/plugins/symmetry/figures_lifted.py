"""Figures of drawings in which the pen was lifted within a line, as a Markdown table.

``python -m tests.plugins.symmetry.figures_lifted``; seeds from 7000 on, which nothing was tuned
on. ``… 100 32`` takes 32 drawings from seed 100 on.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from bozzetto.errors import UserError
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.solve.pieces import may_go_on
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry.lifted_drawings import Lifted, lifted
from tests.plugins.symmetry.scenes import Array

SEED: Final = 7000
COUNT: Final = 48
"""Drawings at each noise."""

RIGHT: Final = 0.05
"""Greatest error (95th percentile, either way) of what is right, in sizes of the thing."""


@dataclass(frozen=True)
class Outcome:
    """What became of one drawing.

    Attributes
    ----------
    meant : bool
        One curve, read as it is meant, in its place.
    right : bool
        All curves together are in the place of the thing.
    told : bool
        The person is warned, or ink waits.
    off : float
        Error of all curves together, in sizes of the thing.
    """

    meant: bool
    right: bool
    told: bool
    off: float


def outcome(thing: Lifted) -> Outcome:
    """Draw one thing in an empty box, stroke by stroke, and look at what it becomes."""
    state = add_drawing(SymmetryState(), thing.strokes)
    traces: list[Trace] = []
    told = False
    for curve in state.curves:
        try:
            traces.append(trace_of(curve, state))
        except UserError:
            told = True
    told |= any(trace.curve is None or trace.warnings for trace in traces)
    told |= bool(may_go_on(state))
    off = _off(thing, traces)
    right = off <= RIGHT
    reading = traces[0].reading if traces else ""
    one = len(state.curves) == 1 and reading == thing.reading
    return Outcome(one and right, right, told, off)


def _off(thing: Lifted, traces: list[Trace]) -> float:
    found = [side for t in traces if t.curve is not None for side in (t.points, t.points * MIRROR)]
    if not found:
        return float("inf")
    made, truth = np.vstack([_densely(side) for side in found]), thing.both
    away = cKDTree(truth).query(made)[0]
    missed = cKDTree(made).query(truth)[0]
    return float(np.quantile(np.concatenate((away, missed)), 0.95)) / thing.size


def _densely(points: Array) -> Array:
    fine = np.linspace(0, len(points) - 1, 5 * len(points))
    return np.column_stack([np.interp(fine, np.arange(len(points)), c) for c in points.T])


def row(name: str, found: list[Outcome]) -> str:
    """Return a line of the table."""
    wrong = [each for each in found if not each.right]
    cells = (
        name, str(len(found)), str(sum(each.meant for each in found)),
        str(sum(each.right and not each.meant for each in found)),
        str(sum(each.told for each in wrong)), str(sum(not each.told for each in wrong)),
        f"{100 * float(np.median([each.off for each in found])):.2f}",
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def main(begin: int = SEED, count: int = COUNT) -> None:
    """Print the table."""
    print("|  | drawings | as meant | right, in several curves | wrong, and told | "
          "wrong without a word | median error, % |")  # fmt: skip
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for noise in (1.0, 2.0, 3.0):
        for said, whole in (("whole strokes", True), ("in pieces", False)):
            found = [outcome(lifted(k, noise, whole=whole)) for k in range(begin, begin + count)]
            print(row(f"{said}, {noise:g} px", found), flush=True)


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
