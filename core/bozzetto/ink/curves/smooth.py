"""Smoothing that neither lags behind the pen nor depends on how often it was sampled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.ink.curves.resample import arc_length, distinct, points_along

if TYPE_CHECKING:
    from bozzetto.arrays import Array

REACH: Final = 4.0
"""Half width of the kernel in standard deviations; what lies beyond weighs 6e-5."""

CELLS_PER_SIGMA: Final = 5
"""Fineness of the convolution: linear interpolation errs by less than sigma / 250 then."""

FEWEST_CELLS: Final = 8
"""Cells along a curve that is shorter than the kernel."""

WIDEST: Final = 4.0
"""Largest sigma in curve lengths: wider kernels give the same chord, or the same dot."""

MOST_CELLS: Final = 200_000
"""Most cells along one curve; beyond that sigma is far below what a hand can draw."""


def smooth(points: ArrayLike, sigma: float, *, closed: bool = False) -> Array:
    """Convolve a curve with a Gaussian in arc length.

    The convolution is over the polyline, not over its samples, so the result does not
    depend on the sampling rate. It looks both ways along the curve and therefore has no
    lag. An open curve is continued by its point reflection about each end, which keeps the
    end points where they are; a closed one is continued periodically. A circle of radius r
    shrinks by the factor exp(-sigma² / 2r²).

    Parameters
    ----------
    points : (n, d) array_like
        Points along a curve, at any spacing.
    sigma : float
        Standard deviation along the curve, in the units of the points; 0 changes nothing.
    closed : bool
        Whether the last point is joined to the first.

    Returns
    -------
    (n, d) float
        One point for every point given; a repeated first point stays repeated.
    """
    place = np.asarray(points, float)
    kept = distinct(place, closed=closed)
    if sigma <= 0 or len(kept) < (3 if closed else 2):
        return place.copy()
    ring = np.vstack((place[kept], place[:1])) if closed else place[kept]
    return convolve(ring, arc_length(ring), arc_length(place), sigma, closed=closed)


def convolve(points: Array, along: Array, at: Array, sigma: float, *, closed: bool) -> Array:
    """Convolve a polyline with a Gaussian in a parameter along it.

    Parameters
    ----------
    points : (n, d) float
        ``n >= 2``. Those of a closed curve repeat the first one at the end.
    along : (n,) float
        Parameter of each point, increasing from 0: the arc length, or that of a smoother
        curve beside this one.
    at : (m,) float
        Where the result is wanted.
    sigma : float
        Standard deviation in the parameter, above 0.
    closed : bool
        Whether the curve is periodic.

    Returns
    -------
    (m, d) float
    """
    length = float(along[-1])
    sigma = min(sigma, WIDEST * length)
    cells = int(np.clip(np.ceil(length / sigma * CELLS_PER_SIGMA), FEWEST_CELLS, MOST_CELLS))
    step = length / cells
    borders = np.linspace(0.0, length, cells + 1)
    means = np.diff(_integral(points, along, borders), axis=0) / step
    margin = int(np.ceil(REACH * sigma / step))
    kernel = np.exp(-0.5 * (np.arange(-margin, margin + 1) * step / sigma) ** 2)
    kernel /= kernel.sum()
    extended = _continued(means, points[0], points[-1], margin, closed)
    soft = np.column_stack([np.convolve(column, kernel, "valid") for column in extended.T])
    middles = 0.5 * (borders[1:] + borders[:-1])
    if closed:
        middles = np.concatenate(([middles[-1] - length], middles, [middles[0] + length]))
        soft = np.vstack((soft[-1:], soft, soft[:1]))
    else:
        middles = np.concatenate(([0.0], middles, [length]))
        soft = np.vstack((points[:1], soft, points[-1:]))
    return points_along(soft, middles, at)


def _integral(points: Array, along: Array, at: Array) -> Array:
    """Integrate the polyline over its parameter up to given places, exactly."""
    steps = np.diff(along)[:, None]
    pieces = np.cumsum(0.5 * steps * (points[1:] + points[:-1]), axis=0)
    sums = np.vstack((np.zeros(points.shape[1]), pieces))
    before = np.clip(np.searchsorted(along, at, "right") - 1, 0, len(along) - 2)
    here = points_along(points, along, at)
    return np.asarray(sums[before] + 0.5 * (at - along[before])[:, None] * (points[before] + here))


def _continued(means: Array, first: Array, last: Array, margin: int, closed: bool) -> Array:
    """Return the cells with `margin` more at each end: wrapped round, or reflected about the ends.

    The reflection is repeated as often as it takes.
    """
    cells = len(means)
    index = np.arange(-margin, cells + margin)
    if closed:
        return np.asarray(means[index % cells])
    turns, rest = np.divmod(index, 2 * cells)
    mirrored = (rest >= cells)[:, None]
    back = np.where(rest >= cells, 2 * cells - 1 - rest, rest)
    values = np.where(mirrored, 2.0 * last - means[back], means[back])
    return np.asarray(values + turns[:, None] * (2.0 * (last - first)))
