"""Ink of a line drawing that nothing round speaks for yet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.ink import Stroke
from bozzetto_polyhedron.graph.segments import LIGHT_PRESSURE
from bozzetto_polyhedron.rounds.ellipses import Ellipse
from bozzetto_polyhedron.rounds.ends import LineEnd, both_ends
from bozzetto_polyhedron.rounds.ink_samples import InkSamples, ink_samples
from bozzetto_polyhedron.rounds.straight_rows import DASH, FEWEST_DASHES, rows_of_dashes

Evidence = Literal["clear", "all", "none"]

REACH: Final = 0.028
"""Distance within which ink belongs to a curve, in diagonals: two ends at one corner are 1 to 2 %
apart."""

LEAST_SHIFT: Final = 0.03
"""Least distance of two rims of one cylinder, in diagonals."""

MOST_ARCS: Final = 24
"""Arcs that are looked at."""

FEWEST: Final = 5
"""Samples of the shortest stroke that may be round."""

OF_RADIUS: Final = 0.3
"""The same at most, in shorter half axes."""

SHORT: Final = 0.35
"""Length up to which a straight stroke may be a dash of a curve, in lengths of that."""

OF_ROW: Final = 0.6
"""Share of a row of dashes that lies along a curve for all of it to be part of that: a dash of a
rim may lie in the row of a line that touches it."""

BOW: Final = 0.045
"""Least height of an arc, in lengths of its chord."""

LEAST_BOW: Final = 0.005
"""The same in diagonals: hands bow lines by 0.6 %."""


class InkLeft:
    """Strokes of one drawing, and which of them are spoken for.

    Parameters
    ----------
    strokes : sequence of Stroke
        Of one view.
    paths : list of (n, 2) array
        Their points, px.
    size : float
        Diagonal of the drawing, px.
    curved : set of int
        Strokes that are plainly curved.
    evidence : {"clear", "all", "none"}
        How much reading something as round needs.
    """

    def __init__(
        self,
        strokes: Sequence[Stroke],
        paths: list[Array],
        size: float,
        curved: set[int],
        evidence: Evidence,
    ) -> None:
        self.paths, self.size, self.evidence = paths, size, evidence
        self.samples: InkSamples = ink_samples(paths, size)
        self.light = _light(strokes, self.samples.lengths, size)
        self.curved = curved
        self.bowed = {k for k in range(len(paths)) if k not in curved and is_bowed(paths[k], size)}
        self.row_of = rows_of_dashes(paths, self.samples.lengths, size)
        self.left = set(range(len(paths)))

    def without_rows(self, numbers: Sequence[int]) -> list[int]:
        """Return strokes without dashes of which most of the row is not among them.

        Of a row that mostly is, all dashes are.
        """
        kept = {number for number in numbers if number not in self.row_of}
        for row in {self.row_of[number] for number in numbers if number in self.row_of}:
            members = [k for k, each in self.row_of.items() if each == row and k in self.left]
            if len(set(members) & set(numbers)) >= OF_ROW * len(members):
                kept |= set(members)
        return sorted(kept)

    def take(self, numbers: Sequence[int]) -> tuple[int, ...]:
        """Speak for strokes, and return them in order."""
        self.left -= set(numbers)
        return tuple(sorted(set(numbers)))

    def reach(self, ellipse: Ellipse) -> float:
        """Return the distance within which ink belongs to an ellipse, px."""
        return min(REACH * self.size, OF_RADIUS * float(ellipse.lengths[1]))

    def parts_of(self, curve: Array) -> list[int]:
        """Return the strokes that are left and may be a part of a curve: bent, or short."""
        length = float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum())
        return [
            number
            for number in sorted(self.left)
            if number in self.curved
            or number in self.bowed
            or self.samples.lengths[number] < SHORT * length
        ]

    def mostly_light(self, numbers: Sequence[int]) -> bool:
        """Return whether strokes are drawn as what is hidden, by their length."""
        rows = list(numbers)
        ink = self.samples.lengths[rows]
        return bool(ink[self.light[rows]].sum() > 0.5 * ink.sum())

    def straight(self) -> list[LineEnd]:
        """Return both ends of every straight stroke that is left, and of every row of dashes."""
        found = []
        for number in sorted(self.left - self.curved):
            if number not in self.row_of and self.samples.lengths[number] >= DASH * self.size:
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


def is_bowed(path: Array, size: float) -> bool:
    """Whether a stroke leaves its chord by more than lines of most hands do."""
    chord = path[-1] - path[0]
    length = float(np.linalg.norm(chord))
    if not length > 0.0:
        return False
    away = path - path[0]
    height = float(np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0]).max()) / length
    return height > max(BOW * length, LEAST_BOW * size)


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
