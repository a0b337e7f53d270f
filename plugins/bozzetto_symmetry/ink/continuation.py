"""Whether one line goes on where another one ended, because the pen was lifted there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import arc_length, distances_to_polyline
from bozzetto.plugin import cached_property

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


PARTS: Final = (1.0, 1.0 / 3.0)
"""Shares of the usual length of ink that the direction of an end is taken over."""

SLACK: Final = 1.0 + 1e-9
"""What the quick look at the distance of two ends allows for rounding."""


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


@dataclass(frozen=True, eq=False)
class OpenLine:
    """A line with two ends; what is known of them is worked out once, for whatever it may meet.

    Attributes
    ----------
    pixels : (n, 2) float
        Smoothed and evenly spaced.
    noise : float
        Standard deviation of the hand across it, px.
    """

    pixels: Array
    noise: float = 0.0

    @cached_property
    def along(self) -> Array:
        """Arc length from its beginning to each of its places, (n,) px."""
        return arc_length(self.pixels)

    @cached_property
    def length(self) -> float:
        """Its length, px."""
        return float(self.along[-1])

    @cached_property
    def turned(self) -> OpenLine:
        """The same line in the other sense."""
        return OpenLine(self.pixels[::-1], self.noise)

    @cached_property
    def ends(self) -> tuple[tuple[Array, Array], ...]:
        """Where it ends and the unit direction in which it leaves there, for each of `PARTS`."""
        return tuple(_end(self.pixels, self.along, part) for part in PARTS)


def meeting(lines: Sequence[OpenLine]) -> Iterator[tuple[int, int, Continuation]]:
    """Yield which two of many lines join at their ends, by their numbers, and how.

    Most lines end nowhere near each other, which is seen of all pairs at once.
    """
    long = [k for k, line in enumerate(lines) if line.length >= SHORTEST]
    if len(long) < 2:
        return
    length, noise = np.array([(lines[k].length, lines[k].noise) for k in long]).T
    ends = np.array([lines[k].pixels[[0, -1]] for k in long])
    for i, first in enumerate(long[:-1]):
        later = slice(i + 1, None)
        shorter = np.minimum(length[i], length[later])
        reach = _farthest(shorter, _beside(shorter, np.maximum(noise[i], noise[later])))
        apart = np.linalg.norm(ends[i][:, None] - ends[later, None], axis=-1).min(axis=(1, 2))
        for j in np.flatnonzero(apart <= SLACK * reach).tolist():
            how = continuation(lines[first], lines[long[i + 1 + j]])
            if how is not None:
                yield first, long[i + 1 + j], how


def continuation(one: OpenLine, other: OpenLine) -> Continuation | None:
    """Return how two lines join at their ends, the smoothest way; None where they do not."""
    shorter = min(one.length, other.length)
    if shorter < SHORTEST:
        return None
    beside = float(_beside(shorter, max(one.noise, other.noise)))
    reach = float(_farthest(shorter, beside))
    found = [
        _joint(first, second, shorter, beside)
        for first in (one, one.turned)
        for second in (other, other.turned)
        if np.linalg.norm(second.pixels[0] - first.pixels[-1]) <= reach
    ]
    return min(
        (each for each in found if each is not None), key=lambda each: each.bend, default=None
    )


def _joint(one: OpenLine, other: OpenLine, shorter: float, beside: float) -> Continuation | None:
    """Return how a line that begins where another one ends goes on; None where it does not.

    Parameters
    ----------
    one, other : OpenLine
        In the senses in which the second begins near where the first ends.
    shorter : float
        Length of the shorter one, px.
    beside : float
        How far beside the way of the first end the second may begin, px.
    """
    again = float(_again(shorter))
    away = float(np.linalg.norm(other.pixels[0] - one.pixels[-1]))
    ends = tuple(zip(one.ends, other.turned.ends, strict=True))
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
        over = other.pixels[other.along <= -along]
        across = float(np.max(distances_to_polyline(over, one.pixels))) if len(over) else across
    if across > LOOSELY * beside or not -again <= along <= LOOSELY * GAP:
        return None
    smooth = bend <= BENDS[0]
    return Continuation(away, bend, smooth and across <= beside and along <= GAP)


def _beside(shorter: Array | float, noise: Array | float) -> Array | float:
    """Return how far beside the way of one end another one may begin, px."""
    share, least, most = BESIDE
    return np.clip(share * shorter, least, most) + noise


def _again(shorter: Array | float) -> Array | float:
    """Return how much ink may be drawn twice, px."""
    return np.minimum(AGAIN[0] * shorter, AGAIN[1])


def _farthest(shorter: Array | float, beside: Array | float) -> Array | float:
    """Return how far apart two ends may be, px."""
    return LOOSELY * np.hypot(GAP, beside) + _again(shorter)


def _bend(way: Array, back: Array) -> float:
    """Return the angle, degrees, between the ways of two ends that go on into one another."""
    return float(np.degrees(np.arccos(np.clip(-(way @ back), -1.0, 1.0))))


def _end(line: Array, along: Array, part: float) -> tuple[Array, Array]:
    """Return where a line ends, and the unit direction in which it leaves there.

    Both are those of a parabola along the arc length, fitted by least squares to a part of the
    usual length of ink.
    """
    share, least, most = REACH
    reach = part * float(np.clip(share * along[-1], least, most))
    back = along[-1] - along
    near = back <= max(reach, float(back[-min(4, len(back))]))
    basis = np.vander(-back[near], min(3, int(near.sum())), increasing=True)
    found = np.linalg.lstsq(basis, line[near], rcond=None)[0]
    return found[0], found[1] / max(float(np.linalg.norm(found[1])), 1e-300)
