"""What lies under the pen: ray casting on the CPU, for every backend alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.scene.display_list import Scene
from bozzetto.view.camera import Rays

__all__ = ["Hits", "cast_rays"]


@dataclass(frozen=True, eq=False)
class Hits:
    """The front-most surface under each ray.

    Attributes
    ----------
    points : (n, 3) float
        mm; NaN where nothing was hit.
    normals : (n, 3) float
        Unit face normals turned towards the eye; NaN where nothing was hit.
    distance : (n,) float
        Along the ray, mm; inf where nothing was hit.
    owners : tuple of str
        Id of the model hit; "" where none.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    distance: NDArray[np.float64]
    owners: tuple[str, ...]

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Which rays met a surface."""
        return np.isfinite(self.distance)


def cast_rays(scene: Scene, rays: Rays) -> Hits:
    """Find where rays first meet a pickable surface of the scene."""
    count = len(rays.origins)
    nothing = np.full((count, 3), np.nan)
    return Hits(nothing, nothing, np.full(count, np.inf), ("",) * count)
