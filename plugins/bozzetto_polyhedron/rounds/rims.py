"""Rims of cylinders in a line drawing.

In a parallel view a circle is seen as an ellipse whose shorter axis is the image of its normal,
and circles of one size and direction as the same ellipse, moved. So a rim of which only a part is
drawn, or all in dashes, is found as a whole ellipse moved along its shorter axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.rounds.ellipses import TURN, Ellipse, even_samples, whole_ellipse
from bozzetto_polyhedron.rounds.ink_left import LEAST_SHIFT, MOST_ARCS, REACH, InkLeft
from bozzetto_polyhedron.rounds.round_things import Barrel, Rim

ALIKE: Final = 1.3
"""Largest ratio of the axes of two rims of one size."""

ASIDE: Final = 0.3
"""Largest share of the shift between two rims across their shorter axis; a hand errs by 2 %."""

NEARLY_ROUND: Final = 0.88
"""Ratio of axes above which the shorter one says nothing about where its circle looks."""

SEEN: Final = 0.2
"""Least share of a rim that is drawn, where the other one of its cylinder is drawn whole."""

LEAST_TANGENT: Final = 0.45
"""Share of the line between two rims, tangent to both, from which it is drawn."""

TANGENT_REACH: Final = 1.4
"""Distance within which ink is tangent to both, in reaches: what is tangent to which place is hard
to see."""

BEYOND: Final = 0.1
"""How far beyond both rims the side of a cylinder may be drawn, in lengths of it."""

DASH_REACH: Final = 0.012
"""Distance, in diagonals, within which dashes lie on one line."""

GAP: Final = 0.35
"""Largest gap between two halves of an ellipse, in extents of the longer one."""

MOST_RIMS: Final = 24
"""Whole ellipses that are looked for: each may be the template of another rim."""


class Rims:
    """Rims that are found, and which two are of one cylinder.

    Parameters
    ----------
    ink_left : InkLeft
        Strokes that become rims, or sides of cylinders, are spoken for.
    """

    def __init__(self, ink_left: InkLeft) -> None:
        self._ink = ink_left
        self.rims: list[Rim] = []
        self.barrels: list[Barrel] = []
        self._find_whole()
        self._find_pairs()
        for number in range(len(self.rims)):
            if self.rims[number].is_whole and not any(
                number in (barrel.near, barrel.far) for barrel in self.barrels
            ):
                self._find_others(number)

    def _find_whole(self) -> None:
        """Find ellipses that one stroke draws, or two; what lies over one of them is part of it."""
        for number in sorted(self._ink.curved):
            if number in self._ink.left and len(self.rims) < MOST_RIMS:
                found = whole_ellipse([self._ink.paths[number]], self._ink.evidence)
                if found is not None:
                    self._add_whole(found, [number])
        open_ones = [number for number in sorted(self._ink.curved) if number in self._ink.left][
            :MOST_ARCS
        ]
        pairs = []
        for one, other in combinations(open_ones, 2):
            if self._may_close(one, other):
                paths = [self._ink.paths[one], self._ink.paths[other]]
                found = whole_ellipse(paths, self._ink.evidence)
                if found is not None:
                    off = np.abs(found.distances(even_samples(paths))).mean() / found.radius
                    pairs.append((float(off), one, other, found))
        for _, one, other, found in sorted(pairs, key=lambda each: each[:3]):
            if {one, other} <= self._ink.left and len(self.rims) < MOST_RIMS:
                self._add_whole(found, [one, other])

    def _may_close(self, one: int, other: int) -> bool:
        """Whether two strokes go on from one another at both ends, or over one another."""
        shorter, longer = sorted((one, other), key=lambda k: float(self._ink.samples.lengths[k]))
        ends, path = self._ink.paths[shorter][[0, -1]], self._ink.paths[longer]
        gaps = np.linalg.norm(ends[:, None] - path, axis=2).min(axis=1)
        return bool(gaps.max() < GAP * np.linalg.norm(np.ptp(path, axis=0)))

    def _add_whole(self, ellipse: Ellipse, numbers: list[int]) -> None:
        self._ink.take(numbers)
        curve = ellipse.at(np.linspace(0.0, TURN, 73))
        parts = self._ink.parts_of(curve)
        also = self._ink.without_rows(
            self._ink.samples.lying_along(curve, parts, 0.6 * self._ink.reach(ellipse), 0.9)
        )
        own = self._ink.take([*numbers, *also])
        self.rims.append(Rim(ellipse, own, True, self._ink.mostly_light(own)))

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
                bool(tangents) and not self._ink.mostly_light(tangents)
            )
            self._ink.take(tangents)
            self.barrels.append(Barrel(near, far, tuple(tangents), outside))

    def _is_before(self, one: int, other: int) -> bool:
        """Whether the first of two whole rims is the near one: the firm one, else the upper one."""
        first, second = self.rims[one], self.rims[other]
        if first.light != second.light:
            return second.light
        return bool(first.ellipse.center[1] <= second.ellipse.center[1])

    def _is_along_normal(self, ellipse: Ellipse, shift: Array) -> bool:
        length = float(np.linalg.norm(shift))
        if length < LEAST_SHIFT * self._ink.size:
            return False
        long, short = ellipse.lengths
        if short > NEARLY_ROUND * long:
            return True
        aside = abs(float(shift @ ellipse.axes[0])) / long
        return bool(aside < max(ASIDE * length, 1.5 * self._ink.reach(ellipse)))

    def _tangents(self, ellipse: Ellipse, shift: Array) -> list[int]:
        """Return the strokes that are left and lie on the lines tangent to two rims."""
        found: list[int] = []
        wide = TANGENT_REACH * min(
            REACH * self._ink.size, 0.4 * float(np.linalg.norm(ellipse.axes[0]))
        )
        length = float(np.linalg.norm(shift))
        straight = [number for number in sorted(self._ink.left) if number not in self._ink.curved]
        short = [number for number in straight if self._ink.samples.lengths[number] < 0.5 * length]
        long = [number for number in straight if self._ink.samples.lengths[number] >= 0.5 * length]
        tight = DASH_REACH * self._ink.size
        for line in tangent_lines(ellipse, shift):
            side = line[0] + np.linspace(-BEYOND, 1.0 + BEYOND, 72)[:, None] * shift
            here = self._ink.samples.lying_along(side, long, wide)
            if not here and short:
                across = np.array((-shift[1], shift[0])) / length
                steps = np.arange(-wide, wide + 0.5 * tight, 0.5 * tight)
                best = max(
                    steps,
                    key=lambda step: (
                        self._ink.samples.covered(side + step * across, short, tight)
                        - 0.2 * abs(step) / wide
                    ),
                )
                here = self._ink.without_rows(
                    self._ink.samples.lying_along(side + best * across, short, tight, 0.9)
                )
                here = [k for k in self._one_row(here, line) if self._is_between(k, line)]
                side = side + best * across
            if here and self._ink.samples.covered(side, here, wide) >= LEAST_TANGENT:
                found += here
        return sorted(set(found))

    def _is_between(self, number: int, line: Array) -> bool:
        """Whether a dash lies between both rims: a dashed edge may go on where a side ends."""
        along = line[1] - line[0]
        shares = (self._ink.paths[number] - line[0]) @ along / float(along @ along)
        return bool(shares.min() > -BEYOND and shares.max() < 1.0 + BEYOND)

    def _one_row(self, numbers: Sequence[int], line: Array) -> list[int]:
        """Return strokes with no more than one row of dashes: that which ends as a line does."""
        rows: dict[int, list[int]] = {}
        for number in numbers:
            if number in self._ink.row_of:
                rows.setdefault(self._ink.row_of[number], []).append(number)
        if len(rows) < 2:
            return list(numbers)

        def off(members: list[int]) -> float:
            points = np.concatenate([self._ink.paths[k][[0, -1]] for k in members])
            return float(np.linalg.norm(line[:, None] - points, axis=2).min(axis=1).sum())

        kept = min(rows.values(), key=off)
        return [k for k in numbers if k not in self._ink.row_of or k in kept]

    def _find_others(self, number: int) -> None:
        """Find what is drawn of the other rim of a cylinder, where it is not drawn whole."""
        rim = self.rims[number]
        ellipse, reach = rim.ellipse, self._ink.reach(rim.ellipse)
        curve = ellipse.at(np.linspace(0.0, TURN, 72, endpoint=False))
        parts = self._ink.parts_of(curve)
        for shift in self._ink.samples.shifts(curve, parts, reach):
            if not self._is_along_normal(ellipse, shift):
                continue
            moved = curve + shift
            own = self._ink.without_rows(self._ink.samples.lying_along(moved, parts, 1.25 * reach))
            if not own or self._ink.samples.covered(moved, own, 1.25 * reach) < SEEN:
                continue
            if not any(k in self._ink.curved for k in own) and not self._tangents(ellipse, shift):
                continue
            strokes = self._ink.take(own)
            tangents = self._tangents(ellipse, shift)
            self._ink.take(tangents)
            far = ellipse.moved(shift)
            firm = [k for k in strokes if not self._ink.light[k]]
            if firm:
                away = ellipse.distances(self._ink.samples.points[self._ink.samples.of(firm)])
                outside = bool(np.median(away) > 0.0)
            else:
                outside = bool(tangents) and not self._ink.mostly_light(tangents)
            self.rims.append(Rim(far, strokes, False, self._ink.mostly_light(strokes)))
            barrel = Barrel(number, len(self.rims) - 1, tuple(tangents), outside)
            self.barrels.append(barrel)
            return


def tangent_lines(ellipse: Ellipse, shift: Array) -> Array:
    """Return the two lines tangent to an ellipse and to its copy, (2, 2, 2) px."""
    x, y = ellipse.unit(ellipse.center + shift[None])[0]
    across = np.array((-y, x)) / max(float(np.hypot(x, y)), 1e-12) @ ellipse.axes
    begin = ellipse.center + np.array((across, -across))
    return np.stack((begin, begin + shift), axis=1)
