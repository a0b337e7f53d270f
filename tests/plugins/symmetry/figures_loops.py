"""Figures of loops and hooks drawn left and right, in the wrong sense or not, as a Markdown table.

``python -m tests.plugins.symmetry.figures_loops``; seeds from 5000 on, which nothing was tuned on.
"""

from __future__ import annotations

import sys
from typing import Final

import numpy as np

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


def is_wrong(side: Array, noise: float, alike: bool, random: np.random.Generator,
             closed: bool = True) -> bool:  # fmt: skip
    """Draw both sides of a curve, and say whether it was read in the wrong sense.

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
    """
    view = m.view_of(random)
    side = side * (MIRROR if random.random() < 0.5 else 1.0)
    begin = random.random()
    strokes = []
    for curve in (side, side * MIRROR):
        if closed:
            shift = begin + random.uniform(-LIKE, LIKE) if alike else random.random()
            curve = np.roll(curve, -int(shift * len(curve)), axis=0)
        pixels = s.drawn(curve, view, noise=noise, random=random, closed=closed)
        pixels = pixels[:: int(random.choice((-1, 1)))]
        strokes.append(Stroke(pixels[:, 0], pixels[:, 1], view))
    state = add_drawing(SymmetryState(), tuple(strokes))
    trace = trace_of(state.curves[0], state)
    if len(state.curves) != 1 or trace.reading != "pair":
        return True
    size = float(np.linalg.norm(np.ptp(side, axis=0)))
    off = min(
        float(np.median(s.distances(trace.points * way, side, closed=closed)))
        for way in (np.ones(3), MIRROR)
    )
    return off > WRONG * size


def main(begin: int = SEED, count: int = COUNT, noise: float = 1.0) -> None:
    """Print the table."""
    print(f"| wrong at {noise:g} px of tremor, facing | {' | '.join(FACING)} |")
    print("| --- | " + " | ".join("---" for _ in FACING) + " |")
    seeds = range(begin, begin + count)
    for shape in SHAPES:
        for alike, told in ((True, "begun alike"), (False, "begun anywhere")):
            cells = [
                np.mean(
                    [
                        is_wrong(loop(shape, facing, random), noise, alike, random)
                        for random in map(np.random.default_rng, seeds)
                    ]
                )
                for facing in FACING
            ]
            print(f"| {shape}, {told} | " + " | ".join(f"{100 * c:.0f} %" for c in cells) + " |",
                  flush=True)  # fmt: skip
    cells = [
        np.mean(
            [
                is_wrong(hook(facing, random), noise, True, random, closed=False)
                for random in map(np.random.default_rng, seeds)
            ]
        )
        for facing in FACING
    ]
    print("| hooks | " + " | ".join(f"{100 * c:.0f} %" for c in cells) + " |")


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
