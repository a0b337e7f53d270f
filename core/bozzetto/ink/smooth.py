"""Smoothing that neither lags behind the pen nor depends on how often it was sampled."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.ink.resample import arc_length, distinct

__all__ = ["smooth"]

Array = NDArray[np.float64]

REACH: Final = 4.0
"""Half width of the kernel in standard deviations; what lies beyond weighs 6e-5."""

STEPS_PER_SIGMA: Final = 6
"""Fineness of the convolution: linear interpolation errs by less than sigma / 250 then."""

WIDEST: Final = 4.0
"""Largest sigma in curve lengths: wider kernels give the same chord, or the same dot."""

MAX_STEPS: Final = 200_000
"""Most steps along one curve; beyond that sigma is far below what a hand can draw."""


def smooth(points: ArrayLike, sigma: float, *, closed: bool = False) -> Array:
    """Convolve a curve with a Gaussian in arc length.

    The convolution is over the polyline, not over its samples, so the result does not
    depend on the sampling rate. It looks both ways along the curve and therefore has no
    lag. An open curve is continued by its point reflection about each end, which keeps the
    end points where they are; a closed one is continued periodically. A circle of radius r
    shrinks by the factor exp(-sigma² / 2r²).

    Parameters
    ----------
    points : (n, 2) array_like
    sigma : float
        Standard deviation along the curve, in the units of the points; 0 changes nothing.
    closed : bool
        The curve goes on from its last point to its first.

    Returns
    -------
    (n, 2) float
        One point for every point given; a repeated first point stays repeated.
    """
    place = np.asarray(points, float)
    kept = distinct(place, closed=closed)
    if sigma <= 0 or len(kept) < (3 if closed else 2):
        return place.copy()
    ring = np.vstack((place[kept], place[:1])) if closed else place[kept]
    along = arc_length(ring)
    length = float(along[-1])
    sigma = min(sigma, WIDEST * length)
    steps = int(np.clip(np.ceil(length / sigma * STEPS_PER_SIGMA), 8, MAX_STEPS))
    stations = np.linspace(0.0, length, steps + 1)
    fine = np.column_stack([np.interp(stations, along, ring[:, axis]) for axis in (0, 1)])

    step = length / steps
    margin = int(np.ceil(REACH * sigma / step))
    offsets = np.arange(-margin, margin + 1) * step
    kernel = np.exp(-0.5 * (offsets / sigma) ** 2)
    kernel /= kernel.sum()
    extended = _continued(fine, margin, closed)
    soft = np.column_stack([np.convolve(extended[:, axis], kernel, "valid") for axis in (0, 1)])
    if not closed:
        soft[0], soft[-1] = fine[0], fine[-1]  # equal already, but for rounding

    own = arc_length(place)
    return np.column_stack([np.interp(own, stations, soft[:, axis]) for axis in (0, 1)])


def _continued(fine: Array, margin: int, closed: bool) -> Array:
    """The curve with `margin` more points at each end."""
    last = len(fine) - 1
    before, after = np.arange(-margin, 0), np.arange(last + 1, last + 1 + margin)
    if closed:
        return np.vstack((fine[before % last], fine, fine[after % last]))
    return np.vstack((_reflected(fine, before), fine, _reflected(fine, after)))


def _reflected(fine: Array, index: NDArray[np.intp]) -> Array:
    """Odd continuation: point reflection about an end, as often as it takes."""
    last = len(fine) - 1
    turns, rest = np.divmod(index, 2 * last)
    mirrored = rest > last
    back = np.where(mirrored, 2 * last - rest, rest)
    ends = 2.0 * (fine[last] - fine[0])
    values = np.where(mirrored[:, None], 2.0 * fine[last] - fine[back], fine[back])
    return np.asarray(values + turns[:, None] * ends)
