"""Weights of control points, and curves that reach given ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.geometry import DEGREE, Spline


def free_controls(spline: Spline) -> Array:
    """Return the control points that can be chosen, (k, d): those of a closed curve once."""
    points = spline.control_points
    return points[:-DEGREE] if spline.closed else points


def with_controls(spline: Spline, controls: Array) -> Spline:
    """Return a spline over the same knots with other control points, as `free_controls` lists."""
    points = np.vstack((controls, controls[:DEGREE])) if spline.closed else controls
    return Spline(spline.knots, points, spline.closed)


def chord_length(spline: Spline) -> float:
    """Return the length of a chain of 64 chords along a curve, mm: quick, and close enough."""
    points = spline.sampled(65)
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def greville(spline: Spline) -> Array:
    """Return where along the curve each control point acts, as shares of its range, (k,)."""
    begin, end = spline.range
    knots = spline.knots
    mean = (knots[1:-3] + knots[2:-2] + knots[3:-1]) / DEGREE
    return np.asarray((mean - begin) / (end - begin))


def bent(spline: Spline, start: ArrayLike, end: ArrayLike) -> Spline:
    """Return an open clamped spline that begins and ends in the very numbers given.

    The displacement fades from one end to the other by ``S = t² (3 − 2t)``, so that the
    directions of the ends hardly turn.
    """
    points = spline.control_points
    first, last = np.asarray(start, float), np.asarray(end, float)
    if (first == points[0]).all() and (last == points[-1]).all():
        return spline
    along = np.clip(greville(spline), 0.0, 1.0)
    share = (along**2 * (3.0 - 2.0 * along))[:, None]
    moved = points + (1.0 - share) * (first - points[0]) + share * (last - points[-1])
    moved[0], moved[-1] = first, last
    return Spline(spline.knots, moved)
