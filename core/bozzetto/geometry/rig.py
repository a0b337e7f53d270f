"""Rigs and skins: joints, and the vertices that follow them."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Floats, frozen
from bozzetto.geometry.mesh import Mesh

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement

UNIT_SUM: float = 1e-5
"""Greatest difference of a vertex's weights from a sum of one: the rounding of float32."""


@dataclass(frozen=True, eq=False)
class Rig:
    """A tree of joints that skins follow.

    Parameters
    ----------
    joints : (n, 3) float64
        Places at rest, mm. Parents stand before their children.
    parents : (n,) int32
        Index of each joint's parent; -1 for roots.
    names : tuple of str
        One per joint, all different.
    turns : (n, 4) float64, optional
        Pose: a unit quaternion (x, y, z, w) per joint, relative to its parent; the identity
        where none is given.
    cuts : (k, 2) int32, optional
        Pairs of joints that were neighbours in a loop of the shape, which was cut there.
    axes : (n, 3, 3) float64, optional
        Axes of each joint at rest as columns, in the model's: the second points along its bone.
        Those of the model where none are given. Turns are in the model's axes in any case.
    shifts : (n, 3) float64, optional
        Pose: how far each joint is moved before its parent turns, mm; not at all where none
        are given.

    Raises
    ------
    ValueError
        If the arrays do not fit together, or the joints are no trees.
    """

    joints: Array
    parents: NDArray[np.int32]
    names: tuple[str, ...]
    turns: Array | None = None
    cuts: NDArray[np.int32] | None = None
    axes: Array | None = None
    shifts: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", frozen(self.joints, np.float64, 3))
        object.__setattr__(self, "parents", frozen(self.parents, np.int32))
        count = len(self.joints)
        if len(self.parents) != count or len(self.names) != count or len(set(self.names)) != count:
            raise ValueError("a rig needs one parent and one name of its own per joint")
        if (self.parents >= np.arange(count)).any() or (self.parents < -1).any():
            raise ValueError("the parent of a joint must stand before it")
        if self.turns is not None:
            object.__setattr__(self, "turns", frozen(self.turns, np.float64, 4))
            length = np.linalg.norm(self.turns, axis=1)
            if len(self.turns) != count or not np.allclose(length, 1.0, atol=1e-6):
                raise ValueError("a rig needs one unit quaternion per joint")
        if self.cuts is not None:
            object.__setattr__(self, "cuts", frozen(self.cuts, np.int32, 2))
            if self.cuts.size and not 0 <= self.cuts.min() <= self.cuts.max() < count:
                raise ValueError("a cut names a joint that does not exist")
        if self.axes is not None:
            axes = frozen(self.axes, np.float64)
            object.__setattr__(self, "axes", axes)
            fits = axes.shape == (count, 3, 3)
            fits = fits and np.allclose(axes.transpose(0, 2, 1) @ axes, np.eye(3), atol=1e-6)
            if not fits or (np.linalg.det(axes) < 0.0).any():
                raise ValueError("a rig needs one right-handed frame of unit vectors per joint")
        if self.shifts is not None:
            object.__setattr__(self, "shifts", frozen(self.shifts, np.float64, 3))
            if len(self.shifts) != count:
                raise ValueError("a rig needs one shift per joint")

    @property
    def is_posed(self) -> bool:
        """Whether joints may be turned or moved."""
        return self.turns is not None or self.shifts is not None

    def placed(self, placement: Placement) -> Rig:
        """Return the rig moved by a placement; a mirror turns the other way round."""
        turns = None if self.turns is None else _carried(self.turns, placement)
        axes = self.axes
        if axes is not None:
            axes = np.asarray(placement.rotation).reshape(3, 3) @ axes
            if placement.mirrors:
                # Bones keep their direction and their front; so the third axis turns over.
                axes = axes * np.array([-1.0, 1.0, 1.0])
        joints = placement.points(self.joints)
        shifts = None if self.shifts is None else _moved(self.shifts, placement)
        return Rig(joints, self.parents, self.names, turns, self.cuts, axes, shifts)

    def posed(self) -> tuple[Array, Array]:
        """Return where turns and shifts take the joints.

        Returns
        -------
        rotations : (n, 3, 3) float64 array
            Rotation of every joint, in the model's axes.
        places : (n, 3) float64 array
            mm.
        """
        places = np.array(self.joints if self.shifts is None else self.joints + self.shifts)
        if not self.is_posed:
            return np.tile(np.eye(3), (len(places), 1, 1)), places
        still = np.tile((0.0, 0.0, 0.0, 1.0), (len(places), 1))
        rotations = _matrices(still if self.turns is None else self.turns)
        for joint, parent in enumerate(self.parents.tolist()):
            if parent >= 0:
                rotations[joint] = rotations[parent] @ rotations[joint]
                arm = places[joint] - self.joints[parent]
                places[joint] = places[parent] + rotations[parent] @ arm
        return rotations, places


def same_rig(one: Rig, other: Rig) -> bool:
    """Whether two rigs are the same in all they say."""
    if one is other:
        return True
    for entry in fields(Rig):
        a, b = getattr(one, entry.name), getattr(other, entry.name)
        same = a == b if isinstance(a, tuple) else np.array_equal(a, b)
        if (a is None) != (b is None) or not same:
            return False
    return True


@dataclass(frozen=True, eq=False)
class Clip:
    """A motion of a rig: poses at times, and turns at an even pace in between.

    Parameters
    ----------
    name : str
    seconds : (k,) float64
        Growing.
    turns : (k, n, 4) float64
        At each time a unit quaternion (x, y, z, w) per joint, as `Rig.turns`.
    shifts : (k, n, 3) float64, optional
        At each time how far each joint is moved, as `Rig.shifts`, mm.

    Raises
    ------
    ValueError
        If the arrays do not fit together, or times do not grow.
    """

    name: str
    seconds: Array
    turns: Array
    shifts: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "seconds", frozen(self.seconds, np.float64))
        object.__setattr__(self, "turns", frozen(self.turns, np.float64))
        if self.turns.shape != (len(self.seconds), *self.turns.shape[1:2], 4):
            raise ValueError("a clip needs a quaternion for each joint at each time")
        if not len(self.seconds) or (np.diff(self.seconds) <= 0.0).any():
            raise ValueError("the times of a clip must grow")
        if not np.allclose(np.linalg.norm(self.turns, axis=2), 1.0, atol=1e-6):
            raise ValueError("a clip needs unit quaternions")
        if self.shifts is not None:
            object.__setattr__(self, "shifts", frozen(self.shifts, np.float64))
            if self.shifts.shape != (*self.turns.shape[:2], 3):
                raise ValueError("a clip needs a shift for each joint at each time")

    def placed(self, placement: Placement) -> Clip:
        """Return the clip moved by a placement, as `Rig.placed` does."""
        shifts = None if self.shifts is None else _moved(self.shifts, placement)
        return Clip(self.name, self.seconds, _carried(self.turns, placement), shifts)


@dataclass(frozen=True, eq=False)
class Skin:
    """Weights by which the vertices of a mesh follow the joints of a rig.

    Parameters
    ----------
    rig : Rig
    joints : (v, 4) int32
        Up to four joints per vertex, all different; 0 where the weight is 0.
    weights : (v, 4) float32
        Not negative, sum 1 per vertex.
    rest : Mesh, optional
        The mesh before the rig was posed, vertex for vertex; None where it is not.
    clips : tuple of Clip
        Motions of the rig, for files that hold them.

    Raises
    ------
    ValueError
        If a joint does not exist or is named twice, a vertex's weights do not sum up to 1, or a
        clip turns other joints.
    """

    rig: Rig
    joints: NDArray[np.int32]
    weights: Floats
    rest: Mesh | None = None
    clips: tuple[Clip, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", frozen(self.joints, np.int32, 4))
        object.__setattr__(self, "weights", frozen(self.weights, np.float32, 4))
        if len(self.joints) != len(self.weights):
            raise ValueError("a skin needs four weights for the four joints of a vertex")
        if self.joints.size and not 0 <= self.joints.min() <= self.joints.max() < len(
            self.rig.joints
        ):
            raise ValueError("a skin names a joint that does not exist")
        sums = self.weights.sum(axis=1, dtype=np.float64)
        if (self.weights < 0).any() or (np.abs(sums - 1.0) > UNIT_SUM).any():
            raise ValueError("the weights of a vertex must sum up to one")
        ranked = np.sort(np.where(self.weights > 0, self.joints.astype(np.int32), -1), axis=1)
        if ((ranked[:, 1:] == ranked[:, :-1]) & (ranked[:, 1:] >= 0)).any():
            raise ValueError("a vertex names a joint twice")
        if self.rest is not None and len(self.rest.vertices) != len(self.joints):
            raise ValueError("a skin belongs to a mesh of as many vertices")
        if any(clip.turns.shape[1] != len(self.rig.joints) for clip in self.clips):
            raise ValueError("a clip must turn the joints of its rig")

    def placed(self, placement: Placement) -> Skin:
        """Return the skin moved by a placement, rig and all."""
        rest = None if self.rest is None else self.rest.placed(placement)
        clips = tuple(clip.placed(placement) for clip in self.clips)
        return Skin(self.rig.placed(placement), self.joints, self.weights, rest, clips)

    def posed(self, mesh: Mesh) -> Mesh:
        """Return the rest mesh posed as the rig is: linear blend skinning, as in glTF.

        Parameters
        ----------
        mesh : Mesh
            With as many vertices as the skin; its normals turn along.
        """
        from scipy.sparse import csr_array

        if not self.rig.is_posed:
            return mesh
        rotations, places = self.rig.posed()
        shifts = places - np.einsum("nij,nj->ni", rotations, self.rig.joints)
        moves = np.concatenate((rotations.reshape(-1, 9), shifts), axis=1)
        ends = np.arange(len(self.joints) + 1) * 4
        follows = csr_array(
            (self.weights.ravel().astype(np.float64), self.joints.ravel(), ends),
            shape=(len(self.joints), len(moves)),
        )
        mixed = follows @ moves
        turn = mixed[:, :9].reshape(-1, 3, 3)
        vertices = np.einsum("vij,vj->vi", turn, mesh.vertices) + mixed[:, 9:]
        normals = mesh.normals
        if normals is not None:
            turned = np.einsum("vij,vj->vi", turn, normals)
            length = np.sqrt((turned**2).sum(axis=1, keepdims=True))
            # Opposite turns may cancel: then the normal stays as it was.
            known = length > 0.0
            normals = np.divide(turned, length, out=normals.astype(np.float64), where=known)
        return replace(mesh, vertices=vertices, normals=normals)


def _moved(shifts: Array, placement: Placement) -> Array:
    """Carry shifts into another frame."""
    return placement.scale * placement.directions(shifts).reshape(shifts.shape)


def _carried(turns: Array, placement: Placement) -> Array:
    """Carry quaternions into another frame; their axes are axial: a mirror reverses them."""
    sense = -1.0 if placement.mirrors else 1.0
    axes = sense * placement.directions(turns[..., :3].reshape(-1, 3))
    return np.concatenate((axes.reshape(*turns.shape[:-1], 3), turns[..., 3:]), axis=-1)


def _matrices(quaternions: Array) -> Array:
    """Return rotation matrices (n, 3, 3) of unit quaternions (n, 4), x, y, z, w."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], axis=1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], axis=1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], axis=1),
        ],
        axis=1,
    )
