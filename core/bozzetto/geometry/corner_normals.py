"""Normals of a surface at the corners of its triangles, which may differ where it has an edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Floats, frozen

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bozzetto.geometry.mesh import Mesh
    from bozzetto.geometry.placement import Placement


@dataclass(frozen=True, eq=False)
class CornerNormals:
    """Normals for the corners of faces, shared where the surface is smooth.

    Parameters
    ----------
    vectors : (n, 3) float32
        Unit normals (zero where a face has no area).
    corners : (f, 3) int32
        Which of them belongs to each corner of each face.
    """

    vectors: Floats
    corners: NDArray[np.int32]

    def __post_init__(self) -> None:
        object.__setattr__(self, "vectors", frozen(self.vectors, np.float32, 3))
        object.__setattr__(self, "corners", frozen(self.corners, np.int32, 3))

    @classmethod
    def of_meshes(cls, meshes: Sequence[Mesh]) -> CornerNormals:
        """Return the normals of meshes whose faces follow one another in a mesh of all of them."""
        starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
        rows = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
        vectors = np.concatenate([mesh.vertex_normals() for mesh in meshes])
        return cls(vectors, np.concatenate(rows).astype(np.int32))

    def placed(self, placement: Placement) -> CornerNormals:
        """Return the normals moved by a placement, as the faces of `Mesh.placed` have them."""
        if placement.is_identity:
            return self
        corners = self.corners[:, ::-1] if placement.mirrors else self.corners
        return CornerNormals(placement.directions(self.vectors).astype(np.float32), corners)

    def of_faces(self, which: NDArray[np.bool_]) -> CornerNormals:
        """Return the normals of some faces, (f,) bool."""
        return CornerNormals(self.vectors, self.corners[which])

    def turned_over(self) -> CornerNormals:
        """Return the normals of the same faces seen from the other side."""
        return CornerNormals(-self.vectors, self.corners[:, ::-1])
