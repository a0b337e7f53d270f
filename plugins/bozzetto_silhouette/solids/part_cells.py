"""How fine the mesh of each part is: what is small in the whole needs no more than is seen."""

from __future__ import annotations

from contextlib import suppress
from math import ceil

import numpy as np

from bozzetto.errors import UserError
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.placements import carried, outlined_parts, placement_of

CLASSES = 8
"""Steps up to the resolution asked for: a part that grows seldom needs another mesh."""

FINER = 2.0
"""How much finer than the largest part's the cells of the others are at most: the facets of a ball
of a quarter of the size are then as close to it, and forty small parts are no million triangles."""

WIDEST = 4.0
"""How many times the size of the largest part the whole may span before all parts count as smaller:
of a string of twenty beads none fills the sheet."""

FEWEST, FEWEST_IN_DRAFTS = 48, 24
"""Cells along the longest side of a small part, at least."""


def cells_of(state: SilhouetteState, resolution: int, fewest: int = FEWEST) -> dict[str, int]:
    """Return the cells along the longest side of each part, by its size in the whole.

    Parameters
    ----------
    state : SilhouetteState
        Whose parts that are switched on count.
    resolution : int
        Cells of the largest part, where the whole is not much larger.
    fewest : int
        Those of any, at least.
    """
    sizes: dict[str, float] = {}
    corners = []
    for part in outlined_parts(state):
        with suppress(UserError):  # told when it is to be made
            low, high = outline_of(part).bounds
            sizes[part.id] = float((high - low).max()) * carried(state, part).scale
            ends = np.array([(x, y, 0.0) for x in (low[0], high[0]) for y in (low[1], high[1])])
            corners.append(placement_of(state, part).points(ends))
    if not sizes:
        return {}
    span = float(np.ptp(np.concatenate(corners), axis=0).max())
    largest = max(*sizes.values(), span / WIDEST, np.finfo(float).tiny)
    return {
        name: max(
            min(fewest, resolution),
            resolution * min(CLASSES, ceil(CLASSES * FINER * size / largest)) // CLASSES,
        )
        for name, size in sizes.items()
    }
