"""Where copies lie: beside what they are copies of, and in nobody's way."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.document.edit import IN_PLACE
from bozzetto.scene.display_list import Lines, Points, Scene, Shaded

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.document.edit import Vector
    from bozzetto.scene.display_list import Layer
    from bozzetto.view.camera import Camera

__all__ = ["extent_of", "step_aside", "step_beside"]

ASIDE: Final = 24.0
"""About how far a copy of something without extent lies from it, to the right and down, pixels."""

GAP: Final = 0.2
"""Room between a copy and what it lies beside, as share of its width."""

ACROSS: Final = 0.5
"""Least share of an axis that the sheet shows from left to right for a copy to lie along it."""


def extent_of(layers: Iterable[Layer]) -> Array:
    """Return the box of layers with surfaces, else of all lines, (2, 3) mm; NaN for none.

    What a tool shows, or what is shown of a selected model only, does not count.
    """
    seen = [layer for layer in layers if not layer.tool and not layer.chosen]
    solid = [layer for layer in seen if any(isinstance(item, Shaded) for item in layer.items)]
    if solid:
        return Scene(tuple(solid)).bounds()
    return Scene(tuple(seen)).of_kinds(Lines, Points).bounds()


def step_beside(camera: Camera, copied: Sequence[Array], others: Sequence[Array]) -> Vector | None:
    """Return the way to the nearest free place beside objects, mm; None if they have no extent.

    It goes to the right on the sheet along an axis of the world, of those that run across it along
    the one along which the objects are narrower: cars stand side by side. The way is a round
    number, which is what *Place* shows.

    Parameters
    ----------
    camera : Camera
        The view.
    copied, others : sequence of (2, 3) float
        Boxes of what is copied, and of everything else in sight, mm. Those that are not finite do
        not count.
    """
    boxes = [box for box in copied if np.isfinite(box).all()]
    if not boxes:
        return None
    low = np.min([box[0] for box in boxes], axis=0)
    high = np.max([box[1] for box in boxes], axis=0)
    right = np.asarray(camera.axes[0], float)
    width = high - low
    axis = int(np.argmin(np.where(np.abs(right) >= ACROSS, width, np.inf)))
    gap = GAP * max(width[axis], float(width.max()) / 10.0)
    if not gap > 0.0:
        return None  # a point
    sign = math.copysign(1.0, right[axis])
    rest = [k for k in range(3) if k != axis]
    in_the_way = []
    for box in others:
        if np.isfinite(box).all() and (box[0] < high)[rest].all() and (box[1] > low)[rest].all():
            ends = (box[:, axis] - low[axis], box[:, axis] - high[axis])
            near, far = np.sort(sign * np.ravel(ends))[[0, -1]].tolist()
            in_the_way.append((near, far))
    length = _rounded_up(float(width[axis]) + gap)
    for near, far in sorted(in_the_way):
        if near < length < far:
            length = _rounded_up(far + gap)
    way = [0.0, 0.0, 0.0]
    way[axis] = sign * length
    return way[0], way[1], way[2]


def step_aside(camera: Camera) -> Vector:
    """Return a short way to the right and down, mm, for what has no extent that is known.

    It goes along two axes of the world by a round number.
    """
    right, up, _ = camera.axes
    length = ASIDE / camera.pixels_per_mm
    if not 0.0 < length < math.inf:  # a view at the ends of what numbers hold
        return IN_PLACE
    ten = 10.0 ** math.floor(math.log10(length))
    length = ten * min((1.0, 2.0, 5.0, 10.0), key=lambda each: abs(each - length / ten))
    across = int(np.argmax(np.abs(right)))
    down = int(np.argmax(np.where(np.arange(3) == across, 0.0, np.abs(up))))
    way = [0.0, 0.0, 0.0]
    way[across] = math.copysign(length, right[across])
    way[down] = -math.copysign(length, up[down])
    return way[0], way[1], way[2]


def _rounded_up(length: float) -> float:
    """Return the next number of two digits that is not smaller."""
    ten = 10.0 ** (math.floor(math.log10(length)) - 1)
    return ten * math.ceil(length / ten)
