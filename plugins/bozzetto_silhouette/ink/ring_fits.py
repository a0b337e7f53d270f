"""Local quadratic fits along a closed ring, and how far they may be widened.

After Savitzky and Golay (1964), along the arc, one piece from corner to corner; windows grow after
the intersection of confidence intervals (Goldenshluger and Nemirovski, 1997).
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Flags, Index

SPACING = 3e-3
"""Resampling before a fit, as a share of the size."""

WIDEST = 40
"""Half width of the widest window, in samples."""

CORNER_TURN = np.deg2rad(55.0)
"""A sample where the smoothed direction turns by more, over the window, is a corner."""


def resampled(ring: Array, spacing: float) -> Array:
    """Return places at equal steps of about `spacing` round a ring, 12 at least, (n, 2)."""
    closed = np.vstack([ring, ring[:1]])
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    count = max(round(arc[-1] / spacing), 12)
    at = arc[-1] * np.arange(count) / count
    return np.stack([np.interp(at, arc, closed[:, k]) for k in (0, 1)], axis=1)


def differing_bends(ring: Array) -> Array:
    """Return by how much each place of a ring bends aside more than its neighbours do, (n,).

    The deviation of each vertex from the line through its neighbours, less what both neighbours
    agree on: none on a smooth line, which bends alike there.
    """
    chord = np.roll(ring, -1, axis=0) - np.roll(ring, 1, axis=0)
    span = np.maximum(np.hypot(chord[:, 0], chord[:, 1]), 1e-12)
    away = ring - np.roll(ring, 1, axis=0)
    bend = (away[:, 0] * chord[:, 1] - away[:, 1] * chord[:, 0]) / span
    differ: Array = bend - 0.5 * (np.roll(bend, 1) + np.roll(bend, -1))
    return differ


def widened(
    dense: Array, calm: Array, corners: Index, half: int, wider: tuple[float, ...], bound: float
) -> Array:
    """Widen the windows of fits where that tells no other shape, as far as it does not.

    Parameters
    ----------
    dense, calm : (n, 2) float array
        The ring, and the fit of the narrowest window.
    corners : (k,) int array
        Where neither is widened.
    half : int
        Half width of the narrowest window.
    wider : tuple of float
        Half widths of further fits, in those of the first.
    bound : float
        Farthest that a wider fit may lie from the first.
    """
    count = len(dense)
    widths = [w for w in (round(half * wide) for wide in wider) if w <= min(WIDEST, count // 8)]
    gap = _from_marked(count, corners)
    result, open_to = calm, np.ones(count, bool)
    for width in widths:
        fit = quadratic(dense, width)
        same = np.hypot(*(fit - calm).T) < bound
        open_to = open_to & same & (gap > width)
        weight = faded_in(open_to, half)
        result = result + weight[:, None] * (fit - result)
    return result


def _from_marked(count: int, marked: Index) -> Index:
    """Count the samples from each of a ring to the nearest marked one; their numbers grow."""
    if not len(marked):
        return np.full(count, count)
    around = np.concatenate([marked[-1:] - count, marked, marked[:1] + count])
    each = np.arange(count)
    following = np.searchsorted(around, each)
    nearest: Index = np.minimum(around[following] - each, each - around[following - 1])
    return nearest


def faded_in(inside: Flags, width: int) -> Array:
    """Return weights (n,) that rise smoothly from 0 where a cyclic mask begins to 1 within it."""
    t = np.clip((_from_marked(len(inside), np.flatnonzero(~inside)) - 1.0) / width, 0.0, 1.0)
    weight: Array = t * t * (3.0 - 2.0 * t)
    return weight


def quadratic(points: Array, half: int) -> Array:
    """Smooth a closed ring by Savitzky and Golay, quadratic, window 2 half + 1."""
    k = np.arange(-half, half + 1)
    design = np.stack([np.ones_like(k), k, k**2], axis=1).astype(np.float64)
    kernel = np.linalg.pinv(design)[0]
    padded = np.concatenate([points[-half:], points, points[:half]])
    return np.stack([np.convolve(padded[:, c], kernel, mode="valid") for c in (0, 1)], axis=1)


def corners_of(ring: Array, arm: int, least: float = CORNER_TURN) -> Index:
    """Find where a ring turns by more than an angle over some samples to either side."""
    ahead = np.roll(ring, -arm, axis=0) - ring
    behind = ring - np.roll(ring, arm, axis=0)
    turn = np.abs(
        np.arctan2(
            behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0], (behind * ahead).sum(axis=1)
        )
    )
    highest = np.max([np.roll(turn, k) for k in range(-arm, arm + 1)], axis=0)
    return np.flatnonzero((turn >= highest) & (turn > least))


def with_corners(dense: Array, smooth: Array, corners: Index, half: int) -> Array:
    """Return a smoothed ring whose corners stand: each side is fitted by itself, right up to it."""
    result = smooth.copy()
    offsets = np.arange(-half, half + 1)
    for corner in corners.tolist():
        around = (corner + offsets) % len(dense)
        for side in (offsets[offsets <= 0], offsets[offsets >= 0]):
            where = (corner + side) % len(dense)
            fit = np.polynomial.polynomial.polyfit(side, dense[where], 2 if half > 4 else 1)
            result[where] = np.polynomial.polynomial.polyval(side, fit).T
        result[around[half]] = dense[corner]
    return result
