"""The triangle mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles over shared vertices; arrays are read-only.

    Parameters
    ----------
    vertices : (v, 3) float32
        mm, in the model's own frame.
    faces : (f, 3) int32
        Counter-clockwise seen from outside.
    normals : (v, 3) float32, optional
        Unit vertex normals.
    colors : (v, 4) uint8, optional
        RGBA per vertex, sRGB.
    cover : (v,) uint8, optional
        How much of each vertex's colour is its own, 255 for all of it; the rest is the colour
        of what the mesh belongs to (`colors_over`). Only beside `colors`; default all.

    Raises
    ------
    ValueError
        If an array has the wrong shape, is not finite, or a face names a missing vertex.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32] | None = None
    colors: NDArray[np.uint8] | None = None
    cover: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen(self.vertices, np.float32, 3))
        object.__setattr__(self, "faces", frozen(self.faces, np.int32, 3))
        count = len(self.vertices)
        if len(self.faces) and (self.faces.min() < 0 or self.faces.max() >= count):
            raise ValueError("a face names a vertex that does not exist")
        if self.normals is not None:
            object.__setattr__(self, "normals", frozen(self.normals, np.float32, 3))
            if len(self.normals) != count:
                raise ValueError("a mesh needs as many normals as vertices")
        if self.colors is not None:
            object.__setattr__(self, "colors", frozen(self.colors, np.uint8, 4))
            if len(self.colors) != count:
                raise ValueError("a mesh needs as many colours as vertices")
        if self.cover is not None:
            object.__setattr__(self, "cover", frozen(self.cover, np.uint8))
            if self.colors is None or self.cover.shape != (count,):
                raise ValueError("a mesh needs one cover for the colour of every vertex")

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Corners of the bounding box, shape (2, 3), mm; NaN for an empty mesh."""
        if not len(self.vertices):
            return np.full((2, 3), np.nan)
        return np.stack((self.vertices.min(0), self.vertices.max(0))).astype(np.float64)

    @property
    def nbytes(self) -> int:
        """Size of the arrays in bytes."""
        arrays = (self.vertices, self.faces, self.normals, self.colors, self.cover)
        return sum(array.nbytes for array in arrays if array is not None)

    def placed(self, placement: Placement) -> Mesh:
        """Return the mesh moved by a placement; turned inside out where the placement mirrors."""
        if placement.is_identity:
            return self
        faces = self.faces[:, ::-1] if placement.mirrors else self.faces
        normals = None if self.normals is None else placement.directions(self.normals)
        return Mesh(
            placement.points(self.vertices).astype(np.float32),
            faces,
            None if normals is None else normals.astype(np.float32),
            self.colors,
            self.cover,
        )

    def colors_over(self, base: tuple[int, int, int]) -> NDArray[np.uint8] | None:
        """Return RGBA per vertex where the whole's colour shows through; None without colours."""
        if self.colors is None or self.cover is None:
            return self.colors
        share = self.cover[:, None].astype(np.float64) / 255.0
        under = np.array((*base, 255.0))
        return np.asarray(np.rint(under + share * (self.colors - under)), np.uint8)

    def vertex_normals(self) -> NDArray[np.float32]:
        """Return unit normals: the given ones, or the area-weighted mean of the faces around."""
        if self.normals is not None:
            return self.normals
        corners = self.vertices[self.faces].astype(np.float64)
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        total = np.zeros((len(self.vertices), 3))
        for axis in range(3):
            total[:, axis] = np.bincount(
                self.faces.ravel(), np.repeat(across[:, axis], 3), len(self.vertices)
            )
        length = np.linalg.norm(total, axis=1, keepdims=True)
        length[length == 0] = 1.0
        return np.asarray(total / length, np.float32)
