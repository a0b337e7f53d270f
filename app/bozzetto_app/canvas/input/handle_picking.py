"""The handle that a press would take."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.scene.display_list import Handle, Scene

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera

__all__ = ["HANDLE_REACH", "INKING_REACH", "HandleTargets"]

HANDLE_REACH: Final = 22.0
"""Radius of a handle's target, pixels: 44 px across, a fingertip."""

INKING_REACH: Final = 10.0
"""The same while the active tool inks or aims: the disc itself, so that ink can start, and places
can be met, right beside it."""


class HandleTargets:
    """The handles of a scene with their canvas positions; made once per scene and camera.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    """

    def __init__(self, scene: Scene, camera: Camera) -> None:
        self.handles = tuple(item for _, item in scene.items() if isinstance(item, Handle))
        if self.handles:
            self.places, _ = camera.project([handle.point for handle in self.handles])
        else:
            self.places = np.zeros((0, 2))

    def under(self, x: float, y: float, reach: float) -> tuple[Handle, float, float] | None:
        """Return the nearest handle within reach of a canvas position, and where it is seen."""
        if not self.handles:
            return None
        gaps = np.hypot(self.places[:, 0] - x, self.places[:, 1] - y)
        gaps[~np.isfinite(gaps)] = np.inf
        nearest = int(np.argmin(gaps))
        if gaps[nearest] > reach:
            return None
        place = self.places[nearest]
        return self.handles[nearest], float(place[0]), float(place[1])
