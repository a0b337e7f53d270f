"""Ink beside its surface, continued over a short way in the tangent planes at the ends of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.view.camera import Rays

LEAST_FACING: Final = 0.26
"""Cosine between the normal and the line of sight, 75°, below which the tangent plane is seen too
much edge-on to be followed: at the rim of a round body it runs away along the line of sight. There
the depth of the end is kept."""

STEEPEST: Final = 4.0
"""Difference in depth per distance across the line of sight, from one end of a gap to the other,
beyond which its ends are no neighbours on the surface."""


def continued(rays: Rays, point: Array, normal: Array, sight: Array) -> Array:
    """Continue a surface beyond its end.

    Parameters
    ----------
    rays : Rays
        Lines of sight (n,) beside the surface.
    point, normal, sight : (3,) float
        The end of what is on the surface, mm; the unit normal towards the eye there, and the unit
        direction of the ray that leads to it.

    Returns
    -------
    (n,) float
        How far along each ray the tangent plane is met, mm; NaN where it is not before the eye.
    """
    facing = -sight if float(-normal @ sight) < LEAST_FACING else normal
    with np.errstate(divide="ignore", invalid="ignore"):
        along = ((point - rays.origins) @ facing) / (rays.directions @ facing)
    return np.asarray(np.where(np.isfinite(along) & (along > 0.0), along, np.nan))


def bridged(
    rays: Rays, share: Array, points: Array, normals: Array, sight: Array
) -> tuple[Array, Array] | None:
    """Lead over a gap from one tangent plane to another.

    Parameters
    ----------
    rays : Rays
        Lines of sight (n,) in the gap.
    share : (n,) float
        How far each is over the gap, 0 … 1.
    points, normals, sight : (2, 3) float
        Of both ends, as for `continued`; for an open end the one that there is, twice.

    Returns
    -------
    points, normals : (n, 3) float
        mm, and unit vectors towards the eye. None if the ends lie one behind the other, or a plane
        is not before the eye.
    """
    step = points[1] - points[0]
    depth = float(step @ sight[0])
    if abs(depth) > STEEPEST * float(np.linalg.norm(step - depth * sight[0])):
        return None
    over = share * share * (3.0 - 2.0 * share)
    first, last = (continued(rays, points[k], normals[k], sight[k]) for k in (0, 1))
    along = (1.0 - over) * first + over * last
    if not np.isfinite(along).all():
        return None
    looks = (1.0 - over)[:, None] * normals[0] + over[:, None] * normals[1]
    length = np.linalg.norm(looks, axis=1, keepdims=True)
    return rays.origins + along[:, None] * rays.directions, looks / np.where(length > 0, length, 1)
