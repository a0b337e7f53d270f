"""Ink as points with directions, and where a curve lies in it again, moved along the sheet."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.ink import resample

STEP: Final = 1.0 / 160.0
"""Distance of points along ink, in diagonals of the drawing."""

ALIGNED: Final = np.sin(np.radians(22.0))
"""Sine of the angle within which ink runs along a curve."""

VOTES: Final = np.sin(np.radians(12.0))
"""The same for votes, which are many."""

PEAKS: Final = 12
"""Places with most votes that are looked at."""

MOSTLY: Final = 0.7
"""Share of a stroke that lies along a curve for all of it to be part of that."""


@dataclass(frozen=True, eq=False)
class InkSamples:
    """Points at even steps along strokes.

    Parameters
    ----------
    points, along : (n, 2) float64
        px, and unit vectors.
    strokes : (n,) intp
        Of each point, the number of its stroke.
    lengths : (s,) float64
        Of the strokes, px.
    """

    points: Array
    along: Array
    strokes: Index
    lengths: Array

    def of(self, numbers: Collection[int]) -> Index:
        """Return which points belong to some strokes."""
        return np.flatnonzero(np.isin(self.strokes, list(numbers)))

    def lying_along(
        self, curve: Array, numbers: Collection[int], reach: float, share: float = MOSTLY
    ) -> list[int]:
        """Return which of some strokes lie along a curve, (m, 2), within reach, px."""
        found = []
        for number in numbers:
            rows = self.of([number])
            if len(rows) and self._is_along(curve, rows, reach).mean() >= share:
                found.append(number)
        return found

    def covered(self, curve: Array, numbers: Collection[int], reach: float) -> float:
        """Return the share of the points of a curve, (m, 2), beside which strokes run along it."""
        rows = self.of(numbers)
        if not len(rows):
            return 0.0
        ways = directions(curve)
        apart = np.linalg.norm(curve[:, None] - self.points[rows], axis=2)
        turned = np.abs(_cross(ways[:, None], self.along[rows]))
        return float(((apart < reach) & (turned < ALIGNED)).any(axis=1).mean())

    def shifts(self, curve: Array, numbers: Collection[int], reach: float) -> list[Array]:
        """Return how far a curve, (m, 2), may be moved to lie along some strokes, most ink first.

        Each point of ink votes for the shifts that bring a point of the curve with its direction
        there (a generalised Hough transform, Ballard 1981).
        """
        rows = self.of(numbers)
        if not len(rows):
            return []
        ways = directions(curve)
        one, two = np.nonzero(np.abs(_cross(ways[:, None], self.along[rows])) < VOTES)
        votes = self.points[rows[two]] - curve[one]
        cells = np.round(votes / reach).astype(int)
        unique, owner, counts = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
        del owner
        place = {(int(x), int(y)): int(n) for (x, y), n in zip(unique, counts, strict=True)}
        around = [(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)]
        sums = {(x, y): sum(place.get((x + dx, y + dy), 0) for dx, dy in around) for x, y in place}
        best = sorted(sums, key=lambda cell: (-sums[cell], cell))[:PEAKS]
        made = []
        for cell in best:
            shift = np.asarray(cell, float) * reach
            for _ in range(3):
                near = np.linalg.norm(votes - shift, axis=1) < 1.5 * reach
                shift = votes[near].mean(axis=0) if near.any() else shift
            made.append(shift)
        return sorted(made, key=lambda each: -self.covered(curve + each, numbers, reach))

    def _is_along(self, curve: Array, rows: Index, reach: float) -> Array:
        ways = directions(curve)
        apart = np.linalg.norm(self.points[rows][:, None] - curve, axis=2)
        turned = np.abs(_cross(self.along[rows][:, None], ways))
        return np.asarray(((apart < reach) & (turned < ALIGNED)).any(axis=1))


def ink_samples(paths: Sequence[Array], size: float) -> InkSamples:
    """Return points at even steps along strokes, each (n, 2) px, of a drawing of some size."""
    lengths = [float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()) for path in paths]
    points, along, numbers = [np.zeros((0, 2))], [np.zeros((0, 2))], [np.zeros(0, np.intp)]
    for number, (path, length) in enumerate(zip(paths, lengths, strict=True)):
        count = max(3, round(length / (STEP * size)))
        if not length > 0.0:
            continue
        even = np.asarray(resample(path, count=count))
        points.append(even)
        along.append(directions(even))
        numbers.append(np.full(count, number, np.intp))
    return InkSamples(
        np.concatenate(points), np.concatenate(along), np.concatenate(numbers), np.array(lengths)
    )


def directions(points: Array) -> Array:
    """Return unit vectors along a line through points, (n, 2)."""
    ways = np.gradient(points, axis=0)
    return np.asarray(ways / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-12))


def _cross(one: Array, other: Array) -> Array:
    return np.asarray(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])
