"""The next step of an iteration, mixed from its last ones, where steps get shorter too slowly."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array

MIXED: Final = 5
"""Number of steps that are mixed."""

SINGULAR: Final = 1e-8
"""Share of the largest change of steps below which one tells nothing."""


class MixedSteps:
    """The last steps of an iteration, of which the next one is made (Anderson 1965).

    Where strokes leave the lengths of tangents open, Gauss–Newton steps get shorter by constant
    ratios, one for each open direction. Walker and Ni (2011), algorithm AA.

    Parameters
    ----------
    scales : (q,) float
        Units of the unknowns.
    """

    def __init__(self, scales: Array) -> None:
        self._scales = scales
        self._places: list[Array] = []
        self._steps: list[Array] = []

    def step(self, place: Array, step: Array) -> Array | None:
        """Return the step to take from a place with a Gauss–Newton step; None for that itself."""
        if self._steps and np.linalg.norm(step) > np.linalg.norm(self._steps[-1]):
            self._places, self._steps = [], []  # mixing has led astray
        self._places, self._steps = [*self._places, place][-MIXED:], [*self._steps, step][-MIXED:]
        if len(self._steps) < 2:
            return None
        turns = np.diff(np.stack(self._steps), axis=0)
        ways = np.diff(np.stack(self._places), axis=0)
        shares = np.linalg.lstsq((turns / self._scales).T, step / self._scales, SINGULAR)[0]
        return np.asarray(step - shares @ (ways + turns))
