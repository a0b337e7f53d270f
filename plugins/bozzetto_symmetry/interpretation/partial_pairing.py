"""The matching of one side to a stretch of the other, where it was drawn in part.

Mirrored places lie on one epipolar line, so the stretch begins and ends where the longer
side meets the lines of the ends of the shorter one. Every such stretch is tried.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.ink import distances_to_polyline, resample
from bozzetto_symmetry.interpretation.side_pairing import OPEN_END, SAMPLES, UNEVEN
from bozzetto_symmetry.stereo.correspondence import Pairing, pairing_of
from bozzetto_symmetry.stereo.dynamic_time_warping import warpings
from bozzetto_symmetry.stereo.epipolar_signal import Signal, differences, spread
from bozzetto_symmetry.stereo.mirror_camera import Stereo

ON_LINE: Final = 6.0
"""Distance, px, from an epipolar line within which a side may touch it: a few times the error of
a hand."""

SHORTEST: Final = 0.15
"""Least share of a side that is a stretch of its own."""

WHOLE: Final = 0.93
"""Share of a side from which it is as good as all of it."""

BENT: Final = (3.0, 0.03)
"""Least distance from the straight way between its ends, px and as a share of that way, with
which a side can be known again by a stretch of it: straight lines match stretches of all others."""

MOST: Final = 16
"""Stretches that are tried, those first that are nearest to the length of the other side."""


@dataclass(frozen=True)
class _Stretch:
    """Part of a side between two stations, 0 … 1, and whether the other one runs against it."""

    begin: float
    end: float
    against: bool

    @property
    def share(self) -> float:
        return self.end - self.begin


def partial_pairings(stereo: Stereo, near: ArrayLike, far: ArrayLike) -> tuple[Pairing, ...]:
    """Match all of one open side to a stretch of the other one.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    near, far : (n, 2) array_like
        The sides as drawn, px, in any sense.

    Returns
    -------
    tuple of Pairing
        The best first; their `part` says how much of each side was matched at all.
    """
    lines = [resample(np.asarray(side, float), count=SAMPLES) for side in (near, far)]
    if not all(np.ptp(line, axis=0).any() for line in lines):
        return ()
    made = (*_in_first(stereo, *lines), *_in_second(stereo, *lines))
    kept = [pairing for pairing in made if len(pairing.near) > 1]
    return tuple(sorted(kept, key=lambda pairing: pairing.score))


def _in_first(stereo: Stereo, near: Array, far: Array) -> Iterator[Pairing]:
    """Yield matchings of all of the second side to stretches of the first."""
    stretches = _stretches(stereo, near, far)
    for stretch, found in _matched(stereo, near, far, stretches, cut_first=True):
        yield replace(
            found,
            stations=stretch.begin + stretch.share * found.stations,
            coverage=(stretch.share * found.coverage[0], found.coverage[1]),
            part=(stretch.share, 1.0),
        )


def _in_second(stereo: Stereo, near: Array, far: Array) -> Iterator[Pairing]:
    """Yield matchings of all of the first side to stretches of the second."""
    stretches = _stretches(stereo, far, near)
    for stretch, found in _matched(stereo, near, far, stretches, cut_first=False):
        yield replace(
            found,
            far_stations=stretch.begin + stretch.share * found.far_stations,
            coverage=(found.coverage[0], stretch.share * found.coverage[1]),
            part=(1.0, stretch.share),
        )


def _stretches(stereo: Stereo, longer: Array, shorter: Array) -> list[_Stretch]:
    """Return the stretches of a side whose ends lie on the epipolar lines of another one's ends."""
    if not _is_bent(shorter):
        return []
    one = Signal.of(stereo, longer)
    other = Signal.of(stereo, shorter).shifted(stereo, one)
    last = len(longer) - 1.0
    found = []
    for i, j in product(*(_on_line(one, float(other.angles[end])) for end in (0, -1))):
        if SHORTEST <= abs(j - i) / last < WHOLE:
            found.append(_Stretch(min(i, j) / last, max(i, j) / last, bool(j < i)))
    wanted = other.step / max(one.step, 1e-300)
    return sorted(found, key=lambda stretch: abs(stretch.share - wanted))[:MOST]


def _is_bent(line: Array) -> bool:
    chord = float(np.linalg.norm(line[-1] - line[0]))
    least, share = BENT
    return float(distances_to_polyline(line, line[[0, -1]]).max()) > max(least, share * chord)


def _on_line(signal: Signal, angle: float) -> list[float]:
    """Return where a signal has a value, or nearly touches it, in samples."""
    rest = signal.angles - angle
    away = np.abs(rest) * signal.scales
    inner = np.arange(1, len(rest) - 1)
    least = (away[inner] <= away[inner - 1]) & (away[inner] < away[inner + 1])
    touched = [float(k) for k in inner[least & (away[inner] < ON_LINE)]]
    ends = [float(k) for k in (0, len(rest) - 1) if away[k] < ON_LINE]
    passed = np.flatnonzero(rest[:-1] * rest[1:] < 0.0)
    beside = [float(k) for k in passed if away[[k, k + 1]].min() >= ON_LINE]
    return [*ends, *touched, *beside]


def _matched(
    stereo: Stereo, near: Array, far: Array, stretches: list[_Stretch], *, cut_first: bool
) -> Iterator[tuple[_Stretch, Pairing]]:
    """Yield every stretch with its matching, whose stations are shares of the stretch."""
    if not stretches:
        return
    firsts, seconds = [], []
    for stretch in stretches:
        cut = _cut(near if cut_first else far, stretch)
        one, other = (cut, far) if cut_first else (near, cut)
        first = Signal.of(stereo, one)
        second = Signal.of(stereo, other).shifted(stereo, first)
        firsts.append(first)
        seconds.append(second.turned() if stretch.against else second)
    unit = spread(*firsts, *seconds)
    tables = np.stack([differences(a, b) for a, b in zip(firsts, seconds, strict=True)])
    price = OPEN_END * unit
    ways = warpings(tables, step=UNEVEN * unit, begin=price, end=price)
    for stretch, first, second, way in zip(stretches, firsts, seconds, ways, strict=True):
        found = pairing_of(stereo, first, second, way)
        if stretch.against:
            found = replace(found, far_stations=1.0 - found.far_stations, reversed=True)
        yield stretch, found


def _cut(line: Array, stretch: _Stretch) -> Array:
    """Return a stretch of a line at as many places, (n, 2) px."""
    fine = resample(line, count=4 * len(line))
    begin, end = (round(place * (len(fine) - 1)) for place in (stretch.begin, stretch.end))
    return resample(fine[begin : end + 1], count=len(line))
