"""Lines of a CAD drawing that meet end to end and close, as one."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.exchange.page_layout import Color

TOGETHER: Final = 1e-5
"""Ends that are nearer than this share of the size are one place."""

Line = tuple[Array, Color | None]


def size_of(lines: Sequence[Array]) -> float:
    """Return the diagonal of the box around lines, seen from above."""
    low = np.min([line[:, :2].min(axis=0) for line in lines], axis=0)
    high = np.max([line[:, :2].max(axis=0) for line in lines], axis=0)
    return float(math.hypot(*(high - low)))


def with_rings(lines: Sequence[Line], near: float) -> list[Line]:
    """Join the lines that close when they follow one another; a place where three meet parts them.

    Parameters
    ----------
    lines : sequence of ((n, 2) array, colour)
        Of the same colour they may be joined.
    near : float
        Ends that are nearer are one place.

    Returns
    -------
    list of ((n, 2) array, colour)
        In the order of the first line of each.
    """
    place = _places(np.array([[line[0], line[-1]] for line, _ in lines]).reshape(-1, 2), near)
    at: dict[int, list[int]] = defaultdict(list)
    for end, where in enumerate(place.tolist()):
        at[where].append(end)
    used, opened = [False] * len(lines), [False] * len(lines)
    found: list[Line] = []
    for first, (line, color) in enumerate(lines):
        if opened[first]:  # nor does the row close from its middle
            found.append((line, color))
        if used[first]:
            continue
        used[first] = True
        row, pieces, end = [first], [line], 2 * first + 1
        while place[end] != place[2 * first]:
            meeting = at[int(place[end])]
            if len(meeting) != 2:
                break
            other = meeting[0] if meeting[1] == end else meeting[1]
            after = other // 2
            if used[after] or lines[after][1] != color:
                break
            row.append(after)
            pieces.append(lines[after][0] if other % 2 == 0 else lines[after][0][::-1])
            end = other ^ 1
        closes = place[end] == place[2 * first] and len(at[int(place[end])]) == 2
        if len(row) > 1 and closes:
            for one in row:
                used[one] = True
            whole = np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])
            whole[-1] = whole[0]
            found.append((whole, color))
        else:
            found.append((line, color))
            for one in row[1:]:
                used[one] = opened[one] = True
    return found


def _places(ends: Array, near: float) -> Index:
    """Return the number of the place of each end, (n,): those in reach of one another have one.

    Ends are first put together by cells of a grid, so that the cost does not grow with the square
    of the ends that meet in one place.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    side = max(near, 1e-300) / math.sqrt(2.0)  # all places of a cell are in reach of one another
    cells = np.floor((ends - ends.min(axis=0)) / side)
    _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    pairs = cKDTree(ends[first]).query_pairs(max(near, 1e-300), output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(first), len(first)))
    return np.asarray(connected_components(links, directed=False)[1][cell.reshape(-1)])
