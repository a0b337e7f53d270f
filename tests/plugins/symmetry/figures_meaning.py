"""Figures of drawings in which the rays say little, as a Markdown table.

``python -m tests.plugins.symmetry.figures_meaning``; seeds from 5000 on, which nothing was
tuned on. ``… 100 12`` takes 12 drawings of each kind from seed 100 on.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import distances_to_polyline
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry.meant_drawings import Meant
from tests.plugins.symmetry.scenes import distances

SEED: Final = 5000
COUNT: Final = 24
"""Drawings of a kind."""

ON_INK: Final = 1.5
"""Distance of the ink from the image, px (rms), within which a curve is that of its ink."""


AT_PLANE: Final = 0.05
"""Distance from the plane, in sizes of the curve, within which it crosses it."""


@dataclass(frozen=True)
class Outcome:
    """What became of one drawing.

    Attributes
    ----------
    right : bool
        It is one curve, read as it is meant.
    off : float
        95th percentile of the distances from the true curve, % of its size, either way.
    ratio, crossing : float
        Mean square of error over the told uncertainty; that where the curve crosses the plane.
    ink : float
        Root mean square distance of the ink from the image, px.
    told : bool
        The person is warned.
    """

    right: bool
    off: float
    ratio: float
    crossing: float
    ink: float
    told: bool


def outcome(meant: Meant, whole: bool = True) -> Outcome:
    """Draw one curve in an empty box, stroke by stroke, and look at what it becomes."""
    state = add_drawing(SymmetryState(), meant.strokes)
    try:
        trace = trace_of(state.curves[0], state)
    except UserError:
        return Outcome(False, np.inf, np.nan, np.nan, np.inf, True)
    if trace.curve is None:
        return Outcome(False, np.inf, np.nan, np.nan, np.inf, True)
    return _judged(trace, meant, len(state.curves) == 1, whole)


def _judged(trace: Trace, meant: Meant, alone: bool, whole: bool) -> Outcome:
    truth = meant.truth
    made = trace.points
    if float(np.median(distances(made * MIRROR, truth))) < float(np.median(distances(made, truth))):
        made = made * MIRROR
    away = distances(made, truth, closed=meant.closed)
    missed = distances(truth, made, closed=meant.closed) if whole else away[:0]
    off = 100.0 * float(np.quantile(np.concatenate((away, missed)), 0.95)) / meant.size
    odds = (away / np.maximum(trace.sigma, 1e-9)) ** 2
    at_plane = np.abs(made[:, 1]) < AT_PLANE * meant.size
    right = alone and trace.reading == meant.reading
    crossing = float(odds[at_plane].mean()) if at_plane.any() else np.nan
    ink, told = _from_ink(trace), bool(trace.warnings)
    return Outcome(right, off, float(odds.mean()), crossing, ink, told)


def _from_ink(trace: Trace) -> float:
    """Return the distance of the images from the nearest ink of their view, rms px, the worst."""
    worst = 0.0
    for view in trace.views:
        ink = [np.asarray(side.unrolled) for side in view.sides]
        images = [view.stereo.project(trace.points)]
        if trace.reading == "pair":
            images.append(view.stereo.project(trace.points * MIRROR))
        for line in ink:
            away = np.min([distances_to_polyline(line, image) for image in images], axis=0)
            worst = max(worst, float(np.sqrt(np.mean(away**2))))
    return worst


KINDS: Final[dict[str, tuple[Callable[[float, np.random.Generator], Meant], float, bool]]] = {
    "bars across the plane": (m.bar, 2.0, True),
    "bent tubes across the plane": (m.hoop, 3.0, True),
    "rings round the plane": (m.ring, 3.0, True),
    "spirals, both sides": (m.spiral, 3.0, True),
    "far side drawn at 80 %": (m.partial(0.8), 3.0, False),
    "far side drawn at 60 %": (m.partial(0.6), 3.0, False),
    "far side drawn at 40 %": (m.partial(0.4), 3.0, False),
    "left in one view, right in another": (m.two_views, 3.0, True),
    "ordinary pairs": (m.pair, 2.0, True),
}
"""Kinds of drawings: how one is made, the greatest error (%) that is right, and whether all of
the curve is asked for."""


def row(name: str, bound: float, found: Iterable[Outcome]) -> str:
    """Return a line of the table."""
    outcomes = list(found)
    right = [each.right and each.off <= bound for each in outcomes]
    off = np.array([each.off if each.right else np.inf for each in outcomes])
    known = [each for each in outcomes if each.right and each.off <= bound]
    ink = [not each.right or each.ink <= ON_INK or each.told for each in outcomes]
    cells = (
        name,
        f"{100 * np.mean([each.right for each in outcomes]):.0f} %",
        f"{bound:g} %",
        f"{100 * np.mean(right):.0f} %",
        _number(np.quantile(off, 0.5, method="lower")),
        _number(np.quantile(off, 0.9, method="lower")),
        _root_mean([each.ratio for each in known]),
        _root_mean([each.crossing for each in known if np.isfinite(each.crossing)]),
        f"{100 * np.mean(ink):.0f} %",
    )
    return "| " + " | ".join(cells) + " |"


def _root_mean(squares: list[float]) -> str:
    return f"{np.sqrt(np.mean(squares)):.2f}" if squares else "–"


def _number(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "–"


def _frames(noise: float, seeds: range) -> tuple[list[Outcome], list[Outcome]]:
    crosses, others = [], []
    for seed in seeds:
        across, along = m.frame(noise, np.random.default_rng(seed))
        crosses += [outcome(each) for each in across]
        others += [outcome(each) for each in along]
    return crosses, others


def _kept_apart(meant: Meant) -> bool:
    return len(add_drawing(SymmetryState(), meant.strokes).curves) == 2


def main(begin: int = SEED, count: int = COUNT, noises: tuple[float, ...] = (0.0, 1.0)) -> None:
    """Print the table."""
    seeds = range(begin, begin + count)
    heads = ("", "read as meant", "bound", "within it", "median %", "90th", "error / told",
             "at the plane", "on its ink")  # fmt: skip
    print(f"| {' | '.join(heads)} |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for noise in noises:
        told = "no tremor" if noise == 0 else f"{noise:g} px"
        for name, (made, bound, whole) in KINDS.items():
            found = [outcome(made(noise, np.random.default_rng(k)), whole) for k in seeds]
            print(row(f"{name}, {told}", bound, found), flush=True)
        crosses, others = _frames(noise, range(begin, begin + max(1, count // 4)))
        print(row(f"cross edges of box frames, {told}", 2.0, crosses), flush=True)
        print(row(f"other edges of box frames, {told}", 2.0, others), flush=True)
        for name, made in (
            ("sides of different curves", m.strangers),
            ("different curves, each in a view of its own", m.strangers_in_two_views),
        ):
            apart = [_kept_apart(made(noise, np.random.default_rng(k))) for k in seeds]
            share = f"{100 * np.mean(apart):.0f} %"
            print(f"| {name}, {told} | {share} | | | | | | | |", flush=True)


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
