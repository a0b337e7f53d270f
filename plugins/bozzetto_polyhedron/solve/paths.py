"""Paths of corners, from what was recorded of a motion."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.mechanism.assembly import GROUND
from bozzetto_polyhedron.mechanism.pieces import METRE
from bozzetto_polyhedron.model.fittings import Trace
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.moving import Moving
from bozzetto_polyhedron.solve.spots import place_of


def path_of(trace: Trace, state: PolyhedronState, made: Moving) -> Array:
    """Return where a corner has been, (t, 3) mm; empty where nothing was recorded of it."""
    number, kept = made.number_of(trace.at.body), state.recorded
    count = len(made.machine.rest.places)
    if number is None or kept is None or len(kept.places) != count * len(kept.seconds):
        return np.zeros((0, 3))
    rest = place_of(trace.at, state)
    piece = made.machine.piece_at(number, rest)
    if piece == GROUND:
        return np.zeros((0, 3))
    local = rest * METRE - made.machine.rest.places[piece]
    turns = kept.turns.reshape(-1, count, 3, 3)[:, piece]
    return np.asarray((kept.places.reshape(-1, count, 3)[:, piece] + turns @ local) / METRE)
