"""Closed rows of points that are put together, and triangles between two of them.

Rows of any number of points are joined by triangles in the order in which the points come along
them, so that what is laid is closed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_silhouette.numerics.isotropic_remeshing import dot


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
