"""Normalization between pixels and millimetres and the units in which a camera is solved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.view.camera import Camera
from bozzetto.view.rotations import triple

if TYPE_CHECKING:
    from bozzetto.view.calibration.pose import Poses

ASIDE: Final = 4.0
"""Distance of an orthographic camera's eye from its target, in root mean square radii of the
points: so far off that nothing of them lies behind it."""


@dataclass(frozen=True, eq=False)
class Framing:
    """The units in which a calibration is solved.

    Parameters
    ----------
    centroid : (3,) float
        Centroid of the points, mm.
    radius : float
        Their root mean square distance from it, mm.
    viewport : (width, height)
        Size of the picture, px.
    """

    centroid: Array
    radius: float
    viewport: tuple[float, float]

    @property
    def diagonal(self) -> float:
        """Diagonal of the picture, px."""
        return float(np.hypot(*self.viewport))

    def points(self, points: Array) -> Array:
        """World points (n, 3), mm, about the centroid, in radii."""
        return np.asarray((points - self.centroid) / self.radius)

    def marks(self, places: Array) -> Array:
        """Places (n, 2), px, from the middle of the picture, in diagonals."""
        return np.asarray((places - 0.5 * np.array(self.viewport)) / self.diagonal)

    def pixels(self, marks: Array) -> Array:
        """Undo `marks`."""
        return np.asarray(marks * self.diagonal + 0.5 * np.array(self.viewport))

    def camera(self, pose: Poses) -> tuple[Camera, tuple[float, float]]:
        """Return the camera of the first of the poses, and how far its picture is shifted, px.

        The camera has its principal point in the middle of a canvas as large as the picture;
        its pixels plus the shift are those of the picture.
        """
        right, down, forward = pose.turn[0]
        width, height = self.viewport
        scale = float(np.exp(pose.log_scale[0])) * self.diagonal / self.radius
        aside = pose.offset[0] * self.diagonal / scale
        axis = self.centroid - aside[0] * right - aside[1] * down  # on it, beside the centroid
        shift = pose.principal[0] * self.diagonal
        strength = float(pose.perspectivity[0])
        if strength == 0.0:
            eye = axis - ASIDE * self.radius * forward
            camera = Camera(
                "orthographic", triple(eye), triple(axis), triple(-down),
                height=height / scale, viewport=(width, height),
            )  # fmt: skip
        else:
            focus = self.diagonal / strength
            eye = axis - focus / scale * forward
            opening = float(np.degrees(2.0 * np.arctan2(0.5 * height, focus)))
            camera = Camera(
                "perspective", triple(eye), triple(axis), triple(-down),
                fov_y=opening, viewport=(width, height),
            )  # fmt: skip
        return camera, (float(shift[0]), float(shift[1]))
