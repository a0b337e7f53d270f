"""Simple motions that a rig can do: a walk, and a gentle sway where it stands.

Who faces us walks towards us: legs swing about the axis from side to side, arms against them,
knees bend while a leg comes forward. What is seen from its side, as a horse, walks in the
drawing's plane, neighbouring legs against each other.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.rigging.armature import Armature, armature_of
from bozzetto_silhouette.rigging.key_poses import posed_by

POSES = 8
"""Key poses of a cycle."""

WALK, SWAY = 1.2, 3.0
"""Length of a cycle, s."""

STRIDE, KNEE, SWING, TWIST = np.deg2rad([24.0, 30.0, 16.0, 4.0])
"""Largest turns of a leg, of its knee, of an arm and of the spine."""

LEAN, WAVE = np.deg2rad([2.5, 4.0])
"""Largest turns of the spine and of limbs while swaying."""

FOOT = 0.2
"""Height, as share of the whole, below which a limb that stands ends."""

TRUNK = ("Body", "Spine")
"""Names of what the limbs hang on."""

_, DEEP, UPWARD = np.eye(3)
"""Axes of the model: away from the viewer, and up."""


class _Limb(NamedTuple):
    """A row of joints of one name, without the end.

    Attributes
    ----------
    stem, side : str
        "Arm" and ".L".
    joints : list of int
        From where it begins outwards.
    way : (3,) float array
        From its beginning to its end, mm.
    height : float
        Of its end above the lowest joint of all, as share of the height of all.
    base : int
        Joint that it hangs on; -1 at a root.
    """

    stem: str
    side: str
    joints: list[int]
    way: Array
    height: float
    base: int

    @property
    def stands(self) -> bool:
        """Whether it is a leg: no trunk, and no tail."""
        return (
            self.stem not in TRUNK and -self.way[2] > abs(float(self.way[0])) and self.height < FOOT
        )

    def middle(self, places: Array) -> int:
        """Return the joint, of two or more and not the first, nearest to half of the length."""
        row = places[self.joints]
        along = np.concatenate([[0.0], np.linalg.norm(np.diff(row, axis=0), axis=1).cumsum()])
        return self.joints[1 + int(np.abs(along[1:] - 0.5 * along[-1]).argmin())]


def walking(state: SilhouetteState, context: Context) -> SilhouetteState:
    """Return the state with a walk on the spot as its motion.

    Raises
    ------
    UserError
        If it has no joints, or no two limbs that point down.
    """
    armature = _armature(state)
    limbs = _limbs(armature)
    outer = {joint for limb in limbs if limb.side for joint in limb.joints}
    pairs = [limb for limb in limbs if limb.side and limb.base not in outer]
    sided = [limb for limb in pairs if limb.stands]
    legs = sided or sorted(
        (limb for limb in limbs if limb.stands),
        key=lambda limb: float(armature.rig.joints[limb.joints[0], 0]),
    )
    if len(legs) < 2:
        raise UserError(
            "A walk needs two limbs that point down. Draw legs, take the sway, or keep poses of "
            "your own as keys."
        )
    second = [limb.side == ".R" for limb in legs] if sided else [k % 2 for k in range(len(legs))]
    phases = np.where(second, np.pi, 0.0).tolist()
    turns = np.zeros((POSES, len(armature.radii), 3))
    beat = 2.0 * np.pi * np.arange(POSES) / POSES
    for leg, phase in zip(legs, phases, strict=True):
        about = _backwards(leg) if sided else DEEP
        turns[:, leg.joints[0]] += STRIDE * np.sin(beat + phase)[:, None] * about
        if len(leg.joints) > 1:
            # Bent while it comes forward; forward is towards us, or to where the horse looks.
            bend = np.maximum(np.cos(beat + phase), 0.0)[:, None]
            knee = leg.middle(armature.rig.joints)
            turns[:, knee] += KNEE * bend * about * (1.0 if sided else -1.0)
    if sided:
        legs_at = {leg.side: phase for leg, phase in zip(legs, phases, strict=True)}
        trunk = [limb for limb in limbs if limb.stem in TRUNK or limb.base < 0]
        held = {joint for limb in trunk for joint in limb.joints}
        arms = [limb for limb in pairs if limb.base in held and not limb.stands]
        for arm in arms:
            if arm.side in legs_at:
                against = np.sin(beat + legs_at[arm.side] + np.pi)
                turns[:, arm.joints[0]] += SWING * against[:, None] * _backwards(arm)
        for limb in limbs:
            if limb.stem == "Spine":
                for joint in limb.joints[1:]:
                    turns[:, joint] += TWIST * np.sin(beat)[:, None] * UPWARD
    return posed_by(state, _quaternions(turns), "walk", WALK / POSES)


def swaying(state: SilhouetteState, context: Context) -> SilhouetteState:
    """Return the state with a gentle sway as its motion.

    Raises
    ------
    UserError
        If nothing in it can bend.
    """
    armature = _armature(state)
    limbs = _limbs(armature)
    turns = np.zeros((POSES, len(armature.radii), 3))
    beat = 2.0 * np.pi * np.arange(POSES) / POSES
    for limb in limbs:
        size = LEAN if limb.stem in TRUNK else WAVE
        sense = -1.0 if limb.side == ".R" else 1.0
        for rank, joint in enumerate(limb.joints):
            if armature.rig.parents[joint] >= 0 and not limb.stands:
                late = np.sin(beat - 0.6 * rank)
                turns[:, joint] += sense * size * late[:, None] * DEEP
    if not turns.any():
        raise UserError("Nothing in this shape can bend. Draw a longer shape or a limb.")
    return posed_by(state, _quaternions(turns), "sway", SWAY / POSES)


def _armature(state: SilhouetteState) -> Armature:
    armature = armature_of(state)
    if armature is None:
        raise UserError("This shape has no joints. Draw a longer shape or a limb.")
    return armature


def _limbs(armature: Armature) -> list[_Limb]:
    """Return the joints that something hangs on, by the names of their bones."""
    rig = armature.rig
    rows: dict[tuple[str, str], list[int]] = {}
    for joint, name in enumerate(rig.names):
        stem, side = re.fullmatch(r"(.*?)(?:-\d+)?(\.[LR])?", name).groups("")  # type: ignore[union-attr]
        rows.setdefault((stem, side), []).append(joint)
    low = rig.joints[:, 2].min()
    tall = max(float(np.ptp(rig.joints[:, 2])), 1e-300)
    limbs = []
    for (stem, side), joints in rows.items():
        first = int(rig.parents[joints[0]])
        way = rig.joints[joints[-1]] - rig.joints[max(first, 0)]
        held: Sequence[int] = [joint for joint in joints if (rig.parents == joint).any()]
        if held:
            height = float(rig.joints[joints[-1], 2] - low) / tall
            limbs.append(_Limb(stem, side, list(held), way, height, first))
    return limbs


def _backwards(limb: _Limb) -> Array:
    """Return the axis about which a limb turns away from the viewer."""
    axis = np.cross(limb.way, DEEP)
    return np.asarray(axis / max(float(np.linalg.norm(axis)), 1e-300))


def _quaternions(vectors: Array) -> Array:
    """Return the quaternions of rotation vectors, (k, n, 4), x, y, z, w."""
    from scipy.spatial.transform import Rotation

    flat = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_quat()
    return np.asarray(flat.reshape(*vectors.shape[:2], 4))
