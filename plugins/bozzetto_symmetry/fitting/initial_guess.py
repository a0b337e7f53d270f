"""A first symmetric curve through places in space of different certainty."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_symmetry.fitting.symmetric_basis import SymmetricBasis
from bozzetto_symmetry.ink.polyline import interpolate

ROUGHNESS: Final = 50.0
"""Third derivative (rms), by a parameter from 0 to 1, that a curve of unit length may well
have: that of a wave and a quarter with an amplitude of a sixth of the length."""

KNOWN: Final = 0.002
"""Standard deviation, as a share of the length, below which a place counts as no better."""

GUESSED: Final = 0.01
"""Standard deviation, as a share of the length, that a place has at most: where nothing is
known it was put on a bridge, which is a better guess than none."""

DOUBTFUL: Final = 0.01
"""Standard deviation, as a share of the length, from which steps in a direction say little about
the length of the way."""

BOTH: Final = 0.5
"""Share of the greatest height above the plane that a curve across it reaches on the other
side where both halves are given."""

RIDGE: Final = 1e-12
"""Pull of the control points to the chain through the places, as a share of theirs."""

STATIONS: Final = 10
"""Control points of the curve by which places are given their stations."""


def chord_length(points: Array) -> float:
    """Return the length of the chain through points (n, 3), mm."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def half_of(points: Array, covariances: Array, basis: SymmetricBasis) -> tuple[Array, Array]:
    """Return the half of a curve, in the order of its parameter, from what may be all of it.

    A curve across the plane given whole, from one free end to the other, begins with the
    half that was drawn first; a ring given whole goes round once from where it leaves the
    plane. What is given from the plane outwards is a half already. Points that are not
    finite are left out.

    Raises
    ------
    UserError
        If fewer than two points are left that differ.
    """
    known = np.isfinite(points).all(axis=1) & np.isfinite(covariances).all(axis=(1, 2))
    place, spread = points[known], covariances[known]
    if len(place) < 2 or not np.ptp(place, axis=0).max() > 0:
        raise UserError("The curve comes out as a dot. Draw it larger, or turn the box.")
    if basis.reading == "self":
        heights = place[:, 1]
        most = BOTH * np.abs(heights).max()
        if heights.max() > most and heights.min() < -most:
            changes = np.flatnonzero(np.diff(heights > 0))
            middle = int(changes[np.argmin(np.abs(changes + 1 - 0.5 * len(place)))]) + 1
            middle += int(middle < len(place) and heights[middle] == 0.0)
            way = 1 if basis.ring else -1
            place, spread = place[:middle][::way], spread[:middle][::way]
        for end in (0, -1) if basis.ring else (0,):
            foot = place[end] * (1.0, 0.0, 1.0)
            if (foot != place[end]).any():
                at = 0 if end == 0 else len(place)
                place = np.insert(place, at, foot, axis=0)
                spread = np.insert(spread, at, spread[end], axis=0)
    return place, spread


def stations_of(points: Array, covariances: Array, basis: SymmetricBasis) -> Array:
    """Return shares of the half's parameters, (n,), by the length of the way.

    Where places are known badly in one direction they jump about in it, and their chords are
    far too long: a step counts by what is known of it. Then the way is measured on a smooth
    curve through them.
    """
    lengths = trusted_steps(points, covariances, closed=basis.closed)
    stations = _shares(lengths, len(points))
    smooth = SymmetricBasis(basis.reading, STATIONS, basis.closed, basis.ring)
    made = approximate(smooth, points, covariances, stations)
    low, high = smooth.half
    fine = np.linspace(0.0, 1.0, 20 * STATIONS + 1)
    way = smooth.at(smooth.values(low + (high - low) * fine * (1 - 1e-12)), made)
    passed = np.linalg.norm(np.diff(way, axis=0), axis=1)
    return np.asarray(np.interp(stations, fine, _shares(passed, len(fine))))


def trusted_steps(points: Array, covariances: Array, *, closed: bool) -> Array:
    """Return the lengths of the steps from place to place, less their uncertainty, mm.

    Parameters
    ----------
    points : (n, 3) float
        Places in their order, mm.
    covariances : (n, 3, 3) float
        Covariances of the places, mm².
    closed : bool
        A last step leads back to the first place.

    Returns
    -------
    (n,) or (n - 1,) float
    """
    steps = np.diff(points, axis=0, append=points[:1] if closed else points[:0])
    spread = 0.5 * (covariances + np.roll(covariances, -1, axis=0))[: len(steps)]
    doubt = (DOUBTFUL * chord_length(points)) ** 2
    trusted = np.linalg.solve(np.eye(3) + spread / doubt, steps[:, :, None])[:, :, 0]
    return np.asarray(np.sqrt(np.maximum((steps * trusted).sum(axis=1), 0.0)))


def _shares(lengths: Array, count: int) -> Array:
    """Return the share of the whole way at each of `count` places."""
    total = float(lengths.sum())
    if not total > 0:
        return np.linspace(0.0, 1.0, count)
    return np.concatenate(([0.0], np.cumsum(lengths)))[:count] / total


def approximate(basis: SymmetricBasis, points: Array, covariances: Array, stations: Array) -> Array:
    """Return control points of a half through places, by least squares with their covariances.

    Parameters
    ----------
    basis : SymmetricBasis
        The curves among which the best one is sought.
    points : (n, 3) float
        Places along the half, mm.
    covariances : (n, 3, 3) float
        mm²; only their ratios count.
    stations : (n,) float
        Shares of the half, 0 … 1.

    Returns
    -------
    (count, 3) float
    """
    length = chord_length(points)
    floor = (KNOWN * length) ** 2 * np.eye(3)
    least = np.eye(3) / (GUESSED * length) ** 2
    weight = np.asarray(np.linalg.cholesky(np.linalg.inv(covariances + floor) + least))
    low, high = basis.half
    values = basis.values(low + (high - low) * stations)
    matrix = np.vstack([basis.rows(values, weight[:, :, axis]) for axis in range(3)])
    target = np.concatenate([(points * weight[:, :, axis]).sum(axis=1) for axis in range(3)])
    polygon = polygon_of(basis, points, stations)
    free = polygon.ravel()[basis.free]
    smooth = basis.bending() / (ROUGHNESS * length)
    normal = matrix.T @ matrix + smooth.T @ smooth
    normal += RIDGE * np.trace(normal) / len(normal) * np.eye(len(normal))
    right = matrix.T @ (target - matrix @ free) - smooth.T @ (smooth @ free)
    return basis.moved(polygon, np.asarray(np.linalg.solve(normal, right)))


def polygon_of(basis: SymmetricBasis, points: Array, stations: Array) -> Array:
    """Return control points (count, 3) at even shares of the half on the chain through the points.

    The ends are the first and the last point exactly; coordinates that are not free are 0.
    """
    even = np.linspace(0.0, 1.0, basis.count, endpoint=not basis.closed)
    made = interpolate(even, stations, points)
    if not basis.closed:
        made[[0, -1]] = points[[0, -1]]
    return np.where(basis.free.reshape(-1, 3), made, 0.0)
