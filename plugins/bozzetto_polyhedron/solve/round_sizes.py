"""Typed sizes of what was drawn round, by the curves of the drawing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from bozzetto_polyhedron.model.round_sizes import RimSize, RoundSize
from bozzetto_polyhedron.rounds.round_curves import number_at
from bozzetto_polyhedron.rounds.round_things import Reading, RoundSizes


def sizes_of(typed: Iterable[RoundSize], reading: Reading) -> Mapping[int, RoundSizes]:
    """Return typed sizes by the numbers of curves; what is gone with its curve is left out."""
    found: dict[int, RoundSizes] = {}
    for each in typed:
        number = number_at(reading, np.array(each.place))
        if number is not None:
            depth = each.depth if isinstance(each, RimSize) else 0.0
            found[number] = RoundSizes(each.diameter, depth)
    return found
