"""Dynamic time warping with open ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Index


@dataclass(frozen=True, eq=False)
class Warping:
    """The samples of two sequences that belong together.

    Attributes
    ----------
    path : (k, 2) int
        Index pairs, ``k >= 1``. From one to the next either index or both grow by one.
    total : float
        Cost of the path: its cells, its steps, and the samples at the ends that it leaves
        without a partner.
    """

    path: Index
    total: float


def warpings(
    costs: ArrayLike,
    *,
    step: float = 0.0,
    begin: float = np.inf,
    end: float = np.inf,
) -> tuple[Warping, ...]:
    """Return the cheapest way through each of several tables of costs.

    All cells of an antidiagonal are computed at once, and of all tables at once. The least
    sum is found exactly.

    Parameters
    ----------
    costs : (b, n, m) array_like
        Costs of matching sample i of the first with sample j of the second sequence, not negative;
        ``n, m >= 1``.
    step : float
        Price of a step in which only one index grows; not negative.
    begin, end : float
        Price of a sample left without a partner before the first and after the last pair;
        infinite where the ends belong together.

    Returns
    -------
    tuple of Warping
        One for each table. Of equal ways one that steps in both at once wins.
    """
    table = np.asarray(costs, float)
    count, n, m = table.shape
    sums = _summed(table, step, begin)
    numbers = np.arange(1, n + 1)
    # Where the path may end: in the last column, or in the last row.
    rows = sums[numbers + m, :, numbers] + _prices(end, n)[n - numbers, None]
    columns = np.arange(1, m + 1)
    rests = sums[n + columns, :, n] + _prices(end, m)[m - columns, None]
    found = []
    for number in range(count):
        i, j = int(rows[:, number].argmin()), int(rests[:, number].argmin())
        last, total = ((n, j + 1), rests[j, number])
        if rows[i, number] <= total:
            last, total = ((i + 1, m), rows[i, number])
        found.append(Warping(_traced(sums[:, number], last, step), float(total)))
    return tuple(found)


def _prices(price: float, count: int) -> Array:
    """Return the prices of leaving out 0 … `count` samples; leaving out none is always free."""
    numbers = np.arange(count + 1.0)
    return numbers * price if np.isfinite(price) else np.where(numbers > 0, np.inf, 0.0)


def _summed(table: Array, step: float, begin: float) -> Array:
    """Return the least sums up to each cell, by antidiagonals: (n + m + 1, b, n + 1).

    Cell (i, j), counted from 1, is in row ``i + j`` and column i; index 0 is in front of the
    first sample.
    """
    count, n, m = table.shape
    # Padding every row by n columns and cutting the flat table into rows one shorter moves
    # row i to the right by i: the columns are antidiagonals then.
    padded = np.concatenate([table, np.full((count, n, n), np.inf)], axis=2)
    skewed = padded.reshape(count, -1)[:, : n * (n + m - 1)].reshape(count, n, n + m - 1)
    slices = np.ascontiguousarray(skewed.transpose(2, 0, 1))
    sums = np.full((n + m + 1, count, n + 1), np.inf)
    sums[: m + 1, :, 0] = _prices(begin, m)[:, None]
    sums[np.arange(n + 1), :, np.arange(n + 1)] = _prices(begin, n)[:, None]
    best = np.empty((count, n))
    for d in range(2, n + m + 1):
        before = sums[d - 1]
        np.minimum(before[:, :-1], before[:, 1:], out=best)
        best += step
        np.minimum(best, sums[d - 2][:, :-1], out=best)
        best += slices[d - 2]
        if d <= n:  # the cell in front of the second sequence keeps its price
            sums[d][:, 1:d] = best[:, : d - 1]
        else:
            sums[d][:, 1:] = best
    return sums


def _traced(sums: Array, last: tuple[int, int], step: float) -> Index:
    """Return the path to a cell, found backwards through the sums."""
    i, j = last
    path = []
    while i and j:
        path.append((i - 1, j - 1))
        both = sums[i + j - 2, i - 1]
        first, second = sums[i + j - 1, i - 1] + step, sums[i + j - 1, i] + step
        one = both <= min(first, second)
        i, j = (i - 1 if one or first <= second else i), (j - 1 if one or first > second else j)
    return np.array(path[::-1], np.intp)


def first_row(costs: ArrayLike, begin: float) -> Array:
    """Return the sums after the first sample of a sequence that is still growing.

    Parameters
    ----------
    costs : (..., m) array_like
        Costs of the new sample with each sample of the sequence that is known whole.
    begin : float
        Price of a sample of the known sequence left out before the first pair; not above the
        price of a step, for then leaving out never costs more than stepping along the row.

    Returns
    -------
    (..., m) float
    """
    cell = np.asarray(costs, float)
    return np.asarray(cell + begin * np.arange(cell.shape[-1]))


def next_row(sums: Array, costs: ArrayLike, step: float) -> tuple[Array, Index]:
    """Return the sums after one more sample of a sequence that is still growing.

    Parameters
    ----------
    sums : (..., m) float
        After the sample before.
    costs : (..., m) array_like
        Costs of the new sample with each sample of the known sequence, not negative.
    step : float
        Price of a step in which only one index grows.

    Returns
    -------
    sums : (..., m) float
        The least sum of a path that ends at each sample of the known sequence.
    sources : (..., m) int
        Where that path was at the sample before.
    """
    cell = np.asarray(costs, float)
    numbers = np.arange(cell.shape[-1])
    best = sums + step
    diagonal = np.zeros(cell.shape, bool)
    diagonal[..., 1:] = sums[..., :-1] <= best[..., 1:]
    np.minimum(best[..., 1:], sums[..., :-1], out=best[..., 1:])
    best += cell
    # Steps along the row: a running minimum, after what they cost has been taken off.
    along = np.cumsum(cell + step, axis=-1)
    lead = best - along
    least = np.minimum.accumulate(lead, axis=-1)
    entered = np.maximum.accumulate(np.where(lead == least, numbers, 0), axis=-1)
    sources = entered - np.take_along_axis(diagonal, entered, axis=-1)
    return np.asarray(least + along), np.asarray(sources)
