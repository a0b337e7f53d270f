"""Points at equal steps along a curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Index


def arc_length(points: ArrayLike) -> Array:
    """Return the length of the polyline up to each point.

    Parameters
    ----------
    points : (n, 2) array_like
        Canvas pixels.

    Returns
    -------
    (n,) float
        Starts at 0, does not decrease; the last value is the whole length.
    """
    place = np.asarray(points, float)
    steps = np.linalg.norm(np.diff(place, axis=0), axis=1)
    return np.concatenate(([0.0], np.cumsum(steps)))


def points_along(points: Array, along: Array, at: ArrayLike) -> Array:
    """Interpolate a polyline.

    Parameters
    ----------
    points : (n, d) float
        Its corners.
    along : (n,) float
        Their values of a parameter, increasing, such as the arc length.
    at : (m,) or () float
        Where the results are wanted.

    Returns
    -------
    (m, d) or (d,) float
    """
    places = np.asarray(at, float)
    return np.stack([np.interp(places, along, column) for column in points.T], axis=-1)


def distinct(points: ArrayLike, *, closed: bool = False) -> Index:
    """Return the indices of the points that differ from the one before.

    Parameters
    ----------
    points : (n, 2) array_like
        Canvas pixels.
    closed : bool
        The last point is followed by the first: trailing copies of the first are left out.

    Returns
    -------
    (m,) int
        Increasing; holds 0 where there is a point at all.
    """
    place = np.asarray(points, float)
    if not len(place):
        return np.zeros(0, np.intp)
    kept = np.flatnonzero(np.append(True, (place[1:] != place[:-1]).any(axis=1)))
    if closed and len(kept) > 1 and (place[kept[-1]] == place[0]).all():
        kept = kept[:-1]
    return kept


def resample(
    points: ArrayLike,
    *,
    spacing: float | None = None,
    count: int | None = None,
    closed: bool = False,
) -> Array:
    """Return points at equal arc length along a polyline.

    Parameters
    ----------
    points : (n, 2) array_like
        ``n >= 1``. A closed curve may repeat its first point at the end or not.
    spacing : float, optional
        Wanted distance between points, along the curve. It is rounded so that a whole
        number of steps fits.
    count : int, optional
        Wanted number of points; exactly one of the two is given.
    closed : bool
        Whether the last point is joined to the first.

    Returns
    -------
    (m, 2) float
        Both ends of an open curve are kept. A closed result starts at the first point and
        does not repeat it. A curve without length gives copies of its point (one, where a
        spacing was asked).
    """
    place = np.asarray(points, float)
    place = place[distinct(place, closed=closed)]
    if closed:
        place = np.vstack((place, place[:1]))
    along = arc_length(place)
    stations = _stations(float(along[-1]), spacing, count, closed)
    return points_along(place, along, stations)


def _stations(length: float, spacing: float | None, count: int | None, closed: bool) -> Array:
    if (spacing is None) == (count is None):
        raise ValueError("resampling needs either a spacing or a count")
    if count is None:
        assert spacing is not None
        if not spacing > 0:
            raise ValueError("a spacing must be above zero")
        steps = max(1, round(length / spacing)) if length > 0 else 0
        count = max(1, steps if closed else steps + 1)
    if count < 1:
        raise ValueError("resampling needs at least one point")
    return np.linspace(0.0, length, count, endpoint=not closed)


def steps_along(points: ArrayLike, step: float, most: int) -> Array:
    """Return places at even steps along a growing polyline: a longer one begins with the same.

    Parameters
    ----------
    points : (n, 2) array_like
        Canvas pixels.
    step : float
        Length between two places.
    most : int
        Most places between two points; after a leap they are farther apart.

    Returns
    -------
    (k, 2) float
        The first point, then one after every step; in general not the last point.
    """
    line = np.asarray(points, float)
    if not len(line):
        return line
    along = arc_length(line)
    passed = np.floor(along / step)
    counts = np.diff(passed)
    leaps = np.flatnonzero(counts > most)
    # Those between two points are numbered on from the last one before; leaps get their own.
    counts = np.where(counts > most, 0.0, counts).astype(np.intp)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    steps = step * (np.repeat(passed[:-1] + 1.0, counts) + within)
    rest = [np.linspace(along[k], along[k + 1], most + 1)[1:] for k in leaps.tolist()]
    steps = np.sort(np.concatenate([[0.0], steps[steps <= along[-1]], *rest]))
    return points_along(line, along, steps)
