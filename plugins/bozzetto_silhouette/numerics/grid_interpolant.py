"""A function of the plane on a square lattice, smooth between the nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import cached_property

BORDER = 6
"""Nodes along the edge of a lattice where the spline is bent: it goes on there as in a mirror,
and each node takes off three quarters of the error."""


@dataclass(frozen=True, eq=False)
class Lattice:
    """Coefficients of a bicubic spline; its second derivatives are continuous.

    Parameters
    ----------
    low : (2,) float array
        Place of node (0, 0).
    step : float
    coefficients : (nx, ny) float array
    """

    low: Array
    step: float
    coefficients: Array

    @classmethod
    def through(cls, low: Array, step: float, values: Array) -> Lattice:
        """Fit the spline through values (nx, ny) at the nodes."""
        from scipy.ndimage import spline_filter

        return cls(low, step, spline_filter(values, order=3, mode="mirror"))

    @property
    def bounds(self) -> Array:
        """The box (2, 2) within which what lies beyond the lattice is not felt."""
        last = np.array(self.coefficients.shape) - 1.0
        return self.low + self.step * np.stack([np.full(2, BORDER), last - BORDER])

    @cached_property
    def padded(self) -> Array:
        """The coefficients mirrored at the border, with a node more on every side."""
        return np.pad(self.coefficients, 1, mode="reflect")


class Cells(NamedTuple):
    """Places in the cells of lattices whose numbers stand in one row.

    Attributes
    ----------
    first : (n,) int array
        Where in the row the node before the cell's first stands, along both axes.
    width : (n,) int array or int
        Nodes across, those at the border included.
    along, across : (n,) float array
        From 0 to 1 within the cell.
    """

    first: Index
    width: Index | int
    along: Array
    across: Array

    def cubic(self, row: Array) -> tuple[Array, Array, Array]:
        """Return values and slopes (n,), per cell, of the spline with a row of coefficients."""
        near = [
            [row.take(start + k) for k in range(4)]
            for start in (self.first + k * self.width for k in range(4))
        ]
        (w, v), (s, r) = _weights(self.along), _weights(self.across)
        value, x, y = np.zeros((3, len(self.first)))
        for k in range(4):
            one, two, three, four = near[k]
            middle = one * s[0] + two * s[1] + three * s[2] + four * s[3]
            value += middle * w[k]
            x += middle * v[k]
            y += (one * r[0] + two * r[1] + three * r[2] + four * r[3]) * w[k]
        return value, x, y

    def linear(self, row: Array) -> Array:
        """Return values (n,) between the four nodes of the cells."""
        start = self.first + self.width + 1
        low = row.take(start)
        low += self.across * (row.take(start + 1) - low)
        start = start + self.width
        high = row.take(start)
        high += self.across * (row.take(start + 1) - high)
        result: Array = low + self.along * (high - low)
        return result


def _weights(t: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Return the four uniform cubic B-splines over a cell and their slopes at places (n,) in it."""
    s = 1.0 - t
    t2, s2 = t * t, s * s
    t3, s3 = t2 * t / 6.0, s2 * s / 6.0
    weights = s3, 2.0 / 3.0 - t2 + 3.0 * t3, 2.0 / 3.0 - s2 + 3.0 * s3, t3
    slopes = -0.5 * s2, 1.5 * t2 - 2.0 * t, 2.0 * s - 1.5 * s2, 0.5 * t2
    return weights, slopes


def on_nodes(
    points: Array,
    triangles: Index,
    values: Array,
    gradients: Array,
    low: Array,
    step: float,
    shape: tuple[int, int],
) -> Array:
    """Interpolate at the nodes of a lattice that lie in triangles; NaN at the others.

    With barycentric coordinates b the value is the sum of b_i (v_i + g_i (p - p_i) / 2), which
    is exact where the function is quadratic.

    Parameters
    ----------
    points, values, gradients : (n, 2), (n,), (n, 2) float array
        Places of the corners, and the function there.
    triangles : (t, 3) int array
        Index of their corners.
    low, step, shape
        Node (i, j) lies at ``low + step * (i, j)``.

    Returns
    -------
    (nx, ny) float array
    """
    corner = (points[triangles] - low) / step
    first = np.maximum(np.ceil(corner.min(axis=1) - 1e-9).astype(np.intp), 0)
    last = np.minimum(np.floor(corner.max(axis=1) + 1e-9).astype(np.intp), np.array(shape) - 1)
    count = np.maximum(last - first + 1, 0)
    total = count.prod(axis=1)
    owner = np.repeat(np.arange(len(triangles)), total)
    place = np.arange(len(owner)) - np.repeat(np.cumsum(total) - total, total)
    node = first[owner] + np.stack([place // count[owner, 1], place % count[owner, 1]], axis=1)
    a, b, c = corner.transpose(1, 0, 2)
    twice = _cross(b - a, c - a)
    offset = node - a[owner]
    with np.errstate(divide="ignore", invalid="ignore"):
        v = _cross(offset, (c - a)[owner]) / twice[owner]
        w = _cross((b - a)[owner], offset) / twice[owner]
    share = np.stack([1.0 - v - w, v, w], axis=1)
    hit = np.flatnonzero((share >= -1e-9).all(axis=1))
    node, share, owner = node[hit], share[hit], triangles[owner[hit]]
    away = (low + step * node)[:, None, :] - points[owner]
    result = np.full(shape, np.nan)
    result[node[:, 0], node[:, 1]] = (
        share * (values[owner] + 0.5 * (gradients[owner] * away).sum(axis=2))
    ).sum(axis=1)
    return result


def _cross(a: Array, b: Array) -> Array:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
