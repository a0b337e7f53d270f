"""Ink made ready for fitting: cleaned, smoothed and spaced whatever the sampling rate was."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError
from bozzetto.ink.resample import arc_length, distinct

__all__ = ["Prepared", "checked_points", "prepare"]

Array = NDArray[np.float64]

FILTER: Final = 4.0
"""Standard deviation of the low-pass along the curve, pixels. Chord lengths of dense noisy
ink are too long (1000 samples with 1 px noise: 1392 for 741 px); this width cures it."""

SPACING: Final = 3.0
"""Distance of prepared points, pixels: below the filter's width, so that nothing is lost."""

FILTER_SHARE: Final = 0.02
"""Widest filter as a share of the length: short ink keeps its form."""

MOST_POINTS: Final = 1200
"""Most prepared points of a curve: longer ink is spaced and filtered more widely."""

ROUNDS: Final = 8
"""Most rounds in which the arc length is measured anew on the smoothed curve."""

SETTLED: Final = 0.99
"""A round that leaves this share of the length ends the rounds."""

CELLS_PER_FILTER: Final = 4
"""Fineness of the convolution."""

REACH: Final = 3.5
"""Half width of the kernel in standard deviations."""

LARGEST: Final = 1e12
"""Largest coordinate accepted, in pixels: beyond it a pixel is lost in rounding."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """Ink ready for fitting.

    Attributes
    ----------
    points : (m, d) float
        About equally spaced.
    weights : (m,) float
    along : (n,) float
        Share of the length of the smoothed curve at each given point.
    noise : float
        Typical distance of the given points from the smoothed curve, sideways.
    """

    points: Array
    weights: Array
    along: Array
    noise: float


def checked_points(points: ArrayLike, pixel: float) -> Array:
    """Points as an array.

    Parameters
    ----------
    points : (n, 2) or (n, 3) array_like
    pixel : float
        Length of a pixel in the units of the points.

    Raises
    ------
    UserError
        If there are none, or some are not finite or beyond all bounds.
    """
    try:
        place = np.asarray(points, float)
    except (TypeError, ValueError):
        raise UserError("The ink is not made of points: draw the curve again.") from None
    if place.ndim != 2 or not len(place) or place.shape[1] not in (2, 3):
        raise UserError("The ink holds no points: draw the curve again.")
    if not (np.isfinite(place).all() and np.abs(place).max() <= LARGEST * pixel):
        raise UserError("The ink runs beyond all bounds: draw the curve again.")
    return place


def prepare(
    points: Array, weights: Array, *, pixel: float, closed: bool = False, spacing: float = SPACING
) -> Prepared:
    """Smooth a curve along its own length, and space it equally.

    The Gaussian runs in the arc length of the *smoothed* curve, found in a few rounds: the
    arc length of noisy ink grows with the sampling rate, that of the smoothed one does not.
    Samples are averaged over cells of the curve, so a dense stroke loses no information.
    The end points of an open curve stay where they are.

    Parameters
    ----------
    points : (n, d) float
        ``n >= 1``.
    weights : (n,) float
    pixel : float
        Length of a pixel in the units of the points.
    closed : bool
        The curve goes on from its last point to its first.
    spacing : float
        Wanted distance of the prepared points, pixels.
    """
    kept = distinct(points, closed=closed)
    turn = np.append(kept, kept[0]) if closed else kept
    place, weight = points[turn], weights[turn]
    along = arc_length(place)
    soft = place
    for _ in range(ROUNDS):
        length = float(along[-1])
        if length <= 0 or len(place) < 3:
            break
        soft = _blurred(place, along, _width(length, pixel), closed)
        again = arc_length(soft)
        ratio, along = again[-1] / length, _increasing(again)
        if ratio >= SETTLED:
            break
    length = float(along[-1])
    step = max(min(spacing * pixel, 0.75 * FILTER_SHARE * length), length / MOST_POINTS)
    count = max(1, round(length / step)) + 1 if length > 0 else 1
    stations = np.linspace(0.0, length, count)[: count - 1 if closed and count > 1 else count]
    own = np.interp(arc_length(points), arc_length(place), along)
    return Prepared(
        _columns(stations, along, soft),
        np.interp(stations, along, weight),
        own / length if length > 0 else np.zeros(len(points)),
        _noise(place, soft),
    )


def _width(length: float, pixel: float) -> float:
    """Standard deviation of the filter for a curve of this length."""
    return max(min(FILTER * pixel, FILTER_SHARE * length), 2.0 * length / MOST_POINTS)


def _increasing(along: Array) -> Array:
    """Arc lengths without steps of no length, which would make the inverse ambiguous."""
    hair = 1e-9 * along[-1] / len(along)
    return np.asarray(along + hair * np.arange(len(along)))


def _columns(stations: Array, along: Array, points: Array) -> Array:
    return np.column_stack([np.interp(stations, along, column) for column in points.T])


def _blurred(place: Array, along: Array, sigma: float, closed: bool) -> Array:
    """Convolve with a Gaussian of a width measured along the curve; one point for each."""
    length = float(along[-1])
    cells = max(8, int(np.ceil(length / sigma * CELLS_PER_FILTER)))
    borders = np.linspace(0.0, length, cells + 1)
    integral = _integral(place, along, borders)
    means = np.diff(integral, axis=0) * (cells / length)
    margin = int(np.ceil(REACH * CELLS_PER_FILTER))
    kernel = np.exp(-0.5 * (np.arange(-margin, margin + 1) * (length / cells) / sigma) ** 2)
    kernel /= kernel.sum()
    index = np.arange(-margin, cells + margin)
    if closed:
        extended = means[index % cells]
    else:  # point reflection about the ends, which keeps them where they are
        inner = np.clip(np.where(index < 0, -1 - index, index), 0, None)
        inner = np.clip(np.where(inner >= cells, 2 * cells - 1 - inner, inner), 0, cells - 1)
        beyond = (index < 0)[:, None], (index >= cells)[:, None]
        extended = np.select(
            [np.broadcast_to(b, (len(index), place.shape[1])) for b in beyond],
            [2.0 * place[0] - means[inner], 2.0 * place[-1] - means[inner]],
            means[inner],
        )
    soft = np.column_stack([np.convolve(column, kernel, "valid") for column in extended.T])
    middles = 0.5 * (borders[1:] + borders[:-1])
    if closed:
        middles = np.concatenate(([middles[-1] - length], middles, [middles[0] + length]))
        soft = np.vstack((soft[-1:], soft, soft[:1]))
    else:
        middles = np.concatenate(([0.0], middles, [length]))
        soft = np.vstack((place[:1], soft, place[-1:]))
    return _columns(along, middles, soft)


def _integral(place: Array, along: Array, at: Array) -> Array:
    """Integral of the polyline over its length up to given lengths, exactly."""
    steps = np.diff(along)[:, None]
    sums = np.vstack(
        (np.zeros(place.shape[1]), np.cumsum(0.5 * steps * (place[1:] + place[:-1]), 0))
    )
    before = np.clip(np.searchsorted(along, at, "right") - 1, 0, len(along) - 2)
    here = _columns(at, along, place)
    return np.asarray(sums[before] + 0.5 * (at - along[before])[:, None] * (place[before] + here))


def _noise(place: Array, soft: Array) -> float:
    """Standard deviation of the ink about the smoothed curve, sideways; corners do not count."""
    if len(place) < 5:
        return 0.0
    tangent = np.gradient(soft, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-300)
    offset = place - soft
    aside = offset - (offset * tangent).sum(axis=1, keepdims=True) * tangent
    return float(1.4826 * np.median(np.linalg.norm(aside, axis=1)))
