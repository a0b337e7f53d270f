"""Motions by hand: what a drag on the canvas does to a thing in space.

A motion is a placement in the model's frame. All are about or through a middle, as seen by
one camera, and are safe in floating point however many of them add up.
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.view import Camera

SIZES = (1e-3, 1e3)
"""Bounds of how much smaller or larger than drawn a thing may become."""

TURN_STEP = np.deg2rad(15.0)
"""Angle that a turn is rounded to with Shift."""

END_ON = 0.2
"""Sine of the angle to the line of sight below which an axis is not to be followed: a pixel
would be a long way."""

AIM = 4.0
"""Distance from the middle, px, below which a direction or a size cannot be found."""


def moved(
    middle: Array, camera: Camera, start: Array, end: Array, *, along_axis: bool = False
) -> Placement:
    """Return a shift parallel to the screen, or along one axis of the world.

    Parameters
    ----------
    middle : (3,) float array
        What is moved; its depth tells how far a pixel goes.
    camera : Camera
        What the drag is seen through.
    start, end : (2,) float array
        Canvas pixels.
    along_axis : bool
        Follow the world's axis that is seen nearest to the drag's direction.

    Raises
    ------
    UserError
        If it cannot be seen how far to go.
    """
    before, after = camera.on_plane([start, end], middle, camera.axes[2])
    shift = after - before
    if not np.isfinite(shift).all():
        raise UserError("This lies behind the eye. Turn the view until you see it, then drag.")
    if along_axis and shift.any():
        axis = _nearest_axis(shift, camera)
        shift = axis * (_along(middle, axis, camera, end) - _along(middle, axis, camera, start))
        if not np.isfinite(shift).all():
            raise UserError("Along this axis that is too far. Drag less, or turn the view.")
    return _shift(shift)


def pulled(place: Array, axis: Array, camera: Camera, start: Array, end: Array) -> float:
    """Return how far a drag pulls a place along an axis (3,), a unit vector, mm.

    Raises
    ------
    UserError
        If the axis runs along the line of sight.
    """
    right, up, _ = camera.axes
    seen = np.hypot(axis @ right, axis @ up)
    by = _along(place, axis, camera, end) - _along(place, axis, camera, start)
    if seen < END_ON or not np.isfinite(by):
        raise UserError("From here the depth is not seen. Turn the view to the side, then drag.")
    return by


def turned(
    middle: Array, camera: Camera, start: Array, end: Array, *, stepped: bool = False
) -> Placement:
    """Return a turn about the line of sight; `stepped` rounds it to 15 degrees."""
    first, last = _from_middle(middle, camera, start, end)
    angle = float(np.arctan2(-last[1], last[0]) - np.arctan2(-first[1], first[0]))
    if stepped:
        angle = TURN_STEP * round(angle / TURN_STEP)
    return _about(middle, _rotation(-camera.axes[2], angle), 1.0)


def resized(middle: Array, camera: Camera, start: Array, end: Array) -> Placement:
    """Return a change of size about the middle."""
    first, last = _from_middle(middle, camera, start, end)
    share = np.hypot(*last) / np.hypot(*first)
    return _about(middle, np.eye(3), float(np.clip(share, *SIZES)))


def mirrored(point: Array, normal: Array) -> Placement:
    """Return the reflection in a plane through a point."""
    unit = np.asarray(normal, np.float64) / np.linalg.norm(normal)
    return _about(np.asarray(point, np.float64), np.eye(3) - 2.0 * np.outer(unit, unit), 1.0)


def settled(placement: Placement) -> Placement:
    """Return a placement with the nearest rotation and a size in bounds: errors do not add up."""
    left, _, right = np.linalg.svd(np.reshape(placement.rotation, (3, 3)))
    rotation = tuple(float(v) for v in (left @ right).ravel())
    return Placement(rotation, float(np.clip(placement.scale, *SIZES)), placement.offset)


def _from_middle(middle: Array, camera: Camera, start: Array, end: Array) -> tuple[Array, Array]:
    """Return both positions relative to the middle as it is seen, px; never zero."""
    seen, _ = camera.project(middle)
    first, last = start - seen[0], end - seen[0]
    if not np.isfinite(seen).all() or np.hypot(*first) < AIM:
        raise UserError("From here this cannot be turned or sized. Turn the view, then drag.")
    if np.hypot(*last) < AIM:
        last = AIM * first / np.hypot(*first)
    return first, last


def _nearest_axis(shift: Array, camera: Camera) -> Array:
    """Return the world's axis that is seen to run most like a shift on the screen."""
    right, up, _ = camera.axes
    pictures = np.column_stack([np.eye(3) @ right, np.eye(3) @ up])
    length = np.hypot(pictures[:, 0], pictures[:, 1])
    likeness = np.abs(pictures @ (shift @ right, shift @ up)) / np.maximum(length, END_ON)
    likeness[length < END_ON] = -1.0
    axis: Array = np.eye(3)[int(likeness.argmax())]
    return axis


def _along(middle: Array, axis: Array, camera: Camera, pixel: Array) -> float:
    """Return how far along an axis through the middle its point nearest to a line of sight lies."""
    rays = camera.rays([pixel])
    between, direction = rays.origins[0] - middle, rays.directions[0]
    slope = float(axis @ direction)
    rest = 1.0 - slope**2
    if rest < 1e-9:
        return float("nan")
    return float((axis @ between - slope * (direction @ between)) / rest)


def _rotation(axis: Array, angle: float) -> Array:
    """Return the matrix of a turn about a unit vector, counter-clockwise seen against it."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix: Array = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    return matrix


def _shift(by: Array) -> Placement:
    x, y, z = (float(v) for v in by)
    return Placement(offset=(x, y, z))


def _about(middle: Array, matrix: Array, scale: float) -> Placement:
    """Return a rotation and scaling that leaves the middle where it is."""
    x, y, z = (float(v) for v in middle - scale * (matrix @ middle))
    return Placement(tuple(float(v) for v in matrix.ravel()), scale, (x, y, z))
