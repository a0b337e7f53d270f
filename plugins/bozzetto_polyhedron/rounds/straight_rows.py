"""Dashes that lie on one straight line, one after another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array

DASH: Final = 0.06
"""Longest dash of a straight row, in diagonals."""

DASH_GAP: Final = 0.045
"""Largest gap between two dashes of one row, in diagonals."""

ROW: Final = 0.007
"""Distance from a line within which dashes are a row, in diagonals."""

OVERLAP: Final = 0.5
"""Share of a dash beside the one before from which on it is of another row."""

SHAKY_ROW: Final = 0.012
"""The same for rows of five and more that are not bent by `ROW`."""

MOST_DASHES, MOST_PAIRS = 300, 600
"""Dashes among which rows are sought, and pairs of them that begin one."""

FEWEST_DASHES: Final = 4
"""Dashes of the shortest row: three of an arc may lie straight."""


def rows_of_dashes(paths: Sequence[Array], lengths: Array, size: float) -> dict[int, int]:
    """Return for each dash of a straight row the number of its row; the longest rows first."""
    dashes = [k for k in range(len(paths)) if 0.0 < lengths[k] < DASH * size][:MOST_DASHES]
    ends = {k: paths[k][[0, -1]] for k in dashes}
    both = np.array([ends[k] for k in dashes]).reshape(-1, 2, 2)
    apart = np.linalg.norm(both[:, None, :, None] - both[:, None], axis=4).min(axis=(2, 3))
    pairs = [(dashes[i], dashes[j]) for i, j in np.argwhere(np.triu(apart < DASH_GAP * size, 1))]
    left = set(dashes)
    found: dict[int, int] = {}
    rows = {pair: _row_along(ends, left, *pair, size) for pair in pairs[:MOST_PAIRS]}
    while rows:
        pair = max(rows, key=lambda each: (len(rows[each]), -each[0], -each[1]))
        best = rows[pair]
        if len(best) < FEWEST_DASHES:
            break
        found |= dict.fromkeys(best, pair[0])
        left -= set(best)
        rows = {
            each: row if not set(row) & set(best) else _row_along(ends, left, *each, size)
            for each, row in rows.items()
            if each[0] in left and each[1] in left
        }
    return found


def _row_along(
    ends: dict[int, Array], left: set[int], one: int, other: int, size: float
) -> list[int]:
    """Return the dashes on the line of two, from each to the next within a gap.

    A shaky row is one where it is longer, and not bent.
    """
    found = _chain(ends, left, one, other, size, ROW)
    shaky = _chain(ends, left, one, other, size, SHAKY_ROW)
    if len(shaky) > max(len(found), FEWEST_DASHES):
        points = np.concatenate([ends[k] for k in shaky])
        x, y = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2] @ (
            (points - points.mean(axis=0)).T
        )
        bend = float(np.polynomial.Polynomial.fit(x, y, 2, domain=[x.min(), x.max()]).coef[2])
        if abs(bend) < ROW * size:
            return shaky
    return found


def _chain(
    ends: dict[int, Array], left: set[int], one: int, other: int, size: float, reach: float
) -> list[int]:
    """Return the dashes within reach of the line of two that follow one another."""
    four = np.concatenate((ends[one], ends[other]))
    middle = four.mean(axis=0)
    along = np.linalg.svd(four - middle)[2][0]
    numbers = sorted(left)
    away = np.array([ends[k] for k in numbers]) - middle
    for _ in range(3):
        across = np.array((-along[1], along[0]))
        near = np.abs(away @ across).max(axis=1) < reach * size
        spans = np.sort(away @ along, axis=1)
        order = [k for k in np.argsort(spans[:, 0], kind="stable").tolist() if near[k]]
        rows: list[list[int]] = [[]]
        reached = -np.inf
        for k in order:
            if reached - spans[k, 0] > OVERLAP * (spans[k, 1] - spans[k, 0]):
                continue
            if spans[k, 0] - reached > DASH_GAP * size:
                rows.append([])
            rows[-1].append(k)
            reached = max(reached, float(spans[k, 1]))
        row = max((row for row in rows if numbers.index(one) in row), key=len, default=[])
        if len(row) < 3:
            break
        points = away[row].reshape(-1, 2)
        along = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
        away = away - points.mean(axis=0)
    return [numbers[k] for k in row]
