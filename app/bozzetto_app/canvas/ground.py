"""The ground: a faint grid at z = 0 whose squares suit the scale of the view."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.scene.display_list import EMPTY, Layer, Lines, Scene
from bozzetto.view.camera import Camera

__all__ = ["GROUND_LAYER", "ground", "square_size"]

Floats = NDArray[np.float64]

GROUND_LAYER: Final = "ground"
"""Name of the layer."""

SQUARES: Final = 10
"""Squares from the middle to the rim of the grid."""

BANDS: Final = 6
"""Rings of falling strength, so that the grid ends in nothing."""

EDGE_ON: Final = 0.02
"""Sine of the angle between sight and ground below which one line stands for the grid."""


def square_size(visible: float) -> float:
    """The length of a square's side, mm: 1, 2 or 5 times a power of ten, about a tenth."""
    wish = visible / 10.0
    decade = 10.0 ** math.floor(math.log10(wish))
    return next(decade * step for step in (1.0, 2.0, 5.0, 10.0) if decade * step >= wish)


def ground(camera: Camera) -> Scene:
    """The grid below what the camera looks at; nothing where the ground is far off."""
    side = square_size(camera.visible_height)
    if abs(camera.target[2]) > 4.0 * camera.visible_height:
        return EMPTY
    middle = np.array([side * round(camera.target[axis] / side) for axis in (0, 1)] + [0.0])
    ticks = np.arange(-SQUARES, SQUARES, dtype=float)
    if abs(camera.axes[2][2]) < EDGE_ON:
        begin = ticks[:, None] * camera.axes[0]
        segments = np.stack((begin, begin + camera.axes[0]), 1)
    else:
        u, v = (grid.ravel() for grid in np.meshgrid(ticks, np.arange(-SQUARES, SQUARES + 1.0)))
        level = np.zeros_like(u)
        along_x = np.stack((np.stack((u, v, level), 1), np.stack((u + 1, v, level), 1)), 1)
        segments = np.concatenate((along_x, along_x[:, :, [1, 0, 2]]))
    return Scene((Layer(GROUND_LAYER, tuple(_bands(segments, side, middle))),))


def _bands(segments: Floats, side: float, middle: Floats) -> Iterator[Lines]:
    """Segments (n, 2, 3), in squares from the middle, as lines that fade towards the rim."""
    distance = np.linalg.norm(segments.mean(1), axis=1) / SQUARES
    band = np.floor(distance * BANDS).astype(int)
    for number in range(BANDS):
        chosen = segments[band == number]
        if len(chosen):
            points = (side * chosen + middle).reshape(-1, 3).astype(np.float32)
            starts = np.arange(0, len(points), 2, dtype=np.int32)
            strength = 1.0 - (number / BANDS) ** 2
            yield Lines(points, starts, "grid", 1.0, opacity=strength, hidden="hide")
