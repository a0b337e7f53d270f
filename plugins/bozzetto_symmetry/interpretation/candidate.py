"""One way to read the ink of a view, with its price in pixels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.ink.curves.resample import arc_length
from bozzetto_symmetry.interpretation.side_pairing import Pairing
from bozzetto_symmetry.interpretation.triangulation import Solved

__all__ = ["TELL", "Read", "matched", "price"]

Array = NDArray[np.float64]
Kind = Literal["pair", "self", "plane", "half"]

MISSING: Final = 20.0
"""Price of a curve of which no place has a partner, px: a tenth without costs 2."""

OUTSIDE: Final = 10.0
"""Price of a curve that is all outside the box, px."""

ASTRIDE: Final = 20.0
"""Price of a side that lies as much on one side of the plane as on the other, px."""

TELL: Final = 0.03
"""Share of a side without a partner that a person is told of."""


@dataclass(frozen=True, eq=False)
class Read:
    """What the ink of one view may mean.

    Attributes
    ----------
    reading : {"pair", "self", "plane", "half"}
        "half" is one side that waits for the other.
    cost : float
        How far the ink contradicts this, px; comparable between readings.
    coverage : float
        Share of the ink that has a partner; of "plane" 1 and of "half" 0.
    points : (k, 3) float
        Places in space, mm, in the sense drawn. Of a pair they run along the first side. Of
        a curve across the plane they run along all of the stroke: k is odd, the middle one
        is on the plane, and ``points[-1 - j]`` is the mirror image of ``points[j]``. Of a
        ring they begin where it first leaves the plane: k is even, number ``k / 2`` is on
        the plane as well, and ``points[k - j]`` is the mirror image of ``points[j]``.
    covariances : (k, 3, 3) float
        For 1 px of noise, mm². Where the view says nothing the one along y is large.
    pairing : Pairing or None
        Of "pair" and "self".
    crossings : (c, 2) float
        Where the curve crosses the plane, px.
    near, far : tuple of (n, 2) float
        Ink that shows the half that was drawn first, and its mirror image; px. Of a curve
        across the plane both run from the plane outwards. What has no partner is left out.
    closed : bool
        The curve returns to its start: a ring, or a pair of loops.
    ring : bool
        Closed, and across the plane.
    warnings : tuple of str
    """

    reading: Kind
    cost: float
    coverage: float
    points: Array
    covariances: Array
    pairing: Pairing | None
    crossings: Array
    near: tuple[Array, ...]
    far: tuple[Array, ...]
    closed: bool = False
    ring: bool = False
    warnings: tuple[str, ...] = ()


def price(misfit: float, made: Solved, missing: float) -> float:
    """What a matching costs, px: how far off it is, and how much and how strange what is left.

    Parameters
    ----------
    misfit : float
        How far off the matching is, px.
    made : Solved
        What it gives.
    missing : float
        Share of the ink without a partner.
    """
    return misfit + MISSING * missing + OUTSIDE * made.outside + ASTRIDE * made.astride


def matched(pixels: Array, stations: Array) -> Array:
    """The part of a line that found partners."""
    begin, end = float(np.min(stations)), float(np.max(stations))
    along = arc_length(pixels)
    share = along / max(float(along[-1]), 1e-300)
    inner = (share > begin) & (share < end)
    ends = np.column_stack([np.interp((begin, end), share, column) for column in pixels.T])
    return np.vstack((ends[:1], pixels[inner], ends[1:]))
