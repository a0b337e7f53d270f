"""Where one stroke crosses the plane, and how its halves belong together.

A curve across the plane leaves it along the plane's normal, so its image touches the
epipolar line there: the angle has a turn. Every turn is tried, and the halves beside it are
matched like a pair.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.ink import resample
from bozzetto_symmetry.stereo.correspondence import Pairing, pairing_of
from bozzetto_symmetry.stereo.dynamic_time_warping import warpings
from bozzetto_symmetry.stereo.epipolar_signal import Signal, at_stations, differences, spread
from bozzetto_symmetry.stereo.mirror_camera import Stereo

SAMPLES: Final = 320
"""Places along the stroke among which turns are looked for."""

HALF: Final = 120
"""Places along each half that are matched."""

OPEN_END: Final = 0.04
"""Price of a sample of a half without a partner, per px of what the signal ranges over.
Halves are mostly drawn whole, so it is higher than with two strokes."""

UNEVEN: Final = 0.01
"""Price of a step along one half only, in the same unit."""

SMOOTHING: Final = 3.0
"""Standard deviation, samples, with which the angle is smoothed to find its turns."""

VERTEX: Final = (8, 24)
"""Fewest and most samples to either side of a turn from which its place is found: the turn
is flat, so a pixel of the hand moves what a few samples say by ten."""

WITHIN: Final = 0.75
"""Share of the way to the next turn, or to the end, that is used for it."""

DEGREE: Final = 3
"""Degree of the polynomial through these samples."""

MOST_TURNS: Final = 10
"""Turns that are tried, those that stand out most."""

SHORTEST: Final = 0.1
"""Least share of the stroke that is a half."""


@dataclass(frozen=True, eq=False)
class Folding:
    """One stroke across the plane, folded where it crosses.

    Attributes
    ----------
    pairing : Pairing
        Matching of its halves, both from the plane outwards; `near` is the longer one. Stations are
        shares of each half.
    crossings : (1, 2) or (2, 2) float
        Where it crosses the plane, px; two of a ring.
    first : bool
        Whether the pairing's `near` is the half that was drawn first.
    """

    pairing: Pairing
    crossings: Array
    first: bool


def foldings(stereo: Stereo, pixels: ArrayLike, *, closed: bool = False) -> tuple[Folding, ...]:
    """Fold one stroke that crosses the plane at every place where it may cross it.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    pixels : (n, 2) array_like
        The stroke, px.
    closed : bool
        It is a ring, which crosses the plane twice; its first point is not repeated.

    Returns
    -------
    tuple of Folding
        The best first; none where the stroke has no place to fold.
    """
    stroke = resample(np.asarray(pixels, float), count=SAMPLES, closed=closed)
    if not np.ptp(stroke, axis=0).any():
        return ()
    turns = _turns(stereo.angles(stroke), closed)
    cuts: list[tuple[float, ...]]
    if closed:
        least = SHORTEST * SAMPLES
        cuts = [(a, b) for a, b in combinations(turns, 2) if least < b - a < SAMPLES - least]
    else:
        cuts = [(a,) for a in turns if SHORTEST <= a / (SAMPLES - 1) <= 1.0 - SHORTEST]
    if not cuts:
        return ()
    halves = [_halves(stroke, cut, closed) for cut in cuts]
    firsts = [Signal.of(stereo, one) for one, _, _ in halves]
    seconds = [
        Signal.of(stereo, other).shifted(stereo, first)
        for first, (_, other, _) in zip(firsts, halves, strict=True)
    ]
    unit = spread(*firsts, *seconds)
    tables = np.stack([differences(a, b) for a, b in zip(firsts, seconds, strict=True)])
    end = np.inf if closed else OPEN_END * unit
    ways = warpings(tables, step=UNEVEN * unit, end=end)
    made = []
    for cut, one, other, way, (_, _, early) in zip(
        cuts, firsts, seconds, ways, halves, strict=True
    ):
        pairing = pairing_of(stereo, one, other, way, pinned=(True, closed))
        made.append(Folding(pairing, _places(stroke, cut, closed), early))
    return tuple(sorted(made, key=lambda folding: folding.pairing.score))


def _turns(angles: Array, closed: bool) -> list[float]:
    """Return the stations, in samples, at which the angle turns, in order along the stroke."""
    from scipy.ndimage import gaussian_filter1d

    soft = gaussian_filter1d(angles, SMOOTHING, mode="wrap" if closed else "nearest")
    rises = np.sign(np.diff(soft, append=soft[:1] if closed else soft[-1:]))
    found = np.flatnonzero(rises * np.roll(rises, 1) < 0)
    if not closed:
        found = found[(found > 0) & (found < len(angles) - 1)]
    # What stands out is what differs most from the turns beside it.
    heights = soft[found]
    if len(found) > MOST_TURNS:
        before = np.abs(heights - np.roll(heights, 1))
        after = np.abs(heights - np.roll(heights, -1))
        found = np.sort(found[np.argsort(-np.minimum(before, after))][:MOST_TURNS])
    count = len(angles)
    if closed:
        gaps = np.diff(np.concatenate((found[-1:] - count, found, found[:1] + count)))
    else:
        gaps = np.diff(np.concatenate(([0], found, [count - 1])))
    reaches = np.clip(WITHIN * np.minimum(gaps[:-1], gaps[1:]), *VERTEX).astype(int)
    return sorted(
        _vertex(angles, int(k), int(reach), closed) for k, reach in zip(found, reaches, strict=True)
    )


def _vertex(angles: Array, turn: int, reach: int, closed: bool) -> float:
    """Return the turn of a polynomial through the samples around a turn."""
    count = len(angles)
    offsets = np.arange(-reach, reach + 1)
    if not closed:
        offsets = offsets[(turn + offsets >= 0) & (turn + offsets < count)]
    fitted = np.polynomial.Polynomial.fit(offsets, angles[(turn + offsets) % count], DEGREE)
    roots = fitted.deriv().roots()
    real = roots[np.abs(roots.imag) < 1e-9].real
    real = real[np.abs(real) <= 0.5 * reach]
    return float(turn + real[np.argmin(np.abs(real))]) if len(real) else float(turn)


def _places(stroke: Array, cut: tuple[float, ...], closed: bool) -> Array:
    ring = np.vstack([stroke, stroke[:1]]) if closed else stroke
    period = float(len(stroke)) if closed else np.inf
    at = np.mod(cut, period)
    return at_stations(ring, at)


def _halves(stroke: Array, cut: tuple[float, ...], closed: bool) -> tuple[Array, Array, bool]:
    """Return both halves from the plane outwards, the longer first; whether it was drawn first."""
    count = len(stroke)
    if closed:
        begin, end = cut
        outward = np.linspace(begin, end, HALF)
        inward = np.linspace(begin + count, end, HALF)
    else:
        outward = np.linspace(cut[0], count - 1.0, HALF)
        inward = np.linspace(cut[0], 0.0, HALF)
    late = _at_stations(stroke, outward, closed)
    early = _at_stations(stroke, inward, closed)
    # At even steps along the stroke, so the longer one has more of them.
    longer = abs(inward[-1] - inward[0]) > abs(outward[-1] - outward[0])
    return (early, late, True) if longer else (late, early, False)


def _at_stations(stroke: Array, stations: Array, closed: bool) -> Array:
    rows = np.vstack([stroke, stroke, stroke[:1]]) if closed else stroke
    shifted = stations % (2 * len(stroke)) if closed else stations
    return at_stations(rows, shifted)
