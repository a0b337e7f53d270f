"""Faint grids on planes of the box, with steps that are easy to count."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags

MOST_CELLS: Final = 25
"""Most cells along the longest edge of the box. With steps of 1, 2 and 5 times a power of
ten there are at least ten then."""

MOST_LINES: Final = 500
"""Most lines on one hand of the middle, whatever the step."""

HEAVY_EVERY: Final = 5
"""Every fifth line, counted from the middle, is heavier."""

FLUSH: Final = 1e-6
"""Share of the step by which a line must lie inside to be no edge."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Lines of a plane inside a box.

    Parameters
    ----------
    begins, ends : (n, 3) float
        mm.
    heavy : (n,) bool
        Those through the middle and every fifth from there.
    """

    begins: Array
    ends: Array
    heavy: Flags


def grid_step(longest: float) -> float:
    """Return the least of 1, 2 or 5 times a power of ten, mm, that makes at most 25 cells."""
    least = longest / MOST_CELLS
    decade = 10.0 ** np.floor(np.log10(least))
    fits = [step for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= least * (1.0 - FLUSH)]
    return float(fits[0] * decade)


def clip_to_box(
    points: ArrayLike, directions: ArrayLike, centre: ArrayLike, size: ArrayLike
) -> tuple[Array, Array, Flags]:
    """Return the parts of lines that lie in a box, by the method of slabs (Kay & Kajiya 1986).

    Parameters
    ----------
    points, directions : (n, 3) array_like
        A place of each line, and its direction.
    centre, size : (3,) array_like
        Of the box.

    Returns
    -------
    begin, end : (n,) float
        Multiples of the direction; a line along a face counts as inside.
    inside : (n,) bool
        Whether there is such a part; without one both ends are 0.
    """
    place, way = np.broadcast_arrays(np.asarray(points, float), np.asarray(directions, float))
    half = 0.5 * np.asarray(size, float)
    offset = place - np.asarray(centre, float)
    slack = FLUSH * float(half.max())
    flat = np.abs(way) < FLUSH * np.abs(way).max(axis=1, keepdims=True)
    across = np.where(flat, 1.0, way)
    one, other = (-half - offset) / across, (half - offset) / across
    begin = np.where(flat, -np.inf, np.minimum(one, other)).max(axis=1)
    end = np.where(flat, np.inf, np.maximum(one, other)).min(axis=1)
    aside = (flat & (np.abs(offset) > half + slack)).any(axis=1)
    inside = (begin < end) & ~aside & np.isfinite(begin) & np.isfinite(end)
    return np.where(inside, begin, 0.0), np.where(inside, end, 0.0), inside


def grid_in_box(
    point: ArrayLike,
    across: ArrayLike,
    up: ArrayLike,
    step: float,
    *,
    centre: ArrayLike,
    size: ArrayLike,
) -> Grid:
    """Return the grid of a plane as far as it lies in a box.

    Parameters
    ----------
    point : (3,) array_like
        Where two lines cross, mm.
    across, up : (3,) array_like
        Unit vectors along the plane, square to each other: the directions of the lines.
    step : float
        Between two lines, mm.
    centre, size : (3,) array_like
        Of the box, mm.
    """
    middle, first, second = (np.asarray(v, float) for v in (point, across, up))
    reach = float(np.linalg.norm(size)) + float(np.linalg.norm(middle - np.asarray(centre)))
    count = int(min(np.ceil(reach / step), MOST_LINES))
    number = np.arange(-count, count + 1)
    parts = []
    for along, aside in ((first, second), (second, first)):
        places = middle + number[:, None] * step * aside
        begin, end, inside = clip_to_box(places, along, centre, size)
        # Neither the edges themselves nor what only touches a corner.
        inside &= ~_on_edge(places + 0.5 * (begin + end)[:, None] * along, aside, centre, size)
        inside &= end - begin > FLUSH * step
        begins = places + begin[:, None] * along
        ends = places + end[:, None] * along
        parts.append((begins[inside], ends[inside], number[inside] % HEAVY_EVERY == 0))
    begins, ends, heavy = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Grid(begins, ends, heavy)


def _on_edge(places: Array, aside: Array, centre: ArrayLike, size: ArrayLike) -> Flags:
    """Return whether a step to the side from places of the box leaves it on one hand."""
    half = 0.5 * np.asarray(size, float)
    least = float(half.min())
    half, step = half + FLUSH * least, 1e3 * FLUSH * least * aside
    offset = places - np.asarray(centre, float)
    leaves = [(np.abs(offset + sign * step) > half).any(axis=1) for sign in (1.0, -1.0)]
    return np.asarray(leaves[0] | leaves[1])
