"""Canvas of curves: a plane, or the surface of another object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.scene import SurfacePlaces
from bozzetto_symmetry.model.symmetry_plane import CentrePlane


@dataclass(frozen=True)
class DrawingPlane(CentrePlane):
    """A plane that a curve is drawn in (Bae, Balakrishnan & Singh 2008: ILoveSketch).

    Parameters
    ----------
    point, normal : (x, y, z)
        In the frame of the model, mm.
    """


@dataclass(frozen=True, eq=False)
class LaidInk:
    """Where a stroke lies on the surface of another model.

    Parameters
    ----------
    places : SurfacePlaces
        On the surface as it was when the stroke was drawn.
    points, normals : (n, 3) float
        The same places in the frame of the model, mm, and the surface's unit normals.
    image_off : float
        How far the mirror image of these places is off the surface at most, mm.

    Raises
    ------
    ValueError
        If there are not as many of each, or less than two.
    """

    places: SurfacePlaces
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    image_off: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", frozen(self.points, np.float64, 3))
        object.__setattr__(self, "normals", frozen(self.normals, np.float64, 3))
        if not len(self.places) == len(self.points) == len(self.normals) >= 2:
            raise ValueError("every place of laid ink needs one point and one normal")


Canvas = DrawingPlane | LaidInk
