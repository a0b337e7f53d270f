"""A function of the plane on a square lattice, smooth between the nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import cached_property

BORDER = 6
"""Nodes along the edge of a lattice where the spline is bent: it goes on there as in a mirror,
and each node takes off three quarters of the error."""

_CHUNK = 4_096
"""Points evaluated at a time: the sixteen coefficients of each stay in the cache."""


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

    def sample(self, xy: Array) -> tuple[Array, Array]:
        """Return values (n,) and gradients (n, 2) at points (n, 2) within the lattice."""
        parts = [self._sample(xy[i : i + _CHUNK]) for i in range(0, max(1, len(xy)), _CHUNK)]
        value, x, y = np.concatenate(parts, axis=1)
        return value, np.stack([x, y], axis=1)

    def _sample(self, xy: Array) -> Array:
        rows, width, corner = self._padded
        at = (xy - self.low) / self.step
        cell = np.clip(np.floor(at).astype(np.intp), 0, np.array(self.coefficients.shape) - 2)
        weights, slopes = _weights((at - cell).T)
        first = cell[:, 0] * width + cell[:, 1]
        near = rows.take(first + corner[:, None]).reshape(4, 4, -1)
        value, x, y = np.zeros((3, len(xy)))
        for k in range(4):
            along = near[k, 0] * weights[0][1] + near[k, 1] * weights[1][1]
            along += near[k, 2] * weights[2][1] + near[k, 3] * weights[3][1]
            across = near[k, 0] * slopes[0][1] + near[k, 1] * slopes[1][1]
            across += near[k, 2] * slopes[2][1] + near[k, 3] * slopes[3][1]
            value += along * weights[k][0]
            x += along * slopes[k][0]
            y += across * weights[k][0]
        return np.stack([value, x / self.step, y / self.step])

    @cached_property
    def _padded(self) -> tuple[Array, int, Index]:
        """All coefficients in one row, mirrored at the border, and how to find sixteen of them.

        With the row come the number of nodes across, and where the others around a cell lie after
        the first.
        """
        padded = np.pad(self.coefficients, 1, mode="reflect")
        width = padded.shape[1]
        return padded.ravel(), width, (width * np.arange(4)[:, None] + np.arange(4)).ravel()


def _weights(t: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Return the four uniform cubic B-splines over a cell and their slopes at places in it."""
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
