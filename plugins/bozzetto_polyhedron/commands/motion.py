"""Commands on what moves: a push into what is free, and back to rest."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context
from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.mechanism.assembly import Motion
from bozzetto_polyhedron.mechanism.pieces import METRE
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.moving import as_held, kept, moving_bodies

SAME: Final = 0.9
"""Cosine from which on two motions count as the same one."""


def swing(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state pushed into the next of its free motions, one extent a second at most."""
    state = as_held(state)
    made = moving_bodies(state, context.sources, "move")
    motion = made.motion(state.moved)
    found = mobility_of(made.machine.assembly, motion)
    if not found.degrees:
        raise UserError("Nothing is free here. Touch a held corner to let it go, or erase a link.")
    now = _velocities(made.stepper.turning(motion), motion)
    likeness = [_cosine(mode, now) for mode in found.motions]
    number = int(np.argmax(likeness)) + 1 if max(likeness) > SAME else 0
    mode = found.motions[number % found.degrees]
    sizes = np.linalg.norm(mode[:, :3], axis=1) + np.linalg.norm(mode[:, 3:], axis=1) * (
        made.extent * METRE
    )
    mode = mode * (made.extent * METRE / float(sizes.max()))
    return replace(state, moved=kept(made.stepper.pushed(motion.stopped(), mode)), grab=None)


def at_rest(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with everything where it was drawn."""
    return as_held(replace(state, moved=None, grab=None, recorded=None))


def forget(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state without its recording; everything stays where it is."""
    return replace(state, recorded=None)


def is_recorded(state: PolyhedronState) -> bool:
    """Return whether there is a recording."""
    return state.recorded is not None and len(state.recorded.seconds) > 0


def has_moved(state: PolyhedronState) -> bool:
    """Return whether anything is elsewhere than it was drawn."""
    return state.moved is not None


def _velocities(turning: Array, motion: Motion) -> Array:
    return np.concatenate((motion.velocities, turning), axis=1)


def _cosine(one: Array, other: Array) -> float:
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return abs(float((one * other).sum())) / size if size > 0.0 else 0.0
