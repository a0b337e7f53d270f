"""Anderson's acceleration of a fixed-point iteration (Anderson 1965; Walker & Ni 2011)."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array

MEMORY: Final = 4
"""Differences that are kept: more of them gained nothing on chains of hinged plates."""

RIDGE: Final = 1e-14
"""Added to the squares of the differences, relative to their sum: they may say the same twice."""


class Acceleration:
    """Guesses where an iteration value → value + change ends, from its last rounds."""

    def __init__(self) -> None:
        self._steps: list[Array] = []
        self._turns: list[Array] = []
        self._last: tuple[Array, Array] | None = None

    def after(self, value: Array, change: Array) -> Array:
        """Return the next value: the mixture of the last ones that would change least."""
        if self._last is not None:
            self._steps = [*self._steps[1 - MEMORY :], value - self._last[0]]
            self._turns = [*self._turns[1 - MEMORY :], change - self._last[1]]
        self._last = value, change
        if not self._steps:
            return np.asarray(value + change)
        turns = np.array(self._turns)
        squares = turns @ turns.T
        squares.flat[:: len(turns) + 1] += RIDGE * np.trace(squares) + 1e-300
        mixture = np.linalg.solve(squares, turns @ change)
        return np.asarray(value + change - mixture @ (np.array(self._steps) + turns))
