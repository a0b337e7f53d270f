"""Convex outlines on the sheet: cut by planes and windows, and the pixels they cross."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Polygon = NDArray[np.float64]

MARGIN: Final = 2.0
"""Distance beyond a window, px, at which outlines are cut, so that the cuts are not visible."""


def cut(outline: Polygon, normal: ArrayLike, least: float) -> Polygon:
    """Return the part of a convex outline where normal · point ≥ least.

    Sutherland & Hodgman 1974, "Reentrant polygon clipping", for one plane.

    Parameters
    ----------
    outline : (n, d) float
        Corners in order.
    normal : (d,) array_like
        Normal of the border, towards the part that stays.
    least : float
        Least value of normal · point that stays.

    Returns
    -------
    (m, d) float
        Empty if nothing is left.
    """
    if not len(outline):
        return outline
    above = outline @ np.asarray(normal, np.float64) - least
    pieces = []
    for k in range(len(outline)):
        n = (k + 1) % len(outline)
        if above[k] >= 0:
            pieces.append(outline[k])
        if (above[k] >= 0) != (above[n] >= 0):
            t = above[k] / (above[k] - above[n])
            pieces.append(outline[k] + t * (outline[n] - outline[k]))
    return np.array(pieces) if pieces else outline[:0]


def cut_to_window(outline: Polygon, width: int, height: int) -> Polygon:
    """Return the part of a convex outline (n, 2) in a window and a margin round it, px."""
    for axis, size in ((0, width), (1, height)):
        side = np.eye(2)[axis]
        outline = cut(outline, side, -MARGIN)
        outline = cut(outline, -side, -size - MARGIN)
    return outline


def crossed(outline: Polygon) -> NDArray[np.intp]:
    """Return pixels (column, row) that the sides of an outline (n, 2) pass through, or nearly so.

    Returns
    -------
    (m, 2) int
        Each once.
    """
    found = []
    for begin, end in zip(outline, np.roll(outline, -1, 0), strict=True):
        span = end - begin
        major = int(np.argmax(np.abs(span)))
        minor = 1 - major
        low, high = sorted((begin[major], end[major]))
        cells = np.arange(np.floor(low), np.floor(high) + 1)
        slope = span[minor] / span[major] if span[major] else 0.0
        middle = begin[minor] + slope * (np.clip(cells + 0.5, low, high) - begin[major])
        for step in (-1, 0, 1):
            pair = np.empty((len(cells), 2), np.intp)
            pair[:, major], pair[:, minor] = cells, np.floor(middle) + step
            found.append(pair)
    cells = np.concatenate(found)
    first = cells.min(0)
    width = int(cells[:, 0].max() - first[0]) + 1
    row, column = np.divmod(np.unique((cells - first) @ (1, width)), width)
    return np.asarray(np.column_stack((column, row)) + first)
