"""The plane of a flat symmetric curve, and the surface of one that bows out of it a little.

A plane that is its own mirror image contains the normal of the centre plane, so its angle about
that normal and its distance say which it is. Three figures more bow it across and along itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_symmetry.stereo.mirror_camera import Stereo

STEEP: Final = 0.05
"""Least sine of the angle between rays and the surface: flatter ones do not say where it is."""

STEPS: Final = 6
"""Newton steps to where a ray meets a bowed surface; a bow is shallow."""

FIGURES: Final = 5
"""Angle, distance, and three bows."""


@dataclass(frozen=True, eq=False)
class BowedPlane:
    """A surface ``n · X = d + bows``, n of unit length with ``n_y = 0``.

    Attributes
    ----------
    angle, away : float
        Of n about the y axis, radians, and d, mm.
    bows : (float, float, float)
        Height above the plane at one `size` from `middle`, in sizes: by the square of y, and by the
        square and the cube of the way along the plane.
    middle, size : float
        Where bows are nought along the plane, and their unit, mm.
    """

    angle: float
    away: float
    bows: tuple[float, float, float] = (0.0, 0.0, 0.0)
    middle: float = 0.0
    size: float = 1.0

    @property
    def normal(self) -> Array:
        """The unit normal of the plane, (3,)."""
        return np.array((np.cos(self.angle), 0.0, np.sin(self.angle)))

    @property
    def along(self) -> Array:
        """The direction in the plane that is square to the y axis, (3,)."""
        return np.array((-np.sin(self.angle), 0.0, np.cos(self.angle)))

    @property
    def figures(self) -> Array:
        """Angle, distance and bows, (5,)."""
        return np.array((self.angle, self.away, *self.bows))

    @property
    def flat(self) -> bool:
        """Whether it is a plane."""
        return not any(self.bows)

    def moves(self, points: Array) -> Array:
        """Return how far the surface rises at places for a unit of each figure, (n, 5) mm."""
        way = (points @ self.along - self.middle) / self.size
        bows = self.size * np.column_stack(((points[:, 1] / self.size) ** 2, way**2, way**3))
        return np.column_stack((-(points @ self.along), np.ones(len(points)), bows))

    def heights(self, points: Array) -> Array:
        """Return how far places are above the surface along n, (n,) mm."""
        if self.flat:
            return np.asarray(points @ self.normal - self.away)
        return np.asarray(
            points @ self.normal - self.away - self.moves(points)[:, 2:] @ np.array(self.bows)
        )

    def gradients(self, points: Array) -> Array:
        """Return the derivatives of the heights by the place, (n, 3)."""
        made = np.tile(self.normal, (len(points), 1))
        if not self.flat:
            across, square, cube = self.bows
            way = (points @ self.along - self.middle) / self.size
            made[:, 1] -= 2.0 * across * points[:, 1] / self.size
            made -= np.outer(2.0 * square * way + 3.0 * cube * way**2, self.along)
        return np.asarray(made)

    def met(self, stereo: Stereo, pixels: Array) -> tuple[Array, Array, Array]:
        """Return where rays meet the surface.

        Returns
        -------
        points : (n, 3) float
            mm; NaN where a ray does not meet it, or nearly runs along it.
        directions : (n, 3) float
            Of the rays.
        slopes : (n,) float
            How fast a ray rises above the surface there.
        """
        rays = stereo.rays(pixels)
        origins, directions = rays.origins, rays.directions
        slope = directions @ self.normal
        rest = self.away - origins @ self.normal
        reach = np.full(len(slope), np.nan)
        np.divide(rest, slope, out=reach, where=np.abs(slope) > STEEP)
        points = origins + reach[:, None] * directions
        for _ in range(0 if self.flat else STEPS):
            slope = (self.gradients(points) * directions).sum(axis=1)
            steep = np.abs(slope) > STEEP
            step = np.full(len(slope), np.nan)
            np.divide(-self.heights(points), slope, out=step, where=steep)
            reach = reach + step
            points = origins + reach[:, None] * directions
        if not stereo.parallel:
            points = np.where(reach[:, None] > 0.0, points, np.nan)
        return points, directions, slope
