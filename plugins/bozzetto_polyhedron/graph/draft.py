"""Lines between corners as they are while they are searched for, and what a change would cost."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field, replace
from typing import Final

from bozzetto_polyhedron.graph.grouping import Members
from bozzetto_polyhedron.graph.likelihood import (
    FEW_LINES,
    SAME_ENDS,
    End,
    Fits,
    Line,
    corner_cost,
    passing_cost,
    place_of,
)
from bozzetto_polyhedron.graph.planar_embedding import is_whole, neighbors_of

NOTHING: Final[End] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Sums over no ends."""

NOT_WHOLE: Final = 12.0
"""Cost of lines that fall apart in two corners, or cannot be drawn without crossings: of 108 solids
12 do, but of their graphs that came out wrong 13 of 16."""

CROWDED: Final = 4
"""Lines at a corner from which on it may be a place that lines pass."""


@dataclass(frozen=True)
class Joined:
    """A line and the numbers of the corners at its start and its stop."""

    line: Line
    start: int
    stop: int

    @property
    def pair(self) -> tuple[int, int]:
        """Both corners, the smaller number first."""
        return (self.start, self.stop) if self.start < self.stop else (self.stop, self.start)

    def angle_at(self, corner: int) -> float:
        """Return where the line goes from one of its corners, radians."""
        return self.line.angles[0 if self.start == corner else 1]


@dataclass(frozen=True)
class Change:
    """Lines that go and lines that come instead.

    Parameters
    ----------
    removed : tuple of int
        Keys of lines.
    added : tuple of Joined
        New lines.
    dropped : tuple of int
        Segments that become stray marks.
    """

    removed: tuple[int, ...]
    added: tuple[Joined, ...]
    dropped: Members = ()


@dataclass(eq=False)
class Draft:
    """Lines and corners, changed in place by `apply`.

    Parameters
    ----------
    fits : Fits
        Lines through segments.
    """

    fits: Fits
    lines: dict[int, Joined] = field(default_factory=dict)
    sums: dict[int, End] = field(default_factory=dict)
    degrees: dict[int, int] = field(default_factory=dict)
    costs: dict[int, float] = field(default_factory=dict)
    pairs: dict[tuple[int, int], list[int]] = field(default_factory=dict)
    around: dict[int, list[int]] = field(default_factory=dict)
    dropped: Members = ()
    cost: float = 0.0
    next_line: int = 0
    next_corner: int = 0

    def places(self) -> dict[int, tuple[float, float]]:
        """Return the places of corners by their numbers."""
        return {corner: place_of(sums) for corner, sums in self.sums.items()}

    def price(self, change: Change) -> float:
        """Return by how much a change raises the cost; infinite if it is impossible."""
        if any(each.start == each.stop for each in change.added):
            return float("inf")
        return self._priced(change, self._after(change), {})

    def _priced(
        self, change: Change, after: dict[int, tuple[End, int]], costs: dict[int, float]
    ) -> float:
        """Return the price of a change, and put the costs of corners after it into `costs`."""
        total = self.fits.tick_cost(change.dropped) if change.dropped else 0.0
        for each in change.added:
            total += each.line.misfit
        for key in change.removed:
            total -= self.lines[key].line.misfit
        before = self.costs
        for corner, (sums, degree) in after.items():
            cost = costs[corner] = corner_cost(sums, degree, self.fits.few)
            total += cost - before.get(corner, 0.0)
            if degree >= CROWDED:
                passing = self._passing_cost(corner, change)
                total += passing
                costs[corner] += passing
        return total + SAME_ENDS * self._more_pairs(change)

    def apply(self, change: Change) -> None:
        """Make a change that is possible."""
        after, costs = self._after(change), dict[int, float]()
        self.cost += self._priced(change, after, costs)
        for corner, (sums, degree) in after.items():
            if degree:
                self.sums[corner], self.degrees[corner] = sums, degree
                self.costs[corner] = costs[corner]
            else:
                self.sums.pop(corner, None)
                self.degrees.pop(corner, None)
                self.costs.pop(corner, None)
        for key in change.removed:
            gone = self.lines.pop(key)
            self.pairs[gone.pair].remove(key)
            for corner in {gone.start, gone.stop}:
                self.around[corner].remove(key)
        for each in change.added:
            self.lines[self.next_line] = each
            self.pairs.setdefault(each.pair, []).append(self.next_line)
            for corner in {each.start, each.stop}:
                self.around.setdefault(corner, []).append(self.next_line)
            self.next_line += 1
            self.next_corner = max(self.next_corner, each.start + 1, each.stop + 1)
        self.dropped = (*self.dropped, *change.dropped)

    def copied(self) -> Draft:
        """Return a draft that can be changed by itself."""
        return replace(
            self,
            lines=dict(self.lines),
            sums=dict(self.sums),
            degrees=dict(self.degrees),
            costs=dict(self.costs),
            pairs={pair: list(keys) for pair, keys in self.pairs.items()},
            around={corner: list(keys) for corner, keys in self.around.items()},
        )

    @property
    def is_whole(self) -> bool:
        """Whether its lines are those of solids, as far as which corners they join tells."""
        return is_whole(neighbors_of(pair for pair, keys in self.pairs.items() if keys))

    @property
    def loose(self) -> int:
        """Number of corners of one or two lines."""
        return sum(degree < 3 for degree in self.degrees.values())

    @property
    def doubt(self) -> float:
        """The cost, and more where the lines should be those of solids and are not."""
        parts = self.fits.few != FEW_LINES
        return self.cost + (0.0 if parts or self.is_whole else NOT_WHOLE)

    @property
    def meeting_ends(self) -> Hashable:
        """Which ends of lines meet in one corner, whatever the numbers of lines and corners."""
        ends: dict[int, set[tuple[Members, bool]]] = {}
        for each in self.lines.values():
            for corner, last in ((each.start, False), (each.stop, True)):
                ends.setdefault(corner, set()).add((each.line.members, last))
        return frozenset(map(frozenset, ends.values()))

    @property
    def groups(self) -> frozenset[Members]:
        """Which segments are one line."""
        return frozenset(each.line.members for each in self.lines.values())

    def fits_now(self, change: Change) -> bool:
        """Whether all lines that the change removes are still there."""
        return all(key in self.lines for key in change.removed)

    def at(self, corner: int) -> list[int]:
        """Return the keys of the lines at a corner."""
        return list(self.around.get(corner, ()))

    def _passing_cost(self, corner: int, change: Change) -> float:
        """Return the cost of lines that go straight on through a corner after a change."""
        lines, removed = self.lines, change.removed
        here = [lines[key] for key in self.around.get(corner, ()) if key not in removed]
        here += [each for each in change.added if corner in (each.start, each.stop)]
        return passing_cost([each.angle_at(corner) for each in here])

    def _after(self, change: Change) -> dict[int, tuple[End, int]]:
        """Return sums and degrees of the corners that a change concerns."""
        after: dict[int, tuple[End, int]] = {}
        for key in change.removed:
            each = self.lines[key]
            one, other = each.line.ends
            for corner, (p, q, r, s, t, u, v) in ((each.start, one), (each.stop, other)):
                (a, b, c, d, e, f, g), degree = after.get(corner) or self._now(corner)
                after[corner] = (a - p, b - q, c - r, d - s, e - t, f - u, g - v), degree - 1
        for each in change.added:
            one, other = each.line.ends
            for corner, (p, q, r, s, t, u, v) in ((each.start, one), (each.stop, other)):
                (a, b, c, d, e, f, g), degree = after.get(corner) or self._now(corner)
                after[corner] = (a + p, b + q, c + r, d + s, e + t, f + u, g + v), degree + 1
        return after

    def _now(self, corner: int) -> tuple[End, int]:
        """Return the sums over the ends at a corner, and their number."""
        return self.sums.get(corner, NOTHING), self.degrees.get(corner, 0)

    def _more_pairs(self, change: Change) -> int:
        """Return how many more lines share both corners with another one."""
        counts: dict[tuple[int, int], int] = {}
        for key in change.removed:
            pair = self.lines[key].pair
            counts[pair] = counts.get(pair, 0) - 1
        for each in change.added:
            pair = each.pair
            counts[pair] = counts.get(pair, 0) + 1
        more = 0
        for pair, step in counts.items():
            if step:
                before = len(self.pairs.get(pair, ()))
                more += max(0, before + step - 1) - max(0, before - 1)
        return more


def refitted(draft: Draft, fits: Fits) -> Draft:
    """Return the same lines and corners with other spreads of their ends.

    Parameters
    ----------
    draft : Draft
        Lines and corners.
    fits : Fits
        The same segments with another spread.
    """
    made = draft_of(
        fits,
        (
            Joined(fits.line(each.line.members), each.start, each.stop)
            for each in draft.lines.values()
        ),
    )
    made.dropped = draft.dropped
    made.cost += fits.tick_cost(draft.dropped)
    return made


def draft_of(fits: Fits, lines: Iterable[Joined]) -> Draft:
    """Start a draft from lines between numbered corners."""
    draft = Draft(fits)
    draft.apply(Change((), tuple(lines)))
    return draft
