"""Curves that a file gives more than once: each is one curve of the network.

Programs that write the edges of every surface write each shared one twice, often in the other
direction. Both together would be joined wherever they touch, and no loop could be told.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.geometry import Spline
from bozzetto.ink import distances_to_polyline

__all__ = ["equal_curves"]

PLACES: Final = 65
"""Places at which curves are compared."""

FINE: Final = 1025
"""Points of the polyline that stands for a curve; it is within a millionth of its size."""


def equal_curves(splines: Sequence[Spline], tolerance: float) -> dict[int, int]:
    """Return which curves are an earlier one again, whatever their direction.

    Parameters
    ----------
    splines : sequence of Spline
        In the order of the file.
    tolerance : float
        Distance up to which they are the same, mm.

    Returns
    -------
    dict of int to int
        The number of the first of the same ones, by that of each further one.
    """
    boxes = np.array([[f(s.sampled(FINE), axis=0) for f in (np.min, np.max)] for s in splines])
    found: dict[int, int] = {}
    for number, spline in enumerate(splines):
        alike = np.abs(boxes[:number] - boxes[number]).max(axis=(1, 2)) <= 2.0 * tolerance
        for other in np.flatnonzero(alike).tolist():
            if other not in found and _are_same(splines[other], spline, tolerance):
                found[number] = other
                break
    return found


def _are_same(one: Spline, other: Spline, tolerance: float) -> bool:
    """Whether each of two curves lies on the other along all its length."""
    return all(
        distances_to_polyline(a.sampled(PLACES), b.sampled(FINE)).max() <= tolerance
        for a, b in ((one, other), (other, one))
    )
