"""Motions: key poses in a row, the pose at any time between them, and the clip that files get."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Clip
from bozzetto.plugin import remembered
from bozzetto_silhouette.model.state import KeyPose, SilhouetteState, Turn
from bozzetto_silhouette.rigging.armature import Armature, armature_of
from bozzetto_silhouette.rigging.posing import quaternions_of, turns_of

MOST_KEYS = 240
"""Poses of a motion: a minute at four a second."""

ASIDE = np.radians(40.0)
"""Angle by which the figures of poses are seen from further right than the front."""

NONE_YET = "There is no motion yet. Pose the shape and keep the pose as a key, or take a walk."


def key_at(state: SilhouetteState) -> int:
    """Return the number of the key that the state is at, or the last one before its time."""
    return min(int(np.floor(state.time / state.beat + 1e-6)), max(len(state.keys) - 1, 0))


def with_key(state: SilhouetteState) -> SilhouetteState:
    """Return the state with its pose as a key after the one that it is at.

    Raises
    ------
    UserError
        If there are no joints, or too many keys.
    """
    if armature_of(state) is None:
        raise UserError("This shape has no joints. Draw a longer shape or a limb.")
    if len(state.keys) >= MOST_KEYS:
        raise UserError(f"A motion has {MOST_KEYS} key poses at most. Take some away.")
    number = key_at(state) + 1 if state.keys else 0
    keys = (*state.keys[:number], KeyPose(state.turns), *state.keys[number:])
    return replace(state, keys=keys, time=number * state.beat)


def with_changed_key(state: SilhouetteState) -> SilhouetteState:
    """Return the state with its pose in place of the key that it is at.

    Raises
    ------
    UserError
        If there is none.
    """
    number = _some_key(state)
    keys = (*state.keys[:number], KeyPose(state.turns), *state.keys[number + 1 :])
    return replace(state, keys=keys, time=number * state.beat)


def without_key(state: SilhouetteState) -> SilhouetteState:
    """Return the state without the key that it is at, in the one before.

    Raises
    ------
    UserError
        If there is none.
    """
    number = _some_key(state)
    keys = (*state.keys[:number], *state.keys[number + 1 :])
    left = replace(state, keys=keys, time=0.0)
    return at_key(left, max(number - 1, 0)) if keys else left


def with_moved_key(state: SilhouetteState, places: int) -> SilhouetteState:
    """Return the state with the key that it is at so many places later; the last goes first.

    Raises
    ------
    UserError
        If there is none.
    """
    number = _some_key(state)
    keys = [*state.keys]
    to = (number + places) % len(keys)
    keys.insert(to, keys.pop(number))
    return at_key(replace(state, keys=tuple(keys)), to)


def at_key(state: SilhouetteState, number: int) -> SilhouetteState:
    """Return the state in a key pose; numbers go round.

    Raises
    ------
    UserError
        If there is none.
    """
    _some_key(state)
    number %= len(state.keys)
    return replace(state, time=number * state.beat, turns=state.keys[number].turns)


def _some_key(state: SilhouetteState) -> int:
    if not state.keys:
        raise UserError(NONE_YET)
    return key_at(state)


def at_rest(state: SilhouetteState) -> SilhouetteState:
    """Return the state as it was drawn, without pose and motion."""
    return replace(state, keys=(), turns=(), time=0.0)


def moved_on(state: SilhouetteState, seconds: float) -> SilhouetteState:
    """Return the state a moment later in its motion; see `at_time`."""
    return at_time(state, state.time + seconds)


def at_time(state: SilhouetteState, seconds: float) -> SilhouetteState:
    """Return the state at a time of its motion, which goes on from its end at its beginning.

    Raises
    ------
    UserError
        If it has none.
    """
    armature = armature_of(state)
    if not state.keys or armature is None:
        raise UserError(NONE_YET)
    time = seconds % (len(state.keys) * state.beat)
    keys = _keys(armature, state)
    before, part = divmod(time / state.beat, 1.0)
    one, other = (keys[(int(before) + k) % len(keys)] for k in (0, 1))
    return replace(state, time=time, turns=turns_of(armature, _between(one, other, part)))


def clip_of(armature: Armature, state: SilhouetteState) -> Clip | None:
    """Return the motion of a state on the joints of its armature; None without one."""
    if not state.keys:
        return None
    keys = _keys(armature, state)
    keys = np.concatenate([keys, keys[:1]])
    seconds: Array = state.beat * np.arange(len(keys), dtype=np.float64)
    return Clip(state.motion or "motion", seconds, keys)


def figures_of(state: SilhouetteState) -> Array:
    """Return the joints of every key pose, seen from front right, (k, n, 2), mm, y up.

    From the front a walk towards us looks as if nothing moved.
    """
    armature = armature_of(state)
    if armature is None or not state.keys:
        return np.zeros((0, 0, 2))
    rigs = [replace(armature.rig, turns=turns) for turns in _keys(armature, state)]
    x, y, z = np.moveaxis(np.array([rig.posed()[1] for rig in rigs]), 2, 0)
    return np.stack((np.cos(ASIDE) * x + np.sin(ASIDE) * y, z), axis=2)


# Asked for at every moment of a motion.
@remembered(limit=16, key=lambda armature, state: (state.unpainted, state.keys))
def _keys(armature: Armature, state: SilhouetteState) -> Array:
    """Return the quaternions of every key, (k, n, 4), x, y, z, w."""
    return np.array([quaternions_of(armature, key.turns) for key in state.keys])


def _between(one: Array, other: Array, part: float) -> Array:
    """Return quaternions on the shortest way between two, (n, 4) (Shoemake, 1985: slerp)."""
    cosine = np.einsum("ni,ni->n", one, other)[:, None]
    other = np.where(cosine < 0.0, -other, other)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    small = angle < 1e-6
    sine = np.where(small, 1.0, np.sin(angle))
    first = np.where(small, 1.0 - part, np.sin((1.0 - part) * angle) / sine)
    second = np.where(small, part, np.sin(part * angle) / sine)
    mixed = first * one + second * other
    return np.asarray(mixed / np.linalg.norm(mixed, axis=1, keepdims=True))


def posed_by(state: SilhouetteState, poses: Array, name: str, beat: float) -> SilhouetteState:
    """Return the state with a motion through poses.

    Parameters
    ----------
    state : SilhouetteState
        With joints.
    poses : (k, n, 4) float array
        Quaternions x, y, z, w of the joints.
    name : str
        Of the motion.
    beat : float
        Time from one to the next, s.
    """
    armature = armature_of(state)
    assert armature is not None
    keys: list[tuple[Turn, ...]] = [turns_of(armature, pose) for pose in poses]
    first = KeyPose(keys[0])
    made = (first, *(KeyPose(turns) for turns in keys[1:]))
    return replace(state, keys=made, motion=name, beat=beat, time=0.0, turns=first.turns)
