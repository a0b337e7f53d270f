"""Textures: pictures painted on shapes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen

if TYPE_CHECKING:
    from bozzetto.geometry.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Texture:
    """A picture wrapped around a mesh.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, sRGB, straight alpha; first row on top. Where it is transparent the colour of
        what the mesh belongs to shows through.
    corners : (f, 3, 2) float32
        Place in the picture of every corner of every face: u to the right, v down, 0 to 1.

    Raises
    ------
    ValueError
        If an array has the wrong shape or is not finite.
    """

    pixels: NDArray[np.uint8]
    corners: NDArray[np.float32]

    def __post_init__(self) -> None:
        object.__setattr__(self, "pixels", frozen(self.pixels, np.uint8))
        object.__setattr__(self, "corners", frozen(self.corners, np.float32))
        if self.pixels.ndim != 3 or self.pixels.shape[2] != 4 or not self.pixels.size:
            raise ValueError("a texture needs pixels of the shape (height, width, 4)")
        if self.corners.ndim != 3 or self.corners.shape[1:] != (3, 2):
            raise ValueError("a texture needs a place for every corner of every face")

    def painted(self, mesh: Mesh) -> Mesh:
        """Return the mesh that is wrapped, with the picture's colours at its vertices.

        A vertex at several places of the picture has the colour of one of them.
        """
        height, width = self.pixels.shape[:2]
        places = np.zeros((len(mesh.vertices), 2), np.float32)
        places[mesh.faces] = self.corners
        column, row = np.clip(places * (width, height), 0, (width - 1, height - 1)).astype(int).T
        colors = self.pixels[row, column]
        return replace(mesh, colors=colors, cover=colors[:, 3])

    def turned_over(self) -> Texture:
        """Return the texture for the same faces with their corners in reverse order."""
        return Texture(self.pixels, self.corners[:, ::-1])
