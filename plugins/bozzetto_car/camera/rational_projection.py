"""The picture of a cubic: through a camera it is a rational cubic in the plane.

The four Bézier points times the camera's matrix are the homogeneous points of the picture, so
places and derivatives there cost a few products, however often a search asks for them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.view import Camera

POWERS: Final = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], float)
"""Coefficients of 1, t, t², t³ from Bézier points."""

REMEMBERED: Final = 64
"""Number of cameras whose matrices are remembered: a body has many edits through few cameras."""

AT_EYE: Final = 1e-6
"""Depth, mm, at which a place counts as in the eye."""


@lru_cache(REMEMBERED)
def camera_matrix(camera: Camera) -> Array:
    """Return M (3, 4) with (u w, v w, w) = M (x, y, z, 1): px from mm, w > 0 before the eye."""
    right, up, forward = camera.axes
    eye = np.asarray(camera.eye)
    width, height = camera.viewport
    if camera.kind == "orthographic":
        last, scale = np.array([0.0, 0.0, 0.0, 1.0]), height / camera.height
    else:
        last = np.append(forward, -forward @ eye)
        scale = 0.5 * height / np.tan(np.radians(0.5 * camera.fov_y))
    across = scale * np.append(right, -right @ eye) + 0.5 * width * last
    down = 0.5 * height * last - scale * np.append(up, -up @ eye)
    matrix = np.stack((across, down, last))
    matrix.flags.writeable = False
    return matrix


@dataclass(frozen=True, eq=False)
class Pictured:
    """The picture of a cubic.

    Attributes
    ----------
    coefficients : (4, 3) float
        Coefficients of 1, t, t², t³ in (u w, v w, w).
    """

    coefficients: Array

    @classmethod
    def of(cls, matrix: Array, control_points: Array) -> Pictured:
        """Return the picture of Bézier points (4, 3), mm, through a camera's matrix (3, 4)."""
        seen = control_points @ matrix[:, :3].T + matrix[:, 3]
        return cls(POWERS @ seen)

    def laid_out(self, pieces: int) -> Array:
        """Return places (pieces + 1, 2), px, at equal steps of t; infinite at or behind the eye."""
        t = np.linspace(0.0, 1.0, pieces + 1)
        return self._places(self._at(t))

    def places(self, t: Array) -> Array:
        """Return places (n, 2), px; infinite at or behind the eye."""
        return self._places(self._at(t))

    def rates(self, t: Array) -> tuple[Array, Array, Array]:
        """Return places (n, 2), px, their derivatives by t, and w (n,), clipped above 0."""
        c, s = self.coefficients, t[:, None]
        seen = self._at(t)
        slope = c[1] + s * (2.0 * c[2] + s * (3.0 * c[3]))
        w = np.maximum(seen[:, 2], AT_EYE)
        places = seen[:, :2] / w[:, None]
        return places, (slope[:, :2] - slope[:, 2:] * places) / w[:, None], w

    def _at(self, t: Array) -> Array:
        c, s = self.coefficients, t[:, None]
        return np.asarray(c[0] + s * (c[1] + s * (c[2] + s * c[3])))

    @staticmethod
    def _places(seen: Array) -> Array:
        places = np.full((len(seen), 2), np.inf)
        np.divide(seen[:, :2], seen[:, 2:], out=places, where=seen[:, 2:] > AT_EYE)
        return places
