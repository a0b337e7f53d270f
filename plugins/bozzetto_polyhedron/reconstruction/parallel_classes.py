"""Lines that are parallel on the sheet, taken to be parallel in space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.reconstruction.drawing import Drawing

LOOSE: Final = 2.8
"""Difference of two mean angles, in its standard deviations, up to which groups are joined."""

STRICT: Final = 1.6
"""The same for the second guess, which keeps apart what the first one may have fused."""

HAND: Final = np.radians(0.7)
"""Standard deviation of the angle of a very long line: a hand is not parallel to itself."""

FARTHEST: Final = np.radians(25.0)
"""Angle beyond which groups are never joined, however short their lines."""


@dataclass(frozen=True, eq=False)
class ParallelClasses:
    """Groups of lines of one direction.

    Parameters
    ----------
    labels : (m,) intp
        Class of each line.
    directions : (c, 2) float64
        Unit vector of each class on the sheet.
    """

    labels: Index
    directions: Array


def angle_between(first: Array, second: Array) -> Array:
    """Angle between undirected lines of given angles, radians, 0 … pi / 2."""
    turned = np.abs(first - second) % np.pi
    return np.asarray(np.minimum(turned, np.pi - turned))


def angle_deviations(drawing: Drawing) -> Array:
    """Return standard deviation of the angle of each line, (m,), radians."""
    return np.asarray(np.hypot(HAND, drawing.noise / np.maximum(drawing.lengths, 1e-6)))


def parallel_classes(drawing: Drawing, joining: float = LOOSE) -> ParallelClasses:
    """Group lines by their angles.

    Groups grow by the distance of their mean angles in standard deviations, the nearest pair
    first, so that several short lines pool their evidence before they meet a long one. Then each
    line goes to the class that explains it best.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    joining : float
        Distance of mean angles, in standard deviations, up to which groups are joined.
    """
    spans = drawing.spans
    angles = np.arctan2(spans[:, 1], spans[:, 0]) % np.pi
    deviations = angle_deviations(drawing)
    labels = _agglomerated(angles, deviations, joining)
    for _ in range(2):
        labels = _reassigned(angles, deviations, drawing.lengths, labels)
    means = _means(angles, deviations, labels)
    return ParallelClasses(labels, np.column_stack((np.cos(means), np.sin(means))))


def _agglomerated(angles: Array, deviations: Array, joining: float) -> Index:
    """Labels after joining the nearest groups until none are near."""
    count = len(angles)
    weights = deviations**-2.0
    vectors = weights * np.exp(2j * angles)
    labels = np.arange(count)
    means = angles.copy()
    apart = np.full((count, count), np.inf)
    for first in range(count):
        _measure(apart, means, weights, first, np.arange(first + 1, count))
    while count > 1:
        first, second = divmod(int(apart.argmin()), count)
        if apart[first, second] > joining**2:
            break
        labels[labels == second] = first
        vectors[first] += vectors[second]
        weights[first] += weights[second]
        means[first] = 0.5 * np.angle(vectors[first]) % np.pi
        apart[second, :] = apart[:, second] = np.inf
        others = np.unique(labels)
        _measure(apart, means, weights, first, others[others != first])
    return np.unique(labels, return_inverse=True)[1].astype(np.intp)


def _measure(apart: Array, means: Array, weights: Array, group: int, others: Index) -> None:
    """Fill in the squared distances of one group from others, above the diagonal."""
    turned = angle_between(means[others], means[group])
    distances = np.where(
        turned > FARTHEST, np.inf, turned**2 / (1.0 / weights[others] + 1.0 / weights[group])
    )
    apart[np.minimum(others, group), np.maximum(others, group)] = distances


def _reassigned(angles: Array, deviations: Array, lengths: Array, labels: Index) -> Index:
    """Labels after each line has gone to its likeliest class; long classes are likelier."""
    means = _means(angles, deviations, labels)
    total = np.bincount(labels, lengths, len(means))
    off = angle_between(angles[:, None], means[None]) / deviations[:, None]
    value = 0.5 * np.log(np.maximum(total, 1e-12))[None] - 0.5 * off**2
    value = np.where(off < 2.6, value, -np.inf)
    best = np.where(np.isfinite(value).any(1), value.argmax(1), labels)
    return np.unique(best, return_inverse=True)[1].astype(np.intp)


def _means(angles: Array, deviations: Array, labels: Index) -> Array:
    """Mean angle of each class, radians."""
    vectors = np.zeros(int(labels.max(initial=-1)) + 1, complex)
    np.add.at(vectors, labels, deviations**-2.0 * np.exp(2j * angles))
    return np.asarray(0.5 * np.angle(vectors))
