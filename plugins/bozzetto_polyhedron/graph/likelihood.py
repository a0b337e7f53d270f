"""How likely lines and corners are, given the segments: the value that the search lowers.

An end of a line lies about its corner with a covariance that is long along the line and short
across it, so that a corner is where lines cross and an overshoot costs little. The place of the
corner is integrated out, uniform over the sheet, so a free end costs nothing by itself and d ends
cost what they gain by agreeing. Lengths are shares of the drawing's diagonal, costs are nats.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from math import atan2, cos, hypot, inf, log, pi, radians, sin, sqrt
from typing import Any, Final

from bozzetto_polyhedron.graph.grouping import LONGEST_DASH, Members
from bozzetto_polyhedron.graph.segments import Segments

FEW_LINES: Final = (0.0, 22.0, 14.0)
"""Cost of a corner of no, one, two lines: closed polyhedra have three or more at each."""

FEW_VISIBLE: Final = (0.0, 4.0, -1.0)
"""The same where only visible lines are drawn: hidden ones are missing at many corners, and a line
that goes behind a face ends alone."""

MANY_LINES: Final = 3.0
"""Cost of every line beyond three at a corner: most corners of solids have three."""

AGAIN: Final = 1.5
"""Cost of drawing over a line again."""

AGAIN_AT_ONCE: Final = 0.0
"""Cost of drawing over a line again with the very next stroke, which is what hands do."""

TICK: Final = 5.0
"""Cost of a stray mark of no length."""

TICK_LENGTH: Final = 0.005
"""Length by which a stray mark costs one more."""

LONGEST_TICK: Final = 0.035
"""Length over which no segment is taken for a stray mark."""

PASSES: Final = 10.0
"""Cost of two lines that go straight on through a corner of three others, and of two that cross
in a corner of their own: no corner of a solid lies on an edge that goes on there, and lines that
cross on the sheet do not meet."""

THREE_BARS: Final = -6.0
"""Cost of six lines that go straight on in three pairs, beside `MANY_LINES`: three bars meet there,
and three lines do not cross at one place by chance, nor do two corners lie at one."""

STRAIGHT_ON: Final = radians(12.0)
"""Angle up to which two lines go straight on."""

SAME_ENDS: Final = 60.0
"""Cost of a second line between the same corners."""

NAMED: Final = 5.0
"""Cost of a line for the pair of corners that it names: log of the pairs of about 18 corners."""

MIXED: Final = 10.0
"""Cost of a line drawn partly lightly and partly firmly, as hidden and as visible."""

BESIDE: Final = 5.0
"""Cost of a dash beside another one of its line: nobody draws dashes over dashes."""

WORST: Final = 18.0
"""Cost of a segment end across its line, at most."""

End = tuple[float, float, float, float, float, float, float]
"""What an end tells of its corner: information matrix (xx, xy, yy), its product with the place of
the end (x, y), the quadratic form there, and the logarithm of the normaliser."""


@dataclass(frozen=True)
class Spread:
    """How ends of lines lie about their corners.

    Parameters
    ----------
    across, along : float
        Standard deviations across and along the line.
    overshoot : float
        Mean length by which lines go beyond their corners.
    """

    across: float
    along: float
    overshoot: float = 0.0


@dataclass(frozen=True)
class Line:
    """One line and the segments it was drawn with.

    Parameters
    ----------
    members : tuple of int
        Segments, ascending.
    start, stop : (x, y)
        Where the ink of the line ends.
    misfit : float
        Cost of the segment ends that are within the line.
    ends : (End, End)
        What both ends tell of their corners.
    angles : (float, float)
        Where the line goes from either end, radians, -pi … pi.
    """

    members: Members
    start: tuple[float, float]
    stop: tuple[float, float]
    misfit: float
    ends: tuple[End, End]
    angles: tuple[float, float]

    @property
    def length(self) -> float:
        """Distance of the ends."""
        return hypot(self.stop[0] - self.start[0], self.stop[1] - self.start[1])


@dataclass(frozen=True, eq=False)
class Fits:
    """Lines fitted to segments, each set of segments once.

    Parameters
    ----------
    segments : Segments
        What was drawn.
    spread : Spread
        How ends lie about their corners.
    few : (float, float, float)
        Cost of a corner of no, one, two lines.
    """

    segments: Segments
    spread: Spread
    few: tuple[float, float, float] = FEW_LINES
    known: dict[Members, Line] = field(default_factory=dict)
    rows: list[list[list[float]]] = field(default_factory=list)
    light: list[bool] = field(default_factory=list)
    strokes: list[int] = field(default_factory=list)
    dealt: dict[tuple[Any, ...], tuple[tuple[Members, Members], ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.rows.extend(self.segments.ends.tolist())
        self.light.extend(self.segments.light.tolist())
        self.strokes.extend(self.segments.strokes.tolist())

    def line(self, members: Members) -> Line:
        """Return the line through segments, given in any order."""
        found = self.known.get(members)
        if found is None:
            key = tuple(sorted(members))
            found = self.known.get(key) or self._fitted(key)
            self.known[key] = self.known[members] = found
        return found

    def once(
        self, ways: Callable[..., Iterator[tuple[Members, Members]]], *members: Members
    ) -> tuple[tuple[Members, Members], ...]:
        """Return the ways to deal segments of lines out in two, found once for the same lines.

        Parameters
        ----------
        ways : callable
            Of these fits and the segments of each line.
        *members : tuple of int
            Segments of each line.
        """
        key = ways, *members
        found = self.dealt.get(key)
        if found is None:
            found = self.dealt[key] = tuple(ways(self, *members))
        return found

    def _fitted(self, key: Members) -> Line:
        """Return the line through segments, which ascend."""
        found = _line([self.rows[k] for k in key], key, self.spread)
        if len(key) == 1:
            return found
        at_once = sum(self.strokes[b] - self.strokes[a] <= 1 for a, b in pairwise(key))
        light = sum(self.light[k] for k in key)
        misfit = found.misfit - (AGAIN - AGAIN_AT_ONCE) * at_once
        beside = self._dashes_beside(key, found) if light > 1 else 0
        misfit += MIXED * (0 < light < len(key)) + BESIDE * beside
        return Line(key, found.start, found.stop, misfit, found.ends, found.angles)

    def _dashes_beside(self, members: Members, line: Line) -> int:
        """Count light dashes that lie beside the one before them along the line."""
        (x, y), (x1, y1) = line.start, line.stop
        ux, uy = (x1 - x) / line.length, (y1 - y) / line.length
        dashes = sorted(
            tuple(sorted((a - x) * ux + (b - y) * uy for a, b in self.rows[k]))
            for k in members
            if self.light[k]
        )
        count, reach = 0, -inf
        for low, high in dashes:
            if high - low < LONGEST_DASH:
                count += min(reach, high) - low > 0.4 * (high - low)
                reach = max(reach, high)
        return count

    def tick_cost(self, members: Members) -> float:
        """Return the cost of taking segments for stray marks."""
        cost = 0.0
        for number in members:
            (x0, y0), (x1, y1) = self.rows[number]
            length = hypot(x1 - x0, y1 - y0)
            cost += inf if length > LONGEST_TICK else TICK + length / TICK_LENGTH
        return cost


def _line(rows: list[list[list[float]]], members: Members, spread: Spread) -> Line:
    cx, cy, ux, uy = _axis(rows)
    away = [(x - cx, y - cy) for row in rows for x, y in row]
    along = [x * ux + y * uy for x, y in away]
    low, high = min(along), max(along)
    length = max(high - low, 1e-6)
    misfit = NAMED
    if len(rows) > 1:
        unit = log(sqrt(2 * pi) * spread.across * length)
        costs = [
            min(
                WORST,
                0.5 * ((y * ux - x * uy) / spread.across) ** 2 + (unit if low < at < high else 0.0),
            )
            for (x, y), at in zip(away, along, strict=True)
        ]
        misfit += sum(costs) + AGAIN * (len(rows) - 1)
    start, stop = (cx + ux * low, cy + uy * low), (cx + ux * high, cy + uy * high)
    ends = (
        _end(start, (-ux, -uy), length, spread),
        _end(stop, (ux, uy), length, spread),
    )
    angle = atan2(stop[1] - start[1], stop[0] - start[0])
    angles = angle, angle - pi if angle > 0.0 else angle + pi
    return Line(members, start, stop, misfit, ends, angles)


def _axis(rows: list[list[list[float]]]) -> tuple[float, float, float, float]:
    """Return center and direction of the line nearest to all points of some segments."""
    masses = [max(hypot(b[0] - a[0], b[1] - a[1]), 1e-9) for a, b in rows]
    total = sum(masses)
    cx = sum(m * (a[0] + b[0]) for m, (a, b) in zip(masses, rows, strict=True)) / (2 * total)
    cy = sum(m * (a[1] + b[1]) for m, (a, b) in zip(masses, rows, strict=True)) / (2 * total)
    if len(rows) == 1:
        a, b = rows[0]
        return cx, cy, (b[0] - a[0]) / total, (b[1] - a[1]) / total
    xx = xy = yy = 0.0
    for m, (a, b) in zip(masses, rows, strict=True):
        x, y = (a[0] + b[0]) / 2 - cx, (a[1] + b[1]) / 2 - cy
        dx, dy = b[0] - a[0], b[1] - a[1]
        xx += m * (x * x + dx * dx / 12)
        xy += m * (x * y + dx * dy / 12)
        yy += m * (y * y + dy * dy / 12)
    angle = 0.5 * atan2(2 * xy, xx - yy)
    return cx, cy, cos(angle), sin(angle)


def _end(
    place: tuple[float, float], outward: tuple[float, float], length: float, spread: Spread
) -> End:
    ux, uy = outward
    sigma = max(spread.across, min(spread.along, 0.35 * length))
    narrow = spread.across * (1.0 + 0.25 * min(4.0, spread.along / length))
    back = min(spread.overshoot, 0.2 * length)
    x, y = place[0] - ux * back, place[1] - uy * back
    p, q = sigma**-2, narrow**-2
    xx, xy, yy = p * ux * ux + q * uy * uy, (p - q) * ux * uy, p * uy * uy + q * ux * ux
    bx, by = xx * x + xy * y, xy * x + yy * y
    return xx, xy, yy, bx, by, bx * x + by * y, log(2 * pi * sigma * narrow)


def place_of(sums: End) -> tuple[float, float]:
    """Return the place of the corner at which ends meet, from the sums over them."""
    xx, xy, yy, bx, by, _, _ = sums
    determinant = xx * yy - xy * xy
    return (yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant


def corner_cost(sums: End, degree: int, fewer: tuple[float, float, float] = FEW_LINES) -> float:
    """Return the cost of a corner from the sums over its ends."""
    if degree <= 0:
        return 0.0
    xx, xy, yy, bx, by, form, normalizer = sums
    determinant = max(xx * yy - xy * xy, 1e-12)
    strain = form - (yy * bx * bx - 2 * xy * bx * by + xx * by * by) / determinant
    few = fewer[degree] if degree < 3 else MANY_LINES * (degree - 3)
    return 0.5 * max(strain, 0.0) + normalizer - log(2 * pi) + 0.5 * log(determinant) + few


def strain_of(sums: End) -> float:
    """Return the sum of squared standardised distances of ends from their corner."""
    x, y = place_of(sums)
    return max(0.0, sums[5] - sums[3] * x - sums[4] * y)


def passing_cost(angles: Iterable[float]) -> float:
    """Return the cost of pairs of lines that go straight on through a corner.

    One pair with two others is a corner of solids, where a rib ends at an edge; and so are three
    pairs, where three bars meet.

    Parameters
    ----------
    angles : iterable of float
        Where the lines of the corner go from there, radians, -pi … pi.
    """
    left = sorted(angles)
    count, pairs = len(left), 0
    while len(left) > 1:
        one = left.pop()
        for number, other in enumerate(left):
            if abs(one - other - pi) < STRAIGHT_ON:
                del left[number]
                pairs += 1
                break
    if pairs == 3 and count == 6:
        return THREE_BARS
    return 0.0 if count - 2 * pairs == 2 else PASSES * pairs
