"""A symmetric curve through places in space that are known."""

from __future__ import annotations

from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto_symmetry.space_curve import Reading, SpaceCurve
from bozzetto_symmetry.starting import approximated, half_of, stations_of
from bozzetto_symmetry.symmetric_basis import SymmetricBasis

__all__ = ["FEWEST", "MORE", "MOST", "Controls", "through"]

Array = NDArray[np.float64]

Controls = Literal["adaptive", "seven"]

FEWEST: Final = 7
"""Control points of a half to begin with (Bae, Kijima & Kim 2004 always take seven)."""

MORE: Final = 3
"""Control points added until the curve is good."""

MOST: Final = 25
"""Control points of a half at which adding ends."""


def through(
    points: ArrayLike,
    reading: Reading,
    *,
    closed: bool = False,
    ring: bool = False,
    pixel: float,
    controls: Controls = "adaptive",
) -> SpaceCurve:
    """Fit a symmetric spline to places in space."""
    place = np.reshape(np.asarray(points, float), (-1, 3))
    basis = SymmetricBasis(reading, MOST, closed and reading != "self", ring)
    spread = np.broadcast_to(1e-12 * np.eye(3), (len(place), 3, 3))
    place, spread = half_of(place, spread, basis)
    made = approximated(basis, place, spread, stations_of(place, spread, basis))
    return basis.curve(made)
