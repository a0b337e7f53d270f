"""The three directions of the box, and places along lines in space seen through a camera."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.scene import Paint
from bozzetto.view import Camera
from bozzetto_symmetry.model.perspective import toward_vanishing

AXES: Final = np.eye(3)
"""Length, width and height of the box: x, y and z of the model."""

AXIS_PAINTS: Final[tuple[Paint, Paint, Paint]] = ("accent", "second", (0x5E, 0x94, 0x62))
"""Colours of x, y and z: the first two as on the ground, and a green that both themes bear."""

END_ON: Final = 0.02
"""Sine of the angle between a line and the line of sight below which the line is seen as a
point: places along it cannot be separated."""

ACROSS: Final = 1e-6
"""Cosine between a direction and the line of sight below which it lies across."""


def along(camera: Camera, pixel: ArrayLike, point: ArrayLike, direction: ArrayLike) -> float | None:
    """Return how far along a line in space a place on the sheet is.

    It is the place of the line seen at the point of the line's image nearest to the pen: what the
    pen does beside the line's image does not count.

    Parameters
    ----------
    camera : Camera
        In the frame of the line.
    pixel : (2,) array_like
        px.
    point, direction : (3,) array_like
        A place of the line that is in front of the eye, and the line's unit direction.

    Returns
    -------
    float or None
        mm from `point` in the sense of `direction`. None where the line is seen as a point,
        or where the place is beyond its vanishing point.
    """
    base, way = np.asarray(point, float), np.asarray(direction, float)
    seen, _ = camera.project(base)
    if not np.isfinite(seen).all():
        return None
    if np.linalg.norm(np.cross(camera.rays(seen).directions[0], way)) < END_ON:
        return None
    # The image of a line is straight: two of its places say where it runs.
    across = toward_vanishing(camera, way, seen[0])
    across /= np.linalg.norm(across)
    foot = seen[0] + across * float((np.asarray(pixel, float) - seen[0]) @ across)
    origins, directions = camera.rays(foot)
    # The ray of that point and the line lie in one plane, and meet.
    sight, between = directions[0], base - origins[0]
    cosine = float(sight @ way)
    sine_squared = 1.0 - cosine**2
    if sine_squared < END_ON**4:
        return None
    distance = float((between @ sight) * cosine - between @ way) / sine_squared
    depth = float(camera.axes[2] @ (base + distance * way - camera.eye))
    return None if camera.kind == "perspective" and depth <= 0.0 else distance


def receding(camera: Camera, direction: ArrayLike) -> Array | None:
    """Return the sense of a direction that runs away from the eye, a unit vector (3,).

    None where lines of this direction do not vanish in a point: in a parallel view, and
    where they lie across the line of sight.
    """
    way = np.asarray(direction, float)
    depth = float(camera.axes[2] @ way)
    if camera.kind == "orthographic" or abs(depth) <= ACROSS:
        return None
    return np.asarray(np.copysign(1.0, depth) * way)
