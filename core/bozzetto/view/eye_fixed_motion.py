"""Motion of a camera about its eye: its picture is only mapped to another one.

Two pictures taken from one eye differ by a homography, whatever the camera's direction and
opening angle (Hartley & Zisserman, *Multiple View Geometry*, 2nd ed., section 8.4.2). So a
sketch that was drawn from there and what is laid over it stay together.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.view.rotations import triple

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.view.camera import Camera

FOV_LIMITS = (0.5, 150.0)
"""Opening angles (degrees) within which a perspective view is zoomed about its eye."""

STEEPEST = np.radians(89.0)
"""Largest angle between the line of sight and the level of `up`: beyond, `up` says nothing."""


def aimed(camera: Camera, direction: ArrayLike, pixel: tuple[float, float]) -> Camera:
    """Turn a perspective camera about its eye until a direction is seen at a place.

    Parameters
    ----------
    camera : Camera
        The view before.
    direction : (3,) array_like
        World vector from the eye, not zero.
    pixel : (x, y)
        Where it is to be seen on the canvas.

    Returns
    -------
    Camera
        With the same `up`, so it never rolls: which way it looks is all that there is to it.
        Where `up` does not allow the place, it looks as steeply as may be.

    Notes
    -----
    With the pixel's ray (a, b, c) in the camera's frame and the direction v, of one length,
    the elevation φ of the view satisfies b cos φ + c sin φ = v · up; then the azimuth follows
    from what is level of both.
    """
    frame = _level_frame(camera)
    right, away, up = frame
    x, y = pixel
    width, height = camera.viewport
    focal = 0.5 * height / np.tan(np.radians(camera.fov_y) / 2.0)
    ray = np.array((x - 0.5 * width, 0.5 * height - y, focal))
    ray /= np.linalg.norm(ray)
    towards = np.asarray(direction, float)
    towards = towards / np.linalg.norm(towards)
    rise, reach = float(towards @ up), float(np.hypot(ray[1], ray[2]))
    now = float(np.arcsin(np.clip(camera.axes[2] @ up, -1.0, 1.0)))
    phase, swing = np.arctan2(ray[2], ray[1]), np.arccos(np.clip(rise / reach, -1.0, 1.0))
    # Beside the zenith there are two views with the place there; the nearer one is meant.
    elevation = float(min(phase - swing, phase + swing, key=lambda angle: abs(angle - now)))
    elevation = float(np.clip(elevation, -STEEPEST, STEEPEST))
    ahead = ray[2] * np.cos(elevation) - ray[1] * np.sin(elevation)
    azimuth = np.arctan2(towards @ away, towards @ right) - np.arctan2(ahead, ray[0])
    level = -np.sin(azimuth) * right + np.cos(azimuth) * away
    forward = np.cos(elevation) * level + np.sin(elevation) * up
    target = np.asarray(camera.eye) + camera.distance * forward
    return replace(camera, target=triple(target), up=triple(up))


def enlarged(camera: Camera, factor: float) -> Camera:
    """Return a perspective camera with its picture enlarged about the middle (`FOV_LIMITS`)."""
    slope = np.tan(np.radians(camera.fov_y) / 2.0) / factor
    fov = float(np.degrees(2.0 * np.arctan(slope)))
    least, most = FOV_LIMITS
    return replace(
        camera, fov_y=float(np.clip(fov, min(least, camera.fov_y), max(most, camera.fov_y)))
    )


def _level_frame(camera: Camera) -> Array:
    """Return rows right, ahead and up of a camera that stands level.

    Where the line of sight is nearly along `up`, what is upwards in its picture is up.
    """
    right, upwards, forward = camera.axes
    up = np.asarray(camera.up, float)
    largest = float(np.abs(up).max())
    if largest > 0.0:
        up = up / largest
        up = up / np.linalg.norm(up)
    if largest == 0.0 or abs(float(up @ forward)) > np.sin(STEEPEST):
        return np.vstack((right, forward, upwards))
    return np.vstack((right, np.cross(up, right), up))
