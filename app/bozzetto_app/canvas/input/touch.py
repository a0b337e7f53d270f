"""Fingers turn, move and zoom the view, and never ink."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF

from bozzetto.view.camera import Camera
from bozzetto.view.navigation import orbit, pan, zoom

__all__ = ["Fingers"]

LEAST_SPREAD = 1.0
"""Distance from their middle below which two fingers say nothing about scale, pixels."""


class Fingers:
    """Where the fingers were at the last event.

    Parameters
    ----------
    places : sequence of QPointF
        At least one.
    pivot : (3,) float
        The place in the world under their middle, mm.
    """

    def __init__(self, places: Sequence[QPointF], pivot: NDArray[np.float64]) -> None:
        self.count = len(places)
        self._pivot = pivot
        self._middle, self._spread = middle_and_spread(places)

    def moved(
        self, places: Sequence[QPointF], camera: Camera, *, eye_fixed: bool = False
    ) -> Camera:
        """The view after as many fingers moved on: one orbits, more pan and zoom."""
        before, spread_before = self._middle, self._spread
        self._middle, self._spread = middle_and_spread(places)
        dx, dy = self._middle[0] - before[0], self._middle[1] - before[1]
        if self.count == 1:
            return orbit(camera, dx, dy, self._pivot)
        camera = pan(camera, dx, dy, self._pivot, eye_fixed=eye_fixed)
        if min(self._spread, spread_before) > LEAST_SPREAD:
            factor = self._spread / spread_before
            camera = zoom(camera, factor, self._middle, eye_fixed=eye_fixed)
        return camera


def middle_and_spread(places: Sequence[QPointF]) -> tuple[tuple[float, float], float]:
    """Mean of some places, and the largest distance from it, pixels."""
    x = sum(place.x() for place in places) / len(places)
    y = sum(place.y() for place in places) / len(places)
    return (x, y), max(math.hypot(place.x() - x, place.y() - y) for place in places)
