"""Which part of a curve a stroke speaks of: foot points that keep their order."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["LAPS", "ordered_feet"]

Array = NDArray[np.float64]

LAPS: Final = 3
"""How often a stroke may start and go round a closed curve: nearly twice from any start."""


def ordered_feet(stroke: Array, nodes: Array, *, closed: bool = False) -> NDArray[np.intp]:
    """Give every sample of a stroke a node of a curve, without going back along the curve.

    Of all assignments in which the nodes never go back, the one with the least sum of
    squared distances is found by dynamic programming. A nearest node alone would jump
    between the legs of a narrow U and across the crossing of a loop; order forbids it.
    The stroke may run along the curve or against it: the cheaper way counts.

    Parameters
    ----------
    stroke : (m, 2) float
        Samples at about equal steps, px; ``m >= 1``.
    nodes : (n, 2) float
        Nodes of the curve, px; ``n >= 1``.
    closed : bool
        The curve goes on from its last node to its first.

    Returns
    -------
    (m,) int
        Not decreasing if the stroke runs along the curve, not increasing if against it.
        On a closed curve node k in lap l is ``k + l n``, with l below `LAPS`.
    """
    span = nodes - nodes[0]
    away = stroke - nodes[0]
    scale = max(float(np.abs(span).max()), float(np.abs(away).max())) or 1.0
    offset = away[:, None] / scale - span / scale  # no square overflows
    squares = np.einsum("mnk,mnk->mn", offset, offset)
    if closed:
        squares = np.tile(squares, (1, LAPS))
    along, forward = _monotone(squares)
    against, backward = _monotone(squares[::-1])
    return along if forward <= backward else against[::-1]


def _monotone(cost: Array) -> tuple[NDArray[np.intp], float]:
    """The cheapest column for each row, not decreasing, and what it costs in all."""
    rows, columns = cost.shape
    numbers = np.arange(columns)
    came_from = np.empty((rows, columns), np.intp)
    total = np.zeros(columns)
    for row in range(rows):
        least = np.minimum.accumulate(total)
        came_from[row] = np.maximum.accumulate(np.where(total == least, numbers, 0))
        total = cost[row] + least
    chosen = np.empty(rows, np.intp)
    column = int(np.argmin(total))
    price = float(total[column])
    for row in range(rows - 1, -1, -1):
        chosen[row] = column
        column = int(came_from[row, column])
    return chosen, price
