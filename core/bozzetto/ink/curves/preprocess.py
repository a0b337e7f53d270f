"""Preparation of ink for fitting: cleaned, smoothed and evenly spaced."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink.curves.noise_estimate import sample_noise
from bozzetto.ink.curves.resample import arc_length, distinct, points_along
from bozzetto.ink.curves.smooth import convolve

FILTER: Final = 4.0
"""Widest standard deviation of the low-pass along the curve, pixels. Chord lengths of dense
noisy ink are too long (1000 samples with 1 px noise: 1392 for 741 px); this width cures it."""

NOISY: Final = 0.3
"""Noise of the samples, in pixels, at which the low-pass is that wide; for less noise it is
narrower in proportion. A Gaussian shrinks bends (radius 20 px: by 0.4 px), so ink without
noise is not filtered at all."""

NARROWEST: Final = 0.05
"""Low-pass, in pixels, below which there is nothing to filter."""

SPACING: Final = 3.0
"""Distance of prepared points, pixels: below the filter's width, so that nothing is lost."""

FILTER_SHARE: Final = 0.02
"""Widest filter as a share of the length: short ink keeps its form."""

MOST_POINTS: Final = 1200
"""Most prepared points of a curve: longer ink is spaced and filtered more widely."""

ROUNDS: Final = 8
"""Limit of rounds in which the arc length is measured again on the smoothed curve."""

SETTLED: Final = 0.99
"""A round that leaves this share of the length ends the rounds."""

LARGEST: Final = 1e12
"""Largest coordinate accepted, in pixels: beyond it a pixel is lost in rounding."""


@dataclass(frozen=True, eq=False)
class PreparedCurve:
    """Ink ready for fitting.

    Attributes
    ----------
    points : (m, d) float
        About equally spaced.
    weights : (m,) float
    along : (n,) float
        Share of the length of the smoothed curve at each given point.
    noise : float
        Standard deviation of the given points across the curve (`sample_noise`).
    """

    points: Array
    weights: Array
    along: Array
    noise: float


def checked_points(points: ArrayLike, pixel: float) -> Array:
    """Return points as a checked array.

    Parameters
    ----------
    points : (n, 2) or (n, 3) array_like
        Pixels; see `pixel` for other units.
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


def prepare_curve(
    points: Array, weights: Array, *, pixel: float, closed: bool = False, spacing: float = SPACING
) -> PreparedCurve:
    """Smooth a curve along its own length as much as its noise asks, and space it equally.

    The Gaussian runs in the arc length of the *smoothed* curve, found in a few rounds: the
    arc length of noisy ink grows with the sampling rate, that of the smoothed one does not.
    The Gaussian is as wide as the noise asks; ink without noise keeps its form.
    The end points of an open curve stay where they are.

    Parameters
    ----------
    points : (n, d) float
        ``n >= 1``.
    weights : (n,) float
        Weight of each point, not negative.
    pixel : float
        Length of a pixel in the units of the points.
    closed : bool
        Whether the last point is joined to the first.
    spacing : float
        Wanted distance of the prepared points, pixels.
    """
    kept = distinct(points, closed=closed)
    turn = np.append(kept, kept[0]) if closed else kept
    place, weight = points[turn], weights[turn]
    along = arc_length(place)
    noise = sample_noise(place, pixel=pixel)
    soft = place
    for _ in range(ROUNDS):
        length = float(along[-1])
        width = _width(length, pixel) * min(1.0, noise / (NOISY * pixel))
        if length <= 0 or len(place) < 3 or width < NARROWEST * pixel:
            break
        soft = convolve(place, along, along, width, closed=closed)
        again = arc_length(soft)
        ratio, along = again[-1] / length, _increasing(again)
        if ratio >= SETTLED:
            break
    length = float(along[-1])
    step = max(min(spacing * pixel, 0.75 * FILTER_SHARE * length), length / MOST_POINTS)
    count = max(1, round(length / step)) + 1 if length > 0 else 1
    stations = np.linspace(0.0, length, count)[: count - 1 if closed and count > 1 else count]
    own = np.interp(arc_length(points), arc_length(place), along)
    return PreparedCurve(
        points_along(soft, along, stations),
        np.interp(stations, along, weight),
        own / length if length > 0 else np.zeros(len(points)),
        noise,
    )


def _width(length: float, pixel: float) -> float:
    """Return the standard deviation of the widest filter for a curve of this length."""
    return max(min(FILTER * pixel, FILTER_SHARE * length), 2.0 * length / MOST_POINTS)


def _increasing(along: Array) -> Array:
    """Return arc lengths without steps of no length, which would make the inverse ambiguous."""
    hair = 1e-9 * along[-1] / len(along)
    return np.asarray(along + hair * np.arange(len(along)))
