"""Things that a hand draws with the pen lifted within a line, by seed.

Everything is in the frame of the centre plane (y = 0, mm), in a box of 200 × 100 × 100 of which
the diagonal is 800 px long.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.interpolate import PchipInterpolator

from bozzetto.ink import Stroke, resample
from bozzetto.view import Camera
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import meant_drawings as m
from tests.plugins.symmetry import scenes as s
from tests.plugins.symmetry.scenes import Array

MISSED: Final = 1.2
"""How far a hand that sets the pen down again misses where it was lifted, px a direction."""

ALONG: Final = (-9.0, 3.0)
"""How far along the line it begins too early (drawn twice) or too late, px."""

REVERSED: Final = 0.2
"""Share of pieces that are drawn towards the one before."""


def _through(*places: tuple[float, float, float]) -> Array:
    """A rounded line through places, (300, 3) mm, without overshoot."""
    points = np.array(places)
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    return resample(PchipInterpolator(along, points)(np.linspace(0, along[-1], 600)), count=300)


def _straight(*places: tuple[float, float, float]) -> Array:
    """A line with corners at its places, (300, 3) mm."""
    return resample(np.array(places), count=300)


def _whole(half: Array) -> Array:
    return resample(np.vstack(((half * MIRROR)[:0:-1], half)), count=300)


_S: Final = np.linspace(0.0, 1.0, 300)


def _of(x: Array | float, y: Array | float, z: Array | float) -> Array:
    return np.column_stack(np.broadcast_arrays(np.asarray(x, float), y, z))


PAIRS: Final[dict[str, Array]] = {
    "temple of spectacles": _through(
        (60, 38, 10), (0, 40, 12), (-50, 39, 10), (-75, 37, -4), (-80, 36, -24)
    ),
    "chair frame": _through(
        (30, 30, -45), (26, 31, -5), (10, 32, 0), (-30, 32, 0), (-45, 31, 10), (-55, 28, 45)
    ),
    "chair frame with corners": _straight((40, 30, -45), (36, 30, 0), (-35, 34, 0), (-50, 32, 46)),
    "kite": _straight((90, 3, 20), (30, 45, 25), (-90, 4, -10)),
    "gunwale": _of(-90 + 180 * _S, 4 + 42 * np.sin(np.pi * _S**0.8), 10 + 22 * (2 * _S - 1) ** 2),
    "sledge runner": _through(
        (-85, 30, -20), (-20, 30, -20), (40, 30, -20), (70, 30, -8), (72, 30, 14), (50, 30, 24)
    ),
    "wing edge": _through((20, 6, 0), (5, 30, 3), (-15, 46, 6), (-35, 48, 14), (-45, 47, 30)),
    "horn": _of(10 + 35 * _S * np.cos(4.2 * _S), 10 + 35 * _S, 35 * _S * np.sin(4.2 * _S)),
    "sabre leg": _through((0, 20, 40), (6, 21, 20), (2, 24, -10), (-15, 30, -30), (-40, 38, -45)),
    "eyebrow and cheek": _through(
        (45, 6, 25), (42, 22, 30), (30, 34, 20), (24, 36, -5), (36, 20, -34), (44, 4, -42)
    ),
    "fork": _through((50, 5, 42), (54, 7, 10), (58, 8, -15), (72, 8, -42)),
}
"""Sides of pairs, (300, 3) mm."""

ACROSS: Final[dict[str, Array]] = {
    "handlebar": _whole(
        _through((30, 0, 20), (34, 14, 20), (40, 30, 24), (30, 42, 26), (5, 46, 24))
    ),
    "boat rib": _whole(_of(5.0, 44 * np.sin(0.5 * np.pi * _S) ** 0.9, -30 + 55 * _S**2.2)),
    "headphone band": _whole(
        _of(8 * _S, 38 * np.sin(0.55 * np.pi * _S), 40 * np.cos(0.6 * np.pi * _S))
    ),
    "mirror arch": _whole(
        _through((10, 0, 42), (10, 20, 38), (10, 32, 20), (8, 35, -10), (0, 34, -42))
    ),
    "chin and jaw": _whole(
        _through((52, 0, -42), (46, 14, -40), (30, 28, -28), (10, 36, -8), (2, 38, 24))
    ),
}
"""Curves across the plane, (300, 3) mm."""


@dataclass(frozen=True)
class Lifted:
    """A thing of one curve that was drawn in pieces.

    Attributes
    ----------
    name : str
    reading : str
        What the curve is.
    truth : (300, 3) float
        The curve, of a pair one side; mm.
    strokes : tuple of Stroke
        In the order drawn.
    """

    name: str
    reading: str
    truth: Array
    strokes: tuple[Stroke, ...]

    @property
    def both(self) -> Array:
        """The curve with its mirror image, (600, 3) mm."""
        return np.vstack((self.truth, self.truth * MIRROR))

    @property
    def size(self) -> float:
        """The diagonal of the smallest box around one side, mm."""
        return float(np.linalg.norm(np.ptp(self.truth, axis=0)))


def lifted(seed: int, noise: float, *, whole: bool = False) -> Lifted:
    """Draw one thing; seeds go through the things, and all else is by chance.

    Parameters
    ----------
    seed : int
    noise : float
        Standard deviation of the hand, px.
    whole : bool
        The same thing in the same view, with whole strokes.
    """
    names = (*PAIRS, *ACROSS)
    name = names[seed % len(names)]
    random = np.random.default_rng(seed)
    curve = PAIRS.get(name, ACROSS.get(name, s.S)) * random.uniform(0.8, 1.1, 3)
    view = m.view_of(random)
    if name in ACROSS:
        pieces = 1 if whole else int(random.integers(2, 4))
        return Lifted(name, "self", curve, tuple(_pieces(curve, view, pieces, noise, random)))
    counts = (1, 1) if whole else _counts(random)
    first = curve * (MIRROR if random.random() < 0.5 else 1.0)
    one = _pieces(first, view, counts[0], noise, random)
    other = _pieces(first * MIRROR, view, counts[1], noise, random)
    in_turn = not whole and random.random() < 0.35
    drawn = _in_turn(one, other) if in_turn else (*one, *other)
    return Lifted(name, "pair", first, tuple(drawn))


def _counts(random: np.random.Generator) -> tuple[int, int]:
    """How many pieces the first and the second side are drawn in; one of them in several."""
    several, rest = int(random.integers(2, 4)), int(random.integers(1, 4))
    return (several, rest) if random.random() < 0.5 else (rest, several)


def _in_turn(one: Sequence[Stroke], other: Sequence[Stroke]) -> list[Stroke]:
    longer = max(len(one), len(other))
    return [side[k] for k in range(longer) for side in (one, other) if k < len(side)]


def _pieces(
    curve: Array, view: Camera, count: int, noise: float, random: np.random.Generator
) -> list[Stroke]:
    """A line drawn in pieces, one after the other, by a hand that misses where it was lifted."""
    pixels = view.project(curve)[0]
    pixels = resample(pixels, count=600)
    pixels = pixels if random.random() < 0.5 else pixels[::-1]
    step = float(np.linalg.norm(np.diff(pixels, axis=0), axis=1).mean())
    cuts = (np.arange(1, count) + random.uniform(-0.22, 0.22, count - 1)) / count
    begins, strokes = [0, *(round(cut * 600) for cut in cuts)], []
    for k, begin in enumerate(begins):
        end = begins[k + 1] if k + 1 < count else 600
        missed = np.zeros(2)
        if k:
            begin += round(random.uniform(*ALONG) / max(step, 1e-9))
            missed = MISSED * random.standard_normal(2)
        ink = pixels[max(begin, 0) : end]
        fading = np.exp(-np.linspace(0.0, 6.0, len(ink)))[:, None]
        ink = ink + s.tremor(len(ink), noise, random) + missed * fading if noise else ink
        if k and random.random() < REVERSED:
            ink = ink[::-1]
        strokes.append(Stroke(ink[:, 0], ink[:, 1], view))
    return strokes
