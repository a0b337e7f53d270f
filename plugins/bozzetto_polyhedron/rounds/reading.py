"""What of a line drawing is round: rims, the two rims of a cylinder, and rounded corners.

In a parallel view a circle is seen as an ellipse whose shorter axis is the image of its normal, and
circles of one size and direction as the same ellipse, moved. So a rim of which only a part is drawn,
or all in dashes, is found as a whole ellipse moved along its shorter axis.
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
from bozzetto_polyhedron.rounds.ink_samples import InkSamples, directions, ink_samples

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

GOES_ON: Final = np.cos(np.radians(35.0))
"""Cosine of the angle within which it does."""

TURNED_BACK: Final = np.cos(np.radians(30.0))
"""Cosine of the angle between two lines within which the arc between them is a half turn."""

COPIED: Final = 0.5
"""Least share of the copy of an arc that is drawn."""


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
    light : (s,) bool
        Which strokes were drawn lightly.
    size : float
        Diagonal of the drawing, px.
    """

    rims: tuple[Rim, ...]
    barrels: tuple[Barrel, ...]
    bends: tuple[Bend, ...]
    light: Flags
    size: float

    @property
    def strokes(self) -> frozenset[int]:
        """Strokes that are no edge: rims, sides of cylinders, arcs."""
        rims = [number for rim in self.rims for number in rim.strokes]
        sides = [number for barrel in self.barrels for number in barrel.tangents]
        bends = [number for bend in self.bends for number in bend.strokes]
        return frozenset((*rims, *sides, *bends))


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
    if not curved:
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
        self.light = _light(strokes, self.ink.lengths)
        self.curved = curved
        self.left = set(range(len(paths)))
        self.rims: list[Rim] = []
        self.barrels: list[Barrel] = []
        self.bends: list[Bend] = []

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
        if not self.rims and not self.bends:
            return None
        return Reading(
            tuple(self.rims), tuple(self.barrels), tuple(self.bends), self.light, self.size
        )

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
        for one, other in combinations(open_ones, 2):
            if one in self.left and other in self.left and len(self.rims) < MOST_RIMS:
                ends = self.paths[one][[0, -1]], self.paths[other][[0, -1]]
                gaps = np.linalg.norm(ends[0][:, None] - ends[1], axis=2).min(axis=1)
                extent = np.linalg.norm(np.ptp(self.paths[one], axis=0))
                if gaps.max() > 0.4 * extent:
                    continue
                found = whole_ellipse([self.paths[one], self.paths[other]], self.evidence)
                if found is not None:
                    self._add_whole(found, [one, other])

    def _add_whole(self, ellipse: Ellipse, numbers: list[int]) -> None:
        self._take(numbers)
        curve = ellipse.at(np.linspace(0.0, TURN, 73))
        also = self.ink.lying_along(curve, self._parts_of(curve), 0.6 * self._reach(ellipse), 0.9)
        own = self._take([*numbers, *also])
        self.rims.append(Rim(ellipse, own, True, self._mostly_light(own)))

    def _parts_of(self, curve: Array) -> list[int]:
        """Return the strokes that are left and may be a part of a curve: bent, or short."""
        length = float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum())
        return [
            number
            for number in sorted(self.left)
            if number in self.curved or self.ink.lengths[number] < SHORT * length
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
        return aside < max(ASIDE * length, 1.5 * self._reach(ellipse))

    def _tangents(self, ellipse: Ellipse, shift: Array) -> list[int]:
        """Return the strokes that are left and lie on the lines tangent to two rims."""
        found: list[int] = []
        reach = min(
            TANGENT_REACH * REACH * self.size, 0.45 * float(np.linalg.norm(ellipse.axes[0]))
        )
        straight = [number for number in sorted(self.left) if number not in self.curved]
        for line in tangent_lines(ellipse, shift):
            side = line[0] + np.linspace(0.0, 1.0, 60)[:, None] * (line[1] - line[0])
            here = self.ink.lying_along(side, straight, reach)
            if here and self.ink.covered(side, here, reach) >= LEAST_TANGENT:
                found += here
        return sorted(set(found))

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
            own = self.ink.lying_along(moved, parts, 1.25 * reach)
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
        arcs = [number for number in sorted(self.curved) if number in self.left][:MOST_ARCS]
        arcs.sort(key=lambda k: bool(self.light[k]))
        for number in arcs:
            if number in self.left:
                bend = self._bend(number)
                if bend is not None:
                    self._take(bend.strokes)
                    self.bends.append(bend)

    def _bend(self, number: int) -> Bend | None:
        arc = even_samples([self.paths[number]], 40)
        ways = directions(arc)
        turns = np.unwrap(np.arctan2(ways[:, 1], ways[:, 0]))
        if not LEAST_ARC < abs(turns[-3] - turns[2]) < MOST_ARC:
            return None
        lines = self._lines_at(arc, np.zeros(2))
        if lines is None or -1 in [stroke for stroke, _, _ in lines]:
            return None
        corners = _corners(arc, lines)
        if corners is None:
            return None
        parts = [k for k in self._parts_of(arc) if k != number]
        reach = min(REACH * self.size, 0.3 * float(np.linalg.norm(arc[-1] - arc[0])))
        best: tuple[float, Array, list[int]] | None = None
        for shift in self.ink.shifts(arc, parts, reach):
            if np.linalg.norm(shift) < LEAST_SHIFT * self.size:
                continue
            own = self.ink.lying_along(arc + shift, parts, 1.25 * reach)
            covered = self.ink.covered(arc + shift, own, 1.25 * reach) if own else 0.0
            support = self._edges_along(shift)
            if covered >= COPIED and support and (best is None or covered > best[0] + 0.15):
                best = covered, shift, own
        if best is None:
            return None
        _, shift, own = best
        behind = self._lines_at(arc, shift)
        if behind is None:
            return None
        places = [corners[min(k, len(corners) - 1)] for k in range(2)]
        ends = [(s, at, place) for (s, at, _), place in zip(lines, places, strict=True)]
        ends += [(s, at, place + shift) for (s, at, _), place in zip(behind, places, strict=True)]
        sides = self._sides_of(arc, shift, {s for s, _, _ in ends})
        light = bool(self.light[number]), self._mostly_light(own)
        strokes = tuple(sorted({number, *own, *sides}))
        return Bend(arc, corners, shift, tuple(ends), strokes, light)

    def _lines_at(self, arc: Array, shift: Array) -> list[tuple[int, Array, Array]] | None:
        """Return the lines that go on at both ends of an arc, or where it was moved to.

        Of each the number of its stroke, the end of the arc, and the direction away from it. Where
        the arc was moved, the number is −1 where dashes go on, and None is never returned.
        """
        ways = directions(arc)
        found = []
        moved = bool(shift.any())
        for end, way in ((arc[0], -ways[:4].mean(axis=0)), (arc[-1], ways[-4:].mean(axis=0))):
            way = way / np.linalg.norm(way)
            best: tuple[float, int, Array] | None = None
            for number in sorted(self.left - self.curved):
                if self.ink.lengths[number] < 0.5 * JOINS * self.size:
                    continue
                path = self.paths[number]
                for tip, other in ((path[0], path[-1]), (path[-1], path[0])):
                    span = other - tip
                    apart = float(np.linalg.norm(tip - end - shift))
                    if apart > JOINS * self.size or not np.linalg.norm(span) > 0.0:
                        continue
                    if span @ way > GOES_ON * np.linalg.norm(span) and (
                        best is None or apart < best[0]
                    ):
                        best = apart, number, span / np.linalg.norm(span)
            if best is None and not moved:
                return None
            number, direction = (-1, way) if best is None else best[1:]
            found.append((number, end + shift, direction))
        return found

    def _edges_along(self, shift: Array) -> bool:
        """Whether a straight stroke is as long as a shift and runs along it."""
        length = float(np.linalg.norm(shift))
        for number in self.left - self.curved:
            span = self.paths[number][-1] - self.paths[number][0]
            along = abs(float(span @ shift)) / length
            if along > 0.5 * length and along > 0.97 * np.linalg.norm(span):
                return True
        rows = self.ink.of(self.left - self.curved)
        ways = self.ink.along[rows]
        running = np.abs(ways @ (shift / length)) > 0.97
        return bool(running.sum() * self.size / 160.0 > 0.5 * length)

    def _sides_of(self, arc: Array, shift: Array, kept: set[int]) -> list[int]:
        """Return straight strokes from one arc to the other: no edge, for the body is smooth."""
        straight = [k for k in sorted(self.left - self.curved) if k not in kept]
        reach = REACH * self.size
        length = float(np.linalg.norm(shift))
        found = []
        for number in straight:
            path = self.paths[number]
            span = path[-1] - path[0]
            extent = float(np.linalg.norm(span))
            if extent < 0.6 * length or abs(float(span @ shift)) < 0.93 * extent * length:
                continue
            ends = (path[0], path[-1]) if span @ shift > 0 else (path[-1], path[0])
            first = np.linalg.norm(arc - ends[0], axis=1).min()
            second = np.linalg.norm(arc + shift - ends[1], axis=1).min()
            if max(first, second) < 1.4 * reach:
                found.append(number)
        return found


def tangent_lines(ellipse: Ellipse, shift: Array) -> Array:
    """Return the two lines tangent to an ellipse and to its copy, (2, 2, 2) px."""
    x, y = ellipse.unit(ellipse.center + shift[None])[0]
    across = np.array((-y, x)) / max(float(np.hypot(x, y)), 1e-12) @ ellipse.axes
    begin = ellipse.center + np.array((across, -across))
    return np.stack((begin, begin + shift), axis=1)


def _corners(arc: Array, lines: list[tuple[int, Array, Array]]) -> Array | None:
    """Return where the lines at both ends of an arc would meet, or the corners of a square end."""
    (_, first, one), (_, second, other) = lines
    if float(one @ other) > TURNED_BACK:
        forward = -(one + other)
        forward = forward / np.linalg.norm(forward)
        across = second - first
        system = np.column_stack((forward, across))
        if abs(float(np.linalg.det(system))) < 0.2 * np.linalg.norm(across):
            return None
        reached = float(np.linalg.solve(system, (arc - first).T)[0].max())
        return np.stack((first + reached * forward, second + reached * forward))
    system = np.column_stack((one, -other))
    if abs(float(np.linalg.det(system))) < np.sin(np.radians(15.0)):
        return None
    back, _ = np.linalg.solve(system, second - first)
    corner = first + back * one
    ahead = float((corner - second) @ other)
    return corner[None] if back < 0.0 and ahead < 0.0 else None


def _light(strokes: Sequence[Stroke], lengths: Array) -> Flags:
    """Return which strokes press less than most ink does."""
    pressure = np.array([float(np.mean(stroke.pressure)) for stroke in strokes])
    order = np.argsort(pressure, kind="stable")
    ink = np.cumsum(lengths[order])
    if not ink[-1] > 0.0:
        return np.zeros(len(pressure), bool)
    firm = float(pressure[order][min(int(np.searchsorted(ink, 0.75 * ink[-1])), len(order) - 1)])
    return np.asarray(pressure < LIGHT_PRESSURE * firm)
