"""The relief: a solid of heights over an outline as a function of space.

With u the squared height, ``F = u(x, y) - z^2`` is zero on the surface, positive inside, and
on balls and tubes exactly the difference of two squared distances. From F and its gradient
the ball that fits there gives the distance,

    d = 2 F / (g + sqrt(g^2 + 4 F)),    g = |grad F|,

which is exact for them, and smooth where the gradient vanishes, inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.solid import SilhouetteSolid

__all__ = ["Relief"]

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Relief:
    """A solid that was made by `solidify`, in its object frame."""

    solid: SilhouetteSolid
