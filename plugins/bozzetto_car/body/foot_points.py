"""Foot points of strokes' samples on the pictures of edges (Hoschek 1988)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.ink import FARTHEST
from bozzetto.plugin import cached_property
from bozzetto_car.camera.rational_projection import AT_EYE, POWERS, TINY

FOOT_PLACES: Final = 24
"""Pieces of an edge among which the search for foot points begins."""

FOOT_STEPS: Final = 12
"""Most Gauss–Newton steps to a foot point."""

FOOT_SETTLED: Final = 1e-8
"""Longest step of the parameter at which they end."""

LONGEST_SHIFT: Final = 1.0 / FOOT_PLACES
"""Longest step of the parameter."""

FARTHEST_BEYOND: Final = 8.0
"""Most steps of the parameter by which a sample counts as beyond the end of an edge."""

SLOPES: Final = np.array([1.0, 2.0, 3.0])
"""Factors of the coefficients of a cubic's derivative."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """A part of a stroke that tells how an edge looks.

    Attributes
    ----------
    edge : int
        Of the right half or the middle.
    points : (k, 2) float
        Samples, px.
    weights : (k,) float
        Weights of their squared distances.
    matrices : (4, 3, 4) float
        Camera's matrix for each Bézier point: (u w, v w, w) = M (x, y, z, 1).
    """

    edge: int
    points: Array
    weights: Array
    matrices: Array


@dataclass(frozen=True, eq=False)
class Feet:
    """The pictures of edges at the foot points of all samples.

    Attributes
    ----------
    t, w : (s, k) float
        Parameters and homogeneous coordinates.
    places, normals : (s, 2, k) float
        Places on the sheet, and unit vectors across the pictures.
    ways : (s, k) float
        Distances across the pictures, px.
    beyond : (s, k) float
        How far samples are beyond an end of the edge, in steps of the parameter; 0 elsewhere.
    deeper : (s, k) float
        Derivative of the logarithm of the homogeneous coordinate by the parameter.
    """

    t: Array
    w: Array
    places: Array
    normals: Array
    ways: Array
    beyond: Array
    deeper: Array


@dataclass(frozen=True, eq=False)
class Samples:
    """The samples of parts of strokes, one row a part, filled up with ones of no weight.

    Attributes
    ----------
    of : (s,) int
        The number of the edge that each part traces.
    points : (s, k, 2) float
        px.
    weights : (s, k) float
    matrices : (s, 4, 3, 4) float
        As in `Sighting`.
    """

    of: Index
    points: Array
    weights: Array
    matrices: Array

    @classmethod
    def of_sightings(cls, sightings: Sequence[Sighting], edges: Sequence[int]) -> Self:
        """Return the samples of parts of strokes along edges, which are numbered in their order."""
        place = {edge: number for number, edge in enumerate(edges)}
        points, weights = _padded(sightings)
        return cls(
            np.array([place[own.edge] for own in sightings], np.intp),
            points,
            weights,
            np.stack([own.matrices for own in sightings]),
        )

    @cached_property
    def turned(self) -> Array:
        """The samples with coordinates first, (s, 2, k)."""
        return np.swapaxes(self.points, 1, 2)

    def feet(self, curves: Array, near: Array | None) -> Feet | None:
        """Return the foot points of all samples; None if an edge is behind an eye or far away."""
        own = np.concatenate((curves[self.of], np.ones((len(self.of), 4, 1))), axis=2)
        seen = np.swapaxes((self.matrices @ own[..., None])[..., 0], 1, 2)
        w = seen[:, 2:]
        if w.min() <= AT_EYE or (np.abs(seen[:, :2]) > FARTHEST * w).any():
            return None
        cubics = seen @ POWERS.T
        slopes = cubics[:, :, 1:] * SLOPES
        t = self._nearest(cubics) if near is None else near
        powers = np.ones((len(t), 4, t.shape[1]))
        for number in range(FOOT_STEPS + 1):
            powers[:, 1] = t
            np.multiply(t, t, out=powers[:, 2])
            np.multiply(powers[:, 2], t, out=powers[:, 3])
            rows, speeds = cubics @ powers, slopes @ powers[:, :3]
            depth = rows[:, 2:]
            places = rows[:, :2] / depth
            pace = (speeds[:, :2] - speeds[:, 2:] * places) / depth
            ways = places - self.turned
            squares = np.maximum(pace[:, 0] ** 2 + pace[:, 1] ** 2, TINY)
            shift = (ways[:, 0] * pace[:, 0] + ways[:, 1] * pace[:, 1]) / squares
            feet = np.clip(t - np.clip(shift, -LONGEST_SHIFT, LONGEST_SHIFT), 0.0, 1.0)
            if number == FOOT_STEPS or np.abs(feet - t).max() < FOOT_SETTLED:
                break
            t = feet
        normals = np.stack((-pace[:, 1], pace[:, 0]), axis=1) / np.sqrt(squares)[:, None]
        off = normals[:, 0] * ways[:, 0] + normals[:, 1] * ways[:, 1]
        beyond = np.clip(shift, -FARTHEST_BEYOND, FARTHEST_BEYOND)
        return Feet(t, depth[:, 0], places, normals, off, beyond, speeds[:, 2] / depth[:, 0])

    def _nearest(self, cubics: Array) -> Array:
        """Return parameters (s, k) of the nearest places on polylines in the edges' pictures."""
        rows = cubics @ np.linspace(0.0, 1.0, FOOT_PLACES + 1) ** np.arange(4)[:, None]
        path = np.swapaxes(rows[:, :2] / rows[:, 2:], 1, 2)
        begin, piece = path[:, :-1], np.diff(path, axis=1)
        squares = np.maximum((piece**2).sum(axis=2), TINY)[:, None]
        along = self.points @ np.swapaxes(piece, 1, 2) - (begin * piece).sum(axis=2)[:, None]
        share = np.clip(along / squares, 0.0, 1.0)
        # Squared distances, without the term that is equal for all pieces.
        away = (begin**2).sum(axis=2)[:, None] - 2.0 * self.points @ np.swapaxes(begin, 1, 2)
        away += share * (share * squares - 2.0 * along)
        which = np.argmin(away, axis=2)[..., None]
        return np.asarray((which + np.take_along_axis(share, which, axis=2))[..., 0] / FOOT_PLACES)


def _padded(sightings: Sequence[Sighting]) -> tuple[Array, Array]:
    """Return samples (s, k, 2) and weights (s, k), filled up with last samples of no weight."""
    most = max(len(own.points) for own in sightings)
    points, weights = np.empty((len(sightings), most, 2)), np.zeros((len(sightings), most))
    for number, own in enumerate(sightings):
        count = len(own.points)
        points[number, :count], points[number, count:] = own.points, own.points[-1]
        weights[number, :count] = own.weights
    return points, weights
