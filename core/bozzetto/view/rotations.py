"""Rotations and frames of a view, by azimuth and elevation."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.view.camera import Camera, Point

POLE = 1e-3
"""Cosine of the elevation below which Z no longer says which way is up."""

SAME_TURN = 1e-9
"""One minus the cosine of half an angle below which two rotations count as equal."""


def triple(values: ArrayLike) -> Point:
    """Return a point as three plain floats."""
    x, y, z = (float(v) for v in np.ravel(np.asarray(values, float)))
    return x, y, z


def unit(vector: ArrayLike) -> Array:
    """Return the vector at unit length; it must not be zero."""
    values = np.asarray(vector, float)
    values = values / np.abs(values).max()  # no overflow, no underflow
    return np.asarray(values / np.linalg.norm(values), np.float64)


def steepness(camera: Camera) -> tuple[float, float]:
    """Return azimuth and elevation of a view about the world's Z, radians.

    Azimuth 0 looks along +Y and grows counter-clockwise seen from above. Elevation is
    that of the eye above the target, −π/2 … π/2. The azimuth is read off the view's
    right-hand axis, so it means something at the poles too.
    """
    right, up, forward = camera.axes
    side = right if np.hypot(right[0], right[1]) > POLE else np.cross(forward, (0.0, 0.0, 1.0))
    if up[2] < -POLE:  # the view hangs upside down
        side = -side
    azimuth = float(np.arctan2(side[1], side[0]))
    level = np.array((-np.sin(azimuth), np.cos(azimuth), 0.0))
    return azimuth, float(np.arctan2(-forward[2], abs(forward @ level)))


def upright(azimuth: float, elevation: float) -> Array:
    """Return rows right, up, forward of the view with this azimuth and elevation (radians)."""
    right = np.array((np.cos(azimuth), np.sin(azimuth), 0.0))
    level = np.array((-right[1], right[0], 0.0))
    forward = np.cos(elevation) * level - np.array((0.0, 0.0, np.sin(elevation)))
    return np.stack((right, np.cross(right, forward), forward))


def placed(camera: Camera, forward: Array, up: Array) -> Camera:
    """Return the camera at its distance from its target, looking along `forward`."""
    eye = np.asarray(camera.target) - camera.distance * forward
    return replace(camera, eye=triple(eye), up=triple(up))


def _quaternion(axes: Array) -> Array:
    """Return the unit quaternion (w, x, y, z) of a right-handed frame whose rows are its axes.

    Shepperd, "Quaternion from rotation matrix", 1978: divides by the largest of the four
    components, so it has no weak places.
    """
    m = axes.T
    trace = np.trace(m)
    squares = np.array((trace, m[0, 0], m[1, 1], m[2, 2]))
    big = int(np.argmax(squares))
    if big == 0:
        made = (1 + trace, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1])
    elif big == 1:
        made = (m[2, 1] - m[1, 2], 1 + 2 * m[0, 0] - trace, m[0, 1] + m[1, 0], m[0, 2] + m[2, 0])
    elif big == 2:
        made = (m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], 1 + 2 * m[1, 1] - trace, m[1, 2] + m[2, 1])
    else:
        made = (m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 1 + 2 * m[2, 2] - trace)
    return unit(made)


def _rotation(turn: ArrayLike) -> Array:
    """Frame (rows are its axes) of a unit quaternion; undoes `_quaternion`."""
    w, x, y, z = np.asarray(turn, float)
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
            (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
            (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)),
        )
    )


def slerp(begin: Array, end: Array, t: float) -> Array:
    """Interpolate between two view frames, the short way round at constant speed.

    Rows are right, up, forward, which is left-handed; backwards makes it a rotation.
    Shoemake, "Animating rotation with quaternion curves", 1985.
    """
    backwards = np.array(((1.0,), (1.0,), (-1.0,)))
    a, b = _quaternion(begin * backwards), _quaternion(end * backwards)
    if a @ b < 0:
        b = -b
    cosine = min(float(a @ b), 1.0)
    if 1.0 - cosine < SAME_TURN:
        return backwards * _rotation(unit((1 - t) * a + t * b))
    angle = np.arccos(cosine)
    between = unit(np.sin((1 - t) * angle) * a + np.sin(t * angle) * b)
    return backwards * _rotation(between)
