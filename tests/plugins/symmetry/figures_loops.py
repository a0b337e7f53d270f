"""Figures of loops and hooks drawn left and right, in the wrong sense or not, as a Markdown table.

``python -m tests.plugins.symmetry.figures_loops``; seeds from 5000 on, which nothing was tuned on.
"""

from __future__ import annotations

import sys
from typing import Final, NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d

from bozzetto.ink import Stroke
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.assign_stroke import add_drawing
from bozzetto_symmetry.solve.curve_solver import trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry import scenes as s
from tests.plugins.symmetry.scenes import Array

SEED: Final = 5000
COUNT: Final = 24
"""Drawings of a kind."""

WRONG: Final = 0.06
"""Median error, in sizes of the curve, from which it was read in the wrong sense."""

LIKE: Final = 0.05
"""Share of a turn within which a person begins the second loop where the first was begun."""

FACING: Final[dict[str, tuple[tuple[int, int, int], tuple[int, int, int]] | None]] = {
    "the side": ((1, 0, 0), (0, 0, 1)),
    "the front": ((0, 1, 0), (0, 0, 1)),
    "the top": ((1, 0, 0), (0, 1, 0)),
    "anywhere": None,
}
SHAPES: Final = ("ellipses", "rounded boxes", "pointed loops", "bent loops")


def loop(shape: str, facing: str, random: np.random.Generator) -> Array:
    """A loop on one side of the plane, within the box, (300, 3) mm."""
    wide, high = random.uniform(10, 35, 2)
    cosine, sine = np.cos(m.ROUND), np.sin(m.ROUND)
    flat = np.column_stack((wide * cosine, high * sine))
    if shape == "rounded boxes":
        power = 0.5
        flat = np.column_stack(
            (
                wide * np.sign(cosine) * np.abs(cosine) ** power,
                high * np.sign(sine) * np.abs(sine) ** power,
            )
        )
    if shape == "pointed loops":
        flat[:, 1] *= np.sin(m.ROUND / 2.0) ** random.choice((1.0, 1.5))
    turn = random.uniform(0, 2 * np.pi) if shape != "rounded boxes" else random.uniform(-0.15, 0.15)
    way = np.array(((np.cos(turn), np.sin(turn)), (-np.sin(turn), np.cos(turn))))
    known = FACING[facing]
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0][:2] if known is None else np.array(known)
    curve = flat @ way @ axes
    if shape == "bent loops":
        bend = random.uniform(0.1, 0.35) * min(wide, high)
        curve = curve + np.outer(
            bend * np.cos(2 * m.ROUND + random.uniform(0, 6)), np.cross(axes[0], axes[1])
        )
    return _placed(s.resample(curve, count=m.PLACES, closed=True), random)


def hook(facing: str, random: np.random.Generator) -> Array:
    """A straight line that ends in a half turn, on one side of the plane, (300, 3) mm."""
    bow, leg = random.uniform(8, 18), random.uniform(40, 80)
    angle = np.linspace(0.0, random.uniform(0.7, 1.1) * np.pi, 80)
    flat = np.vstack(
        ((0.0, leg), np.column_stack((bow * (np.cos(angle) - 1), -bow * np.sin(angle))))
    )
    known = FACING[facing]
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0][:2] if known is None else np.array(known)
    return _placed(s.resample(flat @ axes, count=m.PLACES), random)


def _placed(curve: Array, random: np.random.Generator) -> Array:
    extent = np.ptp(curve, axis=0)
    curve = curve * min(1.0, *(np.array((180, 40, 90)) / np.maximum(extent, 1e-9)))
    extent = np.ptp(curve, axis=0)
    low, high = np.array((-95, 5, -47)) + extent / 2, np.array((95, 48, 47)) - extent / 2
    middle = random.uniform(np.minimum(low, high), np.maximum(low, high))
    return np.asarray(curve - 0.5 * (curve.min(axis=0) + curve.max(axis=0)) + middle)


def strokes_of(
    side: Array,
    noise: float,
    alike: bool,
    random: np.random.Generator,
    closed: bool = True,
    weight: float | None = None,
) -> tuple[tuple[Stroke, ...], Array]:
    """Draw both sides of a curve; return the strokes, and the side that is drawn first.

    Parameters
    ----------
    side : (n, 3) float
        mm.
    noise : float
        px.
    alike : bool
        The second loop is begun about where the first one was; else anywhere.
    random : Generator
    closed : bool
    weight : float or None
        Share by which the nearest places are pressed harder; None for a pen without pressure.
    """
    view = m.view_of(random)
    side = side * (MIRROR if random.random() < 0.5 else 1.0)
    begin = random.random()
    pen = np.random.default_rng(random.bit_generator.seed_seq.spawn(1)[0])
    strokes = []
    for curve in (side, side * MIRROR):
        if closed:
            shift = begin + random.uniform(-LIKE, LIKE) if alike else random.random()
            curve = np.roll(curve, -int(shift * len(curve)), axis=0)
        pixels = s.drawn(curve, view, noise=noise, random=random, closed=closed)
        sense = int(random.choice((-1, 1)))
        pixels, nearness = pixels[::sense], -view.project(curve)[1][::sense]
        pressure = None if weight is None else pressed(pixels, nearness, weight, pen)
        strokes.append(Stroke(pixels[:, 0], pixels[:, 1], view, pressure=pressure))
    return tuple(strokes), side


def pressed(pixels: Array, nearness: Array, weight: float, pen: np.random.Generator) -> Array:
    """The pressure of a hand that also presses by habit, wanders, slackens, and sets the pen down.

    It presses harder by up to 15 % on its way down or nearly so, and wanders by 8 %.
    """
    count = len(pixels)
    share = np.linspace(0.0, 1.0, count)
    near = nearness - nearness.mean()
    near = near / max(float(np.abs(near).max()), 1e-9)
    way = np.gradient(pixels, axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True) + 1e-9
    down = 0.5 * np.pi + pen.uniform(-0.5, 0.5)
    habit = pen.uniform(0.0, 0.15) * (way @ (np.cos(down), np.sin(down)))
    wander = gaussian_filter1d(pen.standard_normal(count), count / 12, mode="nearest")
    drift = pen.normal(0.0, 0.1) * (share - 0.5)
    firm = 0.5 * (1.0 + weight * near + habit + 0.08 * wander / wander.std() + drift)
    firm *= np.clip(np.minimum(share, 1.0 - share) / 0.04 + 0.4, 0.0, 1.0)
    return np.asarray(np.clip(firm, 0.02, 1.0))


class Outcome(NamedTuple):
    """Whether a drawing was read in the wrong sense, and whether the person is warned."""

    wrong: bool
    told: bool


def outcome(
    side: Array,
    noise: float,
    alike: bool,
    random: np.random.Generator,
    closed: bool = True,
    weight: float | None = None,
) -> Outcome:
    """Draw both sides of a curve, and look at how it was read; parameters as in `strokes_of`."""
    strokes, side = strokes_of(side, noise, alike, random, closed, weight)
    state = add_drawing(SymmetryState(), strokes)
    trace = trace_of(state.curves[0], state)
    told = bool(trace.warnings)
    if len(state.curves) != 1 or trace.reading != "pair":
        return Outcome(True, told)
    size = float(np.linalg.norm(np.ptp(side, axis=0)))
    off = min(
        float(np.median(s.distances(trace.points * way, side, closed=closed)))
        for way in (np.ones(3), MIRROR)
    )
    return Outcome(off > WRONG * size, told)


ROWS: Final[tuple[tuple[str, str, bool, float | None], ...]] = (
    *(
        (f"{shape}, begun {told}", shape, alike, None)
        for shape in SHAPES
        for alike, told in ((True, "alike"), (False, "anywhere"))
    ),
    ("ellipses, begun anywhere, pen without line weight", "ellipses", False, 0.0),
    ("the same, 20 % more weight on what is nearest", "ellipses", False, 0.2),
    ("hooks", "hooks", True, None),
)
"""Rows of the table: what is said, shape, begun alike, line weight."""


def main(begin: int = SEED, count: int = COUNT, noise: float = 1.0) -> None:
    """Print the table."""
    print(f"| wrong, and of these untold, at {noise:g} px, facing | {' | '.join(FACING)} | "
          "wrong and untold | right and told |")  # fmt: skip
    print("| --- | " + " | ".join("---" for _ in FACING) + " | --- | --- |")
    every: list[Outcome] = []
    for said, shape, alike, weight in ROWS:
        cells, found = [], []
        for facing in FACING:
            drawings = []
            for seed in range(begin, begin + count):
                random = np.random.default_rng(seed)
                hooks = shape == "hooks"
                side = hook(facing, random) if hooks else loop(shape, facing, random)
                drawings.append(outcome(side, noise, alike, random, not hooks, weight))
            cells.append(f"{_share(wrong(drawings))}, {_share(untold(drawings))}")
            found += drawings
        every += found
        print(_row(said, cells, found), flush=True)
    print(_row("all", ["" for _ in FACING], every))


def wrong(drawings: list[Outcome]) -> float:
    """Return the share that is wrong."""
    return float(np.mean([each.wrong for each in drawings]))


def untold(drawings: list[Outcome]) -> float:
    """Return the share that is wrong without a warning."""
    return float(np.mean([each.wrong and not each.told for each in drawings]))


def _row(said: str, cells: list[str], found: list[Outcome]) -> str:
    told = float(np.mean([each.told and not each.wrong for each in found]))
    return f"| {said} | {' | '.join(cells)} | {_share(untold(found))} | {_share(told)} |"


def _share(value: float) -> str:
    return f"{100 * value:.0f} %"


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
