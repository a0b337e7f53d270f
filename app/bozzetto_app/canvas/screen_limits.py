"""The one place where numbers become coordinates of the screen.

Places that are projected out of the world, or reported by a driver, can lie anywhere: at a zoom of
10⁹ a point 3 mm beside the sheet is seen three thousand million pixels away, and one behind the
eye nowhere. Qt keeps whole coordinates in 32 bits and its rasteriser in 26 bits before the
binary point. A number beyond 32 bits raises an `OverflowError` without a value; where that leaves
an event handler that was called out of Python, PySide 6.11 asks the missing value for its
arguments, which ends the process. So everything that the canvas paints or marks passes here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPoint, QPointF, QRect

__all__ = [
    "FARTHEST",
    "inside_runs",
    "is_inside",
    "limited",
    "limited_place",
    "pieces_within",
    "point_at",
    "rect_about",
    "rect_around",
    "whole_point",
]

FARTHEST: Final = 1.0e6
"""Largest coordinate that Qt is given, pixels.

Qt's rasteriser counts in 1/64 pixel with 32 bits and thus ends at 3.3 · 10⁷; sums and differences
of a few such coordinates must still fit. No screen is as large.
"""

Line = Sequence[tuple[float, ...]]


def limited(value: float) -> float:
    """Return the nearest number that Qt takes; NaN becomes the farthest one."""
    if math.isnan(value):
        return -FARTHEST
    return min(max(value, -FARTHEST), FARTHEST)


def is_inside(x: float, y: float) -> bool:
    """Whether Qt takes a place as it is; false for what is no number."""
    return abs(x) <= FARTHEST and abs(y) <= FARTHEST


def limited_place(x: float, y: float) -> tuple[float, float]:
    """Return a point within the limits; one beyond is moved to them, out of sight."""
    return limited(x), limited(y)


def point_at(x: float, y: float) -> QPointF:
    """Return a point for a painter."""
    return QPointF(limited(x), limited(y))


def whole_point(x: float, y: float) -> QPoint:
    """Return a point for a widget, in whole pixels."""
    return QPoint(round(limited(x)), round(limited(y)))


def rect_about(xs: Sequence[float], ys: Sequence[float], margin: float) -> QRect:
    """Return the rectangle around some points, in whole pixels; empty without points.

    Parameters
    ----------
    xs, ys : sequence of float
        Coordinates of the points, pixels.
    margin : float
        Room on all sides, pixels.
    """
    if not xs or not ys:
        return QRect()
    left, top = math.floor(limited(min(xs) - margin)), math.floor(limited(min(ys) - margin))
    right, bottom = math.ceil(limited(max(xs) + margin)), math.ceil(limited(max(ys) + margin))
    return QRect(left, top, right - left, bottom - top)


def rect_around(x: float, y: float, radius: float) -> QRect:
    """Return the rectangle around a disc, in whole pixels, with a pixel to spare."""
    left, top = math.floor(limited(x - radius)), math.floor(limited(y - radius))
    size = math.ceil(2.0 * limited(radius)) + 2
    return QRect(left, top, size, size)


def inside_runs(line: Line) -> list[list[tuple[float, ...]]]:
    """Return the parts of a line that lie within the limits.

    Parameters
    ----------
    line : sequence of (x, y, …)
        Further columns, such as a width, are interpolated where the line is cut. The line is
        torn where a number is not finite.

    Returns
    -------
    list of lists
        Runs in the line's order; the direction of no piece is changed.

    Notes
    -----
    Liang & Barsky, "A new concept and method for line clipping", 1984.
    """
    if all(is_inside(point[0], point[1]) for point in line):
        return [list(line)] if line else []
    runs: list[list[tuple[float, ...]]] = []
    for begin, end in pairwise(line):
        piece = _inside(begin, end)
        if piece is None:
            continue
        if runs and runs[-1][-1] == piece[0]:
            runs[-1].append(piece[1])
        else:
            runs.append(list(piece))
    return runs


def _inside(
    begin: tuple[float, ...], end: tuple[float, ...]
) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Return the part of a straight piece within the limits; None if there is none."""
    if not all(map(math.isfinite, (*begin, *end))):
        return None
    enters, leaves = 0.0, 1.0
    for one, other in zip(begin[:2], end[:2], strict=True):
        way = other - one
        if way == 0.0 or not math.isfinite(way):
            if abs(one) > FARTHEST:
                return None
            continue
        at = sorted(((-FARTHEST - one) / way, (FARTHEST - one) / way))
        enters, leaves = max(enters, at[0]), min(leaves, at[1])
    if enters > leaves:
        return None

    def on_the_way(share: float) -> tuple[float, ...]:
        place = [a + share * (b - a) for a, b in zip(begin, end, strict=True)]
        return (limited(place[0]), limited(place[1]), *place[2:])

    first = begin if is_inside(*begin[:2]) else on_the_way(enters)
    last = end if is_inside(*end[:2]) else on_the_way(leaves)
    return first, last


def pieces_within(
    begins: NDArray[np.float64], ends: NDArray[np.float64], reach: float
) -> NDArray[np.float64]:
    """Cut straight pieces at a square about the origin.

    Parameters
    ----------
    begins, ends : (n, 2) float
        Pixels; what is not finite has no part inside.
    reach : float
        Half the side of the square, pixels.

    Returns
    -------
    (k, 4) float
        The parts inside: x, y, x, y.

    Notes
    -----
    Long lines cost Qt the more the less is seen of them. Liang & Barsky, "A new concept and
    method for line clipping", 1984.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        way = ends - begins
        one, other = (-reach - begins) / way, (reach - begins) / way
        enters, leaves = np.minimum(one, other), np.maximum(one, other)
        # Along a side of the square 0 / 0 or a / 0: in all the way, or nowhere.
        along, inside = way == 0.0, np.abs(begins) <= reach
        enters = np.where(along, np.where(inside, -np.inf, np.inf), enters)
        leaves = np.where(along, np.where(inside, np.inf, -np.inf), leaves)
        first = np.maximum(enters.max(axis=1, initial=0.0), 0.0)
        last = np.minimum(leaves.min(axis=1, initial=1.0), 1.0)
        crosses = first <= last  # false where something is not finite
    begins, way = begins[crosses], way[crosses]
    first, last = first[crosses, None], last[crosses, None]
    return np.hstack((begins + first * way, begins + last * way))
