"""Weights of strokes: older ones fade, greyer ones weigh less."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke

FADE: Final = 0.7
"""Factor of a stroke's weight for each later stroke: after three of them a third is left."""

LEAST_SHARE: Final = 0.5
"""Weight of the faintest stroke; the mean pressure (0 … 1) is added."""


def stroke_weights(strokes: Sequence[Stroke]) -> NDArray[np.float64]:
    """Return the weights of strokes in the order in which they were drawn.

    Stroke k of n weighs ``0.7 ** (n - k) * (0.5 + mean pressure)``. The ink can be shown
    with the same weights, so that what is drawn grey counts less indeed.

    Parameters
    ----------
    strokes : sequence of Stroke
        Strokes in the order in which they were drawn.

    Returns
    -------
    (n,) float
    """
    age = np.arange(len(strokes) - 1, -1, -1)
    # Ink of a damaged file can have any pressure.
    pressure = np.clip([float(np.mean(stroke.pressure)) for stroke in strokes], 0.0, 1.0)
    return np.asarray(FADE**age * (LEAST_SHARE + pressure))
