"""Mirror images in the symmetry plane."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto_product.model.planes import Plane

OWN_IMAGE: Final = 1e-7
"""Share of a curve's size by which it may miss its mirror image and still counts as symmetric:
above the error of fitting both halves alike, far below what a hand can draw."""

IN_PLANE: Final = 1e-9
"""Share of a curve's size by which it may leave the plane and still lies in it: rounding."""


@dataclass(frozen=True, eq=False)
class Reflection:
    """Reflection in a plane; only a sign changes where the plane is that of two axes.

    Parameters
    ----------
    plane : Plane
        One without a direction counts as the plane y = 0.
    """

    plane: Plane
    normal: Array = field(init=False)
    offset: float = field(init=False)

    def __post_init__(self) -> None:
        normal, point = np.asarray(self.plane.normal, float), np.asarray(self.plane.point, float)
        size = float(np.linalg.norm(normal))
        sound = 0.0 < size < np.inf and bool(np.isfinite(point).all())
        normal = normal / size if sound else np.array([0.0, 1.0, 0.0])
        object.__setattr__(self, "normal", normal)
        object.__setattr__(self, "offset", float(point @ normal) if sound else 0.0)

    def heights(self, points: Array) -> Array:
        """Return the signed distances of points, (n, 3), from the plane, (n,)."""
        return np.asarray(points @ self.normal - self.offset)

    def points(self, points: Array) -> Array:
        """Return the mirror images of points, (n, 3)."""
        return np.asarray(points - 2.0 * self.heights(points)[:, None] * self.normal)

    def onto(self, points: Array) -> Array:
        """Return the points of the plane nearest to given ones, (n, 3)."""
        return np.asarray(points - self.heights(points)[:, None] * self.normal)

    def spline(self, spline: Spline) -> Spline:
        """Return the mirror image of a curve, over the same parameters."""
        return spline.mirrored(self.normal, self.offset)

    def holds(self, spline: Spline) -> bool:
        """Tell whether a curve lies in the plane."""
        heights = np.abs(self.heights(spline.control_points))
        return bool(heights.max() <= IN_PLANE * size_of(spline))

    def keeps(self, spline: Spline) -> bool:
        """Tell whether a curve is its own mirror image."""
        if not self._may_keep(spline):
            return False
        images = self.points(spline.sampled(9))
        misses = np.linalg.norm(spline.value(spline.foot_points(images)) - images, axis=1)
        return bool(misses.max() <= OWN_IMAGE * size_of(spline))

    def _may_keep(self, spline: Spline) -> bool:
        """Tell quickly whether the ends are each other's images, or a closed curve crosses."""
        if spline.closed:
            heights = self.heights(spline.sampled(33))
            return bool(heights.min() < 0 < heights.max())
        first, last = spline.sampled(2)
        miss = np.linalg.norm(self.points(first[None])[0] - last)
        return bool(miss <= OWN_IMAGE * size_of(spline))

    def symmetric(self, spline: Spline) -> Spline:
        """Return an open curve that is about its own image exactly so, from end to end."""
        begin, end = spline.range
        image = self.spline(spline).reversed()
        knots = 0.5 * (spline.knots + image.knots)
        knots[:4], knots[-4:] = begin, end
        return Spline(knots, 0.5 * (spline.control_points + image.control_points))


def size_of(spline: Spline) -> float:
    """Return the diagonal of the box around a curve's control points."""
    return float(np.linalg.norm(np.ptp(spline.control_points, axis=0)))
