"""Textures: pictures painted on shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Flags, frozen


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

    def of_faces(self, chosen: Flags) -> Texture:
        """Return the texture of some faces (f,) alone."""
        return Texture(self.pixels, self.corners[chosen])

    def turned_over(self) -> Texture:
        """Return the texture for the same faces with their corners in reverse order."""
        return Texture(self.pixels, self.corners[:, ::-1])
