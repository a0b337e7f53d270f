"""Bones of glTF skins, read: joints at rest, their pose, and the motions of their nodes.

A file says where each joint is at rest by the matrix that brings the mesh to it (the inverse bind
matrix), in axes of the mesh that need not be those of the scene, and where it is now by its node.
A rig of ours is in one frame; the change into it is that under which the nodes are moved least
from rest. Stretched bones keep their place and direction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bozzetto.arrays import Array, Index
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import at_most
from bozzetto.exchange.mesh.gltf_keys import key_times, moved_nodes, node_matrices
from bozzetto.exchange.mesh.gltf_scene import Gltf, Place, SkinRecord
from bozzetto.exchange.mesh.gltf_skin import bound_joints
from bozzetto.exchange.mesh.gltf_values import Blobs, values_of
from bozzetto.geometry.rig import Clip, Rig

STILL: Final = 1e-6
"""Turn, rad, and shift, in the size of the rig, below which a joint counts as at rest: single
precision."""

ALIKE: Final = 1e-3
"""Share by which scales of one rig may differ and still be one."""

MAX_JOINTS: Final = 10_000
MAX_POSES: Final = 4_000_000
"""Joints times key times of one motion: an hour of a body at twenty a second."""


@dataclass(frozen=True, eq=False)
class Bones:
    """The rig of a skin of a file.

    Attributes
    ----------
    rig : Rig
        In the file's axes and unit, posed as its nodes are.
    clips : tuple of Clip
    change : (4, 4) array
        From the mesh's own axes to those of the scene, at rest.
    number : (j,) int
        For each joint of the file's skin its number in the rig.
    """

    rig: Rig
    clips: tuple[Clip, ...]
    change: Array
    number: Index


def bones_of(
    gltf: Gltf, blobs: Blobs, skin: SkinRecord, places: Mapping[int, Place], holder: int
) -> tuple[Bones, tuple[str, ...]]:
    """Return the bones of a skin, and the names of the motions that could not be read.

    Parameters
    ----------
    gltf, blobs
        The file.
    skin : SkinRecord
        Its joints.
    places : mapping of int to Place
        All nodes of the scene.
    holder : int
        The node whose mesh follows the joints.

    Raises
    ------
    FormatError
        If joints are not in the scene, named twice, or at no place at rest.
    """
    joints = skin.joints
    at_most(len(joints), MAX_JOINTS, "bones")
    if not joints or len(set(joints)) < len(joints) or not places.keys() >= set(joints):
        raise FormatError("They are not in the scene.")
    order, parents = _as_tree(joints, places)
    binds = np.tile(np.eye(4), (len(joints), 1, 1))
    if skin.inverse_bind_matrices is not None:
        rows = values_of(gltf, blobs, skin.inverse_bind_matrices, 16)
        if len(rows) < len(joints):
            raise FormatError("There are more of them than places at rest.")
        binds = rows[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    binds = binds[order]
    nodes = [joints[k] for k in order.tolist()]
    now = np.array([places[node].matrix for node in nodes])
    if not np.isfinite(binds).all() or not (np.abs(np.linalg.det(binds)) > 1e-18).all():
        raise FormatError("Their places at rest cannot be told.")
    if (np.linalg.det(now @ binds) <= 1e-18).any():
        raise FormatError("They turn the mesh inside out.")
    change = _change(now, binds, parents, places, nodes, holder)
    points, axes = _at_rest(binds, change)
    names = _names(gltf, nodes)
    rig = Rig(points, parents, names, axes=None if (axes == np.eye(3)).all() else axes)
    turns, shifts = _pose(rig, now[None])
    rig = Rig(
        points,
        parents,
        names,
        None if turns is None else turns[0],
        _cuts(gltf, nodes, names),
        rig.axes,
        None if shifts is None else shifts[0],
    )
    number = np.empty(len(joints), np.intp)
    number[order] = np.arange(len(joints))
    clips, lost = _clips(gltf, blobs, rig, nodes, places)
    return Bones(rig, clips, change, number), lost


def _as_tree(joints: list[int], places: Mapping[int, Place]) -> tuple[Index, NDArray[np.int32]]:
    """Return joints with parents first, as far as can be in their order, and their parents."""
    at = {node: k for k, node in enumerate(joints)}
    above = []
    for node in joints:
        parent = places[node].parent
        while parent >= 0 and parent not in at:
            parent = places[parent].parent
        above.append(at.get(parent, -1))
    order: list[int] = []
    done: set[int] = set()
    for joint in range(len(joints)):
        row = []
        while joint >= 0 and joint not in done:
            row.append(joint)
            done.add(joint)
            joint = above[joint]
        order += reversed(row)
    rank = np.empty(len(joints), np.int32)
    rank[order] = np.arange(len(joints))
    parents = [-1 if above[k] < 0 else int(rank[above[k]]) for k in order]
    return np.array(order, np.intp), np.array(parents, np.int32)


def _names(gltf: Gltf, nodes: list[int]) -> tuple[str, ...]:
    """Return the names of joints; what has none, or another's, gets a number."""
    found: dict[str, None] = {}
    for number, node in enumerate(nodes):
        wanted = name = gltf.nodes[node].name or f"joint {number}"
        count = 1
        while name in found:
            count += 1
            name = f"{wanted} {count}"
        found[name] = None
    return tuple(found)


def _cuts(gltf: Gltf, nodes: list[int], names: tuple[str, ...]) -> NDArray[np.int32] | None:
    """Return the pairs of joints that our own files say were neighbours in a loop."""
    number = {name: k for k, name in enumerate(names)}
    found = []
    for joint, node in enumerate(nodes):
        extras = gltf.nodes[node].extras
        told: Any = extras.get("cut") if isinstance(extras, dict) else None
        for name in told if isinstance(told, list) else []:
            other = number.get(name, -1) if isinstance(name, str) else -1
            if other > joint:
                found.append((joint, other))
    return np.array(sorted(found), np.int32) if found else None


def _change(
    now: Array,
    binds: Array,
    parents: NDArray[np.int32],
    places: Mapping[int, Place],
    nodes: list[int],
    holder: int,
) -> Array:
    """Return the change of axes from the mesh to the scene under which joints are moved least."""
    moves = now @ binds
    scale = float(np.median(np.cbrt(np.linalg.det(moves))))
    root = int(np.flatnonzero(parents < 0)[0])
    above = places[nodes[root]].parent
    best = np.eye(4)
    least = np.inf
    for change in (
        np.eye(4),
        np.eye(4) if above < 0 else places[above].matrix,
        places[holder].matrix,
        moves[root],
    ):
        size = np.linalg.det(change)
        if size <= 0.0 or abs(np.cbrt(size) / scale - 1.0) > ALIKE:
            continue
        points, axes = _at_rest(binds, change)
        _, shifts = _apart(points, axes, parents, now[None])
        far = float(np.abs(shifts).max()) / _extent(points)
        if far < least - STILL:
            best, least = change, far
    if least == np.inf:
        best = moves[root]
    return best


def _at_rest(binds: Array, change: Array) -> tuple[Array, Array]:
    """Return joints, (n, 3), and their axes, (n, 3, 3), at rest in the scene."""
    if (change == np.eye(4)).all() and _is_rigid(binds):
        return bound_joints(binds.transpose(0, 2, 1).reshape(-1, 16))
    at_rest = change @ np.linalg.inv(binds)
    return at_rest[:, :3, 3], _rotations(at_rest[:, :3, :3])


def _is_rigid(matrices: Array) -> bool:
    turns = matrices[:, :3, :3]
    near = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max() < 1e-6
    return bool(near and (np.linalg.det(turns) > 0.0).all())


def _rotations(matrices: Array) -> Array:
    """Return the nearest rotations of matrices, (…, 3, 3)."""
    left, _, right = np.linalg.svd(matrices)
    turned = np.sign(np.linalg.det(left @ right))
    left[..., 2] *= turned[..., None]
    return np.asarray(left @ right)


def _apart(
    points: Array, axes: Array, parents: NDArray[np.int32], now: Array
) -> tuple[Rotation, Array]:
    """Return how joints are turned, (k n), and shifted, (k, n, 3), when their nodes stand so.

    With R the axes at rest and G those now, a joint is turned by R_parent G_parentᵀ G Rᵀ. What its
    place p lacks at g now is shifted before the parent turns: Q_parentᵀ (g − g_parent) − (p −
    p_parent) with Q = G Rᵀ (glTF 2.0, section 3.7.3).
    """
    count, joints = now.shape[:2]
    rest = Rotation.from_matrix(axes).as_matrix()
    turned = _rotations(now[..., :3, :3])
    whole = turned @ rest.transpose(0, 2, 1)
    is_root = parents < 0
    above = np.where(is_root[:, None, None], np.eye(3), whole[:, parents])
    there = np.where(is_root[:, None], 0.0, now[..., :3, 3][:, parents])
    before = np.where(is_root[:, None], 0.0, points[parents])
    back = above.transpose(0, 1, 3, 2)
    shifts = np.einsum("knij,knj->kni", back, now[..., :3, 3] - there) - (points - before)
    turns = (back @ whole).reshape(count * joints, 3, 3)
    return Rotation.from_matrix(turns), shifts


def _pose(rig: Rig, now: Array) -> tuple[Array | None, Array | None]:
    """Return turns, (k, n, 4), and shifts, (k, n, 3), of a rig; None for what stays at rest."""
    axes = np.tile(np.eye(3), (len(rig.joints), 1, 1)) if rig.axes is None else rig.axes
    turned, shifts = _apart(rig.joints, axes, rig.parents, now)
    moved = float(np.abs(shifts).max()) > STILL * _extent(rig.joints)
    turns = turned.as_quat().reshape(*now.shape[:2], 4)
    return (
        turns if float(turned.magnitude().max()) > STILL else None,
        shifts if moved else None,
    )


def _extent(points: Array) -> float:
    """Return the size of a rig, or how far it is from the origin, whichever is larger."""
    return max(float(np.abs(points).max()), 1e-12)


def _clips(
    gltf: Gltf, blobs: Blobs, rig: Rig, nodes: list[int], places: Mapping[int, Place]
) -> tuple[tuple[Clip, ...], tuple[str, ...]]:
    """Return the motions of a rig, and the names of those that could not be read."""
    chain = list(_chain(nodes, places))
    found: list[Clip] = []
    lost: list[str] = []
    taken: set[str] = set()
    for animation in gltf.animations:
        name = animation.name or "motion"
        if name in taken:
            name = f"{name} {len(taken) + 1}"
        if moved_nodes(animation).isdisjoint(chain):
            continue
        try:
            times = key_times(gltf, blobs, animation, frozenset(chain))
            at_most(len(times) * len(chain), MAX_POSES, "poses of bones")
            matrices = node_matrices(gltf, blobs, animation, chain, places, times)
            turns, shifts = _pose(rig, np.stack([matrices[node] for node in nodes], axis=1))
            if turns is None:
                turns = np.tile((0.0, 0.0, 0.0, 1.0), (len(times), len(nodes), 1))
            found.append(Clip(name, times, turns, shifts))
            taken.add(name)
        except (FormatError, ValueError):
            lost.append(name)
    return tuple(found), tuple(lost)


def _chain(nodes: list[int], places: Mapping[int, Place]) -> Iterator[int]:
    """Yield joints and all that they are in, parents first."""
    done: set[int] = set()
    for node in nodes:
        row = []
        while node >= 0 and node not in done:
            row.append(node)
            done.add(node)
            node = places[node].parent
        yield from reversed(row)
