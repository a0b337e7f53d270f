"""Loops that are round: wheels, which stand along the centre plane, and no rings across it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import resample
from bozzetto_symmetry.interpretation.candidate import Read

ROUND: Final = 0.08
"""Distance from a circle (rms, in its radius) up to which a hand meant one. Of 200 rings across
the plane one is seen so near to a circle in the centre plane; wheels that are up to 6 %
longer than wide, drawn at 1 px, are within 0.046 (seeds from 71000 and 72000)."""

ROUNDER: Final = 2.0
"""How many times rounder along the plane than across it a loop is that was meant there."""

PLACES: Final = 100
"""Places by which roundness is measured."""


def off_circle(points: Array) -> float:
    """Return how far a loop (n, 3) strays from a circle in its own plane, rms over the radius.

    The circle is that of least squares of the squared distances (Kåsa, 1976).
    """
    even = resample(points, count=PLACES, closed=True)
    middle = even.mean(axis=0)
    ways = np.linalg.svd(even - middle, full_matrices=False)[2]
    flat = (even - middle) @ ways[:2].T
    columns = np.column_stack((2.0 * flat, np.ones(len(flat))))
    x, y, rest = np.linalg.lstsq(columns, (flat**2).sum(axis=1), rcond=None)[0]
    radius = float(np.sqrt(max(rest + x * x + y * y, 0.0)))
    off = np.linalg.norm(flat - (x, y), axis=1) - radius
    return float(np.sqrt(np.mean(off**2))) / max(radius, 1e-300)


def is_wheel(along: Read, crossings: Sequence[Read]) -> bool:
    """Return whether a loop is meant along the centre plane: in it, or on either side.

    A circle that is parallel to the plane is seen as one in it is, only larger or smaller. A ring
    across the plane looks so by chance in one of a hundred drawings.

    Parameters
    ----------
    along : Read
        The loop in the plane.
    crossings : sequence of Read
        What it is across the plane.
    """
    rings = [read for read in crossings if read.ring]
    if not along.closed or not rings:
        return False
    off = off_circle(along.points)
    return off < ROUND and all(ROUNDER * off < off_circle(ring.points) for ring in rings)
