"""Whether one line goes on where another one ended, because the pen was lifted there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import arc_length, distances_to_polyline
from bozzetto_symmetry.ink.polyline import length_of

SHORTEST: Final = 12.0
"""Length, px, from which ink is a piece of a line and no dot or tick."""

REACH: Final = (0.2, 10.0, 40.0)
"""Length of ink over which the direction of an end is taken, as a share of its line; least and
greatest, px. A parabola is fitted to it, and one to a third of it: where a line bends tightly the
short one tells its direction, and where the hand trembles the long one. The smoother counts."""

BESIDE: Final = (0.04, 4.0, 8.0)
"""How far beside the way of one end another one begins that surely goes on with it, as a share of
the shorter line, least and greatest, px. What a hand trembles by it misses by, twice."""

GAP: Final = 10.0
"""Gap along the way that the pen leaves out there, px; as of strokes of one line."""

LOOSELY: Final = 2.0
"""How many times farther ends may be that possibly belong together."""

AGAIN: Final = (0.25, 60.0)
"""Ink that is drawn twice where the pen is set down again, as a share of the shorter line, and px
at most."""

BENDS: Final = (30.0, 115.0)
"""Bend, degrees, up to which a line surely goes on, and up to which it may have a corner there."""


@dataclass(frozen=True)
class Continuation:
    """How one line goes on where another one ended.

    Attributes
    ----------
    gap : float
        Distance of the ends, px.
    bend : float
        Angle between the ways of both ends, degrees.
    sure : bool
        It goes on as smoothly and as near as a hand does; else there may be a corner, or two ends.
    """

    gap: float
    bend: float
    sure: bool

    @property
    def smooth(self) -> bool:
        """Whether there is no corner."""
        return self.bend <= BENDS[0]


def continuation(one: Array, other: Array, noise: float = 0.0) -> Continuation | None:
    """Return how two open lines join at their ends, the smoothest way; None where they do not.

    Parameters
    ----------
    one, other : (n, 2), (m, 2) float
        Smoothed and evenly spaced lines, px, in any sense.
    noise : float
        Standard deviation of the hand across them, px.
    """
    if min(map(length_of, (one, other))) < SHORTEST:
        return None
    found = [
        _joint(first, second, noise)
        for first in (one, one[::-1])
        for second in (other, other[::-1])
    ]
    return min(
        (each for each in found if each is not None), key=lambda each: each.bend, default=None
    )


def _joint(one: Array, other: Array, noise: float) -> Continuation | None:
    """Return how a line that begins where another one ends goes on; None where it does not."""
    shorter = min(length_of(one), length_of(other))
    share, least, most = BESIDE
    beside = float(np.clip(share * shorter, least, most)) + noise
    again = min(AGAIN[0] * shorter, AGAIN[1])
    away = float(np.linalg.norm(other[0] - one[-1]))
    if away > LOOSELY * float(np.hypot(GAP, beside)) + again:
        return None
    ends = [(_end(one, part), _end(other[::-1], part)) for part in (1.0, 1.0 / 3.0)]
    bends = [_bend(way, back) for (_, way), (_, back) in ends]
    (place, way), (there, back) = ends[int(np.argmin(bends))]
    bend = min(bends)
    if bend > BENDS[1]:
        return None
    ahead = way - back
    ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
    step = there - place
    along = float(step @ ahead)
    across = abs(float(step[0] * ahead[1] - step[1] * ahead[0]))
    if along < -beside:
        # Drawn again before it goes on: that ink lies over the end of the first line.
        over = other[arc_length(other) <= -along]
        across = float(np.max(distances_to_polyline(over, one))) if len(over) else across
    if across > LOOSELY * beside or not -again <= along <= LOOSELY * GAP:
        return None
    smooth = bend <= BENDS[0]
    return Continuation(away, bend, smooth and across <= beside and along <= GAP)


def _bend(way: Array, back: Array) -> float:
    """Return the angle, degrees, between the ways of two ends that go on into one another."""
    return float(np.degrees(np.arccos(np.clip(-(way @ back), -1.0, 1.0))))


def _end(line: Array, part: float) -> tuple[Array, Array]:
    """Return where a line ends, and the unit direction in which it leaves there.

    Both are those of a parabola along the arc length, fitted by least squares to a part of the
    usual length of ink.
    """
    share, least, most = REACH
    along = arc_length(line)
    reach = part * float(np.clip(share * along[-1], least, most))
    back = along[-1] - along
    near = back <= max(reach, float(back[-min(4, len(back))]))
    basis = np.vander(-back[near], min(3, int(near.sum())), increasing=True)
    found = np.linalg.lstsq(basis, line[near], rcond=None)[0]
    return found[0], found[1] / max(float(np.linalg.norm(found[1])), 1e-300)
