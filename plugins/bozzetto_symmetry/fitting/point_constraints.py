"""A symmetric curve through places in space that are known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto_symmetry.fitting.initial_guess import (
    ROUGHNESS,
    half_of,
    length_of,
    polygon_of,
    stations_of,
)
from bozzetto_symmetry.fitting.space_curve import Reading, SpaceCurve
from bozzetto_symmetry.fitting.symmetric_basis import SymmetricBasis

__all__ = ["FEWEST", "MORE", "MOST", "Controls", "through"]

Array = NDArray[np.float64]

Controls = Literal["adaptive", "seven"]

FEWEST: Final = 7
"""Control points of a half to begin with (Bae, Kijima & Kim 2004 always take seven)."""

MORE: Final = 3
"""Control points added until the curve is good."""

MOST: Final = 25
"""Control points of a half at which adding ends."""

ENOUGH: Final = 0.1
"""Distance of the places from the curve (rms, px) at which more control points are of no use."""

ROUNDS: Final = 10
"""Most rounds of reparametrisation."""

SLIDE: Final = (0.1, 0.25)
"""First weight of a deviation along the curve against one across it, and what it is
multiplied by after a round that made it better."""

GAIN: Final = 0.03
"""Share of the distance that a round must take away for another one to follow."""


def through(
    points: ArrayLike,
    reading: Reading,
    *,
    closed: bool = False,
    ring: bool = False,
    pixel: float,
    controls: Controls = "adaptive",
) -> SpaceCurve:
    """Fit a symmetric spline to places in space, its free ends exactly in the first and last.

    Least squares of the distances across the curve, with feet found anew (Wang, Pottmann &
    Liu 2006, section 3.3).

    Parameters
    ----------
    points : (k, 3) array_like
        mm, in order; of a curve across the plane all of it, beginning with the half that was
        drawn first, or that half from the plane outwards. Those that are not finite are left
        out.
    reading : {"pair", "self", "plane"}
    closed : bool
        The side is closed; the first point may be repeated or not.
    ring : bool
        The curve across the plane is closed.
    pixel : float
        Length of a pixel, mm.
    controls : {"adaptive", "seven"}
        Control points of a half. "adaptive" takes 7, then 3 more until the places are within
        a tenth of a pixel (rms), at most 25.

    Returns
    -------
    SpaceCurve

    Raises
    ------
    UserError
        If fewer than two points differ.
    """
    place = np.reshape(np.asarray(points, float), (-1, 3))
    round_trip = closed and reading != "self"
    if round_trip and len(place) > 1 and (place[0] == place[-1]).all():
        place = place[:-1]
    nothing = np.zeros((len(place), 3, 3))
    first = SymmetricBasis(reading, FEWEST, round_trip, ring)
    place, nothing = half_of(place, nothing, first)
    stations = stations_of(place, nothing, first)
    best: _Approach | None = None
    for count in range(FEWEST, (MOST if controls == "adaptive" else FEWEST) + 1, MORE):
        made = _approach(SymmetricBasis(reading, count, round_trip, ring), place, stations, pixel)
        if best is None or made.rms < best.rms:
            best = made
        if best.rms < ENOUGH * pixel:
            break
    assert best is not None
    return best.curve


@dataclass(frozen=True, eq=False)
class _Approach:
    """A curve, the parameters of the places on it, and their distance (rms, mm)."""

    curve: SpaceCurve
    feet: Array
    rms: float

    @classmethod
    def of(cls, curve: SpaceCurve, places: Array, feet: Array, *, steps: int) -> _Approach:
        feet = curve.spline.foot_points(places, feet, steps=steps)
        apart = curve.spline.value(feet) - places
        return cls(curve, feet, float(np.sqrt((apart**2).sum(axis=1).mean())))


def _approach(basis: SymmetricBasis, places: Array, stations: Array, pixel: float) -> _Approach:
    """The best curve with one number of control points."""
    low, high = basis.half
    polygon = polygon_of(basis, places, stations)
    feet = low + (high - low) * stations
    across = np.tile(np.eye(3), (len(places), 1, 1))
    first = _solved(basis, polygon, places, feet, across, pixel)
    best = _Approach.of(first, places, feet, steps=2)
    slide, smaller = SLIDE
    for _ in range(ROUNDS):
        tangent = best.curve.spline.derivative(best.feet)
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-300)
        across = np.eye(3) - (1.0 - slide) * tangent[:, :, None] * tangent[:, None]
        curve = _solved(basis, polygon, places, best.feet, across, pixel)
        made = _Approach.of(curve, places, best.feet, steps=1)
        gain = best.rms - made.rms
        if gain <= 0.0:
            break
        best, slide = made, slide * smaller
        if gain < GAIN * made.rms:
            break
    return best


def _solved(
    basis: SymmetricBasis, polygon: Array, places: Array, feet: Array, across: Array, pixel: float
) -> SpaceCurve:
    """The best curve for given parameters; the ends of the polygon stay where they are."""
    values = basis.values(feet)
    moving = np.ones((basis.count, 3), bool)
    if not basis.periodic:
        moving[[-1] if basis.reading == "self" else [0, -1]] = False
    columns = moving.ravel()[basis.free]
    target = places - basis.at(values, polygon)
    scale = 1.0 / (ENOUGH * pixel)
    matrix = np.vstack([basis.rows(values, across[:, axis]) for axis in range(3)]) * scale
    right = np.einsum("nab,nb->an", across, target).ravel() * scale
    smooth = basis.bending() / (ROUGHNESS * length_of(places))
    rest = smooth @ polygon.ravel()[basis.free]
    matrix, smooth = matrix[:, columns], smooth[:, columns]
    normal = matrix.T @ matrix + smooth.T @ smooth
    normal += 1e-12 * np.trace(normal) / len(normal) * np.eye(len(normal))
    step = np.zeros(len(columns))
    step[columns] = np.linalg.solve(normal, matrix.T @ right - smooth.T @ rest)
    return basis.curve(basis.moved(polygon, step))
