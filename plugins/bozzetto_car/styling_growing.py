"""A line on the body while it is being drawn: every move of the pen adds a few rays."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.ink.resample import arc_length
from bozzetto.view import Camera
from bozzetto_car.styling_laying import Seen, runs_of, seen_on_body
from bozzetto_car.styling_line import STEP

__all__ = ["Growing"]

Array = NDArray[np.float64]

MOST_AT_ONCE: Final = 24
"""Most rays of one move; after a leap of the pen they are farther apart."""


class Growing:
    """Remembers what is seen under the ink so far.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        Of the body, mm.
    camera : Camera
    """

    def __init__(self, nets: ArrayLike, camera: Camera) -> None:
        self._nets = np.asarray(nets, float)
        self._camera = camera
        self._pen = np.zeros((0, 2))
        self._seen: Seen | None = None
        self._taken = 0

    def lines(self, ink: Array) -> list[Array]:
        """The ink (n, 2) px, all of it so far, as polylines (m, 3) on the body, mm."""
        fresh = self._fresh(ink)
        if len(fresh):
            seen = seen_on_body(self._nets, fresh, self._camera)
            self._seen = seen if self._seen is None else self._seen.extended(seen)
        if self._seen is None:
            return []
        return [self._seen.points[run] for run in runs_of(self._seen) if len(run) > 1]

    def _fresh(self, ink: Array) -> Array:
        """Places at steps along the ink that has come since the last call."""
        if len(ink) <= self._taken:
            return np.zeros((0, 2))
        path = np.concatenate((self._pen, ink[self._taken :]))
        along = arc_length(path)
        if len(self._pen) and along[-1] < STEP:
            return np.zeros((0, 2))
        count = int(np.clip(along[-1] // STEP, 1, MOST_AT_ONCE))
        stations = np.linspace(0.0, along[-1], count + 1)[len(self._pen) :]
        self._taken, self._pen = len(ink), ink[-1:].copy()
        return np.column_stack([np.interp(stations, along, column) for column in path.T])
