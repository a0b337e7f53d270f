"""Hidden corners of a solid, found where lines meet that visible corners lack.

A corner of a solid has three lines at least. One at the border of the drawing that shows two lacks
a line that goes behind, along a direction of other lines; a line that ends on the middle of another
goes on behind it. Two such lines meet in a hidden corner, from which a third one goes on, until no
corner lacks a line (Varley & Martin, *A system for constructing boundary representation solid
models from a two-dimensional sketch*, 2000, complete the hidden part alike). Corners of four lines,
and those that no such line leads to, are not found. Lengths are shares of the diagonal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.graph.planar_embedding import (
    Ring,
    components,
    embedded_faces,
    neighbors_of,
)
from bozzetto_polyhedron.reconstruction.affine_depth import affine_depth
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.outline import Outline
from bozzetto_polyhedron.reconstruction.parallel_classes import ParallelClasses, parallel_classes
from bozzetto_polyhedron.reconstruction.visible_regions import Junctions

MOST_CORNERS: Final = 6
"""Hidden corners that are looked for."""

MOST_STEPS: Final = 3000
"""Partial completions that are looked at."""

MOST_FOUND: Final = 12
"""Completions after which the search ends."""

MOST_TRIED: Final = 60
"""Completions of which it is asked whether they can be."""

MOST_DIRECTIONS: Final = 4
"""Directions, those of most ink first, that a missing line may have."""

LEAST_TURN: Final = 0.15
"""Sine of the angle between lines on the sheet below which no corner is where they cross."""

DEEPER: Final = 2.5
"""Distance in depth within which lines meet, in those on the sheet."""

LEAST_LINE: Final = 0.03
"""Shortest hidden line."""


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
class _Lack:
    """A line that a corner lacks: of one of some classes, from a place (x, y, depth).

    `line` is the line of the drawing that goes on, and `slot` its end; -1 for a new one. `sense` is
    +1 or -1 where the line goes on one way along its class, and 0 otherwise.
    """

    corner: int
    place: tuple[float, float, float]
    classes: tuple[int, ...]
    line: int = -1
    slot: int = 0
    sense: int = 0


@dataclass(frozen=True)
class _State:
    """Lacks that are left, and what was made: hidden corners, lines, new ends of drawn lines."""

    lacks: tuple[_Lack, ...]
    corners: tuple[tuple[float, float, float], ...] = ()
    lines: tuple[tuple[int, int], ...] = ()
    moved: tuple[tuple[int, int, int], ...] = ()


def with_hidden_corners(
    drawing: Drawing,
    junctions: Junctions,
    faces: Sequence[tuple[Ring, ...]],
    outline: Outline,
    reach: float,
    can_be: Callable[[Whole], bool],
) -> list[Whole]:
    """Return whole solids with the fewest hidden corners, and those with one more.

    Parameters
    ----------
    drawing : Drawing
        Corners and visible lines, parallel.
    junctions : Junctions
        Ends of lines that go behind others.
    faces : sequence of tuple of Ring
        Visible faces.
    outline : Outline
        Of the drawing, which hides all that is missing.
    reach : float
        Distance within which places are one.
    can_be : callable
        Whether a whole is a solid that shows what was drawn.
    """
    search = _Search.of(drawing, junctions, faces, outline, reach)
    start = _State(search.lacks())
    if not start.lacks:
        return []
    found: list[Whole] = []
    tried: set[frozenset[tuple[float, ...]]] = set()
    for count in range(MOST_CORNERS + 1):
        before = len(found)
        for whole in search.completions(start, count):
            lines = whole.key
            if lines in tried:
                continue
            tried.add(lines)
            if can_be(whole):
                found.append(whole)
            if len(found) >= MOST_FOUND or len(tried) >= MOST_TRIED:
                return found
        if before or search.steps > MOST_STEPS:
            break
    return found


@dataclass(eq=False)
class _Search:
    """State of the search: what is known of the drawing, and the number of steps so far."""

    drawing: Drawing
    junctions: Junctions
    labels: Index
    ways: Array
    """Classes' directions with their slopes, (c, 3); nan where no depth is told."""
    order: list[int]
    space: Array
    """Corners with depths, (n, 3); nan where none is told."""
    outline: Outline
    reach: float
    steps: int = 0

    @classmethod
    def of(
        cls,
        drawing: Drawing,
        junctions: Junctions,
        faces: Sequence[tuple[Ring, ...]],
        outline: Outline,
        reach: float,
    ) -> _Search:
        classes = parallel_classes(drawing)
        depths = _depths(drawing, classes, faces)
        rise = depths[drawing.lines[:, 1]] - depths[drawing.lines[:, 0]]
        along = (drawing.spans * classes.directions[classes.labels]).sum(1)
        slopes = np.full(len(classes.directions), np.nan)
        for name in range(len(slopes)):
            told = (classes.labels == name) & np.isfinite(rise)
            if told.any():
                weights = np.abs(along[told])
                slopes[name] = (rise[told] * along[told]).sum() / max((weights**2).sum(), 1e-12)
        ink = np.bincount(classes.labels, drawing.lengths, len(slopes))
        return cls(
            drawing,
            junctions,
            classes.labels,
            np.column_stack((classes.directions, slopes)),
            np.argsort(-ink, kind="stable").tolist(),
            np.column_stack((drawing.points, depths)),
            outline,
            reach,
        )

    def lacks(self) -> tuple[_Lack, ...]:
        """Return what corners of the drawing lack: lines that go on behind others come first."""
        found, rest = [], []
        for corner in range(len(self.drawing.points)):
            here = np.flatnonzero((self.drawing.lines == corner).any(1)).tolist()
            place = tuple(self.space[corner].tolist())
            if len(here) == 1:
                slot = int(self.drawing.lines[here[0], 1] == corner)
                name = int(self.labels[here[0]])
                span = self.drawing.spans[here[0]] * (1.0 if slot else -1.0)
                sense = 1 if span @ self.ways[name, :2] > 0.0 else -1
                found.append(_Lack(-1, place, (name,), here[0], slot, sense))
            elif len(here) == 2:
                rest.append(_Lack(corner, place, self._others([int(self.labels[k]) for k in here])))
        return (*found, *rest)

    def _others(self, names: Sequence[int]) -> tuple[int, ...]:
        return tuple(k for k in self.order if k not in names)[:MOST_DIRECTIONS]

    def completions(self, state: _State, left: int) -> Iterator[Whole]:
        """Yield wholes with so many more hidden corners."""
        self.steps += 1
        if self.steps > MOST_STEPS:
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

    def _continued(self, state: _State, left: int) -> list[_State]:
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

    def _hits(self, lack: _Lack, name: int, other: _Lack) -> bool:
        """Whether a line that a corner lacks leads to another corner that lacks one."""
        off = np.subtract(other.place, lack.place)
        way = self.ways[name]
        run = float(off[:2] @ way[:2])
        if not self._may_run(lack, run) or abs(off[0] * way[1] - off[1] * way[0]) > self.reach:
            return False
        deep = abs(off[2] - run * way[2])
        middle = (np.array(lack.place[:2]) + other.place[:2]) / 2.0
        return not deep > DEEPER * self.reach and self.outline.covers(middle)

    def _may_run(self, lack: _Lack, run: float) -> bool:
        if lack.sense:
            return run * lack.sense > -self.reach
        return abs(run) > LEAST_LINE

    def _meeting(self, one: _Lack, name: int, two: _Lack, other: int) -> Array | None:
        """Return the place where lines of two lacks meet inside the outline, (3,)."""
        way, across = self.ways[name], self.ways[other]
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
        self, first: _Lack, name: int, other: _Lack, others: Sequence[_Lack]
    ) -> Iterator[tuple[Array, list[tuple[_Lack, int]]]]:
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

    def _passes(self, lack: _Lack, name: int, place: Array) -> bool:
        """Whether a line of a lack runs through a place."""
        off = place - lack.place
        way = self.ways[name]
        run = float(off[:2] @ way[:2])
        beside = abs(off[0] * way[1] - off[1] * way[0]) > self.reach
        deep = abs(off[2] - run * way[2]) > DEEPER * self.reach
        return self._may_run(lack, run) and not beside and not deep

    def _joined(self, state: _State, first: _Lack, other: _Lack, rest: tuple[_Lack, ...]) -> _State:
        if first.line >= 0:
            moved = (*state.moved, (first.line, first.slot, other.corner))
            return replace(state, lacks=rest, moved=moved)
        return replace(state, lacks=rest, lines=(*state.lines, (first.corner, other.corner)))

    def _met(
        self,
        state: _State,
        first: _Lack,
        name: int,
        place: Array,
        partners: list[tuple[_Lack, int]],
    ) -> _State:
        corner = len(self.drawing.points) + len(state.corners)
        here = [(first, name), *partners]
        spot = (float(place[0]), float(place[1]), float(place[2]))
        gone = {id(each[0]) for each in here}
        lacks = tuple(each for each in state.lacks if id(each) not in gone)
        if len(here) < 3:
            lacks = (*lacks, _Lack(corner, spot, self._others([each[1] for each in here])))
        lines = [(lack.corner, corner) for lack, _ in here if lack.line < 0]
        moved = [(lack.line, lack.slot, corner) for lack, _ in here if lack.line >= 0]
        return _State(lacks, (*state.corners, spot), (*state.lines, *lines), (*state.moved, *moved))

    def _whole(self, state: _State) -> Whole:
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


def _depths(drawing: Drawing, classes: ParallelClasses, faces: Sequence[tuple[Ring, ...]]) -> Array:
    """Return depths of the largest part, as spread as the sheet; nan where none is told."""
    depths = np.full(len(drawing.points), np.nan)
    parts = components(neighbors_of(drawing.lines))
    part = max(parts, key=len)
    known = [rings for rings in faces if all(set(ring) <= set(part) for ring in rings)]
    if len(part) < 5:
        return depths
    found = affine_depth(drawing, classes, part, known)
    if found.basis.shape[1] == 1:
        members = list(part)
        spread = np.std(drawing.points[members]) / max(float(np.std(found.depths[members])), 1e-12)
        depths[members] = found.depths[members] * spread
    return depths
