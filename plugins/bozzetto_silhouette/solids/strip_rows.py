"""Strips: rows of points from the borders of two meshes to where both bodies count alike.

Every row is a level of the blend on the blended surface. Rows of any number of points are joined by
triangles in the order in which the points come along them, so that what is laid is closed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_silhouette.numerics.isotropic_remeshing import dot, unit
from bozzetto_silhouette.solids.contacts import Apart, Pair, Told
from bozzetto_silhouette.solids.fillet import FINENESS, FINEST
from bozzetto_silhouette.solids.strip_borders import FINE_CUT, Border

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

AGREED = 0.95
"""Share of the points of a row that must lie beside the same row of the other side."""


class Ring(NamedTuple):
    """Closed rows of points, those of each border in turn.

    Attributes
    ----------
    points : (n, 3) float array
    along : (n,) float array
        Where along its row each point counts, from 0 to 1; the first of each row is at 0.
    row : (n,) int array
        The number of the row.
    ends : (r + 1,) int array
        Row k are the points from ``ends[k]`` up to ``ends[k + 1]``; it may have none.
    """

    points: Array
    along: Array
    row: Index
    ends: Index

    @classmethod
    def of(cls, rows: Sequence[Array]) -> Ring:
        """Put rows of points (n, 3) together."""
        counts = [len(row) for row in rows]
        points = np.concatenate(rows)
        number = np.repeat(np.arange(len(rows)), counts)
        return cls(points, np.zeros(len(points)), number, np.cumsum([0, *counts]))

    @property
    def after(self) -> Index:
        """The point (n,) that follows each."""
        following = np.arange(1, len(self.points) + 1)
        full = np.diff(self.ends) > 0
        following[self.ends[1:][full] - 1] = self.ends[:-1][full]
        return following

    @property
    def before(self) -> Index:
        """The point (n,) that each follows."""
        after = self.after
        result = np.empty_like(after)
        result[after] = np.arange(len(after))
        return result

    def lengths(self) -> tuple[Array, Array]:
        """Return the lengths of the edges (n,) from each point, and of the rows (r,)."""
        way = self.points[self.after] - self.points
        edges = np.sqrt(dot(way, way))
        total = np.bincount(self.row, edges, len(self.ends) - 1)
        return np.asarray(edges), total.astype(np.float64)

    def smoothed(self, rounds: int) -> Ring:
        """Return the rows with points moved towards their neighbours."""
        before, after, points = self.before, self.after, self.points
        for _ in range(rounds):
            points = 0.25 * points[before] + 0.5 * points + 0.25 * points[after]
        return self._replace(points=points)

    def measured(self) -> Ring:
        """Return the rows with `along` as their points are now."""
        edges, _ = self.lengths()
        along = np.zeros(len(edges))
        # Row by row, here and below: what is remembered of one must not depend on others.
        for low, high in pairwise(self.ends.tolist()):
            if low < high:
                way = np.cumsum(edges[low:high])
                along[low + 1 : high] = way[:-1] / way[-1]
        return self._replace(along=along)

    def resampled(self, counts: Index) -> Ring:
        """Return rows of so many points (r,) each, at even distances."""
        edges, _ = self.lengths()
        points, along = [np.zeros((0, 3))], [np.zeros(0)]
        for k in np.flatnonzero(counts).tolist():
            own = slice(self.ends[k], self.ends[k + 1])
            way = np.concatenate([[0.0], np.cumsum(edges[own])])
            place = np.arange(counts[k]) * (way[-1] / counts[k])
            closed = np.concatenate([self.points[own], self.points[own][:1]])
            points.append(np.stack([np.interp(place, way, column) for column in closed.T], axis=1))
            along.append(np.interp(place, way, np.append(self.along[own], 1.0)))
        return Ring(
            np.concatenate(points), np.concatenate(along),
            np.repeat(np.arange(len(counts)), counts), np.cumsum([0, *counts]),
        )  # fmt: skip

    def chosen(self, rows: Flags) -> Ring:
        """Return some of the rows (r,); the others have no points."""
        mine = rows[self.row]
        counts = np.where(rows, np.diff(self.ends), 0)
        return Ring(self.points[mine], self.along[mine], self.row[mine], np.cumsum([0, *counts]))

    def of_points(self, values: Array, other: Ring) -> Array:
        """Interpolate values (n,) at the points of other rows with the same numbers."""
        found = np.empty(len(other.points))
        for k, (low, high) in enumerate(pairwise(other.ends.tolist())):
            if low < high:
                own = slice(self.ends[k], self.ends[k + 1])
                found[low:high] = np.interp(
                    other.along[low:high],
                    np.append(self.along[own], 1.0), np.append(values[own], values[own][0]),
                )  # fmt: skip
        return found


def zipped(one: Ring, first: Index, other: Ring, second: Index) -> Index:
    """Return triangles (t, 3) between rows with the same numbers.

    Parameters
    ----------
    one, other : Ring
        The row, and the one that follows it to the left.
    first, second : (n,), (m,) int array
        The numbers of their points in the mesh.
    """
    a, b = _keys(one), _keys(other)
    at_b = np.searchsorted(b, a, side="left") - other.ends[one.row]
    at_a = np.searchsorted(a, b, side="right") - one.ends[other.row]
    count_a, count_b = np.diff(one.ends)[other.row], np.diff(other.ends)[one.row]
    across_b = second[other.ends[one.row] + at_b % count_b]
    across_a = first[one.ends[other.row] + at_a % count_a]
    return np.concatenate([
        np.stack([first[one.after], first, across_b], axis=1),
        np.stack([across_a, second, second[other.after]], axis=1),
    ])  # fmt: skip


def _keys(ring: Ring) -> Array:
    """Return numbers (n,) by which the middles of edges are in order; of a row less than 2."""
    following = ring.along[ring.after].copy()
    following[ring.ends[1:][np.diff(ring.ends) > 0] - 1] += 1.0
    return 4.0 * ring.row + 0.5 * (ring.along + following)


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


class _Last(NamedTuple):
    """The last row from a border: where its points come to lie, and which they are."""

    points: Array
    along: Array
    names: Index


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
        self._last: dict[int, _Last] = {}
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
                self._last[j] = _Last(points, ring.along[own], names[own])
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
                self._last[j] = _Last(row.points[own], row.along[own], new[own])
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
            partners = _partners(firsts, seconds)
            if partners is None:
                raise Apart(self._pairs[number].ends)
            for row, end in zip(partners, seconds, strict=True):
                order, along = _matched(end.points[::-1], row.points, row.along)
                if along is None:
                    raise Apart(self._pairs[number].ends)
                one, other = (
                    Ring.of([some.points])._replace(along=where)
                    for some, where in ((row, row.along), (end, along))
                )
                self._faces.append(zipped(one, row.names, other, end.names[::-1][order]))


def _partners(firsts: list[_Last], seconds: list[_Last]) -> list[_Last] | None:
    """Return for each row of one side the row of the other that it runs along, if that is clear."""
    from scipy.spatial import cKDTree

    if len(firsts) != len(seconds):
        return None
    tree = cKDTree(np.concatenate([row.points for row in firsts]))
    which = np.repeat(np.arange(len(firsts)), [len(row.points) for row in firsts])
    found = []
    for row in seconds:
        votes = np.bincount(which[tree.query(row.points)[1]], minlength=len(firsts))
        if votes.max() < AGREED * votes.sum():
            return None
        found.append(int(votes.argmax()))
    return [firsts[k] for k in found] if len(set(found)) == len(found) else None


def _matched(points: Array, row: Array, along: Array) -> tuple[Index, Array | None]:
    """Find where points (m, 3) in a closed row lie on another one, of points (n, 3).

    Returns
    -------
    order : (m,) int array
        In which they are to be taken, so that the first is nearest to the other's first.
    along : (m,) float array or None
        Where on the other row each is then; it never falls. None where they do not run along it
        just once.
    """
    from scipy.spatial import cKDTree

    count = len(row)
    _, near = cKDTree(row).query(points)
    following = np.append(along[1:], 1.0)
    least, where = np.full(len(points), np.inf), np.zeros(len(points))
    for begin in ((near - 1) % count, near):
        way = row[(begin + 1) % count] - row[begin]
        beyond = points - row[begin]
        t = np.clip(dot(beyond, way) / np.maximum(dot(way, way), 1e-300), 0.0, 1.0)
        gap = beyond - t[:, None] * way
        square = dot(gap, gap)
        place = along[begin] + t * (following[begin] - along[begin])
        where = np.where(square < least, place, where)
        least = np.minimum(square, least)
    steps = (np.append(where[1:], where[0]) - where + 0.5) % 1.0 - 0.5
    if round(float(steps.sum())) != 1:
        return np.arange(len(points)), None
    walked = where[0] + np.concatenate([[0.0], np.cumsum(steps[:-1])])
    later = np.minimum.accumulate(walked[::-1])[::-1]
    walked = np.minimum(0.5 * (np.maximum.accumulate(walked) + later), walked[0] + 1.0)
    order = np.roll(np.arange(len(points)), -int(np.argmin(walked % 1.0)))
    return order, np.maximum.accumulate(walked[order] % 1.0)
