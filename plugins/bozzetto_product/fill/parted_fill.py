"""Fills in several parts, of loops that are bent inward so far that patches round a centre fold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Brep, Mesh, sewn
from bozzetto.plugin import cached_property, override
from bozzetto_product.fill.fill import CHECKS, Fill
from bozzetto_product.fill.half_sides import HalfSide
from bozzetto_product.fill.patch_fill import PatchFill
from bozzetto_product.network.net import Loop


@dataclass(frozen=True, eq=False)
class PartedFill(Fill):
    """One surface of several parts, which have common tangent planes along the cuts between them.

    Parameters
    ----------
    loop, spacing, key
        See `Fill`.
    sides, patches
        Those of the parts, one after the other; pieces of cuts have the half edge `CUT`.
    parts : tuple of PatchFill
    whole : PatchFill, optional
        Patches round one centre, where these do not fold.
    guided : frozenset of int
        Half edges that the network asks no normals of: creases along which the parts took those of
        a guide.
    starts : tuple of int
        First half edge of each outline.
    """

    parts: tuple[PatchFill, ...]
    whole: PatchFill | None = None
    guided: frozenset[int] = frozenset()
    starts: tuple[int, ...] = (0,)

    @classmethod
    def of(
        cls,
        loop: Loop,
        parts: tuple[PatchFill, ...],
        whole: PatchFill | None = None,
        guided: frozenset[int] = frozenset(),
        starts: tuple[int, ...] = (0,),
    ) -> PartedFill:
        """Return parts as one surface."""
        sides = tuple(side for part in parts for side in part.sides)
        patches = tuple(patch for part in parts for patch in part.patches)
        key = b"".join(part.key for part in parts)
        return cls(loop, sides, patches, parts[0].spacing, key, parts, whole, guided, starts)

    @cached_property
    @override
    def size(self) -> float:
        """Diagonal of the box of the loop, mm."""
        points = [half.points for side in self.sides for half in side.halves]
        return float(np.linalg.norm(np.ptp(np.concatenate(points), axis=0)))

    @cached_property
    @override
    def mesh(self) -> Mesh:
        """Triangles with normals; vertices on an edge are those of all fills that have it."""
        meshes = [part.mesh for part in self.parts]
        starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
        faces = np.concatenate(
            [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
        )
        vertices, numbers = np.unique(
            np.concatenate([mesh.vertices for mesh in meshes]), axis=0, return_inverse=True
        )
        numbers = numbers.ravel()
        normals = np.zeros(vertices.shape)
        np.add.at(normals, numbers, np.concatenate([part.mesh.normals for part in self.parts]))
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        return Mesh(vertices, numbers[faces].astype(np.int32), normals.astype(np.float32))

    @cached_property
    @override
    def brep(self) -> Brep:
        """The patches of all parts as faces, sewn along the cuts."""
        return sewn([part.brep for part in self.parts], "surface")

    @cached_property
    @override
    def folded(self) -> bool:
        """Whether normals of places beside one another point to opposite sides."""
        return any(part.folded for part in self.parts)

    @property
    @override
    def bent(self) -> PatchFill | None:
        """Patches round one centre: parts cannot be bent as one. None where these would fold."""
        return self.whole

    @property
    @override
    def has_holes(self) -> bool:
        """Whether it has more outlines than one."""
        return len(self.starts) > 1

    @property
    @override
    def g1_degrees(self) -> tuple[float, ...]:
        """Largest angle between the surface and the normals of each half edge; NaN at creases."""
        angles = enumerate(self._off_normals[:-1])
        return tuple(float("nan") if k in self.guided else angle for k, angle in angles)

    @override
    def places_beside(self, half: HalfSide, number: int, at: Array) -> tuple[Array, Array]:
        """Return places of the surface beside half a side, and unit normals there; see `Fill`."""
        for part in self.parts:
            if number < len(part.patches):
                return part.places_beside(half, number, at)
            number -= len(part.patches)
        raise IndexError("there is no such patch")

    @override
    def _halves(self) -> list[tuple[HalfSide, int, Array]]:
        at = np.linspace(0.0, 1.0, CHECKS)
        made = []
        start = 0
        for part in self.parts:
            count = len(part.sides)
            made += [
                (half, start + (number + index) % count, at)
                for number, side in enumerate(part.sides)
                for index, half in enumerate(side.halves)
            ]
            start += count
        return made
