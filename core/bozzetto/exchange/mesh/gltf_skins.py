"""Meshes of a glTF file that follow bones, read."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.cached_properties import cached_property
from bozzetto.errors import FormatError
from bozzetto.exchange.mesh.gltf_bones import Bones, bones_of
from bozzetto.exchange.mesh.gltf_keys import moved_nodes
from bozzetto.exchange.mesh.gltf_scene import (
    AXES,
    MM_PER_METRE,
    Gltf,
    Place,
    Primitive,
    SkinRecord,
    item,
    places_of,
)
from bozzetto.exchange.mesh.gltf_skin import ROUNDING
from bozzetto.exchange.mesh.gltf_values import Blobs, values_of
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.rig import Clip, Rig, Skin

FROM_FILE: Final = Placement(tuple(AXES.ravel().tolist()), 1.0 / MM_PER_METRE).inverse()

MAX_SETS: Final = 4
"""Rows of joints and weights of a vertex that are looked at, four in each."""


@dataclass(frozen=True, eq=False)
class FollowedBones:
    """The bones that a mesh follows, in our axes and unit.

    Attributes
    ----------
    bones : Bones
        As they are in the file.
    rig, clips
        As they are with us.
    """

    gltf: Gltf
    blobs: Blobs
    reading: Reading
    bones: Bones
    rig: Rig
    clips: tuple[Clip, ...]

    @property
    def change(self) -> Array:
        """From the mesh's axes to those of the scene, (4, 4)."""
        return self.bones.change

    def skin(self, primitive: Primitive, count: int) -> Skin | None:
        """Return the skin of so many vertices; None where they follow nothing that can be told."""
        rows: list[Array] = []
        shares: list[Array] = []
        try:
            for number in range(MAX_SETS):
                names = f"JOINTS_{number}", f"WEIGHTS_{number}"
                if not primitive.attributes.keys() >= set(names):
                    break
                joints, weights = (
                    values_of(self.gltf, self.blobs, primitive.attributes[name], 4)
                    for name in names
                )
                rows.append(joints)
                shares.append(weights)
            if not rows:
                raise FormatError("No vertex says which of them it follows.")
            return self._skin(np.hstack(rows), np.hstack(shares), count)
        except FormatError as error:
            self.reading.tell(f"Left out of the glTF file: the bones of a part. {error.message}")
            return None

    def _skin(self, rows: Array, shares: Array, count: int) -> Skin:
        number = self.bones.number
        if len(rows) != count or len(shares) != count:
            raise FormatError("There are not as many weights as vertices.")
        if not np.isfinite(shares).all() or (rows < 0).any() or (rows >= len(number)).any():
            raise FormatError("A vertex follows one that is not there.")
        joints = number[rows.astype(np.intp)]
        shares = np.maximum(shares, 0.0)
        ranked = np.sort(np.where(shares > 0.0, joints, -1), axis=1)
        if ((ranked[:, 1:] == ranked[:, :-1]) & (ranked[:, 1:] >= 0)).any():
            _join_repeated(joints, shares)
        if joints.shape[1] > 4:
            order = np.argsort(-shares, axis=1, kind="stable")[:, :4]
            kept = np.take_along_axis(shares, order, axis=1)
            if float(kept.sum()) < float(shares.sum()) * (1.0 - 1e-6):
                self.reading.tell(
                    "Left out of the glTF file: the weakest of more than four bones that vertices "
                    "follow. The four strongest are kept."
                )
            joints, shares = np.take_along_axis(joints, order, axis=1), kept
        sums = shares.sum(axis=1, keepdims=True)
        shares[sums[:, 0] <= 0.0, 0] = 1.0  # what follows nothing follows the first
        sums = shares.sum(axis=1, keepdims=True)
        shares = np.where(np.abs(sums - 1.0) <= ROUNDING, shares, shares / sums)
        joints = np.where(shares > 0.0, joints, 0)
        weights = shares.astype(np.float32)
        return Skin(self.rig, joints.astype(np.int32), weights, clips=self.clips)


def _join_repeated(joints: Index, shares: Array) -> None:
    """Give the weights of a joint that a vertex names again to its first mention, in place."""
    for later in range(1, joints.shape[1]):
        for first in range(later):
            again = (joints[:, later] == joints[:, first]) & (shares[:, later] > 0.0)
            shares[again, first] += shares[again, later]
            shares[again, later] = 0.0


@dataclass
class Skins:
    """The skins of a file, each read once.

    Parameters
    ----------
    gltf, blobs
        The file.
    reading : Reading
        What is told.
    """

    gltf: Gltf
    blobs: Blobs
    reading: Reading
    _known: dict[tuple[int, int], FollowedBones | None] = field(default_factory=dict)

    def followed(self, place: Place) -> FollowedBones | None:
        """Return the bones that the mesh of a node follows; None where there are none."""
        number = None if place.node < 0 else self.gltf.nodes[place.node].skin
        if number is None:
            return None
        # Meshes that hang on one skin at several places may stand differently at rest.
        key = (number, place.parent)
        if key not in self._known:
            self._known[key] = None
            try:
                skin: SkinRecord = item(self.gltf.skins, number, "skin")
                bones, lost = bones_of(self.gltf, self.blobs, skin, self._places, place.node)
                rig = bones.rig.placed(FROM_FILE)
                clips = tuple(clip.placed(FROM_FILE) for clip in bones.clips)
                args = (self.gltf, self.blobs, self.reading, bones, rig, clips)
                self._known[key] = FollowedBones(*args)
                for name in lost:
                    self.reading.tell(
                        f"Left out of the glTF file: the motion “{name[:80]}”, which is damaged or "
                        "too long. Export it again."
                    )
            except (FormatError, ValueError, np.linalg.LinAlgError) as error:
                said = error.message if isinstance(error, FormatError) else "They are damaged."
                self.reading.tell(f"Left out of the glTF file: the bones of a part. {said}")
        return self._known[key]

    @cached_property
    def _places(self) -> dict[int, Place]:
        return {place.node: place for place in places_of(self.gltf)}

    @property
    def loose_motions(self) -> int:
        """How many motions move what is no bone of a mesh that is read."""
        if not self.gltf.animations:
            return 0
        held: set[int] = set()
        for node in self.gltf.nodes:
            if node.skin is not None and 0 <= node.skin < len(self.gltf.skins):
                for joint in self.gltf.skins[node.skin].joints:
                    while joint >= 0 and joint not in held and joint in self._places:
                        held.add(joint)
                        joint = self._places[joint].parent
        moved = [moved_nodes(one) for one in self.gltf.animations]
        return sum(not nodes or not nodes <= held for nodes in moved)
