"""The strokes of one view as one or two sides of a curve."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, distances_to_polyline, merge_strokes, resample, stroke_weights
from bozzetto.plugin import remembered
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.ink.stroke_grouping import any_drawn_over, bonds_between, group_strokes
from bozzetto_symmetry.ink.stroke_line import (
    CLOSING,
    SPACING,
    Line,
    pen_down,
    smooth_line,
    space_evenly,
)

DOT: Final = 1e-3
"""Extent below which a stroke is a dot, px."""

MOST_STROKES: Final = 150
"""Most strokes of one curve in one view: comparing each with each takes some seconds then."""

MEETING: Final = 0.08
"""Widest gap between the halves of one curve across the plane, as a share of the shorter one."""

UNDRAWN: Final = 3
"""Steps of a merged ring without ink that do not count as a gap: the ink has steps of its own."""


@dataclass(frozen=True, eq=False)
class Side:
    """One side of a curve in one view: a single line, however often it was drawn.

    Attributes
    ----------
    pixels : (n, 2) float
        Evenly spaced, in the sense of the first stroke; a closed side does not repeat its
        first point.
    closed : bool
    noise : float
        Standard deviation of the line across itself, px: what can be separated
        of the hand from the form, over the root of how often the line was drawn. At least 0.
    strokes : tuple of int
        Which of the given strokes.
    sure : bool
        Whether several strokes merge well into one line.
    pressure : (n,) float or None
        That of the pen at each of `pixels`; None where it told none, or there are several strokes.
    """

    pixels: Array
    closed: bool
    noise: float
    strokes: tuple[int, ...]
    sure: bool = True
    pressure: Array | None = None

    @property
    def unrolled(self) -> Array:
        """The side as an open line, (m, 2) px: a closed one ends where it begins."""
        return np.vstack((self.pixels, self.pixels[:1])) if self.closed else self.pixels


def sides_of(
    strokes: Sequence[Stroke], *, apart: bool = False, pieces: Iterable[tuple[int, int]] = ()
) -> tuple[Side, ...]:
    """Put the strokes of one view in sides, and merge the strokes of each.

    A side may be scribbled over with many strokes in any sense, drawn in consecutive pieces,
    and in turn with the other one (`bozzetto_symmetry.ink.stroke_grouping`). A side of one stroke,
    or of pieces that continue one another, keeps its own form; strokes over one another are
    merged, and older ones count less.

    Parameters
    ----------
    strokes : sequence of Stroke
        Of one camera, in the order drawn. Dots are left out.
    apart : bool
        Two sides are kept apart that would otherwise surely be one.
    pieces : iterable of (int, int)
        Numbers of two strokes of which one goes on where the other ended.

    Returns
    -------
    tuple of Side
        One or two; the side whose stroke came first is the first.

    Raises
    ------
    UserError
        If there is no stroke with a length.
    """
    numbers = [k for k, s in enumerate(strokes) if np.ptp(pen_down(s), axis=0).max() > DOT]
    if not numbers:
        raise UserError("There is only a dot. Draw the whole curve.")
    if len(numbers) > MOST_STROKES:
        raise UserError(
            f"{len(numbers)} strokes are too many for one curve; it can have {MOST_STROKES}. Take "
            "some back, and press Enter after each curve."
        )
    # A closed line is compared with its gap, as the pen went.
    index = {number: k for k, number in enumerate(numbers)}
    known = [(index[i], index[j]) for i, j in pieces if i in index and j in index]
    groups = group_strokes([_line(strokes[k]).pixels for k in numbers], apart=apart, pieces=known)
    sides = []
    for group in groups:
        members = tuple(numbers[k] for k in group)
        sides.append(replace(_side(tuple(strokes[k] for k in members)), strokes=members))
    return tuple(sides)


@remembered(limit=512)
def _line(stroke: Stroke) -> Line:
    """Return one stroke smoothed; remembered, for the next stroke is compared with it again."""
    return smooth_line(pen_down(stroke))


@remembered(limit=256)
def _side(strokes: tuple[Stroke, ...]) -> Side:
    """Return one side of some strokes; remembered, for the next stroke may be of the other one.

    It is a single stroke, pieces one after the other, or all strokes settled together.
    """
    lines = [_line(stroke) for stroke in strokes]
    places = [pen_down(stroke) for stroke in strokes]
    if len(lines) > 1 and any_drawn_over([line.pixels for line in lines]):
        return _settled(places, stroke_weights(list(strokes)), ())
    line = lines[0] if len(lines) == 1 else smooth_line(_chained(places))
    pressure = _pressure(strokes[0], line.pixels) if len(strokes) == 1 else None
    return Side(line.pixels, line.closed, line.noise, (), pressure=pressure)


def _pressure(stroke: Stroke, pixels: Array) -> Array | None:
    """Return the pressure of the nearest sample at places (n, 2); None where the pen told none."""
    if not stroke.has_pressure:
        return None
    from scipy.spatial import cKDTree

    return np.asarray(stroke.pressure[cKDTree(stroke.points).query(pixels)[1]], float)


def merge_alongside(one: Side, other: Side) -> Side | None:
    """Return two sides that run alongside one another merged into the one that they may be."""
    if one.closed or other.closed or not bonds_between([one.pixels, other.pixels])[0][1].over:
        return None
    return _settled([one.pixels, other.pixels], np.ones(2), _members(one, other))


def join_ends(one: Side, other: Side) -> Side | None:
    """Return two sides as halves of one line, in the sense of the first, where their ends meet."""
    if one.closed or other.closed:
        return None
    gap = gap_between(one.pixels, other.pixels)[0]
    if gap > MEETING * min(length_of(one.pixels), length_of(other.pixels)):
        return None
    line = space_evenly(_chained([one.pixels, other.pixels]))
    noise = max(one.noise, other.noise)
    return Side(line, False, noise, _members(one, other), one.sure and other.sure)


def gap_between(one: Array, other: Array) -> tuple[float, Array, bool]:
    """Return how near the ends of two lines come, px; where; and whether the first's last end."""
    first, second = one[[0, -1]], other[[0, -1]]
    gaps = np.linalg.norm(first[:, None] - second, axis=2)
    which, that = np.unravel_index(int(gaps.argmin()), gaps.shape)
    return float(gaps.min()), 0.5 * (first[which] + second[that]), bool(which)


def _members(one: Side, other: Side) -> tuple[int, ...]:
    return tuple(sorted((*one.strokes, *other.strokes)))


def _settled(places: Sequence[Array], weights: Array, members: tuple[int, ...]) -> Side:
    """Return lines over one another merged into one, in the sense of the first."""
    found = merge_strokes(places, weights)
    line = found.points
    closed = found.closed
    if closed:
        line, closed = _opened(line[:-1], places)
    pixels = space_evenly(_in_sense_of(places[0], line, closed), closed=closed)
    ring = np.vstack((pixels, pixels[:1])) if closed else pixels
    ink = np.vstack([space_evenly(place) for place in places])
    times = max(1.0, SPACING * len(ink) / max(length_of(ring), SPACING))
    scatter = float(1.4826 * np.median(distances_to_polyline(ink, ring)))
    return Side(pixels, closed, scatter / times**0.5, members, found.sure)


def _opened(ring: Array, places: Sequence[Array]) -> tuple[Array, bool]:
    """Return a ring without the part that nobody drew, if that is too wide for a mere gap."""
    ink = np.vstack([space_evenly(place) for place in places])
    step = length_of(np.vstack((ring, ring[:1]))) / len(ring)
    apart = np.linalg.norm(ring[:, None] - ink, axis=2)
    met = np.unique(apart.argmin(axis=0))
    behind = np.diff(np.append(met, met[0] + len(ring)))
    widest = int(np.argmax(behind))
    diagonal = float(np.linalg.norm(np.ptp(ring, axis=0)))
    if behind[widest] * step <= max(CLOSING * diagonal, UNDRAWN * step):
        return ring, True
    begin = met[(widest + 1) % len(met)]
    return np.roll(ring, -begin, axis=0)[: len(ring) - behind[widest] + 1], False


def _chained(places: Sequence[Array]) -> Array:
    """Return pieces in one line, each joined where the gap is least; in the sense of the first."""
    chain, rest = places[0], list(places[1:])
    while rest:
        joints = [
            (float(np.linalg.norm(chain[at] - piece[end])), k, at, end)
            for k, piece in enumerate(rest)
            for at in (-1, 0)
            for end in (0, -1)
        ]
        _, k, at, end = min(joints)
        piece = rest.pop(k)
        if at == -1:
            chain = np.vstack((chain, piece if end == 0 else piece[::-1]))
        else:
            chain = np.vstack((piece if end == -1 else piece[::-1], chain))
    return chain


def _in_sense_of(stroke: Array, points: Array, closed: bool) -> Array:
    """Return the merged line in the sense of a stroke; a ring begins where that begins."""
    line = points
    ink = resample(stroke, count=64)
    feet = np.linalg.norm(ink[:, None] - line, axis=2).argmin(axis=1)
    steps = np.diff(feet)
    if closed:
        steps = (steps + len(line) // 2) % len(line) - len(line) // 2
        line = np.roll(line, -int(feet[0]), axis=0)
    if np.sign(steps).sum() < 0:
        return np.roll(line[::-1], 1, axis=0) if closed else line[::-1]
    return line
