"""A function of the plane on a square lattice, smooth between the nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Index

BORDER = 6
"""Nodes along the edge of a lattice where the spline is bent: it goes on there as in a mirror,
and each node takes off three quarters of the error."""

_CHUNK = 16_384
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
        shape = np.array(self.coefficients.shape)
        at = (xy - self.low) / self.step
        cell = np.clip(np.floor(at).astype(np.intp), 0, shape - 2)
        wx, dx = _weights(at[:, 0] - cell[:, 0])
        wy, dy = _weights(at[:, 1] - cell[:, 1])
        rows = _mirrored(cell[:, 0] + np.arange(-1, 3)[:, None], shape[0])
        columns = _mirrored(cell[:, 1] + np.arange(-1, 3)[:, None], shape[1])
        near = self.coefficients[rows[:, None], columns[None, :]]
        along, slope = (np.einsum("jn,ijn->in", w, near) for w in (wy, dy))
        return np.stack([
            (wx * along).sum(axis=0),
            (dx * along).sum(axis=0) / self.step,
            (wx * slope).sum(axis=0) / self.step,
        ])  # fmt: skip


def _mirrored(index: Index, count: int) -> Index:
    index = np.abs(index)
    return np.where(index >= count, 2 * (count - 1) - index, index)


def _weights(t: Array) -> tuple[Array, Array]:
    """Return the four uniform cubic B-splines over a cell and their slopes, (4, n) each."""
    s = 1.0 - t
    weights = np.stack([s**3, 4.0 - 6.0 * t**2 + 3.0 * t**3, 4.0 - 6.0 * s**2 + 3.0 * s**3, t**3])
    slopes = np.stack([-(s**2), 3.0 * t**2 - 4.0 * t, 4.0 * s - 3.0 * s**2, t**2])
    return weights / 6.0, slopes / 2.0


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
