"""What a drawing of visible lines lacks, what was made of it, and what it becomes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Index


@dataclass(frozen=True, eq=False)
class Whole:
    """Corners (n, 2) and lines (m, 2) of a whole solid in the picture."""

    points: Array
    lines: Index

    @property
    def key(self) -> frozenset[tuple[float, ...]]:
        """What is the same for wholes of the same lines: where these lie."""
        middles = self.points[self.lines].mean(axis=1)
        return frozenset(map(tuple, np.round(middles, 3).tolist()))


@dataclass(frozen=True)
class Lack:
    """A line that a corner lacks: of one of some classes, from a place (x, y, depth).

    `line` is the line of the drawing that goes on, and `slot` its end; -1 for a new one. `sense` is
    +1 or -1 where the line goes on one way along its class, and 0 otherwise. `sides` are classes of
    other lines of the two faces that meet in it, as far as they are known.
    """

    corner: int
    place: tuple[float, float, float]
    classes: tuple[int, ...]
    line: int = -1
    slot: int = 0
    sense: int = 0
    sides: tuple[int, ...] = ()


@dataclass(frozen=True)
class State:
    """Lacks that are left, and what was made: hidden corners, lines, new ends of drawn lines."""

    lacks: tuple[Lack, ...]
    corners: tuple[tuple[float, float, float], ...] = ()
    lines: tuple[tuple[int, int], ...] = ()
    moved: tuple[tuple[int, int, int], ...] = ()
    later: int = 0

    @property
    def key(self) -> tuple[object, ...]:
        """What is the same for states that go on alike."""
        lacks = frozenset((each.corner, each.line, each.slot, each.classes) for each in self.lacks)
        return lacks, frozenset(self.lines), frozenset(self.moved)
