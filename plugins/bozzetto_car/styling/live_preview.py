"""A line on the body while it is drawn: every move of the pen adds a few rays."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.ink import steps_along
from bozzetto.scene import unbroken_runs
from bozzetto.view import Camera
from bozzetto_car.styling.project_on_body import Seen, seen_on_body
from bozzetto_car.styling.stroke_line import STEP

MOST_AT_ONCE: Final = 24
"""Most rays between two samples; after a leap of the pen they are farther apart."""

BLOCK: Final = 8
"""Places that are projected together and remembered. The number changes the last digits of the
result, so it must not depend on how often the line was asked for."""


class Growing:
    """The projection of ink that grows; it projects each place only once.

    Its answers depend only on the ink.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        Control nets of the body, mm.
    camera : Camera
    """

    def __init__(self, nets: ArrayLike, camera: Camera) -> None:
        self._nets = np.asarray(nets, float)
        self._camera = camera
        self._places = np.zeros((0, 2))
        self._seen: Seen | None = None

    def lines(self, ink: Array) -> list[Array]:
        """Return the ink (n, 2) px, all of it so far, as polylines (m, 3) on the body, mm."""
        places = steps_along(ink, STEP, MOST_AT_ONCE)
        whole = len(places) - len(places) % BLOCK
        known = len(self._places)
        if known > whole or not np.array_equal(self._places, places[:known]):
            self._places, self._seen, known = places[:0], None, 0
        for first in range(known, whole, BLOCK):
            self._seen = self._extended(places[first : first + BLOCK])
        self._places = places[:whole]
        if not len(ink):
            return []
        # The tip of the pen is between two steps.
        seen = self._extended(np.vstack((places[whole:], ink[-1:])))
        return [seen.points[run] for run in unbroken_runs(seen.hit, seen.breaks) if len(run) > 1]

    def _extended(self, places: Array) -> Seen:
        seen = seen_on_body(self._nets, places, self._camera)
        return seen if self._seen is None else self._seen.extended(seen)
