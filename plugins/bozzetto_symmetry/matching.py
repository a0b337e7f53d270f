"""Two curves on one sheet matched by the epipolar lines that they cross.

Both images of a mirrored pair carry the same signal: the epipolar line, named by its angle,
that the curve is on. Where a single epipolar line meets a curve several times nobody can
tell which meeting is meant; matching the whole signals, in order, can. Warping finds the
matching to a sample; a stiff map of stations takes it to a fraction of one, also where the
curve runs along the epipolar lines and the signal says little.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto_symmetry.stereo import Stereo
from bozzetto_symmetry.warping import Warping

__all__ = ["ASTRAY", "Pairing", "Signal", "differences", "paired", "share_astray", "spread"]

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

STIFFNESS: Final = 3.0
"""Weight of the bending of the map of stations (squared second differences, px²) against
squared distances across the epipolar lines: without noise it moves 95 % of the places by
less than 0.1 % of a box, with a pixel of noise it halves the errors where lines touch."""

ROUNDS: Final = 8
"""Most Gauss-Newton steps for the map of stations; three are usual."""

LONGEST_STEP: Final = 6.0
"""Largest change of a station in one of them, samples."""

SETTLED: Final = 1e-3
"""Largest change, samples, at which the map counts as found."""

PINNED: Final = 1e6
"""Weight of a station that is known."""

SHALLOW: Final = 0.06
"""Sine of the angle to the epipolar lines below which a long run says nothing."""

LONG: Final = 0.1
"""Share of a side from which a run is long: about where a turn, rather than a straight line,
would have a radius as large as the whole side."""

WITHOUT: Final = 0.05
"""What sides without any partner would add to the score, per px that the signals range over."""

BENT: Final = 0.5
"""What the bending of the map of stations (root mean square of second differences, px) adds
to the score: of two ways in which the lines agree, the smoother one is meant."""

ASTRAY: Final = 5.0
"""How much dearer a matching becomes if the side it makes lies on both sides of the plane."""

FLOOR: Final = 0.3
"""Mean distance, px, below which no hand draws: what is nearer is equally good."""

FLAT: Final = 150.0
"""Spread of a signal, px, below which prices shrink no more: a hand that shakes by a pixel
would leave everything without a partner."""

STEEPEST: Final = 1e12
"""Most pixels per unit of angle, so that their squares stay finite."""

LEAST: Final = 1e-9
"""Of lengths that are divided by."""


@dataclass(frozen=True, eq=False)
class Pairing:
    """The places of two sides that belong together.

    Attributes
    ----------
    near : (k, 2) float
        On the first side, in its order, px.
    far : (k, 2) float
        Their partners, on the same epipolar lines to rounding, px. Where hand and epipolar
        lines do not allow for it they are beside the other side's ink by as much.
    stations : (k,) float
        Share of the first side's length, 0 … 1, at each of `near`; not decreasing.
    far_stations : (k,) float
        Share of the other side's length, from its own beginning; monotone, on loops after
        whole rounds have been added.
    cost : float
        Root of the mean square distance across the epipolar lines, px, between the places
        that were matched, before they were brought onto common lines.
    score : float
        By what pairings are ordered, px, the lower the better: the mean distance across the
        epipolar lines that is left, and what uneven steps, ends without partners and places
        on the wrong side of the plane add to it. Never nought; if the second best is above
        1.5 times the best, the best is hardly ever wrong.
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
    score: float
    coverage: tuple[float, float]
    reversed: bool
    weak: Flags
    closed: bool


@dataclass(frozen=True, eq=False)
class Signal:
    """A curve as matching sees it.

    Attributes
    ----------
    pixels : (n, 2) float
        At even steps, px.
    angles : (n,) float
        Of the epipolar lines, as `Stereo.angles`.
    scales : (n,) float
        Pixels per unit of angle.
    """

    pixels: Array
    angles: Array
    scales: Array

    @classmethod
    def of(cls, stereo: Stereo, pixels: Array) -> Signal:
        """The signal of a curve that was resampled at even steps."""
        scales = np.minimum(stereo.pixels_per_angle(pixels), STEEPEST)
        return cls(pixels, stereo.angles(pixels), scales)

    def shifted(self, stereo: Stereo, other: Signal) -> Signal:
        """With whole turns added, so that it lies beside another one."""
        if stereo.parallel:
            return self
        turns = np.round((np.median(other.angles) - np.median(self.angles)) / (2.0 * np.pi))
        return replace(self, angles=self.angles + 2.0 * np.pi * turns)

    def turned(self) -> Signal:
        """From its end to its beginning."""
        return Signal(self.pixels[::-1], self.angles[::-1], self.scales[::-1])

    @property
    def step(self) -> float:
        """Mean distance of neighbours, px."""
        return float(np.linalg.norm(np.diff(self.pixels, axis=0), axis=1).mean())


def differences(first: Signal, second: Signal) -> Array:
    """Distances across the epipolar lines, (n, m) px.

    Scales differ between the near and the far side; both hands shake alike, so their squares
    are added.
    """
    weights = np.sqrt(_weights(first.scales[:, None], second.scales))
    return np.asarray(weights * np.abs(first.angles[:, None] - second.angles))


def spread(*signals: Signal) -> float:
    """What the widest of some signals ranges over, px: the unit of prices."""
    return max(FLAT, *(float(np.ptp(s.angles) * np.median(s.scales)) for s in signals))


def paired(
    stereo: Stereo,
    first: Signal,
    second: Signal,
    warping: Warping,
    *,
    pinned: tuple[bool, bool] = (False, False),
    closed: bool = False,
) -> Pairing:
    """What a warping says, brought onto common epipolar lines.

    Parameters
    ----------
    first, second : Signal
        Of loops both repeat their first sample at the end.
    warping : Warping
        Of the second signal along the first.
    pinned : (bool, bool)
        Whether the first and last samples are known to belong together.

    Returns
    -------
    Pairing
        As if both were drawn from their first sample on.
    """
    path = warping.path
    apart = differences(first, second)[path[:, 0], path[:, 1]]
    places, partners = _map_of_stations(first, second, path, pinned, closed)
    if not closed and not all(pinned):
        inside = _with_partner(partners, len(second.angles) - 1.0, pinned)
        if not inside.all():
            path = path[np.isin(path[:, 0], places[inside])]
            places, partners = _map_of_stations(first, second, path, pinned, closed)
    near = first.pixels[places]
    # On a loop the map may run a little beyond the cut, and goes on from the other end.
    at = np.mod(partners, len(second.angles) - 1.0) if closed else partners
    roughly = _at(second.pixels, at)
    way = stereo.toward_vanishing(near)
    far = near + ((roughly - near) * way).sum(axis=1, keepdims=True) * way
    weak = _shallow(first, places) & _shallow(second, np.rint(at).astype(np.intp))
    weak = _long_runs(weak, LONG * len(first.angles))
    far = _bridged(stereo, near, far, weak)
    coverage = (
        float(np.ptp(places)) / (len(first.angles) - 1.0),
        min(1.0, float(np.ptp(partners)) / (len(second.angles) - 1.0)),
    )
    price = WITHOUT * spread(first, second) * (1.0 - 0.5 * sum(coverage))
    left = _left(first, second, places, at) + BENT * _bending(second, partners)
    astray = share_astray(stereo.intersected(near, far)[:, 1])
    return Pairing(
        near,
        far,
        places / (len(first.angles) - 1.0),
        partners / (len(second.angles) - 1.0),
        float(np.sqrt((apart**2).mean())),
        (FLOOR + left + price) * (1.0 + ASTRAY * astray),
        coverage,
        False,
        weak,
        closed,
    )


def _weights(one: Array, other: Array) -> Array:
    """Squares of the pixels that a difference of angles is worth, for two scales."""
    return np.asarray(2.0 / (1.0 / one**2 + 1.0 / other**2))


def _left(first: Signal, second: Signal, places: NDArray[np.intp], partners: Array) -> float:
    """Mean distance across the epipolar lines of samples and partners, px."""
    index = np.arange(len(second.angles))
    weights = _weights(first.scales[places], np.interp(partners, index, second.scales))
    rest = first.angles[places] - np.interp(partners, index, second.angles)
    return float((np.sqrt(weights) * np.abs(rest)).mean())


def _bending(second: Signal, partners: Array) -> float:
    """Root mean square of the second differences of a map of stations, px."""
    if len(partners) < 3:
        return 0.0
    return second.step * float(np.sqrt((np.diff(partners, 2) ** 2).mean()))


def _at(values: Array, stations: Array) -> Array:
    """Rows of an array at fractions of its indices."""
    index = np.arange(len(values))
    return np.column_stack([np.interp(stations, index, column) for column in values.T])


# -- to a fraction of a sample -----------------------------------------------------------------


def _map_of_stations(
    first: Signal,
    second: Signal,
    path: NDArray[np.intp],
    pinned: tuple[bool, bool],
    closed: bool,
) -> tuple[NDArray[np.intp], Array]:
    """Samples of the first signal and the stations, in samples, of their partners.

    Where the second signal equals the first, in the sense of least squares, with a price on
    the bending of the map: where a signal turns, or stays at one value, the equation alone
    would be answered by the noise.
    """
    places, counts = np.unique(path[:, 0], return_counts=True)
    start = np.bincount(path[:, 0], path[:, 1])[places] / counts
    # Several samples may share the place of a known end; it is the outermost that is meant.
    if pinned[0]:
        start[0] = path[0, 1]
    if pinned[1]:
        start[-1] = path[-1, 1]
    if not closed:
        return places, _stiffened(first, second, places, start, pinned)
    # Around the cut of a loop the map goes on: an eighth of a round is added at either end.
    round_first, round_second = len(first.angles) - 1, len(second.angles) - 1
    more = round_first // 8
    index = np.concatenate((places[-1 - more : -1], places, places[1 : 1 + more]))
    stations = np.concatenate(
        (start[-1 - more : -1] - round_second, start, start[1 : 1 + more] + round_second)
    )
    rolled = Signal(
        *(
            np.concatenate((v[:-1], v[:-1], v))
            for v in (second.pixels, second.angles, second.scales)
        )
    )
    found = _stiffened(first, rolled, index, stations + round_second, (False, False))
    return places[:-1], found[more : len(found) - more - 1] - round_second


def _stiffened(
    first: Signal,
    second: Signal,
    places: NDArray[np.intp],
    start: Array,
    pinned: tuple[bool, bool],
) -> Array:
    if len(places) < 3:
        return start
    from scipy.linalg import solveh_banded

    stations, last = start, len(second.angles) - 1.0
    index = np.arange(len(second.angles))
    slopes = np.gradient(second.angles)
    bands = STIFFNESS * second.step**2 * _bending_bands(len(places))
    # A trace of the identity keeps flat signals solvable.
    held = 1e-9 * max(1.0, float(bands.max())) + PINNED * _ends(len(places), pinned)
    angles, scales = first.angles[places], first.scales[places]
    for _ in range(ROUNDS):
        weights = _weights(scales, np.interp(stations, index, second.scales))
        slope = np.interp(stations, index, slopes)
        rest = angles - np.interp(stations, index, second.angles)
        matrix = bands.copy()
        matrix[2] += weights * slope**2 + held
        bent = _bent(bands, stations)
        change = solveh_banded(matrix, weights * slope * rest - bent, check_finite=False)
        change = np.clip(change, -LONGEST_STEP, LONGEST_STEP)
        stations = np.maximum.accumulate(np.clip(stations + change, 0.0, last))
        if np.abs(change).max() < SETTLED:
            break
    return stations


def _bending_bands(count: int) -> Array:
    """Upper bands of DᵀD for second differences D, as `solveh_banded` takes them."""
    bands = np.zeros((3, count))
    for offset, weights in ((0, (1.0, 4.0, 1.0)), (1, (-2.0, -2.0)), (2, (1.0,))):
        for shift, weight in enumerate(weights):
            begin = offset + shift
            bands[2 - offset, begin : begin + count - 2] += weight
    return bands


def _bent(bands: Array, values: Array) -> Array:
    """The symmetric matrix of the bands times a vector."""
    made = bands[2] * values
    for offset in (1, 2):
        band = bands[2 - offset, offset:]
        made[:-offset] += band * values[offset:]
        made[offset:] += band * values[:-offset]
    return np.asarray(made)


def _ends(count: int, pinned: tuple[bool, bool]) -> Array:
    held = np.zeros(count)
    held[0], held[-1] = pinned
    return held


def _with_partner(partners: Array, last: float, pinned: tuple[bool, bool]) -> Flags:
    """False for samples beyond an end of the other side: they all were given its last place."""
    inside = np.ones(len(partners), bool)
    if not pinned[0]:
        inside[: max(0, int((partners <= 0.0).sum()) - 1)] = False
    if not pinned[1]:
        inside[len(partners) - max(0, int((partners >= last).sum()) - 1) :] = False
    return inside if inside.any() else np.ones(len(partners), bool)


# -- where the signal says nothing -------------------------------------------------------------


def _shallow(signal: Signal, places: NDArray[np.intp]) -> Flags:
    """Whether a signal hardly changes around some of its samples."""
    count = len(signal.angles)
    reach = max(1, round(0.5 * LONG * count))
    index = np.clip(places, 0, count - 1)
    low, high = np.maximum(index - reach, 0), np.minimum(index + reach, count - 1)
    rise = np.abs(signal.angles[high] - signal.angles[low]) * signal.scales[index]
    return np.asarray(rise < SHALLOW * signal.step * (high - low))


def _long_runs(flags: Flags, shortest: float) -> Flags:
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    kept = np.zeros(len(flags), bool)
    for begin, end in edges.reshape(-1, 2):
        kept[begin:end] = end - begin >= shortest
    return kept


def _bridged(stereo: Stereo, near: Array, far: Array, weak: Flags) -> Array:
    """Partners on runs that say nothing, from what is known at both their ends.

    Along the epipolar line the place of a partner is taken linear in that of the near one,
    as slopes of rays: a line parallel to the plane's normal then keeps its x and z.
    """
    if not weak.any():
        return far
    known = ~weak
    known[[0, -1]] = True
    made = far.copy()
    ours, theirs = _along(stereo, near), _along(stereo, far)
    anchors = np.flatnonzero(known)
    for begin, end in pairwise(anchors):
        if end - begin < 2:
            continue
        inner = np.arange(begin + 1, end)
        way = ours[end] - ours[begin]
        share = (
            np.clip((ours[inner] - ours[begin]) / way, 0.0, 1.0)
            if way
            else (inner - begin) / (end - begin)
        )
        slopes = theirs[begin] + share * (theirs[end] - theirs[begin])
        places = _on_line(stereo, near[inner], slopes)
        fine = np.isfinite(places).all(axis=1)
        made[inner[fine]] = places[fine]
    return made


def _along(stereo: Stereo, pixels: Array) -> Array:
    """Where on their epipolar lines places are: slopes of rays, or px in a parallel view."""
    if stereo.parallel:
        return np.asarray((pixels * stereo.toward_vanishing(pixels)).sum(axis=1))
    way = stereo.rays(pixels).directions
    return np.asarray(way[:, 1] / np.maximum(np.hypot(way[:, 0], way[:, 2]), LEAST))


def _on_line(stereo: Stereo, pixels: Array, along: Array) -> Array:
    """Places on the epipolar lines of others, px; NaN behind the eye."""
    if stereo.parallel:
        way = stereo.toward_vanishing(pixels)
        return np.asarray(pixels + (along - _along(stereo, pixels))[:, None] * way)
    direction = stereo.rays(pixels).directions
    level = direction * (1.0, 0.0, 1.0)
    level /= np.maximum(np.linalg.norm(level, axis=1, keepdims=True), LEAST)
    eye = np.asarray(stereo.camera.eye)
    points = eye + stereo.camera.distance * (level + along[:, None] * (0.0, 1.0, 0.0))
    way = stereo.toward_vanishing(pixels)
    places = stereo.project(points)
    # Onto the line once more, for it is near and the rounding of the way there is not.
    return np.asarray(pixels + ((places - pixels) * way).sum(axis=1, keepdims=True) * way)


def share_astray(heights: Array) -> float:
    """Which share of the distance from the plane is on the side with less of it, 0 … 0.5."""
    seen = heights[np.isfinite(heights)]
    total = float(np.abs(seen).sum())
    if len(seen) < len(heights) / 2 or total == 0.0:
        return 0.5
    return 0.5 - 0.5 * abs(float(seen.sum())) / total
