"""A simulated hand: strokes for the lines of a drawing, as untidy as asked."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import Stroke
from bozzetto.view import Camera

SIZE = 800.0
"""Diagonal of the drawing, px."""


@dataclass(frozen=True)
class Hand:
    """How untidy; lengths are shares of the drawing's diagonal.

    Parameters
    ----------
    jitter : float
        Two ends at one corner are about so far apart: half of it is the standard deviation of
        each coordinate of an end.
    wobble : float
        Standard deviation of how far a stroke bows out in its middle.
    tremble : float
        Standard deviation of each sample across the stroke.
    retraced, split : float
        Share of the lines a part of which is drawn again, and that are drawn in two pieces.
    overshot : float
        Share of the ends that go 2 … 5 % too far, a quarter of the line at most.
    doubled : float
        Share of the lines that are drawn twice.
    dashed : float
        Share of the lines that are drawn in light dashes.
    ticks : int
        Short stray marks near corners.
    in_order : bool
        Whether lines are drawn one after the other, what is drawn again right behind.
    """

    jitter: float = 0.01
    wobble: float = 0.006
    tremble: float = 0.0008
    retraced: float = 0.0
    split: float = 0.0
    overshot: float = 0.0
    doubled: float = 0.0
    dashed: float = 0.0
    ticks: int = 0
    in_order: bool = False


CLEAN = Hand()
UNTIDY = Hand(retraced=0.15, split=0.10)
CONDITIONS = {
    "clean": CLEAN,
    "15 % over-traced, 10 % split": UNTIDY,
    "and every corner overshot": replace(UNTIDY, overshot=1.0),
    "and two ticks": replace(UNTIDY, ticks=2),
    "overshot and two ticks": replace(UNTIDY, overshot=1.0, ticks=2),
    "and a third dashed": replace(UNTIDY, dashed=1 / 3),
    "a third dashed and two ticks": replace(UNTIDY, dashed=1 / 3, ticks=2),
    "two strokes on every line": replace(UNTIDY, doubled=1.0),
}

Path = tuple[Array, float]
"""Samples (n, 2), shares of the diagonal; pressure 0 … 1."""


def strokes_of(
    places: Array,
    edges: Sequence[tuple[int, int]],
    hand: Hand,
    seed: int,
    hidden: Collection[int] = (),
) -> tuple[Stroke, ...]:
    """Draw the lines between places; `hidden` ones lightly, in dashes."""
    return owned_strokes_of(places, edges, hand, seed, hidden)[0]


def owned_strokes_of(
    places: Array,
    edges: Sequence[tuple[int, int]],
    hand: Hand,
    seed: int,
    hidden: Collection[int] = (),
) -> tuple[tuple[Stroke, ...], tuple[int, ...]]:
    """Draw the lines between places; also give the edge of every stroke, -1 for a tick."""
    rng = np.random.default_rng([seed, 77])
    dashed = set(hidden)
    if hand.dashed:
        dashed |= {int(k) for k in rng.permutation(len(edges))[: round(len(edges) * hand.dashed)]}
    paths: list[Path] = []
    owners: list[int] = []
    for number, (a, b) in enumerate(edges):
        draw = _dashes if number in dashed else _line
        paths += draw(places[a], places[b], hand, rng)
        owners += [number] * (len(paths) - len(owners))
    for _ in range(hand.ticks):
        middle = places[rng.integers(len(places))] + rng.normal(0, 0.03, 2)
        angle = rng.uniform(0, 2 * np.pi)
        step = rng.uniform(0.006, 0.02) * np.array([np.cos(angle), np.sin(angle)])
        paths.append((middle + np.linspace(-0.5, 0.5, 8)[:, None] * step, 0.4))
    order = np.arange(len(paths)) if hand.in_order else rng.permutation(len(paths))
    owners += [-1] * hand.ticks
    strokes = tuple(stroke(paths[k][0] * SIZE + 200.0, paths[k][1]) for k in order)
    return strokes, tuple(owners[k] for k in order)


def stroke(points: Array, pressure: float = 0.8) -> Stroke:
    """Make a stroke of samples (n, 2), px, at 120 a second."""
    count = len(points)
    return Stroke(
        *points.T, Camera(), pressure=np.full(count, pressure), t=np.arange(count) / 120.0
    )


def _line(start: Array, end: Array, hand: Hand, rng: np.random.Generator) -> list[Path]:
    def part(first: float, last: float, at_corner: tuple[bool, bool] = (True, True)) -> Path:
        return _stroke(start, end, first, last, at_corner, hand, rng)

    made = []
    if rng.random() < hand.split:
        cut = rng.uniform(0.35, 0.65)
        made.append(part(0.0, cut + rng.uniform(-0.02, 0.04), (True, False)))
        made.append(part(cut, 1.0, (False, True)))
    else:
        made.append(part(0.0, 1.0))
        if rng.random() < hand.doubled:
            made.append(part(rng.uniform(0, 0.05), rng.uniform(0.95, 1)))
    if rng.random() < hand.retraced:
        first = rng.uniform(0, 0.4)
        made.append(part(first, first + rng.uniform(0.4, 0.6), (False, False)))
    return made


def _stroke(
    start: Array,
    end: Array,
    first: float,
    last: float,
    at_corner: tuple[bool, bool],
    hand: Hand,
    rng: np.random.Generator,
) -> Path:
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    beyond = [
        min(rng.uniform(0.02, 0.05), length / 4)
        if corner and hand.overshot and rng.random() < hand.overshot
        else 0.0
        for corner in at_corner
    ]
    p = start + (end - start) * first + rng.normal(0, hand.jitter / 2, 2) - along * beyond[0]
    q = start + (end - start) * last + rng.normal(0, hand.jitter / 2, 2) + along * beyond[1]
    count = max(8, int(length * 200))
    x = np.linspace(0, 1, count)
    across = hand.wobble * rng.normal() * np.sin(np.pi * x) + rng.normal(0, hand.tremble, count)
    points = p + (q - p) * x[:, None] + across[:, None] * np.array([-along[1], along[0]])
    return (points if rng.random() < 0.5 else points[::-1]), 0.8


def _dashes(start: Array, end: Array, hand: Hand, rng: np.random.Generator) -> list[Path]:
    length = float(np.linalg.norm(end - start))
    normal = np.array([-(end - start)[1], (end - start)[0]]) / length
    count = max(2, round(length / 0.04))
    offset = normal * rng.normal(0, hand.jitter / 2)
    made = []
    for k in range(count):
        first, last = k / count, 1.0 if k == count - 1 else (k + 0.62) / count
        p = start + (end - start) * first + rng.normal(0, hand.jitter / 5, 2) + offset
        q = start + (end - start) * last + rng.normal(0, hand.jitter / 5, 2) + offset
        points = p + (q - p) * np.linspace(0, 1, 8)[:, None] + rng.normal(0, 0.0005, (8, 2))
        made.append((points, 0.35))
    return made
