"""Which ends of lines meet in one corner: agglomeration by the strain that it costs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.likelihood import Line

MOST_STRAIN: Final = 11.0
"""Squared standardised distance that joining two corners may cost: 99.6 % of two ends."""

FARTHEST: Final = 0.09
"""Shares of the diagonal by which an end may be from its corner: the longest overshoot with its
spread."""


def clustered(lines: Sequence[Line]) -> Index:
    """Return the number of the corner at each end of lines, (m, 2).

    The pair of corners whose joint place strains their ends least is joined first; both ends of
    one line never are.
    """
    count = 2 * len(lines)
    if not count:
        return np.zeros((0, 2), np.intp)
    sums = np.array([end[:6] for line in lines for end in line.ends]).T.copy()
    places = np.array([place for line in lines for place in (line.start, line.stop)]).T.copy()
    strain = np.zeros(count)
    on: Flags = np.repeat(np.eye(len(lines), dtype=bool), 2, axis=0)
    barred = on @ on.T
    corner = np.arange(count)
    costs = _pair_costs(sums[:, :, None], places[:, :, None], strain[:, None], sums, places, strain)
    costs[barred | np.tri(count, dtype=bool).T] = np.inf
    while True:
        one, other = divmod(int(costs.argmin()), count)
        if not costs[one, other] <= MOST_STRAIN:
            break
        strain[one] += strain[other] + costs[one, other]
        sums[:, one] += sums[:, other]
        places[:, one] = _solved(sums[:, one])
        barred[one] |= barred[other]
        barred[:, one] = barred[one]
        corner[corner == other] = one
        costs[other, :] = costs[:, other] = np.inf
        barred[other, :] = barred[:, other] = True
        again = _pair_costs(
            sums[:, one, None], places[:, one, None], strain[one], sums, places, strain
        )
        again[barred[one]] = np.inf
        costs[one, :one] = again[:one]
        costs[one + 1 :, one] = again[one + 1 :]
    return np.unique(corner, return_inverse=True)[1].reshape(-1, 2).astype(np.intp)


def _solved(sums: Array) -> Array:
    xx, xy, yy, bx, by = sums[:5]
    determinant = xx * yy - xy * xy
    return np.array([(yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant])


def _pair_costs(
    sums: Array,
    places: Array,
    strain: Array,
    others: Array,
    other_places: Array,
    others_strain: Array,
) -> Array:
    """Return by how much strain grows if corners are joined with others; infinite if too far."""
    xx, xy, yy, bx, by, form = sums + (others[:, None] if sums.ndim == 3 else others)
    determinant = xx * yy - xy * xy
    x, y = (yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant
    grown: Array = form - bx * x - by * y - strain - others_strain
    far = (x - places[0]) ** 2 + (y - places[1]) ** 2 > FARTHEST**2
    far |= (x - other_places[0]) ** 2 + (y - other_places[1]) ** 2 > FARTHEST**2
    grown[far] = np.inf
    return grown
