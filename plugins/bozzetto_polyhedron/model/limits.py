"""Bounds of what a recipe may hold: beyond them nothing can be seen, and squares overflow."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.plugin import UserError

FARTHEST: Final = 1e9
"""Largest number of a place, a velocity or a momentum, in whatever unit it is kept."""


def is_near(values: ArrayLike) -> bool:
    """Return whether all values are numbers within bounds."""
    return bool((np.abs(np.asarray(values, float)) <= FARTHEST).all())


def require_near(values: ArrayLike, what: str) -> None:
    """Raise UserError where a value is beyond bounds, or no number: a view can lead there."""
    if not is_near(values):
        raise UserError(
            f"{what} is farther away than anything can be drawn. Show all of the drawing, and draw "
            "there."
        )
