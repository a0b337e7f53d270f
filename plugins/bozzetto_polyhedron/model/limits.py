"""Bounds of what a recipe may hold: beyond them nothing can be seen, and squares overflow."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

FARTHEST: Final = 1e9
"""Largest number of a place, a velocity or a momentum, in whatever unit it is kept."""


def is_near(values: ArrayLike) -> bool:
    """Return whether all values are numbers within bounds."""
    return bool((np.abs(np.asarray(values, float)) <= FARTHEST).all())


def require_near(values: ArrayLike, what: str) -> None:
    """Raise ValueError where a value is beyond bounds, or no number."""
    if not is_near(values):
        raise ValueError(f"{what} is farther away than anything can be drawn")
