"""Open boxes: flaps that hang at the lines of a solid, which has no face where they hang.

A corner of a solid has three lines or more. Corners of two lines in a row, between two corners that
a line joins, are the free side of a flap; that line is its fold. What is left without flaps is
read as a solid, and no line lies between three faces: so faces between which flaps hang are open.
How far a flap is turned about its fold no face tells. Its sides are taken for square to the fold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.planar_embedding import (
    Neighbors,
    Ring,
    embedded_faces,
    neighbors_of,
    shared_pairs,
)
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing, drawing_of
from bozzetto_polyhedron.reconstruction.regularity import area_vector

MOST_OPENINGS: Final = 3
"""Faces of a solid that are left out so that its flaps may hang."""

EXPECTED: Final = ("corner of two lines", "crossing")
"""What health finds at the free corners of flaps, which may well be seen on other lines."""

UPWARDS: Final = 0.2
"""Logarithm of the reach of a flap over that of the face it covers, which counts as much as whether
the face looks up or aside: boxes open upwards, and a lid covers what is open."""

LEVEL: Final = 1e-4
"""Square of a slope, below which a fold that lies in the sheet tells nothing of its flap."""


@dataclass(frozen=True)
class OpenBox:
    """A solid with flaps.

    Parameters
    ----------
    flaps : tuple of Ring
        Each from one end of its fold to the other, those that hang at other flaps behind these.
    openings : tuple of tuple of Ring
        Each the faces of the solid that may be open together.
    """

    flaps: tuple[Ring, ...]
    openings: tuple[tuple[Ring, ...], ...]

    @property
    def free(self) -> frozenset[int]:
        """Corners of two lines: those of flaps away from their folds."""
        return frozenset(corner for flap in self.flaps for corner in flap[1:-1])

    def solid(self, drawing: Drawing) -> Drawing:
        """Return the drawing without its flaps, all its lines alike."""
        kept = ~np.isin(drawing.lines, list(self.free)).any(axis=1)
        return replace(drawing, lines=drawing.lines[kept], light=np.zeros(int(kept.sum())))

    def faces(self, space: Array, solid: Sequence[Rings]) -> tuple[Rings, ...]:
        """Return the faces of the solid that are there, and the flaps.

        Parameters
        ----------
        space : (n, 3) array
            All corners: x right, y up, and their depths.
        solid : sequence of Rings
            All faces of the solid.
        """
        middle = space[[corner for face in solid for corner in face[0]]].mean(axis=0)
        best = min(self.openings, key=lambda rings: self._doubt(space, middle, rings))
        left_out = {frozenset(ring) for ring in best}
        walls = (face for face in solid if frozenset(face[0]) not in left_out)
        return (*walls, *((flap,) for flap in self.flaps))

    def _doubt(self, space: Array, middle: Array, rings: Sequence[Ring]) -> float:
        """Return how little flaps would cover some open faces, less how much these look upwards."""
        doubt = 0.0
        for ring in rings:
            normal = area_vector(space[list(ring)])
            upwards = abs(float(normal[1])) / max(float(np.linalg.norm(normal)), 1e-12)
            above = np.sign(space[list(ring), 1].mean() - middle[1])
            doubt -= UPWARDS * float(above) * upwards
            for flap in self.flaps:
                if _has(ring, frozenset((flap[0], flap[-1]))):
                    reaches = [_reach(space, flap, each) for each in (flap, ring)]
                    doubt += min(1.0, abs(float(np.log(reaches[0] / reaches[1]))))
        return doubt

    def depths(self, points: Array, solid: Array) -> Array:
        """Return the depths of all corners, (n,), from those of the solid.

        Parameters
        ----------
        points : (n, 2) array
            Corners on the sheet.
        solid : (n,) array
            Depths; those of the free corners of flaps do not count.
        """
        found = np.array(solid, float)
        for flap in self.flaps:
            free = list(flap[1:-1])
            ends = found[flap[0]], found[flap[-1]]
            along = points[flap[-1]] - points[flap[0]]
            rise, length = ends[1] - ends[0], float(along @ along)
            across = np.array((-along[1], along[0]))
            level, aside = 0.0, LEVEL * length**2
            for end, corner in ((flap[0], flap[1]), (flap[-1], flap[-2])):
                side = points[corner] - points[end]
                slope = rise * float(side @ across)
                level -= slope * float(side @ along) * (1.0 + rise**2 / length)
                aside += slope**2
            spans = points[free] - points[flap[0]]
            turned = level / aside
            found[free] = ends[0] + (spans @ along) * rise / length + turned * (spans @ across)
        return found


def open_box(drawing: Drawing) -> OpenBox | None:
    """Return the flaps of a drawing in one piece; None without any, or no solid under them."""
    rest = neighbors_of(drawing.lines)
    flaps: list[Ring] = []
    while (flap := _flap(rest)) is not None:
        flaps.append(flap)
        for corner in flap[1:-1]:
            for other in rest.pop(corner):
                rest.get(other, set()).discard(corner)
    if not flaps or min(map(len, rest.values())) < 3:
        return None
    solid = embedded_faces(rest)
    if solid is None or shared_pairs(solid):
        return None
    folds = {frozenset((flap[0], flap[-1])) for flap in flaps}
    crowded = [fold for fold in folds if sum(_has(ring, fold) for ring in (*solid, *flaps)) > 2]
    for count in range(MOST_OPENINGS + 1):
        fitting = tuple(
            opening
            for opening in combinations(solid, count)
            if all(any(_has(ring, fold) for ring in opening) for fold in crowded)
        )
        if fitting:
            return OpenBox(tuple(reversed(flaps)), fitting)
    return None


def without_findings_at_flaps(graph: LineGraph) -> LineGraph:
    """Return a graph whose health does not ask for lines at the free corners of flaps."""
    if all(each.what not in EXPECTED for each in graph.health):
        return graph
    box = open_box(drawing_of(graph))
    if box is None:
        return graph
    free = {tuple(graph.places[corner].tolist()) for corner in box.free}
    health = tuple(
        each for each in graph.health if each.what not in EXPECTED or tuple(each.place) not in free
    )
    return replace(graph, health=health)


def _flap(rest: Neighbors) -> Ring | None:
    """Return a row of corners of two lines with the two joined corners at its ends."""
    for start in sorted(rest):
        if len(rest[start]) < 3:
            continue
        for following in sorted(rest[start]):
            row = [start, following]
            while len(rest[row[-1]]) == 2:
                row.append(next(iter(rest[row[-1]] - {row[-2]})))
            if len(row) > 2 and row[-1] != start and row[-1] in rest[start]:
                return tuple(row)
    return None


def _has(ring: Ring, line: frozenset[int]) -> bool:
    return any(line == {one, other} for one, other in zip(ring, ring[1:] + ring[:1], strict=True))


def _reach(space: Array, flap: Ring, ring: Ring) -> float:
    """Return how far a face reaches from the fold of a flap."""
    fold = space[flap[-1]] - space[flap[0]]
    spans = space[list(ring)] - space[flap[0]]
    away = np.linalg.norm(np.cross(spans, fold), axis=1) / max(float(np.linalg.norm(fold)), 1e-12)
    return max(float(away.max()), 1e-9)
