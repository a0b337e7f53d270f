"""A filter for the jitter of a hand that keeps corners and does not shrink.

Local quadratic fits (Savitzky and Golay, 1964) along the arc, one piece from corner to
corner. The window grows with the measured noise, and clean outlines are left alone.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.ink.ring_fits import (
    CORNER_TURN,
    SPACING,
    corners_of,
    differing_bends,
    faded_in,
    quadratic,
    resampled,
    widened,
    with_corners,
)

UNNOTICED = 4e-4
"""Noise below this share of the size is left alone, unless it is that of the grain."""

ROUNDING = 12.0**-0.5
"""Standard deviation of places that are rounded to a grain, in grains."""

GRAINY = 0.1
"""Noise of grainy ink, as a share of that, from which on it shows: lines along the grain have
none."""

ROUNDED_BY = 4.0
"""Farthest that grainy ink is moved, in standard deviations: what stands out farther was drawn."""

DENSE, SPARSE = 0.03, 0.08
"""Longest edges of ink, as a share of the size, and of ink that a fast pen left few samples of."""

EVEN = 3.5
"""Samples of a pen come at even times: most of the way is on edges not longer than this many times
those that are a tenth of the way."""

IRREGULAR = 0.75
"""Jitter is random: a quarter of the bends are less than this share of their median."""

WIDER = (1.4, 2.0, 2.8)
"""Half widths of further fits, in those of the first: where they tell the same they are calmer."""

SURE = 1.5
"""Standard deviations of the first fit by which a wider one may differ from it."""

FACETS = 0.04
"""Even steps longer than this show as facets, where the ink bends gently."""

GENTLE = np.deg2rad(12.5)
"""Median turn from step to step of ink that means a curve; a polygon of fewer than 29 sides turns
more."""

_HALF_WINDOW = (4, 14)
"""Bounds of the filter's half width, in samples."""

LEAST_SAMPLES = 2.5
"""Half of the samples of ink that a window holds at least."""

_PASSES = 3

_TO_AND_FRO = 6.0


def noise_of(ring: Array) -> float:
    """Estimate the high-frequency deviation of a ring's samples, robust to corners.

    Parameters
    ----------
    ring : (n, 2) float array
        Longest side about 1.

    Notes
    -----
    The sine of the turn, alternating in sign, is what jitter adds to a smooth line: the
    estimate is the median of `differing_bends`.
    """
    edge = np.roll(ring, -1, axis=0) - ring
    length = np.hypot(edge[:, 0], edge[:, 1])
    differ = differing_bends(ring)
    usable = length < DENSE
    if usable.mean() < 0.7 and _is_sparse_ink(length, differ):
        # What joins its ends lies closer and does not tremble.
        usable = (length < SPARSE) & (length > 0.3 * by_length(length, 0.9))
    # Long edges between short ones: a polygon given by its corners, not ink.
    elif usable.mean() < 0.7:
        return 0.0
    if usable.sum() < 16:
        return 0.0
    return float(np.median(np.abs(differ[usable]))) / 1.5


def _is_sparse_ink(length: Array, differ: Array) -> bool:
    """Whether longer edges are ink of a fast pen: even, and bent at random, unlike cogs."""
    short, long = by_length(length, 0.1), by_length(length, 0.9)
    little, median = np.quantile(np.abs(differ[length > 0.3 * long]), (0.25, 0.5))
    return bool(long < min(SPARSE, EVEN * short) and little < IRREGULAR * median)


def by_length(length: Array, share: float) -> float:
    """Return the length of the edge that a share of the way round a ring is on shorter ones."""
    ordered = np.sort(length)
    way = np.cumsum(ordered)
    return float(ordered[np.searchsorted(way, share * way[-1])])


def filtered(ring: Array, noise: float | None = None, grain: float = 0.0) -> Array:
    """Filter a closed ring.

    Parameters
    ----------
    ring : (n, 2) float array
        Longest side of the drawing about 1.
    noise : float, optional
        Size of the jitter; measured when not given.
    grain : float
        Distance of the places that samples can have, where they were rounded, as by a mouse.

    Returns
    -------
    (m, 2) float array
        The ring itself when there is nothing to filter.
    """
    for _ in range(_PASSES):
        size = noise_of(ring) if noise is None else noise
        if grain and GRAINY * ROUNDING * grain < size < UNNOTICED and len(ring) >= 24:
            rounding = max(size, ROUNDING * grain)
            return _filtered_once(ring, rounding, ROUNDED_BY * rounding)
        if size < UNNOTICED or len(ring) < 24:
            return _rounded(ring)
        # Heavy jitter makes the line much longer than the shape it stands for, and the
        # window so much narrower on it: measure again on the filtered line.
        calm = _filtered_once(ring, size)
        if calm is ring or noise is not None:
            return calm
        ring = calm
    return ring


def _rounded(ring: Array) -> Array:
    """Lead a smooth line through ink of few samples; of anything else return the ring itself.

    A periodic cubic spline over the arc, from corner to corner.
    """
    edge = np.roll(ring, -1, axis=0) - ring
    length = np.hypot(edge[:, 0], edge[:, 1])
    short, long = by_length(length, 0.1), by_length(length, 0.9)
    if not FACETS < long < min(SPARSE * 1.5, EVEN * short):
        return ring
    heading = np.arctan2(edge[:, 1], edge[:, 0])
    turn = np.abs((heading - np.roll(heading, 1) + np.pi) % (2.0 * np.pi) - np.pi)
    if np.median(turn) > GENTLE:
        return ring
    from scipy.interpolate import CubicSpline  # most ink is dense, and importing it takes long

    corners = np.flatnonzero(turn > CORNER_TURN)
    first = int(corners[0]) if len(corners) else 0
    closed = np.roll(ring, -first, axis=0)
    closed = np.vstack([closed, closed[:1]])
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    if not len(corners):
        fine = np.linspace(0.0, arc[-1], round(arc[-1] / SPACING), endpoint=False)
        return np.asarray(CubicSpline(arc, closed, bc_type="periodic")(fine))
    ends = [*(corners - first).tolist(), len(ring)]
    pieces = []
    for start, stop in pairwise(ends):
        piece = slice(start, stop + 1)
        count = max(round((arc[stop] - arc[start]) / SPACING), 1)
        fine = np.linspace(arc[start], arc[stop], count, endpoint=False)
        if stop - start < 3:
            way = np.column_stack([np.interp(fine, arc[piece], closed[piece, k]) for k in (0, 1)])
        else:
            way = CubicSpline(arc[piece], closed[piece], bc_type="not-a-knot")(fine)
        pieces.append(way)
    return np.concatenate(pieces)


def _filtered_once(ring: Array, noise: float, farthest: float = np.inf) -> Array:
    """Run one pass of the filter for jitter of a given size.

    Where it would move the line farther than some distance it stays as it is.
    """
    # Where samples lie closer than the jitter is wide, the line runs to and fro: averaging
    # the samples themselves first gives a line whose length means something.
    spacing = float(np.median(np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)))
    apart = by_length(np.hypot(*(np.roll(ring, -1, axis=0) - ring).T), 0.5)
    if spacing < _TO_AND_FRO * noise:
        half = int(np.clip(round(2.0 * _TO_AND_FRO * noise / spacing), 2, 10))
        ring = quadratic(ring, half)
    dense = resampled(ring, SPACING)
    half = int(np.clip(round(4.0 * np.sqrt(noise / UNNOTICED)), *_HALF_WINDOW))
    half = max(half, round(LEAST_SAMPLES * apart / SPACING))
    if len(dense) < 4 * half:
        return ring
    calm = quadratic(dense, half)
    corners = corners_of(calm, half)
    doubt = noise * 1.5 * np.sqrt(apart / SPACING / (2 * half + 1))
    result = widened(dense, calm, corners, half, WIDER, SURE * doubt)
    result = with_corners(dense, result, corners, half)
    near = np.hypot(*(result - dense).T) < farthest
    if near.all():
        return result
    return np.asarray(dense + faded_in(near, half)[:, None] * (result - dense))
