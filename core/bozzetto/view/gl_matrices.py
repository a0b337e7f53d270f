"""Matrices for a graphics card, and the range of depth that is worth resolving."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.view.camera import Camera

DEPTH_RATIO = 1e-4
"""Nearest over farthest depth of a perspective view; below it 24 bits resolve too little."""

SLACK = 0.01
"""Part of the range of depth added on both sides, so that nothing touches a plane."""


def near_far(camera: Camera, bounds: ArrayLike) -> tuple[float, float]:
    """Return depths between which everything in a box lies.

    Parameters
    ----------
    camera : Camera
        The view.
    bounds : (2, 3) array_like
        Corners of the box, mm; not finite means that nothing is known.

    Returns
    -------
    near, far : float
        mm along the line of sight, near < far. Both positive in perspective, where parts
        nearer than `DEPTH_RATIO` of the farthest depth are given up.
    """
    box = np.asarray(bounds, float).reshape(2, 3)
    if not np.isfinite(box).all():
        reach = max(camera.distance, camera.visible_height)
        box = np.asarray(camera.target) + reach * np.array([[-0.5] * 3, [0.5] * 3])
    corners = np.array([(x, y, z) for x in box[:, 0] for y in box[:, 1] for z in box[:, 2]])
    depth = camera.view_space(corners)[:, 2]
    low, high = float(depth.min()), float(depth.max())
    slack = SLACK * max(high - low, 1e-3 * camera.distance)
    low, high = low - slack, high + slack
    if camera.kind == "orthographic":
        return low, high
    if high <= 0:  # all of it lies behind the eye
        high = camera.distance
    return max(low, DEPTH_RATIO * high), high


def gl_matrices(camera: Camera, near: float, far: float) -> tuple[Array, Array]:
    """Return matrices for column vectors in OpenGL's conventions.

    Parameters
    ----------
    camera : Camera
        The view.
    near, far : float
        Depths that map to −1 and +1, mm.

    Returns
    -------
    view : (4, 4) float
        World to eye coordinates (right, up, backwards).
    projection : (4, 4) float
        Eye to clip coordinates.
    """
    right, up, forward = camera.axes
    view = np.eye(4)
    view[:3, :3] = right, up, -forward
    view[:3, 3] = -view[:3, :3] @ np.asarray(camera.eye)
    width, height = camera.viewport
    projection = np.zeros((4, 4))
    span = far - near
    if camera.kind == "orthographic":
        projection[0, 0] = 2.0 * height / (width * camera.height)
        projection[1, 1] = 2.0 / camera.height
        projection[2, 2:] = -2.0 / span, -(far + near) / span
        projection[3, 3] = 1.0
    else:
        focal = 1.0 / np.tan(np.radians(camera.fov_y) / 2.0)
        projection[0, 0] = focal * height / width
        projection[1, 1] = focal
        projection[2, 2:] = -(far + near) / span, -2.0 * far * near / span
        projection[3, 2] = -1.0
    return view, projection
