"""Floors that later details lie on: places of a surface moved on to them, and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.geometry import Face
from bozzetto.plugin import cached_property
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.face_cuts import ring_of
from bozzetto_product.details.floor import Floor, Offset

if TYPE_CHECKING:
    import shapely

SLACK: Final = 0.02
"""Difference from its height, as share of it, at which a place of a surface is under a floor."""

ON: Final = 2e-3
"""Distance from a floor, as share of the size of its region, at which a place lies on it."""


@dataclass(frozen=True, eq=False)
class LaidFloor:
    """A floor as it was made, before later details were cut into it.

    Parameters
    ----------
    chart : Chart
        Its coordinates are the parameters of the floor.
    floor : Floor
    face : Face
        Within its loops.
    height : float
        Above what it is the offset of, mm; below that it is negative.
    base : callable
        Places of the chart to points and normals of what it is the offset of.
    """

    chart: Chart
    floor: Floor
    face: Face
    height: float
    base: Offset

    @cached_property
    def region(self) -> shapely.Polygon:
        """The region of the floor in its parameters."""
        import shapely

        outline, *holes = (ring_of(loop) for loop in self.face.loops)
        return shapely.Polygon(outline, holes)

    def lifted(self, points: Array, normals: Array) -> tuple[Array, Array, Flags]:
        """Return places of a surface and normals, moved on to the floor, and which were, (n,)."""
        import shapely

        at = self.chart.flat(points)
        over = np.flatnonzero(shapely.contains_xy(self.region, *at.T))
        found = np.zeros(len(points), bool)
        if not len(over):
            return points, normals, found
        surface = self.floor.surface
        there, up = surface.value(*at[over].T), surface.normals(*at[over].T)
        away = np.linalg.norm(there - points[over], axis=1)
        own = np.abs(away - abs(self.height)) <= SLACK * abs(self.height) + self.floor.deviation
        own &= (up * normals[over]).sum(axis=1) > 0.0
        found[over[own]] = True
        points, normals = points.copy(), normals.copy()
        points[found], normals[found] = there[own], up[own]
        return points, normals, found

    def lowered(self, points: Array) -> Array:
        """Return points, (n, 3), of which those on the floor are on what it is the offset of."""
        import shapely

        at = self.floor.nearest(points, self.chart.flat(points))
        low, high = np.array(self.region.bounds).reshape(2, 2)
        near = ON * float(np.linalg.norm(high - low))
        gaps = np.linalg.norm(self.floor.surface.value(*at.T) - points, axis=1)
        on = np.flatnonzero(gaps <= near + self.floor.deviation)
        on = on[shapely.contains_xy(self.region.buffer(near), *at[on].T)]
        base, _ = self.base(at[on])
        known = np.isfinite(base).all(axis=1)
        points = points.copy()
        points[on[known]] = base[known]
        return points


def on_floors(
    floors: Sequence[LaidFloor], points: Array, normals: Array, starts: Sequence[int]
) -> tuple[Array, Array, tuple[LaidFloor, ...]]:
    """Return places of surfaces and normals, those of outlines wholly over a floor moved on to it.

    And the floors on which outlines are, or through which they went to another one.

    Parameters
    ----------
    floors : sequence of LaidFloor
        In the order in which they were made: one may lie on another.
    points, normals : (n, 3) float
        On surfaces without details, mm.
    starts : sequence of int
        First place of each outline.
    """
    used: list[LaidFloor] = []
    which = np.repeat(np.arange(len(starts)), np.diff([*starts, len(points)]))
    for floor in floors:
        moved, up, found = floor.lifted(points, normals)
        beside = np.zeros(len(starts), bool)
        beside[which[~found]] = True
        rows = ~beside[which]
        used += [floor] if rows.any() else []
        points = np.where(rows[:, None], moved, points)
        normals = np.where(rows[:, None], up, normals)
    return points, normals, tuple(used)


def without_floors(floors: Sequence[LaidFloor], points: Array) -> Array:
    """Return points of a surface with details as they lie on it without, (n, 3) mm."""
    for floor in reversed(floors):
        points = floor.lowered(points)
    return points
