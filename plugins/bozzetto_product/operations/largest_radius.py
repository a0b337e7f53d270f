"""The largest radius that a corner takes, for who asked for more."""

from __future__ import annotations

from collections.abc import Callable
from math import floor, log10
from typing import Final

from bozzetto.errors import UserError

DIGITS: Final = 2
"""Digits of a radius that are told."""


def radius_refused(
    reason: str, radius: float, fits: Callable[[float], bool], halvings: int
) -> UserError:
    """Return why a radius is refused, with the largest one found that is not, rounded down.

    Parameters
    ----------
    reason : str
        A sentence without its last stop.
    radius : float
        That does not fit, mm.
    fits : callable
        Whether a radius, mm, does; from some radius on none.
    halvings : int
        Steps of the search: each costs one call.
    """
    low, high = radius * 0.5**halvings, radius
    if not fits(low):
        return UserError(f"{reason}, and it is the same with {low:.1g} mm. Leave it as it is.")
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        if fits(middle):
            low = middle
        else:
            high = middle
    step = 10.0 ** (floor(log10(low)) + 1 - DIGITS)
    return UserError(f"{reason}. Choose at most {step * floor(low / step):.{DIGITS}g} mm.")
