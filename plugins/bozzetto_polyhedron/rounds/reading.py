"""What of a line drawing is round: rims, the two rims of a cylinder, and rounded corners.

In a parallel view a circle is seen as an ellipse whose shorter axis is the image of its normal,
and circles of one size and direction as the same ellipse, moved. So a rim of which only a part is
drawn, or all in dashes, is found as a whole ellipse moved along its shorter axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.ink import Stroke
from bozzetto_polyhedron.graph.segments import LIGHT_PRESSURE, is_curved
from bozzetto_polyhedron.rounds.ellipses import TURN, Ellipse, even_samples, whole_ellipse
from bozzetto_polyhedron.rounds.ends import (
    LineEnd,
    both_ends,
    corners_between,
    ends_of,
    line_at,
)
from bozzetto_polyhedron.rounds.ink_samples import InkSamples, directions, ink_samples
from bozzetto_polyhedron.rounds.straight_rows import DASH, FEWEST_DASHES, rows_of_dashes

Evidence = Literal["clear", "all", "none"]

REACH: Final = 0.028
"""Distance within which ink belongs to a curve, in diagonals: two ends at one corner are 1 to 2 %
apart."""

OF_RADIUS: Final = 0.3
"""The same at most, in shorter half axes."""

LEAST_SHIFT: Final = 0.03
"""Least distance of two rims of one cylinder, in diagonals."""

ALIKE: Final = 1.3
"""Largest ratio of the axes of two rims of one size."""

ASIDE: Final = 0.3
"""Largest share of the shift between two rims across their shorter axis; a hand errs by 2 %."""

NEARLY_ROUND: Final = 0.88
"""Ratio of axes above which the shorter one says nothing about where its circle looks."""

SEEN: Final = 0.2
"""Least share of a rim that is drawn, where the other one of its cylinder is drawn whole."""

SHORT: Final = 0.35
"""Length up to which a straight stroke may be a dash of a curve, in lengths of that."""

LEAST_TANGENT: Final = 0.45
"""Share of the line between two rims, tangent to both, from which it is drawn."""

TANGENT_REACH: Final = 1.4
"""Distance within which ink is tangent to both, in reaches: what is tangent to which place is hard
to see."""

DASH_REACH: Final = 0.012
"""Distance, in diagonals, within which dashes lie on one line."""

GAP: Final = 0.35
"""Largest gap between two halves of an ellipse, in extents of the longer one."""

OF_ROW: Final = 0.6
"""Share of a row of dashes that lies along a curve for all of it to be part of that: a dash of a
rim may lie in the row of a line that touches it."""

BOW: Final = 0.045
"""Least height of an arc, in lengths of its chord."""

LEAST_BOW: Final = 0.005
"""The same in diagonals: hands bow lines by 0.6 %."""

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

WIDE: Final = 0.045
"""Distance, in diagonals, within which single dashes belong to what is round."""

MOST_RIMS: Final = 24
"""Whole ellipses that are looked for: each may be the template of another rim."""

MOST_ARCS: Final = 24
"""Arcs that are looked at."""

FEWEST: Final = 5
"""Samples of the shortest stroke that may be round."""

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


@dataclass(frozen=True, eq=False)
class Rim:
    """A circle as it is seen.

    Parameters
    ----------
    ellipse : Ellipse
        px.
    strokes : tuple of int
        That draw it.
    is_whole : bool
        Whether it is drawn all round; otherwise it is known by the other rim of its cylinder.
    light : bool
        Whether it is drawn as what is hidden.
    """

    ellipse: Ellipse
    strokes: tuple[int, ...]
    is_whole: bool
    light: bool


@dataclass(frozen=True, eq=False)
class Barrel:
    """Two rims of a cylinder.

    Parameters
    ----------
    near, far : int
        Numbers of rims; the near one is drawn whole.
    tangents : tuple of int
        Strokes that are its sides as they are seen.
    outside : bool
        Whether it is seen from outside: what is drawn firmly of the far rim lies beside the near
        one, and not within.
    """

    near: int
    far: int
    tangents: tuple[int, ...]
    outside: bool


@dataclass(frozen=True, eq=False)
class Bend:
    """An arc between two lines, and the same on the other side of the body.

    Parameters
    ----------
    arc : (n, 2) float64
        px.
    corners : (1, 2) or (2, 2) float64
        Where the lines would meet; of a half turn, the corners of the square end in its place.
    shift : (2,) float64
        To the other side, px.
    ends : tuple of (stroke, place, corner)
        Lines that end at the arc, or at the other one: the number of the stroke, where the arc
        begins, and where the line would end, (2,) px each; a number of −1 for one in dashes.
    strokes : tuple of int
        Of both arcs, and of what is tangent to both.
    light : (bool, bool)
        Whether either side is drawn as what is hidden.
    """

    arc: Array
    corners: Array
    shift: Array
    ends: tuple[tuple[int, Array, Array], ...]
    strokes: tuple[int, ...]
    light: tuple[bool, bool]


@dataclass(frozen=True, eq=False)
class Reading:
    """What of a drawing is round.

    Parameters
    ----------
    rims : tuple of Rim
    barrels : tuple of Barrel
    bends : tuple of Bend
    dashes : frozenset of int
        Single dashes about what is round.
    straight : int
        How many straight strokes are left, and rows of dashes.
    light : (s,) bool
        Which strokes were drawn lightly.
    size : float
        Diagonal of the drawing, px.
    """

    rims: tuple[Rim, ...]
    barrels: tuple[Barrel, ...]
    bends: tuple[Bend, ...]
    dashes: frozenset[int]
    straight: int
    light: Flags
    size: float

    @property
    def strokes(self) -> frozenset[int]:
        """Strokes that are no edge: rims, sides of cylinders, arcs."""
        rims = [number for rim in self.rims for number in rim.strokes]
        sides = [number for barrel in self.barrels for number in barrel.tangents]
        bends = [number for bend in self.bends for number in bend.strokes]
        return frozenset((*rims, *sides, *bends, *self.dashes))


def read(strokes: Sequence[Stroke], evidence: Evidence) -> Reading | None:
    """Return what of a drawing is round; None where nothing is."""
    if evidence == "none" or not strokes:
        return None
    paths = [np.asarray(stroke.points, float) for stroke in strokes]
    both = np.concatenate(paths)
    size = float(np.linalg.norm(np.ptp(both, axis=0)))
    if not size > 0.0:
        return None
    curved = {
        number
        for number, stroke in enumerate(strokes)
        if len(paths[number]) >= FEWEST and (is_curved(stroke, size) or _closes(paths[number]))
    }
    if not curved and not any(_is_bowed(path, size) for path in paths):
        return None
    return _Reader(strokes, paths, size, curved, evidence).read()


def _closes(path: Array) -> bool:
    """Whether a stroke goes about a place, back to where it began or beyond."""
    spokes = path - path.mean(axis=0)
    angles = np.unwrap(np.arctan2(spokes[:, 1], spokes[:, 0]))
    return bool(abs(angles[-1] - angles[0]) > 0.75 * TURN)


class _Reader:
    """One reading: strokes that are spoken for are no longer looked at."""

    def __init__(
        self,
        strokes: Sequence[Stroke],
        paths: list[Array],
        size: float,
        curved: set[int],
        evidence: Evidence,
    ) -> None:
        self.paths, self.size, self.evidence = paths, size, evidence
        self.ink: InkSamples = ink_samples(paths, size)
        self.light = _light(strokes, self.ink.lengths, size)
        self.curved = curved
        self.bowed = {k for k in range(len(paths)) if k not in curved and _is_bowed(paths[k], size)}
        self.row_of = rows_of_dashes(paths, self.ink.lengths, size)
        self.left = set(range(len(paths)))
        self.rims: list[Rim] = []
        self.barrels: list[Barrel] = []
        self.bends: list[Bend] = []
        self.swept: set[int] = set()

    def read(self) -> Reading | None:
        """Find rims, then the others of their cylinders, then rounded corners."""
        self._find_whole()
        self._find_pairs()
        for number in range(len(self.rims)):
            if self.rims[number].is_whole and not any(
                number in (barrel.near, barrel.far) for barrel in self.barrels
            ):
                self._find_others(number)
        self._find_bends()
        self._sweep()
        if not self.rims and not self.bends:
            return None
        return Reading(
            tuple(self.rims),
            tuple(self.barrels),
            tuple(self.bends),
            frozenset(self.swept),
            len(self._straight()) // 2,
            self.light,
            self.size,
        )

    def _sweep(self) -> None:
        """Take what is left of dashes that lie about what is round, in no straight row."""
        curves = [rim.ellipse.at(np.linspace(0.0, TURN, 73)) for rim in self.rims]
        for barrel in self.barrels:
            near, far = (self.rims[k].ellipse for k in (barrel.near, barrel.far))
            for line in tangent_lines(near, far.center - near.center):
                curves.append(line[0] + np.linspace(-0.1, 1.1, 60)[:, None] * (line[1] - line[0]))
        curves += [bend.arc + shift for bend in self.bends for shift in (0.0, bend.shift)]
        for curve in curves:
            loose = [
                k
                for k in sorted(self.left)
                if self.ink.lengths[k] < DASH * self.size and k not in self.row_of
            ]
            self.swept |= set(self._take(self.ink.lying_along(curve, loose, WIDE * self.size)))

    def _without_rows(self, numbers: Sequence[int]) -> list[int]:
        """Return strokes without dashes of which most of the row is not among them.

        Of a row that mostly is, all dashes are.
        """
        kept = {number for number in numbers if number not in self.row_of}
        for row in {self.row_of[number] for number in numbers if number in self.row_of}:
            members = [k for k, each in self.row_of.items() if each == row and k in self.left]
            if len(set(members) & set(numbers)) >= OF_ROW * len(members):
                kept |= set(members)
        return sorted(kept)

    def _take(self, numbers: Sequence[int]) -> tuple[int, ...]:
        self.left -= set(numbers)
        return tuple(sorted(set(numbers)))

    def _reach(self, ellipse: Ellipse) -> float:
        return min(REACH * self.size, OF_RADIUS * float(ellipse.lengths[1]))

    def _find_whole(self) -> None:
        """Find ellipses that one stroke draws, or two; what lies over one of them is part of it."""
        for number in sorted(self.curved):
            if number in self.left and len(self.rims) < MOST_RIMS:
                found = whole_ellipse([self.paths[number]], self.evidence)
                if found is not None:
                    self._add_whole(found, [number])
        open_ones = [number for number in sorted(self.curved) if number in self.left][:MOST_ARCS]
        pairs = []
        for one, other in combinations(open_ones, 2):
            if self._may_close(one, other):
                paths = [self.paths[one], self.paths[other]]
                found = whole_ellipse(paths, self.evidence)
                if found is not None:
                    off = np.abs(found.distances(even_samples(paths))).mean() / found.radius
                    pairs.append((float(off), one, other, found))
        for _, one, other, found in sorted(pairs, key=lambda each: each[:3]):
            if {one, other} <= self.left and len(self.rims) < MOST_RIMS:
                self._add_whole(found, [one, other])

    def _may_close(self, one: int, other: int) -> bool:
        """Whether two strokes go on from one another at both ends, or over one another."""
        shorter, longer = sorted((one, other), key=lambda k: float(self.ink.lengths[k]))
        ends, path = self.paths[shorter][[0, -1]], self.paths[longer]
        gaps = np.linalg.norm(ends[:, None] - path, axis=2).min(axis=1)
        return bool(gaps.max() < GAP * np.linalg.norm(np.ptp(path, axis=0)))

    def _add_whole(self, ellipse: Ellipse, numbers: list[int]) -> None:
        self._take(numbers)
        curve = ellipse.at(np.linspace(0.0, TURN, 73))
        parts = self._parts_of(curve)
        also = self._without_rows(
            self.ink.lying_along(curve, parts, 0.6 * self._reach(ellipse), 0.9)
        )
        own = self._take([*numbers, *also])
        self.rims.append(Rim(ellipse, own, True, self._mostly_light(own)))

    def _parts_of(self, curve: Array) -> list[int]:
        """Return the strokes that are left and may be a part of a curve: bent, or short."""
        length = float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum())
        return [
            number
            for number in sorted(self.left)
            if number in self.curved
            or number in self.bowed
            or self.ink.lengths[number] < SHORT * length
        ]

    def _mostly_light(self, numbers: Sequence[int]) -> bool:
        rows = list(numbers)
        ink = self.ink.lengths[rows]
        return bool(ink[self.light[rows]].sum() > 0.5 * ink.sum())

    def _find_pairs(self) -> None:
        """Find two whole rims of one cylinder: of one size, with a side of it, or one light."""
        whole = range(len(self.rims))
        taken: set[int] = set()
        for one, other in combinations(whole, 2):
            if one in taken or other in taken:
                continue
            first, second = self.rims[one], self.rims[other]
            ratios = first.ellipse.lengths / second.ellipse.lengths
            if max(ratios.max(), 1.0 / ratios.min()) > ALIKE:
                continue
            shift = second.ellipse.center - first.ellipse.center
            if not self._is_along_normal(first.ellipse, shift):
                continue
            tangents = self._tangents(first.ellipse, shift)
            if not tangents and first.light == second.light:
                continue
            taken |= {one, other}
            near, far = (one, other) if self._is_before(one, other) else (other, one)
            outside = not self.rims[far].light or (
                bool(tangents) and not self._mostly_light(tangents)
            )
            self._take(tangents)
            self.barrels.append(Barrel(near, far, tuple(tangents), outside))

    def _is_before(self, one: int, other: int) -> bool:
        """Whether the first of two whole rims is the near one: the firm one, else the upper one."""
        first, second = self.rims[one], self.rims[other]
        if first.light != second.light:
            return second.light
        return bool(first.ellipse.center[1] <= second.ellipse.center[1])

    def _is_along_normal(self, ellipse: Ellipse, shift: Array) -> bool:
        length = float(np.linalg.norm(shift))
        if length < LEAST_SHIFT * self.size:
            return False
        long, short = ellipse.lengths
        if short > NEARLY_ROUND * long:
            return True
        aside = abs(float(shift @ ellipse.axes[0])) / long
        return bool(aside < max(ASIDE * length, 1.5 * self._reach(ellipse)))

    def _tangents(self, ellipse: Ellipse, shift: Array) -> list[int]:
        """Return the strokes that are left and lie on the lines tangent to two rims."""
        found: list[int] = []
        wide = TANGENT_REACH * min(REACH * self.size, 0.4 * float(np.linalg.norm(ellipse.axes[0])))
        length = float(np.linalg.norm(shift))
        straight = [number for number in sorted(self.left) if number not in self.curved]
        short = [number for number in straight if self.ink.lengths[number] < 0.5 * length]
        long = [number for number in straight if self.ink.lengths[number] >= 0.5 * length]
        tight = DASH_REACH * self.size
        for line in tangent_lines(ellipse, shift):
            side = line[0] + np.linspace(-0.1, 1.1, 72)[:, None] * shift
            here = self.ink.lying_along(side, long, wide)
            if not here and short:
                across = np.array((-shift[1], shift[0])) / length
                steps = np.arange(-wide, wide + 0.5 * tight, 0.5 * tight)
                best = max(
                    steps,
                    key=lambda step: (
                        self.ink.covered(side + step * across, short, tight)
                        - 0.2 * abs(step) / wide
                    ),
                )
                here = self._without_rows(
                    self.ink.lying_along(side + best * across, short, tight, 0.9)
                )
                here = self._one_row(here, line)
                side = side + best * across
            if here and self.ink.covered(side, here, wide) >= LEAST_TANGENT:
                found += here
        return sorted(set(found))

    def _one_row(self, numbers: Sequence[int], line: Array) -> list[int]:
        """Return strokes with no more than one row of dashes: that which ends as a line does."""
        rows: dict[int, list[int]] = {}
        for number in numbers:
            if number in self.row_of:
                rows.setdefault(self.row_of[number], []).append(number)
        if len(rows) < 2:
            return list(numbers)

        def off(members: list[int]) -> float:
            points = np.concatenate([self.paths[k][[0, -1]] for k in members])
            return float(np.linalg.norm(line[:, None] - points, axis=2).min(axis=1).sum())

        kept = min(rows.values(), key=off)
        return [k for k in numbers if k not in self.row_of or k in kept]

    def _find_others(self, number: int) -> None:
        """Find what is drawn of the other rim of a cylinder, where it is not drawn whole."""
        rim = self.rims[number]
        ellipse, reach = rim.ellipse, self._reach(rim.ellipse)
        curve = ellipse.at(np.linspace(0.0, TURN, 72, endpoint=False))
        parts = self._parts_of(curve)
        for shift in self.ink.shifts(curve, parts, reach):
            if not self._is_along_normal(ellipse, shift):
                continue
            moved = curve + shift
            own = self._without_rows(self.ink.lying_along(moved, parts, 1.25 * reach))
            if not own or self.ink.covered(moved, own, 1.25 * reach) < SEEN:
                continue
            if not any(k in self.curved for k in own) and not self._tangents(ellipse, shift):
                continue
            strokes = self._take(own)
            tangents = self._tangents(ellipse, shift)
            self._take(tangents)
            far = ellipse.moved(shift)
            firm = [k for k in strokes if not self.light[k]]
            if firm:
                away = ellipse.distances(self.ink.points[self.ink.of(firm)])
                outside = bool(np.median(away) > 0.0)
            else:
                outside = bool(tangents) and not self._mostly_light(tangents)
            self.rims.append(Rim(far, strokes, False, self._mostly_light(strokes)))
            barrel = Barrel(number, len(self.rims) - 1, tuple(tangents), outside)
            self.barrels.append(barrel)
            return

    def _find_bends(self) -> None:
        """Find arcs between two lines, with the same arcs on the other side of the body."""
        bent = sorted(self.curved) + sorted(self.bowed)
        arcs = [number for number in bent if number in self.left][:MOST_ARCS]
        arcs.sort(key=lambda k: (bool(self.light[k]), k in self.bowed))
        for number in arcs:
            if number in self.left:
                bend = self._bend(number)
                if bend is not None:
                    self._take(bend.strokes)
                    if not self._is_known(bend):
                        self.bends.append(bend)

    def _is_known(self, bend: Bend) -> bool:
        """Whether another arc has rounded the same edge."""
        known = [each.corners + shift for each in self.bends for shift in (0.0, each.shift)]
        own = np.concatenate((bend.corners, bend.corners + bend.shift))
        return any(
            np.linalg.norm(own[:, None] - corners, axis=2).min() < JOINS * self.size
            for corners in known
        )

    def _bend(self, number: int) -> Bend | None:
        """Return the rounded corner or end that an arc is; None where it is neither.

        Where the other arc is, is told by its own ink, as much of it as is drawn, and by the lines
        that end there as they end at this one.
        """
        arc = even_samples([self.paths[number]], 40)
        ways = directions(arc)
        turns = np.unwrap(np.arctan2(ways[:, 1], ways[:, 0]))
        bowed = number in self.bowed
        if not bowed and not LEAST_ARC < abs(turns[-3] - turns[2]) < MOST_ARC:
            return None
        straight = [each for each in self._straight() if number not in each.members]
        lines = [line_at(straight, place, way, JOINS * self.size) for place, way in ends_of(arc)]
        if None in lines or lines[0] is lines[1]:
            return None
        first, second = (each for each in lines if each is not None)
        corners = corners_between(arc, first, second)
        if corners is None or (bowed and not self._is_as_round(arc, first, second)):
            return None
        parts = [k for k in self._parts_of(arc) if k != number]
        reach = min(REACH * self.size, 0.3 * float(np.linalg.norm(arc[-1] - arc[0])))
        rest = [each for each in straight if each.line is not first.line
                and each.line is not second.line]  # fmt: skip
        best: tuple[float, Array, list[int], list[LineEnd | None]] | None = None
        for shift in self._shifts(arc, (first, second), rest, parts, reach):
            if not self._edges_along(shift):
                continue
            own = self._without_rows(self.ink.lying_along(arc + shift, parts, 1.25 * reach))
            score = self.ink.covered(arc + shift, own, 1.25 * reach) if own else 0.0
            sure = not bowed or self._has_shift(shift)
            if bowed and score > UNDRAWN and not self._is_round_too(own, first, second):
                continue
            if not sure and (score < DRAWN or not self._is_as_round(arc, first, second, sure=True)):
                continue
            there: list[LineEnd | None] = []
            others = [each for each in rest if not set(each.members) & set(own)]
            for place, end in zip((arc[0], arc[-1]), (first, second), strict=True):
                left = [each for each in others if not there or each is not there[0]]
                there.append(line_at(left, place + shift, end.way, 0.8 * JOINS * self.size))
            if not sure and None in there:
                continue
            for place, line in zip((arc[0], arc[-1]), there, strict=True):
                if line is not None:
                    off = float(np.linalg.norm(line.place - place - shift))
                    score += LINE_THERE * (1.0 - 0.3 * off / (JOINS * self.size))
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
        own_light = self._mostly_light(own) if own else True
        light = bool(self.light[number]), own_light
        strokes = tuple(sorted({number, *own, *sides}))
        return Bend(arc, corners, shift, tuple(ends), strokes, light)

    def _has_shift(self, shift: Array) -> bool:
        """Whether a rounded edge was found that runs like this: others are likely then."""
        return any(
            min(np.linalg.norm(shift - each.shift), np.linalg.norm(shift + each.shift))
            < 2.0 * REACH * self.size
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
            sure and (meant < LEAST_MEANT * self.size or length < LEAST_CHORD * self.size)
        ):
            return False
        return abs(height - meant) < BOW_OFF * self.size

    def _is_round_too(self, own: Sequence[int], first: LineEnd, second: LineEnd) -> bool:
        """Whether the ink of the other arc is bent as well: that of a bevel is straight."""
        chord = float(np.linalg.norm(first.place - second.place))
        spans = {k: self.paths[k][[0, -1]] for k in own if k not in self.row_of}
        for row in {self.row_of[k] for k in own if k in self.row_of}:
            ends = np.concatenate(
                [self.paths[k][[0, -1]] for k in own if self.row_of.get(k) == row]
            )
            ends = ends[np.argsort(ends @ (second.place - first.place), kind="stable")]
            if float(np.linalg.norm(ends[-1] - ends[0])) > BEVEL * chord and not (
                self._is_as_round(ends, first, second)
            ):
                return False
        return all(
            k in self.curved
            or (
                k in self.bowed
                and self._is_as_round(self.paths[k], *self._turned(k, first, second))
            )
            for k, ends in spans.items()
            if float(np.linalg.norm(ends[1] - ends[0])) > BEVEL * chord
        )

    def _turned(self, number: int, first: LineEnd, second: LineEnd) -> tuple[LineEnd, LineEnd]:
        """Return the lines at an arc in the order in which another stroke beside it was drawn."""
        span = self.paths[number][-1] - self.paths[number][0]
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
        found = [*self.ink.shifts(arc, parts, reach), *(bend.shift for bend in self.bends)]
        for place, line in zip((arc[0], arc[-1]), lines, strict=True):
            for each in rest:
                if float(each.way @ line.way) > PARALLEL:
                    found.append(each.place - place)
        return [each for each in found if np.linalg.norm(each) > LEAST_SHIFT * self.size]

    def _straight(self) -> list[LineEnd]:
        """Return both ends of every straight stroke that is left, and of every row of dashes."""
        found = []
        for number in sorted(self.left - self.curved):
            if number not in self.row_of and self.ink.lengths[number] >= DASH * self.size:
                found += both_ends(number, self.paths[number][[0, -1]], (number,))
        for row in sorted(set(self.row_of.values())):
            members = [k for k, each in self.row_of.items() if each == row and k in self.left]
            if len(members) < 2:
                continue
            points = np.concatenate([self.paths[k][[0, -1]] for k in members])
            along = np.linalg.svd(points - points.mean(axis=0))[2][0]
            at = points @ along
            tips = points[[int(at.argmin()), int(at.argmax())]]
            found += both_ends(-1, tips, tuple(members))
        return found

    def _edges_along(self, shift: Array) -> bool:
        """Whether a straight stroke or a row of dashes is as long as a shift and runs along it.

        What is tangent to both arcs of another corner counts as well.
        """
        length = float(np.linalg.norm(shift))
        for number in set(range(len(self.paths))) - self.curved:
            span = self.paths[number][-1] - self.paths[number][0]
            along = abs(float(span @ shift)) / length
            if along > 0.5 * length and along > ALONG * np.linalg.norm(span):
                return True
        return any(
            abs(float(each.way @ shift)) > ALONG * length
            and np.linalg.norm(each.line[1] - each.line[0]) > 0.5 * length
            for each in self._straight()
        )

    def _sides_of(self, arc: Array, shift: Array, kept: set[int]) -> list[int]:
        """Return straight strokes from one arc to the other: no edge, for the body is smooth."""
        length = float(np.linalg.norm(shift))
        reach = 1.4 * REACH * self.size
        found: list[int] = []
        for each in self._straight()[::2]:
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


def _is_bowed(path: Array, size: float) -> bool:
    """Whether a stroke leaves its chord by more than lines of most hands do."""
    chord = path[-1] - path[0]
    length = float(np.linalg.norm(chord))
    if not length > 0.0:
        return False
    away = path - path[0]
    height = float(np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0]).max()) / length
    return height > max(BOW * length, LEAST_BOW * size)


def tangent_lines(ellipse: Ellipse, shift: Array) -> Array:
    """Return the two lines tangent to an ellipse and to its copy, (2, 2, 2) px."""
    x, y = ellipse.unit(ellipse.center + shift[None])[0]
    across = np.array((-y, x)) / max(float(np.hypot(x, y)), 1e-12) @ ellipse.axes
    begin = ellipse.center + np.array((across, -across))
    return np.stack((begin, begin + shift), axis=1)


def _light(strokes: Sequence[Stroke], lengths: Array, size: float) -> Flags:
    """Return which strokes press less than most ink does; where none does, which are dashes."""
    pressure = np.array([float(np.mean(stroke.pressure)) for stroke in strokes])
    order = np.argsort(pressure, kind="stable")
    ink = np.cumsum(lengths[order])
    if not ink[-1] > 0.0:
        return np.zeros(len(pressure), bool)
    firm = float(pressure[order][min(int(np.searchsorted(ink, 0.75 * ink[-1])), len(order) - 1)])
    light = np.asarray(pressure < LIGHT_PRESSURE * firm)
    dashes = (lengths > 0.0) & (lengths < DASH * size)
    return light if light.any() or dashes.sum() < FEWEST_DASHES else dashes
