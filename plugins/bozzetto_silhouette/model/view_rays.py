"""Lines of sight through a sheet: how what was drawn on it reaches what lies before and behind.

Through a perspective camera they meet in the eye, else they are parallel. Both are one map:
with z the height above the sheet, the line of sight through q on the sheet passes the points

    p(z) = w q + z m,    w = 1 - k z,

where k is one over the height of the eye (0 for a parallel view) and m its direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.view import Camera
from bozzetto_silhouette.model.sketch_plane import Sheet

NEAREST = 0.02
"""Share of the way from the eye to the sheet that is left free in front of the eye: a cone
has no width there."""

STEEPEST = 1e-6
"""Least height of the eye over the sheet, as a share of its distance; a view that looks along
the sheet is refused where the ink is read."""


@dataclass(frozen=True, eq=False)
class ViewRays:
    """The lines of sight of one camera, in the object frame of a sheet.

    Attributes
    ----------
    narrowing : float
        k, 1/mm.
    slant : (2,) float array
        m, mm per mm.
    """

    narrowing: float
    slant: Array

    def width(self, heights: ArrayLike) -> Array:
        """Return the size of the drawing at heights (n,), as a share of that on the sheet."""
        return 1.0 - self.narrowing * np.asarray(heights, np.float64)

    def above(self, drawn: Array, heights: ArrayLike) -> Array:
        """Follow lines of sight through places on the sheet (n, 2) to heights (n,); (n, 3)."""
        z = np.broadcast_to(np.asarray(heights, np.float64), (len(drawn),))
        across = self.width(z)[:, None] * drawn + z[:, None] * self.slant
        return np.column_stack([across, z])

    def drawn(self, points: Array) -> Array:
        """Return where points (n, 3), before the eye, are seen on the sheet, (n, 2)."""
        z = points[:, 2]
        return np.asarray((points[:, :2] - z[:, None] * self.slant) / self.width(z)[:, None])

    def before_eye(self, low: float, high: float) -> tuple[float, float]:
        """Clip a range of heights to what the eye can see; the sheet's own height is in it."""
        if self.narrowing > 0.0:
            high = min(high, (1.0 - NEAREST) / self.narrowing)
        elif self.narrowing < 0.0:
            low = max(low, (1.0 - NEAREST) / self.narrowing)
        return low, high


def view_rays_through(sheet: Sheet, camera: Camera) -> ViewRays:
    """Return the lines of sight of a camera in the object frame of a sheet."""
    into = sheet.placement.inverse()
    if camera.kind == "orthographic":
        along, narrowing = into.directions(camera.axes[2])[0], 0.0
        height = _apart_from_zero(along[2], 1.0)
    else:
        along = into.points(camera.eye)[0]
        height = _apart_from_zero(along[2], float(np.linalg.norm(along)))
        narrowing = 1.0 / height
    return ViewRays(narrowing, along[:2] / height)


def _apart_from_zero(height: float, size: float) -> float:
    least = STEEPEST * size
    return float(height) if abs(height) > least else float(np.copysign(least, height))
