"""Closest points on a curve that keep the order of a stroke."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Index

FEET_LAPS: Final = 3
"""Rounds of a closed curve that are laid out: a stroke may start anywhere and go round
nearly twice."""


def ordered_feet(
    stroke: Array, step: float, nodes: Array, lengths: Array, *, closed: bool = False
) -> Index:
    """Give every sample of a stroke a node of a curve, without going back along the curve.

    Of all assignments that keep the order, the one is found, by dynamic programming, with
    the least integral of squared distances along the stroke and along that part of the
    curve which it passes. The curve's parts before the first foot and behind the last one
    cost nothing. A nearest node alone would jump between the legs of a narrow U and across
    the crossing of a loop; and it would skip a whole curve whose ends are near each other.

    Parameters
    ----------
    stroke : (m, 2) float
        Samples at equal steps, px; ``m >= 1``.
    step : float
        Length of stroke that belongs to a sample, px.
    nodes : (n, 2) float
        Nodes of the curve, px; ``n >= 1``.
    lengths : (n,) float
        Length of curve that belongs to each node, px.
    closed : bool
        Whether the last node is joined to the first.

    Returns
    -------
    (m,) int
        Not decreasing if the stroke runs along the curve, not increasing if against it,
        whichever fits better. On a closed curve node k in lap l is ``k + l n``, with l
        below `FEET_LAPS`.
    """
    offset = stroke[:, None] - nodes
    squares = np.einsum("mnk,mnk->mn", offset, offset)
    if closed:
        squares, lengths = np.tile(squares, (1, FEET_LAPS)), np.tile(lengths, FEET_LAPS)
    passed = np.cumsum(squares * lengths, axis=1)
    squares *= step
    both = np.stack((squares, squares[::-1])), np.stack((passed, passed[::-1]))
    (along, against), (forward, backward) = _cheapest(*both)
    return np.asarray(along if forward <= backward else against[::-1])


def _cheapest(cost: Array, passed: Array) -> tuple[Index, Array]:
    """Return the best column for each row, not decreasing, and the total cost.

    Parameters
    ----------
    cost : (k, m, n) float
        Cost of a row at a column, of k assignments that are found together.
    passed : (k, m, n) float
        Cost of passing all columns up to this one, in this row.

    Returns
    -------
    chosen : (k, m) int
    price : (k,) float
    """
    count, rows, columns = cost.shape
    numbers = np.arange(columns)
    came_from = np.zeros((rows, count, columns), np.intp)
    beyond = cost[..., 1:] + passed[..., :-1]
    total = cost[:, 0].copy()
    for row in range(1, rows):
        lead = total - passed[:, row]
        least = np.minimum.accumulate(lead, axis=1)
        source = np.maximum.accumulate(np.where(lead == least, numbers, 0), axis=1)
        moved = beyond[:, row] + least[:, :-1]
        total += cost[:, row]
        nearer = moved < total[:, 1:]
        came_from[row, :, 1:] = np.where(nearer, source[:, :-1], numbers[1:])
        np.copyto(total[:, 1:], moved, where=nearer)
    chosen = np.empty((count, rows), np.intp)
    every = np.arange(count)
    chosen[:, -1] = total.argmin(axis=1)
    for row in range(rows - 1, 0, -1):
        chosen[:, row - 1] = came_from[row, every, chosen[:, row]]
    return chosen, total.min(axis=1)
