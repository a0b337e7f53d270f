"""Which of the loops that may be meant are taken together: an integer programme."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_product.loops.candidates import Halves

SIDE_GAIN: Final = 0.9
"""What each side of a loop speaks for it: a fair loop of four sides costs half of that."""

MOST_LOOPS: Final = 2
"""Loops at an edge."""

TIME_LIMIT: Final = 5.0
"""Seconds; programmes of 400 edges take a tenth of one."""

GAP: Final = 1e-6
"""Relative distance from the best choice that is left open."""


def choose_loops(
    loops: Sequence[Halves],
    gains: Array,
    room: Index,
    pairs: Sequence[tuple[int, ...]],
) -> Flags:
    """Choose loops of the greatest gain, so many at each edge as there is room for.

    Parameters
    ----------
    loops : sequence of tuple of int
        Half-edges.
    gains : (k,) float
        Those of 0 or less are not chosen.
    room : (m,) int
        Loops that each edge may still take.
    pairs : sequence of tuple of int
        Numbers of loops that are taken all or none; each loop stands in one.

    Returns
    -------
    (k,) bool
    """
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import coo_matrix

    chosen = np.zeros(len(loops), bool)
    if not pairs:
        return chosen
    gain = np.array([sum(gains[number] for number in each) for each in pairs])
    worth = [group for group, each in zip(pairs, gain.tolist(), strict=True) if each > 0]
    cells = [
        (half // 2, column)
        for column, group in enumerate(worth)
        for number in group
        for half in loops[number]
    ]
    if not cells:
        return chosen
    rows, columns = np.array(cells).T
    uses = coo_matrix((np.ones(len(cells)), (rows, columns)), shape=(len(room), len(worth)))
    found = milp(
        -gain[gain > 0],
        constraints=[LinearConstraint(uses.tocsr(), -np.inf, room)],
        integrality=np.ones(len(worth), int),
        bounds=Bounds(0, 1),
        options={"time_limit": TIME_LIMIT, "mip_rel_gap": GAP},
    )
    if found.x is None:
        return chosen
    for group, taken in zip(worth, found.x > 0.5, strict=True):
        chosen[list(group)] = taken
    return chosen
