"""The matching of two curves on one sheet by the epipolar lines that they cross.

Both images of a mirrored pair carry the same signal: the epipolar line, named by its angle,
that the curve is on. Where a single epipolar line meets a curve several times it
cannot say which meeting is meant; matching the whole signals, in order, can. Warping finds the
matching to a sample; a stiff map of stations takes it to a fraction of one, also where the
curve runs along the epipolar lines and the signal says little.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_symmetry.stereo.correspondence_map import map_of_stations
from bozzetto_symmetry.stereo.degenerate_runs import bridge_weak_runs, weak_runs
from bozzetto_symmetry.stereo.dynamic_time_warping import Warping
from bozzetto_symmetry.stereo.epipolar_signal import (
    Signal,
    at_stations,
    differences,
    spread,
    squared_scales,
)
from bozzetto_symmetry.stereo.mirror_camera import Stereo

WITHOUT: Final = 0.05
"""Score that sides without any partner would add, per px of the range of the signals."""

BENT: Final = 0.5
"""Weight in the score of the bending of the map of stations (root mean square of second
differences, px): of two ways in which the lines agree, the smoother one is meant."""

ASTRAY: Final = 5.0
"""Factor by which the score of a matching grows if its side lies on both sides of the plane."""

FLOOR: Final = 0.3
"""Mean distance, px, below which no hand draws: what is nearer is equally good."""


@dataclass(frozen=True, eq=False)
class Pairing:
    """The places of two sides that belong together.

    Attributes
    ----------
    near : (k, 2) float
        On the first side, in its order, px.
    far : (k, 2) float
        Their partners, on the same epipolar lines to rounding, px. Where the hand did not
        draw on them, the partners lie beside the other side's ink.
    stations : (k,) float
        Share of the first side's length, 0 … 1, at each of `near`; not decreasing.
    far_stations : (k,) float
        Share of the other side's length, from its own beginning; monotone, on loops after
        whole rounds have been added.
    cost : float
        Root of the mean square distance across the epipolar lines, px, between the places
        that were matched, before they were brought onto common lines.
    score : float
        Figure by which pairings are ordered, px, the lower the better: the mean distance across the
        epipolar lines that is left, and what uneven steps, ends without partners and places
        on the wrong side of the plane add to it. Never 0; if the second best is above
        1.5 times the best, the best is hardly ever wrong.
    coverage : (float, float)
        Share of each side's length that found a partner.
    reversed : bool
        The sides were drawn in opposite senses.
    weak : (k,) bool
        Bridged: there the epipolar lines run along the curve and say nothing.
    closed : bool
        Both sides are loops.
    part : (float, float)
        Share of each side that was matched at all: where only a part of the other side was
        drawn the rest waits for it.
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
    part: tuple[float, float] = (1.0, 1.0)


def pairing_of(
    stereo: Stereo,
    first: Signal,
    second: Signal,
    warping: Warping,
    *,
    pinned: tuple[bool, bool] = (False, False),
    closed: bool = False,
) -> Pairing:
    """Return what a warping says, brought onto common epipolar lines.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    first, second : Signal
        Of loops both repeat their first sample at the end.
    warping : Warping
        Of the second signal along the first.
    pinned : (bool, bool)
        Whether the first and last samples are known to belong together.
    closed : bool
        Both signals are of loops.

    Returns
    -------
    Pairing
        As if both were drawn from their first sample on.
    """
    path = warping.path
    apart = differences(first, second)[path[:, 0], path[:, 1]]
    places, partners = map_of_stations(first, second, path, pinned, closed)
    if not closed and not all(pinned):
        inside = _with_partner(partners, len(second.angles) - 1.0, pinned)
        if not inside.all():
            path = path[np.isin(path[:, 0], places[inside])]
            places, partners = map_of_stations(first, second, path, pinned, closed)
    near = first.pixels[places]
    # On a loop the map may run a little beyond the cut, and goes on from the other end.
    at = np.mod(partners, len(second.angles) - 1.0) if closed else partners
    roughly = at_stations(second.pixels, at)
    way = stereo.toward_vanishing(near)
    far = near + ((roughly - near) * way).sum(axis=1, keepdims=True) * way
    weak = weak_runs(first, places, second, np.rint(at).astype(np.intp))
    far = bridge_weak_runs(stereo, near, far, weak)
    coverage = (
        float(np.ptp(places)) / (len(first.angles) - 1.0),
        min(1.0, float(np.ptp(partners)) / (len(second.angles) - 1.0)),
    )
    price = WITHOUT * spread(first, second) * (1.0 - 0.5 * sum(coverage))
    left = _left(first, second, places, at) + BENT * _bending(second, partners)
    astray = Heights().with_more(stereo.intersected(near, far)[:, 1]).share_astray
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


def _left(first: Signal, second: Signal, places: Index, partners: Array) -> float:
    """Return the mean distance across the epipolar lines of samples and partners, px."""
    index = np.arange(len(second.angles))
    weights = squared_scales(first.scales[places], np.interp(partners, index, second.scales))
    rest = first.angles[places] - np.interp(partners, index, second.angles)
    return float((np.sqrt(weights) * np.abs(rest)).mean())


def _bending(second: Signal, partners: Array) -> float:
    """Return the root mean square of the second differences of a map of stations, px."""
    if len(partners) < 3:
        return 0.0
    return second.step * float(np.sqrt((np.diff(partners, 2) ** 2).mean()))


def _with_partner(partners: Array, last: float, pinned: tuple[bool, bool]) -> Flags:
    """Return False for samples beyond an end of the other side.

    The map has given all of them the last place of that side.
    """
    inside = np.ones(len(partners), bool)
    if not pinned[0]:
        inside[: max(0, int((partners <= 0.0).sum()) - 1)] = False
    if not pinned[1]:
        inside[len(partners) - max(0, int((partners >= last).sum()) - 1) :] = False
    return inside if inside.any() else np.ones(len(partners), bool)


@dataclass(frozen=True)
class Heights:
    """Heights of places above the centre plane, summed up.

    Attributes
    ----------
    count, known : int
        How many places there are, and how many of them have a height.
    total, apart : float
        Sum of the heights and of their absolute values, mm.
    """

    count: int = 0
    known: int = 0
    total: float = 0.0
    apart: float = 0.0

    def with_more(self, heights: Array) -> Heights:
        """Return the sums with more heights (n,) mm; NaN where a place has none."""
        seen = heights[np.isfinite(heights)]
        return Heights(
            self.count + len(heights),
            self.known + len(seen),
            self.total + float(seen.sum()),
            self.apart + float(np.abs(seen).sum()),
        )

    @property
    def share_astray(self) -> float:
        """Share of the distance from the plane on the side with less of it, 0 … 0.5.

        It is 0.5 if most places have no height.
        """
        if self.known < self.count / 2 or self.apart == 0.0:
            return 0.5
        return 0.5 - 0.5 * abs(self.total) / self.apart
