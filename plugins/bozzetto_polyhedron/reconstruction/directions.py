"""Directions in space of the lines of a drawing, and those in which hidden faces meet.

Two lines that meet in a hidden corner lie in one face; each has another one at its side. The third
line of the corner is where these two meet, in whatever direction that is: a hidden corner is where
three planes meet. Depths are affine, and so is all that is told of directions here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.graph.planar_embedding import Ring, components, neighbors_of
from bozzetto_polyhedron.reconstruction.affine_depth import affine_depth
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.parallel_classes import ParallelClasses, parallel_classes

MOST_DIRECTIONS: Final = 4
"""Directions, those of most ink first, that a missing line may have."""

SHORT: Final = 1e-9
"""Length on the sheet below which a direction is that of the eye."""

SAME_WAY: Final = 0.12
"""Difference of directions, and half that of slopes, up to which they are one."""

SAME_PLANE: Final = 0.15
"""Sine of the angle between a line and a plane up to which it lies in it."""


@dataclass(eq=False)
class Directions:
    """Classes of parallel lines with their slopes, to which new ones are added."""

    labels: Index
    """Class of each line."""
    ways: Array
    """Directions of classes with their slopes, (c, 3); nan where no depth is told."""
    order: list[int]
    """Classes of drawn lines, those of most ink first."""
    space: Array
    """Corners of the drawing with depths, (n, 3); nan where none is told."""

    @classmethod
    def of(cls, drawing: Drawing, faces: Sequence[tuple[Ring, ...]]) -> Directions:
        """Return the directions of a drawing.

        Parameters
        ----------
        drawing : Drawing
            Corners and visible lines, parallel.
        faces : sequence of tuple of Ring
            Visible faces, which lie in planes.
        """
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
            classes.labels,
            np.column_stack((classes.directions, slopes)),
            np.argsort(-ink, kind="stable").tolist(),
            np.column_stack((drawing.points, depths)),
        )

    def others(self, names: Sequence[int]) -> tuple[int, ...]:
        """Return classes that a line may have which is of none of some."""
        return tuple(k for k in self.order if k not in names)[:MOST_DIRECTIONS]

    def thirds(
        self, one: int, sides: Sequence[int], two: int, beside: Sequence[int]
    ) -> tuple[int, ...]:
        """Return classes of the line in which the faces meet that two lines do not share.

        Where no slopes are told, or nothing is known of the faces, it may have any but theirs.

        Parameters
        ----------
        one, two : int
            Classes of the lines.
        sides, beside : sequence of int
            Of each, classes of a line in either of its faces; empty where they are not known.
        """
        made: list[int] = []
        for shared, own in permutations(sides, 2):
            for common, alone in permutations(beside, 2):
                first, second = self.ways[one], self.ways[two]
                normals = np.cross((first, second), self.ways[[own, alone]])
                way = np.cross(*normals)
                flat = np.cross(first, second)
                off = max(_slant(flat, self.ways[each]) for each in (shared, common))
                if not off < SAME_PLANE or not np.hypot(*way[:2]) > SHORT:
                    continue
                third = self._named(way)
                if third not in (*made, one, two):
                    made.append(third)
        return tuple(made) or self.others((one, two))

    def _named(self, way: Array) -> int:
        """Return the class of a direction with its slope, a new one where there is none."""
        length = float(np.hypot(*way[:2]))
        way = way / max(length, SHORT) * (1.0 if way[0] > 0.0 else -1.0)
        signs = np.where(self.ways[:, 0] > 0.0, 1.0, -1.0)
        off = np.abs(self.ways * signs[:, None] - way)
        near = (off[:, :2].max(1) < SAME_WAY) & (off[:, 2] < 2.0 * SAME_WAY)
        if near.any():
            return int(near.argmax())
        self.ways = np.vstack((self.ways, way))
        return len(self.ways) - 1


def _slant(normal: Array, way: Array) -> float:
    """Return the sine of the angle between a plane of a normal and a way, 0 where it has none."""
    size = float(np.linalg.norm(normal) * np.linalg.norm(way))
    return abs(float(normal @ way)) / size if not size < SHORT else 0.0


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
