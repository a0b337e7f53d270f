"""Skins in glTF: joints as nodes, and the joints and weights of every vertex."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.geometry.rig import Rig, Skin

FEW = 256
"""Joints that one byte can tell apart."""

FINEST = 2.0**-30
"""Least length told of a joint, m: a millionth of a millimetre."""

TURN = 2.0**-24
"""Least difference of quaternions told: single precision near one."""

ROUNDING = 2.0**-23
"""Difference from one of the sum of four weights that were rounded to single precision."""

STEADY = 8
"""Rounds in which rounded quaternions of length one come to rest; two are usual."""


def rig_in_file(rig: Rig) -> tuple[Rig, NDArray[np.float32]]:
    """Return a rig as a file holds it, and its inverse bind matrices, (n, 16), columns first.

    Parameters
    ----------
    rig : Rig
        In the file's axes and unit.

    Returns
    -------
    rig : Rig
        With the joints that the matrices tell, so that what is read is written the same again.
    matrices : (n, 16) float32
    """
    axes = np.tile(np.eye(3), (len(rig.joints), 1, 1)) if rig.axes is None else rig.axes
    matrices = np.tile(np.eye(4, dtype="<f4"), (len(rig.joints), 1, 1))
    matrices[:, :3, :3] = axes  # columns first: the transpose, which is the inverse
    offsets = np.einsum("nij,ni->nj", matrices[:, :3, :3].astype(np.float64), rig.joints)
    matrices[:, 3, :3] = -np.rint(offsets / FINEST) * FINEST
    matrices = matrices + np.float32(0.0)  # no zero has a sign
    flat = matrices.reshape(-1, 16)
    joints, known = bound_joints(flat.astype(np.float64))
    return replace(rig, joints=joints, axes=None if rig.axes is None else known), flat


def bound_joints(matrices: Array) -> tuple[Array, Array]:
    """Return joints, (n, 3), and their axes, (n, 3, 3), of rigid inverse bind matrices, (n, 16)."""
    columns = matrices.reshape(-1, 4, 4)
    axes = columns[:, :3, :3]
    joints = np.linalg.solve(axes.transpose(0, 2, 1), -columns[:, 3, :3, None])[..., 0]
    return np.asarray(joints, np.float64), axes


def rig_nodes(rig: Rig, first: int, name: str) -> list[dict[str, Any]]:
    """Return the nodes of a rig: one that holds all roots, as glTF demands, then the joints.

    Parameters
    ----------
    rig : Rig
        As `rig_in_file` gives it. Its axes and turns are the rotations of the nodes. Where a
        loop was cut, both joints name the other in their extras.
    first : int
        Number of the first of these nodes in the file.
    name : str
        Name of the part that follows the rig.
    """
    nodes: list[dict[str, Any]] = [{"name": f"{name} rig"}]
    turns = local_turns(rig, rig.turns)
    places = local_places(rig, rig.shifts)
    for joint, parent in enumerate(rig.parents.tolist()):
        node: dict[str, Any] = {"name": rig.names[joint], "translation": places[joint].tolist()}
        if turns is not None:
            node["rotation"] = turns[joint].tolist()
        nodes.append(node)
        nodes[parent + 1].setdefault("children", []).append(first + 1 + joint)
    for a, b in [] if rig.cuts is None else rig.cuts.tolist():
        for here, there in ((a, b), (b, a)):
            extras = nodes[here + 1].setdefault("extras", {"cut": []})
            extras["cut"].append(rig.names[there])
    return nodes


def local_places(rig: Rig, shifts: Array | None) -> Array:
    """Return the translations of the nodes, (…, n, 3), in the axes of their parents.

    Parameters
    ----------
    rig : Rig
        In the file's axes.
    shifts : (…, n, 3) float array, optional
        None where joints are not moved.
    """
    is_root = (rig.parents < 0)[:, None]
    arms = rig.joints - np.where(is_root, 0.0, rig.joints[rig.parents])
    arms = arms if shifts is None else arms + shifts
    if rig.axes is not None:
        from scipy.spatial.transform import Rotation

        axes = Rotation.from_matrix(rig.axes).as_matrix()  # rounded ones are made unit vectors
        above = np.where(is_root[..., None], np.eye(3), axes[rig.parents])
        arms = np.einsum("nij,...ni->...nj", above, arms)
    return np.asarray(np.rint(arms / FINEST) * FINEST + 0.0)


def local_turns(rig: Rig, turns: Array | None) -> Array | None:
    """Return the rotations of the nodes, (…, n, 4), x, y, z, w; None where nodes are not rotated.

    With A the axes at rest and T a joint's turn in the model's axes, the node is rotated by
    A_parentᵀ T A.

    Parameters
    ----------
    rig : Rig
        In the file's axes.
    turns : (…, n, 4) float array, optional
        The identity where none are given.
    """
    if rig.axes is None:
        return None if turns is None else _settled(turns)
    from scipy.spatial.transform import Rotation

    still = np.tile((0.0, 0.0, 0.0, 1.0), (len(rig.joints), 1))
    rows = still if turns is None else turns
    axes = np.broadcast_to(rig.axes, (*rows.shape[:-1], 3, 3)).reshape(-1, 3, 3)
    above = np.where((rig.parents < 0)[:, None, None], np.eye(3), rig.axes[rig.parents])
    above = np.broadcast_to(above, (*rows.shape[:-1], 3, 3)).reshape(-1, 3, 3)
    turned = Rotation.from_quat(rows.reshape(-1, 4)) * Rotation.from_matrix(axes)
    local = Rotation.from_matrix(above).inv() * turned
    return _settled(local.as_quat().reshape(rows.shape))


def _settled(turns: Array) -> Array:
    """Return quaternions rounded so that reading and rounding them again changes nothing.

    Of the two of a rotation it is the one with w above zero; where w is zero, with the last
    component above zero that is not.
    """
    known = np.asarray(turns, np.float64)
    for _ in range(STEADY):
        unit = known / np.linalg.norm(known, axis=-1, keepdims=True)
        rounded = np.rint(unit / TURN) * TURN
        if (rounded == known).all():
            break
        known = rounded
    sense = np.zeros(known.shape[:-1])
    for component in (3, 2, 1, 0):
        sense = np.where(sense == 0.0, np.sign(known[..., component]), sense)
    return known * np.where(sense == 0.0, 1.0, sense)[..., None] + 0.0


def follows(
    skin: Skin, vertex: NDArray[np.intp]
) -> tuple[NDArray[np.uint8] | NDArray[np.uint16], NDArray[np.float32]]:
    """Return joints and weights of the file's vertices, (n, 4) each; joint 0 for weight 0."""
    weights = skin.weights[vertex].astype(np.float64)
    sums = weights.sum(axis=1, keepdims=True)
    exact = np.abs(sums - 1.0) <= ROUNDING
    shares = np.where(exact, weights, weights / sums).astype("<f4")
    joints = np.where(shares > 0.0, skin.joints[vertex], 0)
    return joints.astype("<u1" if len(skin.rig.joints) <= FEW else "<u2"), shares
