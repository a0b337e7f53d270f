"""Exact signed distance and closest points on a densely sampled outline."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bozzetto.arrays import Array, Flags, Index

_CANDIDATES = 4
"""Rim vertices looked at around a query; their segments hold the foot point as long as
the lengths of neighbouring segments change gradually."""


@dataclass(frozen=True)
class ClosestPoints:
    """Closest points on the rim, one for each query.

    Attributes
    ----------
    distance : (n,) float array
        Signed, positive inside.
    segment : (n,) int array
        The rim segment (from vertex ``segment`` to its successor) that holds the foot.
    along : (n,) float array
        Position of the foot on that segment, 0 to 1.
    """

    distance: Array
    segment: Index
    along: Array


@dataclass(frozen=True, eq=False)
class RimDistance:
    """Signed distance to closed rings whose inside lies to the left.

    Parameters
    ----------
    points : (m, 2) float array
        Vertices of all rings, ring after ring.
    after : (m,) int array
        Successor of every vertex.
    """

    points: Array
    after: Index
    _tree: Any = field(init=False, repr=False)
    _before: Index = field(init=False, repr=False)
    _edge: Array = field(init=False, repr=False)
    _length2: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        from scipy.spatial import cKDTree

        edge = self.points[self.after] - self.points
        before = np.empty_like(self.after)
        before[self.after] = np.arange(len(self.after))
        object.__setattr__(self, "_tree", cKDTree(self.points))
        object.__setattr__(self, "_before", before)
        object.__setattr__(self, "_edge", edge)
        object.__setattr__(self, "_length2", np.maximum((edge**2).sum(axis=1), 1e-300))

    def __call__(self, xy: Array, *, reach: float = np.inf) -> ClosestPoints:
        """Find the closest points to points (n, 2); beyond `reach` the sign cannot be trusted.

        Points without any rim vertex within `reach` get a distance of ``inf``.
        """
        k = min(_CANDIDATES, len(self.points))
        gap, near = self._tree.query(xy, k=k, distance_upper_bound=reach)
        if k == 1:
            gap, near = gap[:, None], near[:, None]
        missing = near[:, 0] == len(self.points)
        near = np.where(near == len(self.points), near[:, :1], near)
        near[missing] = 0
        segment = np.concatenate([near, self._before[near]], axis=1)
        # By coordinates: sums over an axis of two take three times as long.
        (start_x, start_y), (edge_x, edge_y) = self.points.T, self._edge.T
        edge_x, edge_y = edge_x[segment], edge_y[segment]
        x, y = xy[:, :1] - start_x[segment], xy[:, 1:2] - start_y[segment]
        along = np.clip((x * edge_x + y * edge_y) / self._length2[segment], 0.0, 1.0)
        x -= along * edge_x
        y -= along * edge_y
        distance2 = x * x + y * y
        best = distance2.argmin(axis=1)
        row = np.arange(len(xy))
        segment, along = segment[row, best], along[row, best]
        # At a vertex the side is given by the sum of the two unit normals, which in the
        # plane is the angle-weighted pseudo-normal of Baerentzen and Aanaes (2005).
        left = np.stack([-self._edge[:, 1], self._edge[:, 0]], axis=1)
        left /= np.sqrt(self._length2)[:, None]
        normal = left[segment]
        at_start, at_end = along <= 0.0, along >= 1.0
        normal[at_start] += left[self._before[segment[at_start]]]
        normal[at_end] += left[self.after[segment[at_end]]]
        ahead = x[row, best] * normal[:, 0] + y[row, best] * normal[:, 1]
        side = np.where(ahead >= 0.0, 1.0, -1.0)
        distance = np.sqrt(distance2[row, best]) * side
        distance[missing] = np.inf
        return ClosestPoints(distance, segment, along)


def scanline_inside(
    points: Array, after: Index, low: Array, step: Array, shape: tuple[int, int]
) -> Flags:
    """Test by even-odd which nodes of a lattice lie inside, counting crossings along its rows.

    Parameters
    ----------
    points, after : (m, 2) float array, (m,) int array
        Vertices of all rings and their successors.
    low, step : (2,) float arrays
        Lattice node (i, j) lies at ``low + step * (i, j)``.
    shape : (int, int)
        Number of nodes along x and y.

    Returns
    -------
    (nx, ny) bool array
    """
    ax, ay = ((points - low) / step).T
    bx, by = ax[after], ay[after]
    first = np.ceil(np.minimum(ay, by)).astype(np.intp)
    last = np.ceil(np.maximum(ay, by)).astype(np.intp)  # half-open: [first, last)
    first, last = np.clip(first, 0, shape[1]), np.clip(last, 0, shape[1])
    count = last - first
    edge = np.repeat(np.arange(len(count)), count)
    row = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count) + first[edge]
    column = ax[edge] + (row - ay[edge]) * (bx - ax)[edge] / (by - ay)[edge]
    column = np.clip(np.ceil(column), 0, shape[0]).astype(np.intp)
    crossings = np.zeros((shape[0] + 1, shape[1]), dtype=np.int32)
    np.add.at(crossings, (column, row), 1)
    inside: Flags = np.cumsum(crossings[:-1], axis=0) % 2 == 1
    return inside
