"""Hidden corners of a solid, found where lines meet that visible corners lack.

A corner of a solid has three lines at least. One at the border of the drawing that shows two lacks
a line that goes behind, along a direction of other lines; a line that ends on the middle of another
goes on behind it. Two such lines meet in a hidden corner, from which a third one goes on, until no
corner lacks a line (Varley & Martin, *A system for constructing boundary representation solid
models from a two-dimensional sketch*, 2000, complete the hidden part alike). Where nothing is found
so, a line may wait for a corner that others find, and the third line of a corner is where two faces
meet (`directions`). Corners of four lines, and those that no such line leads to, are not found.
Lengths are shares of the diagonal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.planar_embedding import (
    Ring,
    components,
    embedded_faces,
    neighbors_of,
)
from bozzetto_polyhedron.reconstruction.directions import Directions
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.missing_lines import Lack, State, Whole
from bozzetto_polyhedron.reconstruction.outline import Outline

MOST_CORNERS: Final = 6
"""Hidden corners that are looked for."""

MOST_STEPS: Final = 3000
"""Partial completions that are looked at."""

MOST_WAITING_STEPS: Final = 6000
"""The same where lines wait for corners that others find."""

MOST_FOUND: Final = 12
"""Completions that are found at most."""

MOST_TRIED: Final = 60
"""Completions of which it is asked whether they can be."""

MOST_LATER: Final = 2
"""Lines in a row that may wait for corners which others find."""

LEAST_TURN: Final = 0.15
"""Sine of the angle between lines on the sheet below which no corner is where they cross."""

DEEPER: Final = 2.5
"""Distance in depth within which lines meet, in those on the sheet."""

LEAST_LINE: Final = 0.03
"""Shortest hidden line."""


def with_hidden_corners(
    drawing: Drawing,
    faces: Sequence[tuple[Ring, ...]],
    outline: Outline,
    reach: float,
    misfit: Callable[[Whole], float],
    *,
    waiting: bool,
) -> list[Whole]:
    """Return whole solids with the fewest hidden corners, and those with one more.

    Parameters
    ----------
    drawing : Drawing
        Corners and visible lines, parallel.
    faces : sequence of tuple of Ring
        Visible faces.
    outline : Outline
        Of the drawing, which hides all that is missing.
    reach : float
        Distance within which places are one.
    misfit : callable
        Share of its lines that a whole shows otherwise than they were drawn; 1 if it cannot be.
        Those of the least come first.
    waiting : bool
        Whether a line may wait for a corner that others find; which takes long.
    """
    search = _Search(drawing, Directions.of(drawing, faces), outline, reach)
    start = State(search.lacks())
    if not start.lacks:
        return []
    if waiting:
        search.wait(start.lacks)
    return _found(search, start, misfit)


def _found(search: _Search, start: State, misfit: Callable[[Whole], float]) -> list[Whole]:
    """Return wholes that can be: a search ends one corner after the first, if it comes so far."""
    found: list[tuple[float, Whole]] = []
    tried: set[frozenset[tuple[float, ...]]] = set()
    for count in search.counts(start):
        before = len(found)
        for whole in search.completions(start, count):
            if whole.key in tried:
                continue
            tried.add(whole.key)
            off = misfit(whole)
            found += [(off, whole)] if off < 1.0 else []
            if len(tried) == MOST_TRIED:
                break
        if before or search.steps > search.most_steps or len(tried) == MOST_TRIED:
            break
    found.sort(key=lambda each: each[0])
    return [whole for _, whole in found[:MOST_FOUND]]


@dataclass(eq=False)
class _Search:
    """State of the search: what is known of the drawing, and the number of steps so far."""

    drawing: Drawing
    directions: Directions
    outline: Outline
    reach: float
    waiting: bool = False
    steps: int = 0
    seen: set[tuple[object, ...]] = field(default_factory=set)
    lone: frozenset[Lack] = frozenset()
    """Where lines wait, those of the drawing that lead to no other corner of it."""
    hits: dict[tuple[Lack, int, Lack], bool] = field(default_factory=dict)
    met: dict[tuple[Lack, int, Lack, int], Array | None] = field(default_factory=dict)

    def lacks(self) -> tuple[Lack, ...]:
        """Return what corners of the drawing lack: lines that go on behind others come first."""
        found, rest = [], []
        for corner in range(len(self.drawing.points)):
            here = np.flatnonzero((self.drawing.lines == corner).any(1)).tolist()
            place = tuple(self.directions.space[corner].tolist())
            if len(here) == 1:
                slot = int(self.drawing.lines[here[0], 1] == corner)
                name = int(self.directions.labels[here[0]])
                span = self.drawing.spans[here[0]] * (1.0 if slot else -1.0)
                sense = 1 if span @ self.directions.ways[name, :2] > 0.0 else -1
                origin = int(self.drawing.lines[here[0], 1 - slot])
                sides = self._sides(origin, here[0])
                found.append(Lack(-1, place, (name,), here[0], slot, sense, sides))
            elif len(here) == 2:
                sides = self._sides(corner, -1)
                rest.append(Lack(corner, place, self.directions.others(sides), sides=sides))
        return (*found, *rest)

    def wait(self, lacks: Sequence[Lack]) -> None:
        """Let lines wait for corners that others find."""
        self.waiting = True
        self.lone = frozenset(
            one
            for one in lacks
            if not any(
                name in other.classes
                and (self._hits(one, name, other) or self._hits(other, name, one))
                for other in lacks
                if other is not one
                for name in one.classes
            )
        )

    @property
    def most_steps(self) -> int:
        """Partial completions that are looked at."""
        return MOST_WAITING_STEPS if self.waiting else MOST_STEPS

    def counts(self, start: State) -> range:
        """Return the numbers of hidden corners that are sought, one after the other.

        Each has three lines, so the number is odd if that of lacking lines is.
        """
        if not self.waiting:
            return range(MOST_CORNERS + 1)
        return range(len(start.lacks) % 2, MOST_CORNERS + 1, 2)

    def _may_end(self, state: State, left: int) -> bool:
        """Whether hidden corners have ends enough for lines that lead to no other corner."""
        drawn = len(self.drawing.points)
        ends = 3 * left + sum(each.corner >= drawn for each in state.lacks)
        return sum(each in self.lone for each in state.lacks) <= ends

    def _sides(self, corner: int, line: int) -> tuple[int, ...]:
        """Return the classes of two lines of a corner beside one, where it has just these."""
        here = np.flatnonzero((self.drawing.lines == corner).any(1)).tolist()
        names = tuple(int(self.directions.labels[k]) for k in here if k != line)
        return names if len(names) == 2 else ()

    def completions(self, state: State, left: int) -> Iterator[Whole]:
        """Yield wholes with so many more hidden corners."""
        key = (left, state.later, state.lacks[0] if state.lacks else None, state.key)
        self.steps += 1
        if self.steps > self.most_steps or key in self.seen:
            return
        self.seen.add(key)
        if self.waiting and not self._may_end(state, left):
            return
        if not state.lacks:
            if left == 0:
                whole = self._whole(state)
                neighbors = neighbors_of(whole.lines)
                if len(components(neighbors)) > 1 or embedded_faces(neighbors) is not None:
                    yield whole
            return
        for after in self._continued(state, left):
            yield from self.completions(after, left - len(after.corners) + len(state.corners))
        if self.waiting and state.later < min(MOST_LATER, len(state.lacks) - 1):
            turned = (*state.lacks[1:], state.lacks[0])
            yield from self.completions(replace(state, lacks=turned, later=state.later + 1), left)

    def _continued(self, state: State, left: int) -> list[State]:
        """Return the ways in which the first lack can end."""
        first, others = state.lacks[0], state.lacks[1:]
        joined, met = [], []
        for name in first.classes:
            for number, other in enumerate(others):
                rest = others[:number] + others[number + 1 :]
                if other.corner >= 0 and name in other.classes and self._hits(first, name, other):
                    joined.append(self._joined(state, first, other, rest))
                elif left:
                    met += [
                        self._met(state, first, name, place, partners)
                        for place, partners in self._meetings(first, name, other, others)
                    ]
        met.sort(key=lambda each: len(each.lacks))
        return [*joined, *met]

    def _hits(self, lack: Lack, name: int, other: Lack) -> bool:
        """Whether a line that a corner lacks leads to another corner that lacks one."""
        key = (lack, name, other)
        if key not in self.hits:
            self.hits[key] = self._leads(lack, name, other)
        return self.hits[key]

    def _leads(self, lack: Lack, name: int, other: Lack) -> bool:
        off = np.subtract(other.place, lack.place)
        way = self.directions.ways[name]
        run = float(off[:2] @ way[:2])
        if not self._may_run(lack, run) or abs(off[0] * way[1] - off[1] * way[0]) > self.reach:
            return False
        deep = abs(off[2] - run * way[2])
        middle = (np.array(lack.place[:2]) + other.place[:2]) / 2.0
        return not deep > DEEPER * self.reach and self.outline.covers(middle)

    def _may_run(self, lack: Lack, run: float) -> bool:
        if lack.sense:
            return run * lack.sense > -self.reach
        return abs(run) > LEAST_LINE

    def _meeting(self, one: Lack, name: int, two: Lack, other: int) -> Array | None:
        """Return the place where lines of two lacks meet inside the outline, (3,)."""
        key = (one, name, two, other)
        if key not in self.met:
            self.met[key] = self._crossing(*key)
        return self.met[key]

    def _crossing(self, one: Lack, name: int, two: Lack, other: int) -> Array | None:
        way, across = self.directions.ways[name], self.directions.ways[other]
        turn = float(way[0] * across[1] - way[1] * across[0])
        if abs(turn) < LEAST_TURN:
            return None
        off = np.subtract(two.place, one.place)
        run = float(off[0] * across[1] - off[1] * across[0]) / turn
        back = float(off[0] * way[1] - off[1] * way[0]) / turn
        if not (self._may_run(one, run) and self._may_run(two, back)):
            return None
        found = np.array(one.place) + run * way
        deep = two.place[2] + back * across[2]
        if abs(found[2] - deep) > DEEPER * self.reach:
            return None
        found[2] = (
            deep if np.isnan(found[2]) else found[2] if np.isnan(deep) else (found[2] + deep) / 2
        )
        middles = (found[:2] + np.array((one.place[:2], two.place[:2]))) / 2.0
        covered = all(map(self.outline.covers, (found[:2], *middles)))
        return found if covered else None

    def _meetings(
        self, first: Lack, name: int, other: Lack, others: Sequence[Lack]
    ) -> Iterator[tuple[Array, list[tuple[Lack, int]]]]:
        """Yield places where two lines meet, with all that meet there, and with these two."""
        for across in other.classes:
            if across == name:
                continue
            place = self._meeting(first, name, other, across)
            if place is None:
                continue
            pair = [(other, across)]
            more = list(pair)
            for third in others:
                taken = {name, *(each[1] for each in more)}
                if third is other:
                    continue
                for again in third.classes:
                    if again not in taken and self._passes(third, again, place):
                        more.append((third, again))
                        break
            if len(more) > 1:
                yield place, more
            else:
                yield place, pair

    def _passes(self, lack: Lack, name: int, place: Array) -> bool:
        """Whether a line of a lack runs through a place."""
        off = place - lack.place
        way = self.directions.ways[name]
        run = float(off[:2] @ way[:2])
        beside = abs(off[0] * way[1] - off[1] * way[0]) > self.reach
        deep = abs(off[2] - run * way[2]) > DEEPER * self.reach
        return self._may_run(lack, run) and not beside and not deep

    def _joined(self, state: State, first: Lack, other: Lack, rest: tuple[Lack, ...]) -> State:
        if first.line >= 0:
            moved = (*state.moved, (first.line, first.slot, other.corner))
            return replace(state, lacks=rest, moved=moved, later=0)
        return replace(
            state, lacks=rest, lines=(*state.lines, (first.corner, other.corner)), later=0
        )

    def _met(
        self,
        state: State,
        first: Lack,
        name: int,
        place: Array,
        partners: list[tuple[Lack, int]],
    ) -> State:
        corner = len(self.drawing.points) + len(state.corners)
        here = [(first, name), *partners]
        spot = (float(place[0]), float(place[1]), float(place[2]))
        gone = {id(each[0]) for each in here}
        lacks = tuple(each for each in state.lacks if id(each) not in gone)
        if len(here) < 3:
            (one, name), (two, across) = here
            ways = self.directions
            thirds = (
                ways.thirds(name, one.sides, across, two.sides)
                if self.waiting
                else ways.others((name, across))
            )
            lacks = (*lacks, Lack(corner, spot, thirds, sides=(name, across)))
        lines = [(lack.corner, corner) for lack, _ in here if lack.line < 0]
        moved = [(lack.line, lack.slot, corner) for lack, _ in here if lack.line >= 0]
        return State(lacks, (*state.corners, spot), (*state.lines, *lines), (*state.moved, *moved))

    def _whole(self, state: State) -> Whole:
        """Return the drawing with what was made, without ends that lie nowhere any more."""
        lines = self.drawing.lines.copy()
        for line, slot, corner in state.moved:
            lines[line, slot] = corner
        added = np.array(state.lines, np.intp).reshape(-1, 2)
        lines = np.unique(np.sort(np.concatenate((lines, added)), axis=1), axis=0)
        hidden = np.array(state.corners).reshape(-1, 3)[:, :2]
        points = np.concatenate((self.drawing.points, hidden))
        kept, numbers = np.unique(lines, return_inverse=True)
        return Whole(points[kept], numbers.reshape(-1, 2).astype(np.intp))
