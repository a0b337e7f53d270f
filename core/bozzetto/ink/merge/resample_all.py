"""The ink of several strokes as equally spaced, weighted points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto.ink.curves.preprocess import checked_points, prepare_curve
from bozzetto.ink.curves.resample import arc_length, points_along

FINEST: Final = 1.5
"""Least distance of the points, pixels."""

PER_STROKE: Final = 150
"""Points on the longest stroke."""

MOST: Final = 1500
"""Most points of all strokes together: bounds the time."""

REVERSAL: Final = -0.5
"""Cosine of a turn that cuts a stroke in two: a scribble that runs back over itself."""

PIECE: Final = 4
"""Least points of a piece that is cut off."""


@dataclass(frozen=True, eq=False)
class ResampledInk:
    """All ink at one spacing.

    Attributes
    ----------
    points, tangents : (n, 2) float
        Tangents have length 1 (0 for a dot).
    weights : (n,) float
        Above 0.
    piece : (n,) int
        Number of the piece of a stroke that a point is on; points of one are neighbours.
    spacing : float
        Distance of neighbours.
    pixel : float
    """

    points: Array
    tangents: Array
    weights: Array
    piece: Index
    spacing: float
    pixel: float

    @property
    def pieces(self) -> list[Index]:
        """Numbers of the points of each piece, in the order drawn."""
        return np.split(np.arange(len(self.piece)), np.flatnonzero(np.diff(self.piece)) + 1)


@dataclass(frozen=True, eq=False)
class Ordering:
    """Place of each ink point along the curve: the result of a strategy.

    Attributes
    ----------
    numbers : (m,) int
        Points of the ink that the strategy could place.
    parameters : (m,) float
        0 … 1 along the curve.
    closed : bool
    """

    numbers: Index
    parameters: Array
    closed: bool


def resample_all(strokes: Sequence[ArrayLike], weights: Array, pixel: float) -> ResampledInk:
    """Smooth and space all strokes; strokes that turn back sharply are cut there.

    Parameters
    ----------
    strokes : sequence of (n, 2) array_like
        Their samples, canvas pixels.
    weights : (strokes,) float
        Strokes of weight 0 are left out.
    pixel : float
        Length of a pixel in the units of the points.

    Raises
    ------
    UserError
        If there is no ink, or it is not finite, or it has no length.
    """
    places = [
        (_one_way(checked_points(stroke, pixel)), float(weight))
        for stroke, weight in zip(strokes, weights, strict=True)
        if weight > 0
    ]
    if not places:
        raise UserError("There is no ink to make a curve of: draw one.")
    if any(place.shape[1] != 2 for place, _ in places):
        raise UserError("The ink is not plane: draw on the sheet.")
    # The curve must not depend on the order in which equally heavy strokes were drawn.
    places.sort(key=lambda row: (*row[0][0], *row[0][-1], row[1]))
    # Lengths are measured on smoothed ink: the raw length depends on the sampling rate.
    soft = [prepare_curve(place, np.ones(len(place)), pixel=pixel).points for place, _ in places]
    lengths = np.array([arc_length(points)[-1] for points in soft])
    if not lengths.max() > 0:
        raise UserError("The ink is a dot: draw a curve.")
    spacing = max(FINEST * pixel, lengths.max() / PER_STROKE, lengths.sum() / MOST)
    spacing = min(spacing, lengths.max() / 12.0)
    rows: list[tuple[Array, Array, float]] = []
    for points, length, (_, weight) in zip(soft, lengths, places, strict=True):
        for part in _pieces(_spaced(points, length, spacing)):
            rows.append((part, _tangents(part), weight))
    return ResampledInk(
        np.vstack([part for part, _, _ in rows]),
        np.vstack([tangents for _, tangents, _ in rows]),
        np.concatenate([np.full(len(part), weight) for part, _, weight in rows]),
        np.repeat(np.arange(len(rows)), [len(part) for part, _, _ in rows]),
        float(spacing),
        pixel,
    )


def _one_way(points: Array) -> Array:
    """Return the stroke in the sense that begins at its lesser end."""
    return points if tuple(points[0]) <= tuple(points[-1]) else points[::-1]


def _spaced(points: Array, length: float, spacing: float) -> Array:
    count = max(1, round(length / spacing)) + 1 if length > 0 else 1
    return points_along(points, arc_length(points), np.linspace(0.0, length, count))


def _tangents(points: Array) -> Array:
    if len(points) < 2:
        return np.zeros_like(points)
    tangents = np.gradient(points, axis=0)
    return np.asarray(tangents / np.maximum(np.linalg.norm(tangents, axis=1), 1e-300)[:, None])


def _pieces(points: Array) -> list[Array]:
    """Cut where the stroke turns back; both pieces keep the point of the turn."""
    if len(points) < 2 * PIECE + 1:
        return [points]
    chord = points[PIECE // 2 :] - points[: -(PIECE // 2)]
    chord = chord / np.maximum(np.linalg.norm(chord, axis=1), 1e-300)[:, None]
    turn = (chord[: -PIECE // 2] * chord[PIECE // 2 :]).sum(axis=1)
    cuts: list[int] = []
    last = 0
    for at in np.argsort(turn):
        here = int(at) + PIECE // 2
        if turn[at] > REVERSAL:
            break
        if all(abs(here - other) >= PIECE for other in [0, len(points) - 1, *cuts]):
            cuts.append(here)
    parts = []
    for cut in [*sorted(cuts), len(points) - 1]:
        parts.append(points[last : cut + 1])
        last = cut
    return parts
