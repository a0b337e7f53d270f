"""Polylines: their length, places between their points, and runs of marked points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Index
from bozzetto.ink import arc_length


def length_of(points: ArrayLike) -> float:
    """Return the length of the polyline through points (n, d), in their unit."""
    return float(arc_length(points)[-1])


def interpolate(at: ArrayLike, stations: ArrayLike, rows: Array) -> Array:
    """Return rows of an array at stations between those of its own rows.

    Parameters
    ----------
    at : (m,) array_like
        Stations that are asked for; beyond the ends the end rows are given.
    stations : (n,) array_like
        Stations of the rows, not decreasing.
    rows : (n, d) float
        Points, or whatever else varies linearly between the stations.

    Returns
    -------
    (m, d) float
    """
    asked, known = np.asarray(at, float), np.asarray(stations, float)
    return np.column_stack([np.interp(asked, known, column) for column in rows.T])


def runs(flags: ArrayLike) -> Index:
    """Return the runs of true flags (n,), (k, 2): the first of each, and the one after its last."""
    marked = np.concatenate(([0], np.asarray(flags, np.int8), [0]))
    return np.flatnonzero(np.diff(marked)).reshape(-1, 2)
