"""Which places of one side of a thing belong to which places of its other side.

Both images of a mirrored pair carry the same signal: the epipolar line, named by its angle,
that the curve is on. Where a single epipolar line meets a curve several times nobody can
tell which meeting is meant; matching the whole signals, in order, can.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.ink.resample import arc_length, resample
from bozzetto_symmetry.stereo import Stereo
from bozzetto_symmetry.warping import Warping, warpings

__all__ = ["Folding", "Pairing", "foldings", "pairings"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SAMPLES: Final = 160
"""Places along each side that are matched."""

OPEN_END: Final = 0.02
"""Price of a sample without a partner at an end, per px of what the signals range over."""

UNEVEN: Final = 0.001
"""Price of a step along one side only, in the same unit."""


@dataclass(frozen=True, eq=False)
class Pairing:
    """The places of two sides that belong together.

    Attributes
    ----------
    near : (k, 2) float
        On the first side, in its order, px.
    far : (k, 2) float
        Their partners, on the same epipolar lines to rounding, px.
    stations : (k,) float
        Share of the first side's length, 0 … 1, at each of `near`; not decreasing.
    far_stations : (k,) float
        Share of the other side's length, from its own beginning; monotone.
    cost : float
        Root of the mean square distance across the epipolar lines, px, between the places
        that were matched, before they were brought onto common lines.
    coverage : (float, float)
        Share of each side's length that found a partner.
    reversed : bool
        The sides were drawn in opposite senses.
    weak : (k,) bool
        Bridged: there the epipolar lines run along the curve and say nothing.
    closed : bool
        Both sides are loops.
    """

    near: Array
    far: Array
    stations: Array
    far_stations: Array
    cost: float
    coverage: tuple[float, float]
    reversed: bool
    weak: Flags
    closed: bool


@dataclass(frozen=True, eq=False)
class Folding:
    """One stroke across the plane, folded where it crosses.

    Attributes
    ----------
    pairing : Pairing
        Of its halves, both from the plane outwards.
    crossings : (1, 2) or (2, 2) float
        Where it crosses the plane, px; two of a ring.
    first : bool
        Whether the pairing's `near` is the half that was drawn first.
    """

    pairing: Pairing
    crossings: Array
    first: bool


def pairings(
    stereo: Stereo, near: ArrayLike, far: ArrayLike, *, closed: bool = False
) -> tuple[Pairing, ...]:
    """Match the two sides of a pair.

    Parameters
    ----------
    stereo : Stereo
    near, far : (n, 2) array_like
        The sides as drawn, px, in any sense.
    closed : bool
        Both are loops; the first point is not repeated.

    Returns
    -------
    tuple of Pairing
        The best first; none where nothing matches.
    """
    one = resample(near, count=SAMPLES, closed=closed)
    other = resample(far, count=SAMPLES, closed=closed)
    made = []
    for backwards in (False, True):
        turned = other[::-1] if backwards else other
        first, second = stereo.angles(one), stereo.angles(turned)
        if not stereo.parallel:
            second = second + 2.0 * np.pi * np.round((first.mean() - second.mean()) / (2 * np.pi))
        scale = float(np.median(stereo.pixels_per_angle(np.vstack([one, turned]))))
        table = scale * np.abs(first[:, None] - second)
        spread = scale * max(float(np.ptp(first)), float(np.ptp(second)))
        (warp,) = warpings(
            table[None], step=UNEVEN * spread, begin=OPEN_END * spread, end=OPEN_END * spread
        )
        made.append(_paired(stereo, one, turned, table, warp, backwards, closed))
    return tuple(sorted(made, key=lambda pairing: pairing.cost))


def _paired(
    stereo: Stereo,
    one: Array,
    other: Array,
    table: Array,
    warp: Warping,
    backwards: bool,
    closed: bool,
) -> Pairing:
    path = warp.path
    cost = float(np.sqrt((table[path[:, 0], path[:, 1]] ** 2).mean()))
    places, counts = np.unique(path[:, 0], return_counts=True)
    partner = np.bincount(path[:, 0], path[:, 1])[places] / counts
    near = one[places]
    index = np.arange(len(other))
    roughly = np.column_stack([np.interp(partner, index, column) for column in other.T])
    way = stereo.toward_vanishing(near)
    far = near + ((roughly - near) * way).sum(axis=1, keepdims=True) * way
    share = partner / max(len(other) - 1, 1)
    return Pairing(
        near,
        far,
        places / max(len(one) - 1, 1),
        1.0 - share if backwards else share,
        cost,
        (len(places) / len(one), len(np.unique(path[:, 1])) / len(other)),
        backwards,
        np.zeros(len(places), bool),
        closed,
    )


def foldings(stereo: Stereo, pixels: ArrayLike, *, closed: bool = False) -> tuple[Folding, ...]:
    """Fold one stroke that crosses the plane.

    Parameters
    ----------
    stereo : Stereo
    pixels : (n, 2) array_like
        The stroke, px.
    closed : bool
        It is a ring, which crosses the plane twice; its first point is not repeated.

    Returns
    -------
    tuple of Folding
        The best first; none where the stroke has no place to fold.
    """
    stroke = resample(pixels, count=2 * SAMPLES, closed=closed)
    angle = stereo.angles(stroke)
    turning = np.flatnonzero(np.diff(np.sign(np.diff(angle)))) + 1
    made = []
    for place in turning[(turning > len(stroke) // 10) & (turning < 9 * len(stroke) // 10)]:
        halves = (stroke[place::-1], stroke[place:])
        found = [p for p in pairings(stereo, *halves) if not p.reversed]
        made += [Folding(pairing, stroke[place][None], True) for pairing in found]
    return tuple(sorted(made, key=lambda folding: folding.pairing.cost))
