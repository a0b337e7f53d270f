"""Planes that curves are drawn on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.scene import Scene, cast_rays
from bozzetto_product.model.planes import Plane, Point

STRAIGHT: Final = 1e-6
"""Sine of an angle, or length as a share of another, below which a plane is not determined."""

LOOKS: Final = 65
"""Places of a stroke at which the surface under it is asked for."""


def plane_of(point: ArrayLike, normal: ArrayLike) -> Plane:
    """Return a plane by a point and a normal of any length.

    Raises
    ------
    UserError
        If a number is not finite, or the normal has no direction.
    """
    place, direction = np.asarray(point, float), np.asarray(normal, float)
    largest = float(np.abs(direction).max())
    if not np.isfinite(place).all() or not np.isfinite(largest) or largest == 0.0:
        raise UserError("A plane needs a point and a direction. Choose another plane.")
    unit = direction / largest
    unit = unit / np.linalg.norm(unit)
    return Plane(_triple(place), _triple(unit))


def plane_through(points: ArrayLike) -> Plane:
    """Return the plane through three points.

    Parameters
    ----------
    points : (3, 3) array_like
        mm.

    Raises
    ------
    UserError
        If they are not three, or lie on a line.
    """
    place = np.asarray(points, float)
    if place.shape != (3, 3) or not np.isfinite(place).all():
        raise UserError("A plane needs three points. Mark three places.")
    one, other = place[1] - place[0], place[2] - place[0]
    normal = cross_product(one, other)
    if not np.linalg.norm(normal) > STRAIGHT * np.linalg.norm(one) * np.linalg.norm(other):
        raise UserError("The three points lie on a line. Mark a place beside it.")
    return plane_of(place[0], normal)


def fitted_plane(points: ArrayLike, ends: ArrayLike | None = None) -> Plane:
    """Return the plane nearest to points, by least squares.

    Parameters
    ----------
    points : (n, 3) array_like
        mm.
    ends : (2, 3) array_like, optional
        Two places that the plane passes through.

    Raises
    ------
    UserError
        If the points lie on a line: then every plane through it is as near.
    """
    place = np.asarray(points, float)
    middle = place.mean(axis=0) if ends is None else np.asarray(ends, float)[0]
    offset = place - middle
    if ends is not None:
        chord = np.asarray(ends, float)[1] - middle
        length = float(np.linalg.norm(chord))
        if length > 0.0:
            unit = chord / length
            across = offset - np.outer(offset @ unit, unit)
            # The chord itself counts most, so that the plane holds it.
            offset = np.vstack((across, (1.0 + np.abs(offset).sum()) * unit))
    _, sizes, axes = np.linalg.svd(offset, full_matrices=False)
    if len(sizes) < 3:
        raise UserError("Three places at least make a plane. Draw a longer curve.")
    span = float(np.ptp(place, axis=0).max())
    if not sizes[1] > STRAIGHT * max(span, 1e-300):
        raise UserError("The curve is straight, and so lies in many planes. Choose a plane for it.")
    return plane_of(middle, axes[2])


def plane_standing_on(stroke: Stroke, scene: Scene) -> Plane:
    """Return the plane on a surface, perpendicular to it, in which a stroke is drawn.

    It goes through the places of the surface under the first and the last part of the stroke that
    is over it, along the mean of the normals there.

    Parameters
    ----------
    stroke : Stroke
        With the camera that it was drawn through.
    scene : Scene
        What is visible.

    Raises
    ------
    UserError
        If less than two places of the stroke are over a surface, or the plane is not determined.
    """
    number = np.linspace(0.0, len(stroke.x) - 1.0, LOOKS)
    pixels = np.stack(
        [np.interp(number, np.arange(len(stroke.x)), column) for column in (stroke.x, stroke.y)], 1
    )
    hits = cast_rays(scene, stroke.camera.rays(pixels))
    seen = np.flatnonzero(hits.hit)
    if len(seen) < 2:
        raise UserError("Begin and end the curve on a surface: its plane stands there.")
    first, last = seen[0], seen[-1]
    along = hits.points[last] - hits.points[first]
    upright = hits.normals[first] + hits.normals[last]
    normal = cross_product(along, upright)
    if not np.linalg.norm(normal) > STRAIGHT * np.linalg.norm(along) * np.linalg.norm(upright):
        raise UserError("The plane is not determined. Begin and end the curve apart.")
    return plane_of(hits.points[first], normal)


def heights(points: ArrayLike, plane: Plane) -> Array:
    """Return distances of points from a plane, along its normal, mm."""
    return np.asarray((np.asarray(points, float) - plane.point) @ np.asarray(plane.normal))


def mirror_image(points: ArrayLike, plane: Plane) -> Array:
    """Return the mirror image of points; for a plane across an axis through 0 a change of sign."""
    place, normal = np.asarray(points, float), np.asarray(plane.normal)
    axis = _axis_of(plane)
    if axis is not None:
        image = place.copy()
        image[..., axis] = 2.0 * plane.point[axis] - image[..., axis]
        return image
    return np.asarray(place - 2.0 * heights(place, plane)[..., None] * normal)


def mirrored_plane(plane: Plane, mirror: Plane) -> Plane:
    """Return the mirror image of a plane."""
    point = np.asarray(plane.point)
    tip = mirror_image(point + np.asarray(plane.normal), mirror)
    place = mirror_image(point, mirror)
    return plane_of(place, tip - place)


def in_plane(points: ArrayLike, plane: Plane) -> Array:
    """Return the nearest points of a plane; across an axis exact to the last bit."""
    place, normal = np.asarray(points, float), np.asarray(plane.normal)
    axis = _axis_of(plane)
    if axis is not None:
        image = place.copy()
        image[..., axis] = plane.point[axis]
        return image
    return np.asarray(place - heights(place, plane)[..., None] * normal)


def _axis_of(plane: Plane) -> int | None:
    """Return the axis that a plane is across, if it is across one."""
    normal = np.abs(plane.normal)
    return int(np.argmax(normal)) if np.count_nonzero(normal) == 1 else None


def _triple(values: Array) -> Point:
    x, y, z = (float(value) + 0.0 for value in values)
    return x, y, z


def canvas_plane(point: ArrayLike, forward: Sequence[float] | Array) -> Plane:
    """Return the plane through a point that faces the view."""
    return plane_of(point, -np.asarray(forward, float))
