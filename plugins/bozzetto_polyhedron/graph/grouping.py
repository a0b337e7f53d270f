"""Which segments are one line: drawn over again, or in dashes.

Lengths are shares of the drawing's diagonal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.segments import Segments

Members = tuple[int, ...]
"""Numbers of segments that are one line."""

LEAST_ANGLE: Final = np.radians(5.0)
"""Angle (radians) that a line drawn again may always differ by."""

LONGEST_DASH: Final = 0.045
"""Length of a dash, at most."""

LONGEST_GAP: Final = 0.03
"""Gap between two dashes of a line, at most."""

ACROSS_DASHES: Final = 0.016
"""Distance of dashes from their line, with the slack that lines drawn again have."""

FEWEST_DASHES: Final = 3
"""Short pieces in a row of which a line is dashed, where no pressure tells."""


@dataclass(frozen=True, eq=False)
class _Table:
    """Lines during grouping: axes and extents, changed in place by `_refit`."""

    centers: Array
    axes: Array
    low: Array
    high: Array

    @property
    def lengths(self) -> Array:
        made: Array = self.high - self.low
        return made


def grouped(
    segments: Segments, tolerance: float, start: tuple[Members, ...] | None = None
) -> tuple[Members, ...]:
    """Join segments that were drawn over one another: the largest overlap first.

    Parameters
    ----------
    segments : Segments
        What was drawn.
    tolerance : float
        Distance across the line.
    start : tuple of tuple of int, optional
        Groups to start from; every segment on its own without.
    """
    groups = [list(each) for each in start or [(k,) for k in range(len(segments))]]

    def overlap(table: _Table, one: int, others: Index) -> Array:
        fit, shared, least = _alignment(table, one, others, tolerance, LEAST_ANGLE)
        enough = shared > np.maximum(tolerance, 0.45 * least)
        return np.where(fit & enough, -shared, np.inf)

    return _agglomerated(segments, groups, overlap)


def dashed(segments: Segments, light: Flags, tolerance: float) -> tuple[Members, ...]:
    """Join short segments in a row to dashed lines: the smallest gap first.

    Parameters
    ----------
    segments : Segments
        What was drawn.
    light : (k,) bool
        Which ones were drawn lightly; only these are dashes, unless none was.
    tolerance : float
        Distance across the line.
    """
    short = segments.lengths < LONGEST_DASH
    if light.any():
        short &= light
    groups = [[k] for k in range(len(segments))]

    def gap(table: _Table, one: int, others: Index) -> Array:
        if not short[groups[one][0]]:
            return np.full(len(others), np.inf)
        fit, shared, least = _alignment(table, one, others, 0.6 * tolerance, np.radians(20.0))
        near = (-shared < LONGEST_GAP) & (shared < 0.5 * least)
        both = np.array([short[groups[k][0]] for k in others], bool)
        return np.where(fit & near & both, np.abs(shared), np.inf)

    chains = _agglomerated(segments, groups, gap)
    if light.any():
        return chains
    apart = [(k,) for chain in chains if len(chain) < FEWEST_DASHES for k in chain]
    return (*(chain for chain in chains if len(chain) >= FEWEST_DASHES), *apart)


def _agglomerated(
    segments: Segments,
    groups: list[list[int]],
    score: Callable[[_Table, int, Index], Array],
) -> tuple[Members, ...]:
    """Join the pair of least score until none is left."""
    count = len(groups)
    if count < 2:
        return tuple(tuple(each) for each in groups)
    table = _table(segments, groups)
    scores = np.full((count, count), np.inf)
    for one in range(1, count):
        scores[one, :one] = score(table, one, np.arange(one))
    alive = np.ones(count, bool)
    while True:
        one, other = divmod(int(scores.argmin()), count)
        if not np.isfinite(scores[one, other]):
            break
        groups[one] = groups[one] + groups[other]
        alive[other] = False
        scores[other, :] = scores[:, other] = np.inf
        _refit(table, one, segments, groups[one])
        rest = np.flatnonzero(alive & (np.arange(count) != one))
        if len(rest):
            again = score(table, one, rest)
            scores[np.maximum(one, rest), np.minimum(one, rest)] = again
    return tuple(tuple(sorted(groups[k])) for k in np.flatnonzero(alive))


def _table(segments: Segments, groups: list[list[int]]) -> _Table:
    count = len(groups)
    table = _Table(
        np.zeros((count, 2)),
        np.zeros((count, 2)),
        np.zeros(count),
        np.zeros(count),
    )
    for number, members in enumerate(groups):
        _refit(table, number, segments, members)
    return table


def _refit(table: _Table, number: int, segments: Segments, members: list[int]) -> None:
    center, axis = principal_axis(segments.ends[members])
    along = (segments.ends[members].reshape(-1, 2) - center) @ axis
    table.centers[number] = center
    table.axes[number] = axis
    table.low[number], table.high[number] = along.min(), along.max()


def principal_axis(ends: Array) -> tuple[Array, Array]:
    """Return the center and direction of the line nearest to all points of some segments.

    Parameters
    ----------
    ends : (k, 2, 2) float64
        Of the segments.

    Returns
    -------
    (2,) float64, (2,) float64
        The integrals along the segments are in closed form: one of length L and
        direction u about c adds L to the mass and L³/12 u uᵀ to the second moment.
    """
    steps = ends[:, 1] - ends[:, 0]
    mass = np.maximum(np.hypot(steps[:, 0], steps[:, 1]), 1e-9)
    middles = ends.mean(1)
    center = mass @ middles / mass.sum()
    if len(ends) == 1:
        return center, steps[0] / mass[0]
    away = middles - center
    second = np.einsum("k,ki,kj->ij", mass, away, away)
    second += np.einsum("k,ki,kj->ij", mass / 12.0, steps, steps)
    angle = 0.5 * np.arctan2(2.0 * second[0, 1], second[0, 0] - second[1, 1])
    return center, np.array([np.cos(angle), np.sin(angle)])


def _alignment(
    table: _Table, one: int, others: Index, tolerance: float, least_angle: float
) -> tuple[Flags, Array, Array]:
    """Whether lines lie on one line with another, their overlap (a gap is < 0), the shorter length.

    The shorter of two is measured against the longer one.
    """
    lengths = table.lengths
    mine, theirs = lengths[one], lengths[others]
    first = (mine >= theirs)[:, None]
    center = np.where(first, table.centers[one], table.centers[others])
    axis = np.where(first, table.axes[one], table.axes[others])
    low = np.where(first[:, 0], table.low[one], table.low[others])
    high = np.where(first[:, 0], table.high[one], table.high[others])
    short_center = np.where(first, table.centers[others], table.centers[one])
    short_axis = np.where(first, table.axes[others], table.axes[one])
    short_low = np.where(first[:, 0], table.low[others], table.low[one])
    short_high = np.where(first[:, 0], table.high[others], table.high[one])
    tips = (
        short_center[:, None]
        + short_axis[:, None] * np.stack([short_low, short_high], 1)[..., None]
    )
    away = tips - center[:, None]
    along = np.sort((away * axis[:, None]).sum(2), axis=1)
    across = np.abs(away[..., 1] * axis[:, None, 0] - away[..., 0] * axis[:, None, 1]).max(1)
    least = np.maximum(np.minimum(mine, theirs), 1e-9)
    most = np.maximum(np.maximum(mine, theirs), 1e-9)
    sine = np.abs(axis[:, 0] * short_axis[:, 1] - axis[:, 1] * short_axis[:, 0])
    angle = np.arcsin(np.minimum(1.0, sine))
    allowed = np.maximum(least_angle, np.arctan(1.2 * tolerance / least))
    beyond = np.maximum(0.0, np.maximum(along[:, 1] - high, low - along[:, 0]))
    fit = (angle <= np.minimum(allowed, np.radians(40.0))) & (
        across <= tolerance * (1.0 + np.minimum(beyond / most, 1.0))
    )
    shared = np.minimum(along[:, 1], high) - np.maximum(along[:, 0], low)
    return fit, shared, least
