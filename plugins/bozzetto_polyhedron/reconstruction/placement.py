"""From units of the drawing to mm in the world."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto.view import Camera
from bozzetto_polyhedron.reconstruction.drawing import Drawing


def placed(drawing: Drawing, shape: Array, camera: Camera) -> Array:
    """Return a shape in the world: what lies in the sheet is as deep as the camera's target.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    shape : (n, 3) array
        Right, up and away from the eye, diagonals; the sheet is at depth 0.
    camera : Camera
        Of the drawing.

    Returns
    -------
    (n, 3) array
        mm.
    """
    right, up, forward = camera.axes
    aside = (drawing.center - np.multiply(camera.viewport, 0.5)) * (1.0, -1.0)
    size = drawing.diagonal / camera.pixels_per_mm
    flat = shape[:, :2] * size + aside / camera.pixels_per_mm
    return np.asarray(
        camera.target + flat[:, :1] * right + flat[:, 1:] * up + size * shape[:, 2:] * forward
    )


def residual(vertices: Array, places: Array, camera: Camera) -> float:
    """Return the root mean square distance of projected vertices from corners, px."""
    if not len(vertices):
        return 0.0
    seen, _ = camera.project(vertices)
    drawn = np.nan_to_num(places, posinf=0.0, neginf=0.0)
    squares = ((np.nan_to_num(seen) - drawn) ** 2).sum(1)
    return float(np.sqrt(squares.mean()))
