"""Variational implicit surfaces: the smoothest function that takes given values at points.

Among all functions that take the values, ``sum_i w_i |p - c_i|^3 + a + b . p`` bends least
(Duchon's semi-norm of third order). After G. Turk and J. F. O'Brien, "Modelling with implicit
surfaces that interpolate", 2002, sections 3 and 4; SketchCo uses the same function.

Value and gradient come from one matrix product. With r the distances and q their squares,

    sum w r^3    = |p|^2 (r . w) - 2 p . (r . w c) + r . w |c|^2,
    grad of this = 3 (p (r . w) - r . w c),

so five columns of weights times the matrix of distances give both, and only the square roots
cost anything.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.plugin import cached_property
from bozzetto_silhouette.implicit.implicit_solid import Sample

SPACING = 1e-3
"""Least distance of two constraints, as a share of the size. At a thousandth five hundred
constraints lose ten of sixteen digits, at a millionth all of them, without a word."""

RESIDUAL = 1e-7
"""Largest error allowed at a constraint, as a share of the size."""

COPLANAR = 1e-6
"""Spread, as a share of the size, below which constraints say nothing about a direction."""

FLATTEST = 0.5
"""The function is divided by its slope to become a distance, but never by less than this share
of the slope at the surface: on the axis of a limb the slope vanishes."""

MARGIN = 0.1
"""Beyond its box, widened by this share of its longest side, the surface is taken not to be:
far from all constraints the function may turn positive again."""

CHUNK = 512
"""Points evaluated at a time: with five hundred constraints the table of distances has 2 MB and
stays in the cache, which makes it twice as fast."""


def apart(points: Array, spacing: float) -> Index:
    """Choose points so that no two are closer than a spacing: the earlier one of two stays.

    Parameters
    ----------
    points : (n, 3) float array
        Places in space.
    spacing : float
        Least distance of two points that are kept.

    Returns
    -------
    (k,) int array
        Index, ascending.
    """
    from scipy.spatial import cKDTree

    keep = np.ones(len(points), bool)
    if len(points):
        for one, other in sorted(cKDTree(points).query_pairs(spacing)):
            if keep[one]:
                keep[other] = False
    return np.flatnonzero(keep)


@dataclass(frozen=True, eq=False)
class VariationalSurface:
    """A function of space that takes given values at given points; an `Implicit`.

    Attributes
    ----------
    bounds : (2, 3) float array
        The box of the surface.
    middle, size : (3,) float array, float
        The sums are done at ``(p - middle) / size``.
    centres : (n, 3) float array
        Of the constraints, in the frame of the sums.
    columns : (n, 5) float array
        w, w c, w |c|^2: the weights, ready for the product.
    tail : (4,) float array
        a and b.
    slope : float
        Typical gradient of the function at the surface.
    """

    bounds: Array
    middle: Array
    size: float
    centres: Array = field(repr=False)
    columns: Array = field(repr=False)
    tail: Array
    slope: float = 1.0

    def level(self, points: Array) -> Array:
        """Evaluate the function itself at points (n, 3), in units of length."""
        value = np.empty(len(points))
        weight, ahead = np.ascontiguousarray(self.columns[:, 0]), self._ahead
        for first in range(0, len(points), CHUNK):
            part = slice(first, first + CHUNK)
            p = (points[part] - self.middle) / self.size
            square = np.column_stack([p, (p * p).sum(axis=1), np.ones(len(p))]) @ ahead
            np.maximum(square, 0.0, out=square)
            distance = np.sqrt(square)
            distance *= square
            value[part] = distance @ weight + (self.tail[0] + p @ self.tail[1:])
        return value * self.size

    def level_and_slope(self, points: Array) -> tuple[Array, Array]:
        """Evaluate the function itself and its gradient, (n,) and (n, 3), at points (n, 3)."""
        value, gradient = np.empty(len(points)), np.empty((len(points), 3))
        ahead = self._ahead
        for first in range(0, len(points), CHUNK):
            part = slice(first, first + CHUNK)
            p = (points[part] - self.middle) / self.size
            p2 = (p * p).sum(axis=1)
            r = np.column_stack([p, p2, np.ones(len(p))]) @ ahead
            np.maximum(r, 0.0, out=r)
            np.sqrt(r, out=r)
            sums = r @ self.columns
            plain, turned = sums[:, 0], sums[:, 1:4]
            value[part] = p2 * plain - 2.0 * (p * turned).sum(axis=1) + sums[:, 4]
            value[part] += self.tail[0] + p @ self.tail[1:]
            gradient[part] = 3.0 * (p * plain[:, None] - turned) + self.tail[1:]
        return value * self.size, gradient

    @cached_property
    def _ahead(self) -> Array:
        """The factor (5, n) that turns ``(p, |p|^2, 1)`` into squared distances."""
        square = (self.centres**2).sum(axis=1)
        return np.stack([*(-2.0 * self.centres.T), np.ones(len(square)), square])

    def value(self, points: Array) -> Array:
        """Return about the signed distance to the surface at points (n, 3), positive inside.

        The level over its typical slope: `sample`, which knows the slope at every point, comes
        closer, and takes half as long again.
        """
        value = self.level(points) / self.slope
        beyond, gap = self._beyond(points)
        return np.where(gap > 0.0, np.minimum(value, beyond), value)

    def sample(self, points: Array) -> Sample:
        """Return about the signed distance, and its gradient, at points (n, 3)."""
        level, gradient = self.level_and_slope(points)
        steepness = np.sqrt((gradient**2).sum(axis=1))
        scale = 1.0 / np.maximum(steepness, FLATTEST * self.slope)
        value, gradient = level * scale, gradient * scale[:, None]
        beyond, gap = self._beyond(points)
        over = (gap > 0.0) & (value > beyond)
        nearest = np.clip(points[over], *self._box)
        gradient[over] = (nearest - points[over]) / gap[over, None]
        return Sample(np.where(over, beyond, value), gradient)

    @cached_property
    def _box(self) -> Array:
        margin = MARGIN * float(np.ptp(self.bounds, axis=0).max())
        return self.bounds + margin * np.array([[-1.0], [1.0]])

    def _beyond(self, points: Array) -> tuple[Array, Array]:
        """Return the largest value allowed beyond the wide box, and the distance from it."""
        gap = np.sqrt(((points - np.clip(points, *self._box)) ** 2).sum(axis=1))
        return -MARGIN * float(np.ptp(self.bounds, axis=0).max()) - gap, gap


def interpolated(
    points: Array, values: Array, bounds: Array, *, mirrored: bool = False
) -> VariationalSurface:
    """Find the smoothest function with given values at given points.

    Parameters
    ----------
    points : (n, 3) float array
        No two closer than `SPACING` (see `apart`).
    values : (n,) float array
        In units of length, positive inside.
    bounds : (2, 3) float array
        The box that the surface is known to be in.
    mirrored : bool
        Whether every point above z = 0 stands for its mirror image below, too. The system is
        then half as large, and the function exactly symmetric.

    Raises
    ------
    UserError
        If the function misses the values by more than `RESIDUAL`.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = 0.5 * (low + high), max(float((high - low).max()), 1e-300)
    if mirrored:
        middle[2] = 0.0
    p, wanted = (points - middle) / size, values / size
    paired = p[:, 2] > 0.0 if mirrored else np.zeros(len(p), bool)
    weights, tail = _solved(p, wanted, paired, _directions(p, planar=mirrored))
    image = p[paired] * (1.0, 1.0, -1.0)
    centres = np.concatenate([p, image])
    weights = np.concatenate([weights, weights[paired]])
    columns = np.column_stack(
        [weights, weights[:, None] * centres, weights * (centres**2).sum(axis=1)]
    )
    surface = VariationalSurface(bounds, middle, size, centres, columns, tail)
    value, gradient = surface.level_and_slope(points)
    worst = float(np.abs(value - values).max(initial=0.0))
    if not worst <= RESIDUAL * size:
        raise UserError(
            "No smooth surface passes exactly through this outline: parts of it lie too close "
            "together. Draw it larger there, or choose the round surface."
        )
    on = np.abs(wanted) <= COPLANAR
    steepness = np.sqrt((gradient[on] ** 2).sum(axis=1))
    slope = max(float(np.median(steepness)), 1e-6) if on.any() else 1.0
    return VariationalSurface(bounds, middle, size, centres, columns, tail, slope)


def _directions(p: Array, *, planar: bool) -> Array:
    """Return unit vectors along which the points spread, (k, 3): one linear term each."""
    spread = p - p.mean(axis=0)
    if planar:
        spread[:, 2] = 0.0
    _, extent, axes = np.linalg.svd(spread, full_matrices=False)
    found: Array = axes[extent > COPLANAR * np.sqrt(len(p))]
    return found


def _solved(p: Array, wanted: Array, paired: Flags, directions: Array) -> tuple[Array, Array]:
    """Solve for weights (n,) and tail (4,): Turk and O'Brien, equation 8, with the tail's rows."""
    from scipy.spatial.distance import cdist

    n, k = len(p), 1 + len(directions)
    kernel = cdist(p, p)
    kernel *= kernel * kernel
    if paired.any():
        across = cdist(p, p[paired] * (1.0, 1.0, -1.0))
        kernel[:, paired] += across**3
    linear = np.column_stack([np.ones(n), p @ directions.T])
    matrix = np.zeros((n + k, n + k))
    matrix[:n, :n], matrix[:n, n:] = kernel, linear
    matrix[n:, :n] = (linear * (1.0 + paired)[:, None]).T
    try:
        solution = np.linalg.solve(matrix, np.concatenate([wanted, np.zeros(k)]))
    except np.linalg.LinAlgError:
        solution = np.full(n + k, np.nan)
    tail = np.concatenate([solution[n : n + 1], solution[n + 1 :] @ directions])
    return solution[:n], tail
