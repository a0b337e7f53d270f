"""Paths clipped to a page: what lies beyond its border is not written."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.exchange.svg.path_data import Subpath

SLIVER: Final = 1e-9
"""Shortest piece that is kept, as a share of a cubic's parameter: crossings that are nearer to each
other are one, found twice."""

STRAIGHT: Final = 1e-12
"""Share of the largest coefficient below which the leading ones are rounding: a straight line is a
cubic, too, and its roots would drown in it."""

REAL: Final = 1e-6
"""Imaginary part up to which a root of a cubic is a crossing: rounding gives touching borders
some. A crossing too many only cuts a piece in two."""


def clip_path(path: Subpath, low: Array, high: Array) -> list[Subpath]:
    """Return the stretches of a path that lie on a page.

    Parameters
    ----------
    path : Subpath
        The path, in units of the page.
    low, high : (2,) float
        Upper left and lower right corner of the page.

    Returns
    -------
    list of Subpath
        The path itself where all of it lies on the page. Pieces are cut exactly: they stay
        parts of the same cubics.
    """
    cubics = path.cubics
    whole = _hull_within(cubics, low, high)
    if whole.all():
        return [path]
    beyond = _hull_beyond(cubics, low, high)
    pieces: list[Array] = []
    joins: list[bool] = []  # whether a piece goes on where the one before ended
    going_on = False
    for cubic, is_whole, is_beyond in zip(cubics, whole, beyond, strict=True):
        if is_beyond:
            going_on = False
        elif is_whole:
            pieces.append(cubic)
            joins.append(going_on)
            going_on = True
        else:
            cuts = _crossings(cubic, low, high)
            for begin, end in pairwise(cuts):
                if _is_within(_point(cubic, 0.5 * (begin + end)), low, high):
                    pieces.append(_between(cubic, begin, end))
                    joins.append(going_on)
                    going_on = True
                else:
                    going_on = False
    stretches: list[list[Array]] = []
    for piece, joined in zip(pieces, joins, strict=True):
        if joined:
            stretches[-1].append(piece)
        else:
            stretches.append([piece])
    if path.closed and len(stretches) > 1 and (pieces[0][0] == pieces[-1][3]).all():
        stretches[0] = stretches.pop() + stretches[0]
    return [Subpath(np.array(stretch), False) for stretch in stretches]


def _hull_within(cubics: Array, low: Array, high: Array) -> Flags:
    """Whether all control points of cubics (k, 4, 2) lie on the page, and so the cubics, (k,)."""
    return np.asarray(((cubics >= low) & (cubics <= high)).all(axis=(1, 2)))


def _hull_beyond(cubics: Array, low: Array, high: Array) -> Flags:
    """Whether all control points of cubics (k, 4, 2) lie beyond one side of the page, (k,)."""
    over: Flags = np.all(cubics < low, axis=1) | np.all(cubics > high, axis=1)
    return np.asarray(np.any(over, axis=1))


def _is_within(point: Array, low: Array, high: Array) -> bool:
    return bool(((point >= low) & (point <= high)).all())


def _crossings(cubic: Array, low: Array, high: Array) -> list[float]:
    """Return where a cubic meets the lines of the page's border, with 0 and 1, ascending."""
    found = [0.0, 1.0]
    p0, p1, p2, p3 = cubic
    powers = np.array([p3 - 3 * p2 + 3 * p1 - p0, 3 * (p2 - 2 * p1 + p0), 3 * (p1 - p0), p0])
    for axis in (0, 1):
        for border in (low[axis], high[axis]):
            row = powers[:, axis] - (0.0, 0.0, 0.0, border)
            row[np.abs(row) < STRAIGHT * np.abs(row).max()] = 0.0
            roots = np.roots(row)
            real = roots.real[np.abs(roots.imag) <= REAL]
            found.extend(float(t) for t in real if 0.0 < t < 1.0)
    found.sort()
    kept = [0.0]
    kept.extend(t for before, t in pairwise(found) if t - before > SLIVER)
    kept[-1] = 1.0
    return kept


def _point(cubic: Array, t: float) -> Array:
    s = 1.0 - t
    weights = np.array((s**3, 3 * s * s * t, 3 * s * t * t, t**3))
    return np.asarray(weights @ cubic)


def _between(cubic: Array, begin: float, end: float) -> Array:
    """Return the part of a cubic between two parameters, by its blossom."""

    def blossom(*at: float) -> Array:
        row = cubic
        for t in at:
            row = (1.0 - t) * row[:-1] + t * row[1:]
        return np.asarray(row[0])

    return np.array(
        [blossom(begin, begin, begin), blossom(begin, begin, end),
         blossom(begin, end, end), blossom(end, end, end)]
    )  # fmt: skip
