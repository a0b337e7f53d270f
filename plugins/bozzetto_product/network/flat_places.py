"""Planes in which the curves of a loop lie."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array

OFF_PLANE: Final = 5e-9
"""Largest distance of a loop from its plane, as share of its size: half of what exact shapes
allow between an edge and a face."""


def plane_through(places: Array, off: float = OFF_PLANE) -> tuple[Array, Array] | None:
    """Return the middle and the unit normal of the plane that places lie in, if they do.

    Parameters
    ----------
    places : (n, 3) float
        Control points will do, for a plane is affine.
    off : float
        Largest distance from it, as share of their size.
    """
    middle = places.mean(axis=0)
    normal = np.linalg.svd(places - middle, full_matrices=False)[2][2]
    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    if not float(np.abs((places - middle) @ normal).max()) <= off * size:
        return None
    return middle, normal
