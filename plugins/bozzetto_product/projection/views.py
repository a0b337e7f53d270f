"""Points as a camera sees them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.view import Camera


def seen_at(camera: Camera, points: ArrayLike) -> Array:
    """Return where points are seen, (n, 2) px; NaN at the eye and behind it."""
    pixels, depth = camera.project(np.asarray(points, float).reshape(-1, 3))
    if camera.kind == "orthographic":
        return np.asarray(pixels)
    return np.where((depth > 0.0)[:, None], pixels, np.nan)


def pixel_size(camera: Camera, points: ArrayLike) -> Array:
    """Return the length of a pixel at points, (n,) mm; behind the eye that at the target."""
    at_target = 1.0 / camera.pixels_per_mm
    place = np.asarray(points, float).reshape(-1, 3)
    if camera.kind == "orthographic":
        return np.full(len(place), at_target)
    depth = (place - camera.eye) @ camera.axes[2]
    return np.asarray(at_target * np.where(depth > 0.0, depth / camera.distance, 1.0))
