"""Strips: rows of points from the borders of two meshes to where both bodies count alike.

Every row is a level of the blend on the blended surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.numerics.isotropic_remeshing import dot, unit
from bozzetto_silhouette.solids.contacts import Apart, Pair, Told
from bozzetto_silhouette.solids.fillet import FINENESS, FINEST
from bozzetto_silhouette.solids.strip_borders import Border
from bozzetto_silhouette.solids.strip_closing import LastRow, closed
from bozzetto_silhouette.solids.strip_nets import FINE_CUT
from bozzetto_silhouette.solids.strip_rings import Ring, zipped

GROWTH = 0.5
"""How fast the distance of rows grows from a fine border on, per distance."""

CALMED = 2
"""Rounds of smoothing the borders, which run along edges of the meshes."""

STEADIED = 4
"""Rounds of smoothing the first rows, whose points come from there."""

NEWTON, BEGUN = 2, 4
"""Steps of Newton's method for every row, and for the first one."""

NEAREST, LEAST = 0.2, 0.15
"""Least level, without its sign, that borders are taken for, and at which a first row lies."""

SLOWEST = 0.2
"""Least change of the values across a strip, per distance."""

FEWEST = 6
"""Points of a row at least."""

FLATTEST = 0.05
"""Where the directions of the surface and of the level are nearly one no step is longer than by
this share of their product."""


class _Plan(NamedTuple):
    """The rows from a border: their places from 0 at the first to the width, and sizes there."""

    places: Array
    sizes: Array

    @classmethod
    def of(cls, width: float, low: float, most: float) -> _Plan:
        """Plan rows over a width; sizes grow from a low one at the border up to the most."""
        x = np.linspace(0.0, width, 33)
        density = 1.0 / np.minimum(low + GROWTH * x, most)
        steps = 0.5 * (density[1:] + density[:-1]) * np.diff(x)
        total = np.concatenate([[0.0], np.cumsum(steps)])
        count = max(1, int(np.rint(total[-1])))
        places = np.interp(np.linspace(0.0, total[-1], count + 1), total, x)
        return cls(places, np.minimum(low + GROWTH * places, most))


class Strips:
    """Rows from every border to the level 0 of its pair, and the triangles between them.

    Parameters
    ----------
    vertices : (v, 3) float array
        Of the meshes; new points are numbered from their count on.
    pairs : list of Pair
    borders : sequence of Border

    Attributes
    ----------
    vertices : (v, 3) float array
        With the borders smoothed.
    points : (n, 3) float array
        The new ones.
    pair : (n,) int array
        The number of the pair of each.
    sizes : (n,) float array
        How long edges are there.
    faces : (f, 3) int array
        Between the borders and the points.

    Raises
    ------
    Apart
        Where the rows from both sides do not fit.
    """

    def __init__(self, vertices: Array, pairs: list[Pair], borders: Sequence[Border]) -> None:
        self._pairs = pairs
        self._borders = sorted(
            borders, key=lambda border: (border.pair, border.owner != pairs[border.pair].one)
        )
        self._of_border = [pairs[border.pair] for border in self._borders]
        self._sign = np.array([
            1.0 if border.owner == pairs[border.pair].one else -1.0 for border in self._borders
        ])  # fmt: skip
        self.vertices = vertices.copy()
        self._count = len(vertices)
        self._laid: list[Ring] = []
        self._sizes = [np.zeros(0)]
        self._faces = [np.zeros((0, 3), np.intp)]
        self._last: dict[int, LastRow] = {}
        if self._borders:
            self._lay()
            self._close()
        self.points = np.concatenate([np.zeros((0, 3)), *(ring.points for ring in self._laid)])
        of_row = np.array([border.pair for border in self._borders], np.intp)
        rows = [np.zeros(0, np.intp), *(ring.row for ring in self._laid)]
        self.pair: Index = of_row[np.concatenate(rows)]
        self.sizes = np.concatenate(self._sizes)
        self.faces = np.concatenate(self._faces)

    def _lay(self) -> None:
        names = np.concatenate([border.vertices for border in self._borders])
        ring = Ring.of([self.vertices[border.vertices] for border in self._borders])
        ring = ring.smoothed(CALMED)
        self.vertices[names] = ring.points
        depth, reach, plans = self._planned(ring)
        current = self._onto(ring, -depth, BEGUN, plans, 0, reach).smoothed(STEADIED).measured()
        start = ring = ring._replace(along=current.along)
        is_first = self._sign > 0.0
        for r in range(max(len(plan.places) for plan in plans)):
            live = np.array([r < len(plan.places) for plan in plans])
            final = np.array([r == len(plan.places) - 1 for plan in plans])
            share = np.array([p.places[min(r, len(p.places) - 1)] / p.places[-1] for p in plans])
            current = current.chosen(live)
            level = (share[current.row] - 1.0) * start.of_points(depth, current)
            moved = self._onto(current, level, NEWTON, plans, r, reach)
            for j in np.flatnonzero(final & ~is_first).tolist():  # it ends on the other side's
                own = slice(ring.ends[j], ring.ends[j + 1])
                points = moved.points[moved.ends[j] : moved.ends[j + 1]]
                self._last[j] = LastRow(points, ring.along[own], names[own])
            live &= is_first | ~final
            if not live.any():
                break
            moved = moved.chosen(live)
            size = np.array([plan.sizes[min(r, len(plan.sizes) - 1)] for plan in plans])
            _, length = moved.lengths()
            counts = np.where(live, np.maximum(FEWEST, np.rint(length / size)), 0).astype(np.intp)
            row = moved.resampled(counts)
            level = (share[row.row] - 1.0) * start.of_points(depth, row)
            row = self._onto(row, level, NEWTON, plans, r, reach)
            new = self._count + np.arange(len(row.points))
            self._count += len(new)
            self._laid.append(row)
            self._sizes.append(size[row.row])
            self._faces.append(zipped(ring.chosen(live), names[live[ring.row]], row, new))
            for j in np.flatnonzero(live & final).tolist():
                own = slice(row.ends[j], row.ends[j + 1])
                self._last[j] = LastRow(row.points[own], row.along[own], new[own])
            ring = current = row
            names = new

    def _planned(self, ring: Ring) -> tuple[Array, Array, list[_Plan]]:
        """Plan the rows from every border.

        Returns
        -------
        depth : (n,) float array
            The level, without its sign, of the first row beside each point of the borders.
        reach : (b,) float array
            Of the blend at each border.
        plans : list of _Plan
        """
        counts = np.diff(ring.ends)

        def mean(values: Array) -> Array:
            return np.asarray(np.bincount(ring.row, values, len(counts)) / counts)

        told = self._told(ring)
        reach = np.maximum(mean(told.reach), 1e-9)
        own = ring.lengths()[1] / counts
        step = np.array([pair.step for pair in self._of_border])
        most = np.maximum(FINENESS * mean(told.local), FINEST * step)
        cosine = np.clip(mean(dot(unit(told.first_slope), unit(told.second_slope))), -1.0, 1.0)
        # From the border, where one body's slope counts, to the middle, where both do.
        speed = 0.5 * (np.sqrt(1.0 - cosine**2) + np.sqrt(2.0 - 2.0 * cosine))
        speed = np.maximum(speed, SLOWEST)
        ahead = self._sign[ring.row] * (told.second - told.first) / np.maximum(told.reach, 1e-9)
        depth = np.clip(-ahead, NEAREST, FINE_CUT)
        depth -= (0.5 * np.minimum(own, most) * speed / reach)[ring.row]
        depth = np.maximum(depth, LEAST)
        before, after = ring.before, ring.after
        for _ in range(2):  # within every point of the border beside
            depth = np.minimum(depth, np.minimum(depth[before], depth[after]))
        for _ in range(3):
            depth = 0.25 * depth[before] + 0.5 * depth + 0.25 * depth[after]
        widths = mean(depth) * reach / speed
        plans = [_Plan.of(*some) for some in zip(widths, own, most, strict=True)]
        return depth, reach, plans

    def _told(self, ring: Ring) -> Told:
        return Told.of(self._of_border, ring.points, ring.ends)

    def _onto(
        self, ring: Ring, level: Array, rounds: int, plans: list[_Plan], place: int, reach: Array
    ) -> Ring:
        """Bring points of rings onto the blended surface and to levels (n,), by Newton's method.

        Steps are no longer than the size of a row's edges and half of the reach.
        """
        size = np.array([plan.sizes[min(place, len(plan.sizes) - 1)] for plan in plans])
        most = (size + 0.5 * reach)[ring.row]
        sign = self._sign[ring.row]
        for _ in range(rounds):
            told = self._told(ring)
            across = told.second_slope - told.first_slope
            off = sign * level * told.reach - (told.second - told.first)
            aa, ab, bb = (
                dot(*two)
                for two in ((told.slope, told.slope), (told.slope, across), (across, across))
            )
            det = np.maximum(aa * bb - ab * ab, FLATTEST * aa * bb + 1e-12)
            x, y = (-bb * told.value - ab * off) / det, (aa * off + ab * told.value) / det
            move = x[:, None] * told.slope + y[:, None] * across
            length = np.sqrt(dot(move, move))
            move *= np.minimum(1.0, most / np.maximum(length, 1e-300))[:, None]
            ring = ring._replace(points=ring.points + move)
        return ring

    def _close(self) -> None:
        """Join the last rows from both sides of every pair."""
        for number in sorted({border.pair for border in self._borders}):
            mine = [j for j, border in enumerate(self._borders) if border.pair == number]
            firsts = [self._last[j] for j in mine if self._sign[j] > 0.0]
            seconds = [self._last[j] for j in mine if self._sign[j] < 0.0]
            faces = closed(firsts, seconds)
            if faces is None:
                raise Apart(self._pairs[number].ends)
            self._faces += faces
