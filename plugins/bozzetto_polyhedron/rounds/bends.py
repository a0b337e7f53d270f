"""Rounded corners and ends in a line drawing: an arc between two lines, and the same again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.rounds.ellipses import even_samples
from bozzetto_polyhedron.rounds.ends import LineEnd, corners_between, ends_of, line_at
from bozzetto_polyhedron.rounds.ink_left import FEWEST, LEAST_SHIFT, MOST_ARCS, REACH, InkLeft
from bozzetto_polyhedron.rounds.ink_samples import directions
from bozzetto_polyhedron.rounds.round_things import Bend

BOW_OFF: Final = 0.012
"""Largest difference of the height of an arc from that of a circle between the same lines, in
diagonals."""

BOW_SHARE: Final = 0.5
"""Least share of that height."""

LEAST_MEANT, SURE_SHARE, LEAST_CHORD = 0.015, 0.7, 0.1
"""Height, in diagonals, below which a bow says nothing by itself, for lines bow by less than half
of it; least share of it that is drawn then; and the shortest chord, in diagonals."""

BEVEL: Final = 0.75
"""Share of the chord of an arc from which on a straight line in its place is a bevel."""

UNDRAWN, DRAWN = 0.15, 0.5
"""Share of the other arc below which nothing of it is drawn; and least share where this one is no
more than bowed, and no other edge is round."""

LEAST_BEND: Final = np.radians(20.0)
"""Least angle, on the sheet, between the lines at an arc that is no more than bowed."""

LEAST_ARC, MOST_ARC = np.radians(35.0), np.radians(250.0)
"""Turn of a rounded corner on the sheet, radians."""

JOINS: Final = 0.06
"""Distance, in diagonals, within which a line goes on where an arc ends."""

LINE_THERE: Final = 0.4
"""What a line that ends at the copy of an arc counts, in shares of the arc that are drawn."""

ENOUGH: Final = 0.62
"""Such shares from which on there is a copy: most of the arc, or both lines, or both halves."""

ALONG: Final = 0.97
"""Cosine of the angle within which an edge runs along a shift."""

PARALLEL: Final = np.cos(np.radians(12.0))
"""Cosine of the angle within which lines are parallel on the sheet."""


class Bends:
    """Rounded corners and ends that are found.

    Parameters
    ----------
    ink_left : InkLeft
        Strokes that become arcs, or what is tangent to them, are spoken for.
    """

    def __init__(self, ink_left: InkLeft) -> None:
        self._ink = ink_left
        self.bends: list[Bend] = []
        self._find_bends()

    def _find_bends(self) -> None:
        """Find arcs between two lines, with the same arcs on the other side of the body."""
        bent = sorted(self._ink.curved) + sorted(self._ink.bowed)
        arcs = [number for number in bent if number in self._ink.left][:MOST_ARCS]
        arcs.sort(key=lambda k: (bool(self._ink.light[k]), k in self._ink.bowed))
        for number in arcs:
            if number in self._ink.left:
                bend = self._bend(number)
                if bend is not None:
                    self._ink.take(bend.strokes)
                    if not self._is_known(bend):
                        self.bends.append(bend)

    def _is_known(self, bend: Bend) -> bool:
        """Whether another arc has rounded the same edge."""
        known = [each.corners + shift for each in self.bends for shift in (0.0, each.shift)]
        own = np.concatenate((bend.corners, bend.corners + bend.shift))
        return any(
            np.linalg.norm(own[:, None] - corners, axis=2).min() < JOINS * self._ink.size
            for corners in known
        )

    def _bend(self, number: int) -> Bend | None:
        """Return the rounded corner or end that an arc is; None where it is neither.

        Where the other arc is, is told by its own ink, as much of it as is drawn, and by the lines
        that end there as they end at this one.
        """
        arc = even_samples([self._ink.paths[number]], 40)
        ways = directions(arc)
        turns = np.unwrap(np.arctan2(ways[:, 1], ways[:, 0]))
        bowed = number in self._ink.bowed
        if not bowed and not LEAST_ARC < abs(turns[-3] - turns[2]) < MOST_ARC:
            return None
        straight = [each for each in self._ink.straight() if number not in each.members]
        lines = [
            line_at(straight, place, way, JOINS * self._ink.size) for place, way in ends_of(arc)
        ]
        if None in lines or lines[0] is lines[1]:
            return None
        first, second = (each for each in lines if each is not None)
        corners = corners_between(arc, first, second)
        if corners is None or (bowed and not self._is_as_round(arc, first, second)):
            return None
        parts = [k for k in self._ink.parts_of(arc) if k != number]
        reach = min(REACH * self._ink.size, 0.3 * float(np.linalg.norm(arc[-1] - arc[0])))
        rest = [each for each in straight if each.line is not first.line
                and each.line is not second.line]  # fmt: skip
        best: tuple[float, Array, list[int], list[LineEnd | None]] | None = None
        for shift in self._shifts(arc, (first, second), rest, parts, reach):
            if not self._edges_along(shift):
                continue
            own = self._ink.without_rows(
                self._ink.samples.lying_along(arc + shift, parts, 1.25 * reach)
            )
            score = self._ink.samples.covered(arc + shift, own, 1.25 * reach) if own else 0.0
            sure = not bowed or self._has_shift(shift)
            if bowed and score > UNDRAWN and not self._is_round_too(own, first, second):
                continue
            if not sure and (score < DRAWN or not self._is_as_round(arc, first, second, sure=True)):
                continue
            there: list[LineEnd | None] = []
            others = [each for each in rest if not set(each.members) & set(own)]
            for place, end in zip((arc[0], arc[-1]), (first, second), strict=True):
                left = [each for each in others if not there or each is not there[0]]
                there.append(line_at(left, place + shift, end.way, 0.8 * JOINS * self._ink.size))
            if not sure and None in there:
                continue
            for place, line in zip((arc[0], arc[-1]), there, strict=True):
                if line is not None:
                    off = float(np.linalg.norm(line.place - place - shift))
                    score += LINE_THERE * (1.0 - 0.3 * off / (JOINS * self._ink.size))
            if score >= ENOUGH and (best is None or score > best[0] + 1e-9):
                best = score, shift, own, there
        if best is None:
            return None
        _, shift, own, behind = best
        places = [corners[min(k, len(corners) - 1)] for k in range(2)]
        both = zip((first, second), arc[[0, -1]], places, strict=True)
        ends = [(each.number, at, place) for each, at, place in both]
        for each, at, place in zip(behind, arc[[0, -1]], places, strict=True):
            ends.append((-1 if each is None else each.number, at + shift, place + shift))
        kept = {each.number for each in (first, second, *behind) if each is not None}
        sides = self._sides_of(arc, shift, kept)
        own_light = self._ink.mostly_light(own) if own else True
        light = bool(self._ink.light[number]), own_light
        strokes = tuple(sorted({number, *own, *sides}))
        return Bend(arc, corners, shift, tuple(ends), strokes, light)

    def _has_shift(self, shift: Array) -> bool:
        """Whether a rounded edge was found that runs like this: others are likely then."""
        return any(
            min(np.linalg.norm(shift - each.shift), np.linalg.norm(shift + each.shift))
            < 2.0 * REACH * self._ink.size
            for each in self.bends
        )

    def _is_as_round(
        self, arc: Array, first: LineEnd, second: LineEnd, *, sure: bool = False
    ) -> bool:
        """Whether an arc is as high above its chord as a circle tangent to both lines would be.

        With the turn of the lines θ and the length of the chord c that is ½ c tan θ/4. Lines bow as
        much where that is little: then nothing is `sure`.
        """
        turn = np.pi - float(np.arccos(np.clip(first.way @ second.way, -1.0, 1.0)))
        if len(arc) < FEWEST or turn < LEAST_BEND:
            return False
        chord = arc[-1] - arc[0]
        length = float(np.linalg.norm(chord))
        away = arc - arc[0]
        heights = (away[:, 0] * chord[1] - away[:, 1] * chord[0]) / max(length, 1e-9)
        outward = -(first.way + second.way)
        side = -1.0 if outward[0] * chord[1] - outward[1] * chord[0] > 0 else 1.0
        height = float((-side * heights).max())
        meant = 0.5 * length * float(np.tan(0.25 * turn))
        share = SURE_SHARE if sure else BOW_SHARE
        if height < share * meant or (
            sure and (meant < LEAST_MEANT * self._ink.size or length < LEAST_CHORD * self._ink.size)
        ):
            return False
        return abs(height - meant) < BOW_OFF * self._ink.size

    def _is_round_too(self, own: Sequence[int], first: LineEnd, second: LineEnd) -> bool:
        """Whether the ink of the other arc is bent as well: that of a bevel is straight."""
        chord = float(np.linalg.norm(first.place - second.place))
        spans = {k: self._ink.paths[k][[0, -1]] for k in own if k not in self._ink.row_of}
        for row in {self._ink.row_of[k] for k in own if k in self._ink.row_of}:
            ends = np.concatenate(
                [self._ink.paths[k][[0, -1]] for k in own if self._ink.row_of.get(k) == row]
            )
            ends = ends[np.argsort(ends @ (second.place - first.place), kind="stable")]
            if float(np.linalg.norm(ends[-1] - ends[0])) > BEVEL * chord and not (
                self._is_as_round(ends, first, second)
            ):
                return False
        return all(
            k in self._ink.curved
            or (
                k in self._ink.bowed
                and self._is_as_round(self._ink.paths[k], *self._turned(k, first, second))
            )
            for k, ends in spans.items()
            if float(np.linalg.norm(ends[1] - ends[0])) > BEVEL * chord
        )

    def _turned(self, number: int, first: LineEnd, second: LineEnd) -> tuple[LineEnd, LineEnd]:
        """Return the lines at an arc in the order in which another stroke beside it was drawn."""
        span = self._ink.paths[number][-1] - self._ink.paths[number][0]
        return (first, second) if span @ (second.place - first.place) > 0.0 else (second, first)

    def _shifts(
        self,
        arc: Array,
        lines: tuple[LineEnd, LineEnd],
        rest: list[LineEnd],
        parts: list[int],
        reach: float,
    ) -> list[Array]:
        """Return where the other arc may be, from this one: by its ink, and by lines that end."""
        found = [
            *self._ink.samples.shifts(arc, parts, reach),
            *(bend.shift for bend in self.bends),
        ]
        for place, line in zip((arc[0], arc[-1]), lines, strict=True):
            for each in rest:
                if float(each.way @ line.way) > PARALLEL:
                    found.append(each.place - place)
        return [each for each in found if np.linalg.norm(each) > LEAST_SHIFT * self._ink.size]

    def _edges_along(self, shift: Array) -> bool:
        """Whether a straight stroke or a row of dashes is as long as a shift and runs along it.

        What is tangent to both arcs of another corner counts as well.
        """
        length = float(np.linalg.norm(shift))
        for number in set(range(len(self._ink.paths))) - self._ink.curved:
            span = self._ink.paths[number][-1] - self._ink.paths[number][0]
            along = abs(float(span @ shift)) / length
            if along > 0.5 * length and along > ALONG * np.linalg.norm(span):
                return True
        return any(
            abs(float(each.way @ shift)) > ALONG * length
            and np.linalg.norm(each.line[1] - each.line[0]) > 0.5 * length
            for each in self._ink.straight()
        )

    def _sides_of(self, arc: Array, shift: Array, kept: set[int]) -> list[int]:
        """Return straight strokes from one arc to the other: no edge, for the body is smooth."""
        length = float(np.linalg.norm(shift))
        reach = 1.4 * REACH * self._ink.size
        found: list[int] = []
        for each in self._ink.straight()[::2]:
            span = each.line[1] - each.line[0]
            extent = float(np.linalg.norm(span))
            if each.number in kept - {-1} or extent < 0.6 * length:
                continue
            if abs(float(span @ shift)) < 0.93 * extent * length:
                continue
            begin, end = each.line if span @ shift > 0 else each.line[::-1]
            first = np.linalg.norm(arc - begin, axis=1).min()
            second = np.linalg.norm(arc + shift - end, axis=1).min()
            if max(first, second) < reach:
                found += each.members
        return found
