"""What lets a shape move: rigs and skins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.arrays import frozen
from bozzetto.geometry.placement import Placement

__all__ = ["Rig", "Skin"]


@dataclass(frozen=True, eq=False)
class Rig:
    """A tree of joints that a skin hangs on.

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
    """

    joints: NDArray[np.float64]
    parents: NDArray[np.int32]
    names: tuple[str, ...]
    turns: NDArray[np.float64] | None = None
    cuts: NDArray[np.int32] | None = None

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

    def placed(self, placement: Placement) -> Rig:
        """The rig moved by a placement."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Skin:
    """How the vertices of a mesh follow the joints of a rig.

    Parameters
    ----------
    rig : Rig
    joints : (v, 4) uint16
        Up to four joints per vertex; 0 where the weight is 0.
    weights : (v, 4) float32
        Sum 1 per vertex.
    """

    rig: Rig
    joints: NDArray[np.uint16]
    weights: NDArray[np.float32]

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", frozen(self.joints, np.uint16, 4))
        object.__setattr__(self, "weights", frozen(self.weights, np.float32, 4))
