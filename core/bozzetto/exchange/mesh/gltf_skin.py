"""Skins in glTF: joints as nodes, and the joints and weights of every vertex."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.geometry.rig import Rig, Skin

FEW = 256
"""Joints that one byte can tell apart."""


def rig_nodes(rig: Rig, first: int, name: str) -> list[dict[str, Any]]:
    """Return the nodes of a rig: one that holds all roots, as glTF demands, then the joints.

    Parameters
    ----------
    rig : Rig
        In the file's axes and unit. Its axes and turns are the rotations of the nodes. Where a
        loop was cut, both joints name the other in their extras.
    first : int
        Number of the first of these nodes in the file.
    name : str
        Name of the part that follows the rig.
    """
    nodes: list[dict[str, Any]] = [{"name": f"{name} rig"}]
    turns = local_turns(rig, rig.turns)
    for joint, parent in enumerate(rig.parents.tolist()):
        place = rig.joints[joint]
        if parent >= 0:
            place = place - rig.joints[parent]
            place = place if rig.axes is None else place @ rig.axes[parent]
        node: dict[str, Any] = {"name": rig.names[joint], "translation": place.tolist()}
        if turns is not None:
            node["rotation"] = turns[joint].tolist()
        nodes.append(node)
        nodes[parent + 1].setdefault("children", []).append(first + 1 + joint)
    for a, b in [] if rig.cuts is None else rig.cuts.tolist():
        for here, there in ((a, b), (b, a)):
            extras = nodes[here + 1].setdefault("extras", {"cut": []})
            extras["cut"].append(rig.names[there])
    return nodes


def local_turns(rig: Rig, turns: Array | None) -> Array | None:
    """Return the rotations of the nodes, (n, 4), x, y, z, w; None where nodes are not rotated.

    With A the axes at rest and T a joint's turn in the model's axes, the node is rotated by
    A_parentᵀ T A.

    Parameters
    ----------
    rig : Rig
        In the file's axes.
    turns : (n, 4) float array, optional
        The identity where none are given.
    """
    if rig.axes is None:
        return turns
    from scipy.spatial.transform import Rotation

    own = Rotation.from_matrix(rig.axes)
    above = np.where((rig.parents < 0)[:, None, None], np.eye(3), rig.axes[rig.parents])
    turned = own if turns is None else Rotation.from_quat(turns) * own
    return np.asarray((Rotation.from_matrix(above).inv() * turned).as_quat())


def inverse_binds(rig: Rig) -> NDArray[np.float32]:
    """Return the inverse bind matrices, (n, 16), columns first."""
    axes = np.tile(np.eye(3), (len(rig.joints), 1, 1)) if rig.axes is None else rig.axes
    matrices = np.tile(np.eye(4, dtype="<f4"), (len(rig.joints), 1, 1))
    matrices[:, :3, :3] = axes  # columns first: the transpose, which is the inverse
    matrices[:, 3, :3] = -np.einsum("nij,ni->nj", axes, rig.joints)
    return matrices.reshape(-1, 16)


def follows(
    skin: Skin, vertex: NDArray[np.intp]
) -> tuple[NDArray[np.uint8] | NDArray[np.uint16], NDArray[np.float32]]:
    """Return joints and weights of the file's vertices, (n, 4) each; joint 0 for weight 0."""
    weights = skin.weights[vertex].astype(np.float64)
    shares = (weights / weights.sum(axis=1, keepdims=True)).astype("<f4")
    joints = np.where(shares > 0.0, skin.joints[vertex], 0)
    return joints.astype("<u1" if len(skin.rig.joints) <= FEW else "<u2"), shares
