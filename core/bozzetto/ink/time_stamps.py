"""Time stamps that increase strictly, so that speeds can be computed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.ink.curves.resample import arc_length

if TYPE_CHECKING:
    from bozzetto.arrays import Array

NOMINAL_INTERVAL: Final = 1.0 / 125.0
"""Seconds between samples where the stamps say nothing: the slowest common tablet rate."""


def regular_times(t: ArrayLike) -> Array:
    """Return strictly increasing times for samples of which several share a stamp.

    Tablets and window systems tick at 8 or 16 ms and deliver several samples per tick. The
    samples of one tick are spread so that their middle keeps the stamp; the first and the
    last sample of the stroke keep theirs, and so does every sample alone on its tick.

    Parameters
    ----------
    t : (n,) array_like
        Seconds. A stamp that goes back counts as the one before it.

    Returns
    -------
    (n,) float
        Strictly increasing stamps come back unchanged. If all are equal there is no
        duration to keep, and the samples are `NOMINAL_INTERVAL` apart.
    """
    stamps: Array = np.maximum.accumulate(np.asarray(t, float))
    count = len(stamps)
    if count < 2:
        return stamps
    starts = np.flatnonzero(np.append(True, stamps[1:] > stamps[:-1]))
    if len(starts) == 1:
        return np.asarray(stamps[0] + np.arange(count) * NOMINAL_INTERVAL)
    ends = np.append(starts[1:], count) - 1
    anchors = 0.5 * (starts + ends)
    anchors[0], anchors[-1] = 0, count - 1
    times = np.interp(np.arange(count), anchors, stamps[starts])
    return times if (np.diff(times) > 0).all() else _spaced(times)


def _spaced(times: Array) -> Array:
    """Separate stamps that rounding has pressed together, by the smallest steps there are."""
    for index in range(1, len(times)):
        if times[index] <= times[index - 1]:
            times[index] = np.nextafter(times[index - 1], np.inf)
    return times


def speeds(points: ArrayLike, t: ArrayLike) -> Array:
    """Return the speed of the pen at each sample.

    Parameters
    ----------
    points : (n, 2) array_like
        Canvas pixels.
    t : (n,) array_like
        Seconds; regularised here.

    Returns
    -------
    (n,) float
        Units of the points per second, by second-order differences.
    """
    along = arc_length(points)
    if len(along) < 2:
        return np.zeros(len(along))
    return np.asarray(np.gradient(along, regular_times(t)))
