"""The ground: a faint grid at z = 0 whose squares suit the scale of the view."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from bozzetto.scene.display_list import EMPTY, Layer, Lines, Scene
from bozzetto.view.camera import Camera

__all__ = ["ground", "square_size"]

SQUARES: Final = 8
"""Squares from the middle to each side of the grid."""

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
    middle = [side * round(camera.target[axis] / side) for axis in (0, 1)]
    reach = SQUARES * side
    steps = np.arange(-SQUARES, SQUARES + 1) * side
    if abs(camera.axes[2][2]) < EDGE_ON:
        right = camera.axes[0]
        line = np.outer((-1.0, 1.0), reach * right) + (*middle, 0.0)
        return _layer(line[None])
    across = [((middle[0] - reach, middle[1] + s, 0.0), (middle[0] + reach, middle[1] + s, 0.0))
              for s in steps]  # fmt: skip
    along = [((middle[0] + s, middle[1] - reach, 0.0), (middle[0] + s, middle[1] + reach, 0.0))
             for s in steps]  # fmt: skip
    return _layer(np.array(across + along))


def _layer(segments: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Scene:
    points = segments.reshape(-1, 3).astype(np.float32)
    lines = Lines(
        points,
        np.arange(0, len(points), 2, dtype=np.int32),
        color="grid",
        width=1.0,
        hidden="hide",
    )
    return Scene((Layer("ground", (lines,)),))
