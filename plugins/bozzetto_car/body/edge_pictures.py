"""Where points and edges of a car are seen, and what a view shows of them."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry.patches import bernstein
from bozzetto.view import Camera
from bozzetto_car.camera.rational_projection import camera_matrix, places_of

UNSEEN: Final = 0.17
"""Sine of the angle to the view rays, ten degrees, below which a direction is not seen: a pixel
of the hand would be more than six of depth."""


def project_points(camera: Camera, points: Array) -> Array:
    """Return where points (n, 3), mm, are seen, (n, 2) px; infinite for points behind the eye."""
    pixels = camera.project(points)[0]
    return np.where(np.isfinite(pixels), pixels, np.inf)


def edge_pictures(camera: Camera, control_points: Array, pieces: int) -> Array:
    """Return the pictures of edges (m, 4, 3) as polylines, (m, pieces + 1, 2) px."""
    matrix = camera_matrix(camera)
    seen = bernstein(np.linspace(0.0, 1.0, pieces + 1)) @ (
        control_points @ matrix[:, :3].T + matrix[:, 3]
    )
    return places_of(seen)
