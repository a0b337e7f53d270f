"""Where lines of one direction run on the sheet, and how large a pixel is in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.view import Camera


def focal_length(camera: Camera) -> float:
    """Return the distance of the sheet from the eye, px; 1 in a parallel view."""
    if camera.kind == "orthographic":
        return 1.0
    return float(0.5 * camera.viewport[1] / np.tan(np.radians(camera.fov_y) / 2.0))


def vanishing_point(camera: Camera, direction: ArrayLike) -> Array:
    """Return where lines of a direction (3,) meet on the sheet.

    Returns
    -------
    (3,) float
        Homogeneous coordinates (x, y, w), px. The point is at infinity where w is 0, as it
        always is in a parallel view; all three are 0 where such a view looks along the lines.
    """
    right, up, forward = camera.axes @ np.asarray(direction, float)
    if camera.kind == "orthographic":
        return np.array([right, -up, 0.0])
    (width, height), focal = camera.viewport, focal_length(camera)
    return np.array(
        [focal * right + 0.5 * width * forward, 0.5 * height * forward - focal * up, forward]
    )


def toward_vanishing(camera: Camera, direction: ArrayLike, pixels: ArrayLike) -> Array:
    """Return which way lines of a direction (3,) run at places (..., 2) px on the sheet.

    Returns
    -------
    (..., 2) float
        Of any length: over the focal length it is the sine under which the line is seen.
    """
    x, y, w = vanishing_point(camera, direction)
    return np.asarray(np.array([x, y]) - w * np.asarray(pixels, float))


def pixel_size(camera: Camera, points: ArrayLike) -> Array:
    """Return the length of a pixel at points (n, 3) in front of the eye, (n,) mm."""
    place = np.reshape(np.asarray(points, float), (-1, 3))
    if camera.kind == "orthographic":
        return np.full(len(place), 1.0 / camera.pixels_per_mm)
    depth = camera.view_space(place)[:, 2]
    return np.asarray(depth / (camera.distance * camera.pixels_per_mm))
