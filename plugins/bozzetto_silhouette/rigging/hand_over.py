"""The rig that other programs get: bones with axes, and none that moves nothing.

While posing, a joint stands at the end of each limb, for the pen to take hold of. It moves no
skin, so files do not have it. A bone's second axis points along it and its third one to the side
from which its part was drawn, so that mirrored bones have mirrored axes (Blender's convention).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Rig, Skin
from bozzetto_silhouette.rigging.armature import Armature

SHORTEST = 1e-9
"""Length of a bone, as a share of the rig's size, that points nowhere."""

SAME = 0.1
"""Share by which bones may differ in what speaks for them and still be as good."""


def handed_over(armature: Armature, skin: Skin) -> Skin:
    """Return a skin whose rig has axes, and no joints that neither skin nor joints follow.

    Parameters
    ----------
    armature : Armature
        What the rig's joints are in.
    skin : Skin
        On all joints of the armature.
    """
    rig = skin.rig
    weightless = np.bincount(skin.joints.ravel(), skin.weights.ravel(), len(rig.joints)) <= 0.0
    kept = ~weightless | (rig.parents < 0)
    for joint in range(len(kept) - 1, 0, -1):
        if kept[joint] and rig.parents[joint] >= 0:
            kept[rig.parents[joint]] = True
    number = np.cumsum(kept) - 1
    cuts = rig.cuts
    if cuts is not None:
        cuts = number[cuts[kept[cuts].all(axis=1)]].astype(np.int32)
    parents = rig.parents[kept]
    made = Rig(
        rig.joints[kept],
        np.where(parents < 0, -1, number[parents]).astype(np.int32),
        tuple(name for name, keep in zip(rig.names, kept, strict=True) if keep),
        None if rig.turns is None else rig.turns[kept],
        cuts if cuts is not None and len(cuts) else None,
        bone_axes(armature)[kept],
    )
    joints = np.where(skin.weights > 0.0, number[skin.joints], 0).astype(np.int32)
    clips = tuple(replace(clip, turns=clip.turns[:, kept]) for clip in skin.clips)
    return Skin(made, joints, skin.weights, skin.rest, clips)


def bone_axes(armature: Armature) -> Array:
    """Return the axes of each joint as columns, (n, 3, 3), in the model's frame.

    Of several bones that begin at a joint the one that goes on most straightly gives the
    direction; at a root the one with most of the shape beyond it. Those that are nearly as good
    share it, so that a pelvis points between the legs.
    """
    rig = armature.rig
    count = len(rig.joints)
    beyond = armature.radii**2
    for joint in range(count - 1, 0, -1):
        if rig.parents[joint] >= 0:
            beyond[rig.parents[joint]] += beyond[joint]
    size = max(float(np.ptp(rig.joints, axis=0).max()), 1e-300)
    axes = np.empty((count, 3, 3))
    for joint in range(count):
        placement = armature.limbs_of(joint).placement
        up, front = placement.directions(np.eye(3)[1:])
        parent = int(rig.parents[joint])
        before = rig.joints[joint] - rig.joints[parent] if parent >= 0 else None
        if before is not None and np.linalg.norm(before) <= SHORTEST * size:
            before = None
        children = np.flatnonzero(rig.parents == joint)
        ways = rig.joints[children] - rig.joints[joint]
        long = np.linalg.norm(ways, axis=1) > SHORTEST * size
        children, ways = children[long], ways[long]
        if len(ways):
            ways /= np.linalg.norm(ways, axis=1, keepdims=True)
            say = beyond[children] if before is None else ways @ before / np.linalg.norm(before)
            along = _direction(ways, say)
        elif before is not None:
            along = before / np.linalg.norm(before)
        else:
            along = up
        axes[joint] = _frame(along, front, up)
    return axes


def _direction(ways: Array, say: Array) -> Array:
    """Return the mean of those unit vectors whose say is nearly the largest."""
    best = ways[say.argmax()]
    mean = ways[say >= (1.0 - SAME) * say.max()].sum(axis=0)
    length = float(np.linalg.norm(mean))
    return best if length < SAME else np.asarray(mean / length)


def _frame(along: Array, front: Array, spare: Array) -> Array:
    """Return axes as columns: the second along, the third as near to the front as can be."""
    third = front - (front @ along) * along
    if np.linalg.norm(third) < 1e-6:
        third = spare - (spare @ along) * along
    third /= np.linalg.norm(third)
    return np.column_stack([np.cross(along, third), along, third])
