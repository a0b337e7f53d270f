"""Recordings of motions: kept pose by pose, and shown again."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, frozen
from bozzetto_polyhedron.mechanism.assembly import Motion
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import Moved, PolyhedronState, Recording
from bozzetto_polyhedron.solve.moving import moving

MOST_POSES: Final = 3600
"""Poses that are recorded: a minute."""

SMALL: Final = 1e-7
"""Turn, rad, below which a piece is shifted only."""


def recorded(state: PolyhedronState, before: Motion, motion: Motion) -> Recording | None:
    """Return the recording of a state with one more pose, and where it begins that before it.

    It begins anew where the machine has other pieces. What was recorded of later times is
    overwritten, as after a replay that was stopped.
    """
    known, count = state.recorded, len(motion.places)
    if not state.records or not count:
        return known
    if known is None or len(known.places) != count * len(known.seconds):
        known = Recording()
    kept = int(np.searchsorted(known.seconds[:, 0], before.time, side="right"))
    known = _first(known, kept)
    if kept >= MOST_POSES:
        return known
    is_known = kept > 0 and known.seconds[-1, 0] == before.time
    added = [] if is_known else [before]
    added += [motion] if motion.time > before.time else []
    added = added[: MOST_POSES - kept]
    if not added:
        return known
    return Recording(
        frozen(np.vstack((known.seconds, *([[each.time]] for each in added))), np.float64, 1),
        frozen(np.vstack((known.places, *(each.places for each in added))), np.float64, 3),
        frozen(
            np.vstack((known.turns, *(each.turns.reshape(-1, 3) for each in added))), np.float64, 3
        ),
    )


def recorded_times(state: PolyhedronState) -> tuple[float, ...]:
    """Return the times of the poses that are recorded, s; empty where these are of other pieces."""
    kept = state.recorded
    if kept is None or state.moved is None or not len(kept.seconds):
        return ()
    count = len(state.moved.places)
    known = bool(state.shown(Followed)) or len(moving(state).machine.rest.places) == count
    if not known or len(kept.places) != count * len(kept.seconds):
        return ()
    times: list[float] = kept.seconds[:, 0].tolist()
    return tuple(times)


def at_time(state: PolyhedronState, seconds: float) -> PolyhedronState:
    """Return the state in the pose that it had at a time of its recording, standing still there.

    Between two poses each piece is on the screw that takes it from one to the other (Chasles): so
    what turns about a hinge stays at it.

    Parameters
    ----------
    state : PolyhedronState
        With a recording; see `recorded_times`.
    seconds : float
        Time, s.
    """
    kept, times = state.recorded, np.array(recorded_times(state))
    if kept is None or not len(times):
        return state
    seconds = float(np.clip(seconds, times[0], times[-1]))
    after = int(np.clip(np.searchsorted(times, seconds), 1, max(len(times) - 1, 1)))
    before = after - 1
    after = min(after, len(times) - 1)
    count = len(kept.places) // len(times)
    places = kept.places.reshape(-1, count, 3)
    turns = kept.turns.reshape(-1, count, 3, 3)
    span = times[after] - times[before]
    share = (seconds - times[before]) / span if span > 0.0 else 0.0
    place, turn = screw_between(places[before], turns[before], places[after], turns[after], share)
    still = np.zeros((count, 3))
    moved = Moved(
        places=frozen(place, np.float64, 3),
        turns=frozen(turn.reshape(-1, 3), np.float64, 3),
        velocities=frozen(still, np.float64, 3),
        momenta=frozen(still, np.float64, 3),
        seconds=seconds,
    )
    return replace(state, moved=moved, grab=None)


def recorded_until(state: PolyhedronState, seconds: float) -> PolyhedronState:
    """Return the state with what was recorded until a time only: so far a trace has been drawn."""
    kept = state.recorded
    if kept is None:
        return state
    count = int(np.searchsorted(kept.seconds[:, 0], seconds, side="right"))
    return replace(state, recorded=_first(kept, count))


def _first(kept: Recording, count: int) -> Recording:
    """Return the first poses of a recording."""
    if count >= len(kept.seconds):
        return kept
    pieces = len(kept.places) // len(kept.seconds)
    return Recording(
        frozen(kept.seconds[:count], np.float64, 1),
        frozen(kept.places[: pieces * count], np.float64, 3),
        frozen(kept.turns[: 3 * pieces * count], np.float64, 3),
    )


def screw_between(
    place: Array, turn: Array, other: Array, turned: Array, share: float
) -> tuple[Array, Array]:
    """Return places (n, 3) and turns (n, 3, 3) at a share of the screws from some to others."""
    from scipy.spatial.transform import Rotation

    whole = Rotation.from_matrix(turned @ turn.transpose(0, 2, 1)).as_rotvec()
    part = Rotation.from_rotvec(share * whole).as_matrix()
    angle = np.linalg.norm(whole, axis=1)
    axis = whole / np.maximum(angle, SMALL)[:, None]
    way = other - place
    along = (way * axis).sum(axis=1, keepdims=True) * axis
    aside = way - along
    # From the axis to the place: the inverse of (turn - 1) across the axis.
    half = 0.5 * np.maximum(angle, SMALL)[:, None]
    arm = -0.5 * (aside + np.cross(axis, aside) / np.tan(half))
    swung = np.einsum("nij,nj->ni", part, arm) - arm
    swung = np.where((angle > SMALL)[:, None], swung, share * aside)
    return place + share * along + swung, part @ turn
