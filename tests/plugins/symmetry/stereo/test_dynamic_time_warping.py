"""Warping against every monotone path there is."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from bozzetto_symmetry.stereo.dynamic_time_warping import first_row, next_row, warpings

Cell = tuple[int, int]


@cache
def paths_to(i: int, j: int) -> tuple[tuple[Cell, ...], ...]:
    """Every path to a cell, from wherever it may begin."""
    found: list[tuple[Cell, ...]] = [((i, j),)]
    for di, dj in ((1, 1), (1, 0), (0, 1)):
        if i >= di and j >= dj:
            found += [(*path, (i, j)) for path in paths_to(i - di, j - dj)]
    return tuple(found)


def price(count: int, each: float) -> float:
    """Of so many samples left out; none is free even where one would be infinitely dear."""
    return count * each if count else 0.0


def costs_of(path: tuple[Cell, ...], table: np.ndarray, step: float, begin: float, end: float):
    """What a path costs, term by term."""
    n, m = table.shape
    (i, j), (last_i, last_j) = path[0], path[-1]
    if (i and j) or (last_i < n - 1 and last_j < m - 1):
        return np.inf  # it must begin at a border of the table and end at one
    single = sum(a[0] == b[0] or a[1] == b[1] for a, b in pairwise(path))
    open_ends = price(i + j, begin) + price(n - 1 - last_i + m - 1 - last_j, end)
    return sum(table[cell] for cell in path) + step * single + open_ends


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(
    ("step", "begin", "end"),
    [(0.0, np.inf, np.inf), (0.3, 0.5, 0.5), (0.1, np.inf, 0.2), (0.0, 0.0, np.inf)],
)
def test_no_path_is_cheaper(seed, step, begin, end):
    random = np.random.default_rng(seed)
    n, m = random.integers(1, 6, 2)
    tables = random.uniform(0, 1, (3, n, m)) ** 2
    cells = [(i, j) for i in range(n) for j in range(m)]
    for made, table in zip(warpings(tables, step=step, begin=begin, end=end), tables, strict=True):
        least = min(
            costs_of(path, table, step, begin, end) for cell in cells for path in paths_to(*cell)
        )
        assert made.total == pytest.approx(least, rel=1e-12)
        own = tuple((int(i), int(j)) for i, j in made.path)
        assert costs_of(own, table, step, begin, end) == pytest.approx(least, rel=1e-12)


def test_equal_sequences_go_side_by_side():
    values = np.sin(np.arange(40.0))
    (made,) = warpings(np.abs(values[:, None] - values)[None])
    assert (made.path == np.arange(40)[:, None]).all()
    assert made.total == 0.0


def test_a_missing_end_is_left_out():
    values = np.cumsum(np.random.default_rng(1).uniform(0.5, 1.5, 60))
    (made,) = warpings(np.abs(values[:, None] - values[12:50])[None], begin=0.1, end=0.1)
    assert (made.path[:, 0] - made.path[:, 1] == 12).all()
    assert made.total == pytest.approx(0.1 * (12 + 10))


@pytest.mark.parametrize("seed", range(4))
def test_rows_one_by_one_are_the_whole_table(seed):
    random = np.random.default_rng(seed)
    table = random.uniform(0, 1, (20, 17))
    for begin in (0.0, 0.2):
        row = first_row(table[0], begin)
        # Only the known sequence may lack a beginning: steps along the first row are as dear
        # as leaving its samples out, or dearer.
        for cells in table[1:]:
            row, _ = next_row(row, cells, 0.4)
        prefixes = [
            min(
                warpings(table[None, :, first : last + 1], step=0.4)[0].total + begin * first
                for first in range(last + 1)
            )
            for last in range(17)
        ]
        assert row == pytest.approx(np.array(prefixes))


def test_sources_lead_back_along_the_cheapest_path():
    table = np.random.default_rng(7).uniform(0, 1, (15, 15))
    row, back = first_row(table[0], 0.0), []
    for cells in table[1:]:
        row, sources = next_row(row, cells, 0.3)
        back.append(sources)
    column = 14
    columns = [column]
    for sources in back[::-1]:
        column = int(sources[column])
        columns.append(column)
    # The same end, reached from wherever it is cheapest to begin in the first row.
    tables = [table[None, :, k:] for k in range(15)]
    totals = [warpings(part, step=0.3)[0].total for part in tables]
    (best,) = warpings(tables[int(np.argmin(totals))], step=0.3)
    path = best.path + np.array([0, int(np.argmin(totals))])
    arrived = [int(path[path[:, 0] == i, 1].max()) for i in range(15)]
    assert columns[::-1] == arrived
