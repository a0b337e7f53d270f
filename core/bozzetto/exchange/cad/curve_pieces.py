"""Curves of CAD files as B-splines, exactly: arcs of ellipses, parts of curves, curves in a row."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.cad.cad_curves import MAX_DEGREE
from bozzetto.exchange.limits import MAX_COORDINATE
from bozzetto.geometry.basis import lifted, lowered
from bozzetto.geometry.curve import Curve
from bozzetto.geometry.refinement import elevated

QUARTER: Final = 0.5 * math.pi

SAME_PLACE: Final = 1e-6
"""Ends that are nearer than this share of the size of both are one place; it is what most CAD
programs write as the accuracy of what is 1 m large."""

SAME_ANGLE: Final = 1e-9
"""Angles that differ by less are the same, radians."""


class CurveError(FormatError):
    """One curve, or what it is made of, is damaged; others may be sound."""


def checked_curve(
    degree: int,
    knots: ArrayLike,
    points: ArrayLike,
    weights: ArrayLike | None = None,
    *,
    closed: bool = False,
    name: str = "curve",
) -> Curve:
    """Return a curve of a file.

    Raises
    ------
    CurveError
        If its values make no curve.
    """
    try:
        places = np.asarray(points, float).reshape(-1, 3)
        row = np.asarray(knots, float)
        share = None if weights is None else np.asarray(weights, float)
        if not 1 <= degree <= MAX_DEGREE:
            raise ValueError("a degree that nobody writes")
        if not all(np.isfinite(one).all() for one in (places, row, share) if one is not None):
            raise ValueError("a number that is not finite")
        if places.size and not np.abs(places).max() <= MAX_COORDINATE:
            raise ValueError("it reaches too far")
        if share is not None and (share == share[0]).all():
            share = None
        made = Curve(degree, row, places, share, closed, name)
        if not made.range[1] > made.range[0]:
            raise ValueError("no length")
    except (ValueError, IndexError) as problem:
        raise CurveError(f"A curve of this file is damaged: {words_of(problem)}.") from problem
    return made


def repeated(values: Any, times: Any, count: int) -> Array:
    """Return a knot vector of so many knots, told as places and how often each is there.

    Raises
    ------
    CurveError
        If there are more or fewer.
    """
    row, often = np.array(values, float), np.array(times, float)
    if row.shape != often.shape or (often < 0).any() or often.sum() != count:
        raise CurveError("The knots of a curve of this file do not fit its points.")
    return np.repeat(row, often.astype(int))


def polyline(points: ArrayLike, name: str = "curve") -> Curve:
    """Return straight lines from point to point, (n, 3), mm; closed where the last is the first."""
    places = np.asarray(points, float).reshape(-1, 3)
    count = len(places)
    knots = np.concatenate(([0.0], np.arange(count), [max(count - 1.0, 0.0)]))
    closed = count > 3 and bool((places[0] == places[-1]).all())
    return checked_curve(1, knots, places, closed=closed, name=name)


def ellipse_arc(
    center: ArrayLike, first: ArrayLike, second: ArrayLike, begin: float, end: float
) -> Curve:
    """Return an arc of an ellipse as rational quadratics (Piegl & Tiller 1997, 7.3).

    Parameters
    ----------
    center, first, second : (3,) array_like
        The arc is ``center + cos(t) first + sin(t) second``, mm.
    begin, end : float
        Values of t, radians, of which the second is larger, by a whole turn at most.
    """
    o, a, b = (np.asarray(each, float) for each in (center, first, second))
    turn = end - begin
    whole = abs(turn - 2.0 * math.pi) <= SAME_ANGLE
    count = max(1, math.ceil(turn / QUARTER - SAME_ANGLE))
    at = begin + turn * np.arange(2 * count + 1) / (2 * count)
    cosine = math.cos(turn / (2 * count))
    radius = np.where(np.arange(2 * count + 1) % 2 == 0, 1.0, 1.0 / cosine)
    cosines, sines = np.cos(at), np.sin(at)
    for values in (cosines, sines):  # exact where an axis of the ellipse is met
        values[np.abs(values) < 1e-15] = 0.0
    points = o + (radius * cosines)[:, None] * a + (radius * sines)[:, None] * b
    if whole:
        points[-1] = points[0]
    weights = np.where(np.arange(2 * count + 1) % 2 == 0, 1.0, cosine)
    joints = begin + turn * np.arange(1, count) / count
    knots = np.concatenate(([begin] * 3, np.repeat(joints, 2), [end] * 3))
    return checked_curve(2, knots, points, weights, closed=whole)


def part_of(curve: Curve, begin: float, end: float) -> Curve:
    """Return a curve between two of its parameters; all of it where they are its ends."""
    first, last = curve.range
    near = 1e-12 * max(abs(first), abs(last), last - first)
    begin, end = max(begin, first), min(end, last)
    if begin - first <= near and last - end <= near:
        return curve
    if not end - begin > near:
        raise CurveError("A curve of this file is cut to no length.")
    inner = curve.knots[(curve.knots > begin) & (curve.knots < end)]
    ends = np.ones(curve.degree + 1)
    row = curve.with_knots(np.concatenate((begin * ends, inner, end * ends)))
    return replace(row, closed=False)


def joined(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """Return curves that follow one another as one, exactly; as they are where they do not.

    All get the highest of their degrees; where two meet, the knot is as often there as the degree,
    so that the curve may turn.
    """
    if len(curves) < 2:
        return tuple(curves)
    rows = [curve.clamped() for curve in curves]
    for one, two in pairwise(rows):
        both = np.concatenate((one.control_points, two.control_points))
        size = float(np.ptp(both, axis=0).max())
        if np.abs(one.control_points[-1] - two.control_points[0]).max() > SAME_PLACE * size:
            return tuple(curves)
    degree = max(curve.degree for curve in rows)
    rational = any(curve.weights is not None for curve in rows)
    knots = np.zeros(degree + 1)
    places: list[Array] = []
    for curve in rows:
        weights = curve.weights
        if rational and weights is None:
            weights = np.ones(len(curve.control_points))
        points, own = lifted(curve.control_points, weights), curve.knots
        for low in range(curve.degree, degree):
            own, points = elevated(low, own, points)
        if places and rational:
            points = points * (places[-1][-1, -1] / points[0, -1])
        begin = knots[-1]
        inner = own[degree + 1 : -degree - 1] - own[0] + begin
        end = begin + own[-1] - own[0]
        knots = np.concatenate((knots[:-1] if places else knots, inner, [end] * (degree + 1)))
        places.append(points[1:] if places else points)
    whole, shares = lowered(np.concatenate(places))
    size = float(np.ptp(whole, axis=0).max())
    closed = bool(np.abs(whole[0] - whole[-1]).max() <= SAME_PLACE * size)
    made = checked_curve(degree, knots, whole, shares if rational else None, closed=closed)
    return (replace(made, name=curves[0].name, color=curves[0].color),)
