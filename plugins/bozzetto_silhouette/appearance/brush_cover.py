"""How much a stroke of the brush covers: a function of a place on a surface and its normal.

A stroke is a row of segments, each the part of a ball that goes along it with a radius that
changes evenly. A place is covered by how far inside it lies, and only where the surface faces as
it does under the stroke: paint goes neither around an edge nor through to the back.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index

FACING = 0.3
"""Cosine of the angle between two normals from which paint covers fully, 73°; it fades to nothing
at a right angle."""

AT_ONCE = 8
"""Segments that are held against places in one sweep: neighbours, so that few places are near."""

PARTED = 8
"""Into so many parts a longer row of segments is cut, each with the places near it."""

PLACES_AT_ONCE = 1 << 14
"""Places in one sweep: their arrays stay in the processor's cache."""


class Segments(NamedTuple):
    """Segments of a stroke; a single place is one that ends where it begins.

    Attributes
    ----------
    points : (n, 3) float array
        mm.
    normals : (n, 3) float array
        Unit, of the surface there.
    radii : (n,) float array
        mm.
    ends : (m, 2) int array
        Which two places each joins.
    """

    points: Array
    normals: Array
    radii: Array
    ends: Index

    @classmethod
    def through(cls, points: Array, normals: Array, radii: Array, joined: Flags) -> Segments:
        """Join neighbours (n,) where `joined` (n − 1,) says so; who has none stands alone."""
        first = np.flatnonzero(joined)
        alone = np.ones(len(points), bool)
        alone[first] = alone[first + 1] = False
        lone = np.flatnonzero(alone)
        ends = np.concatenate([np.stack([first, first + 1], 1), np.stack([lone, lone], 1)])
        return cls(points, normals, radii, ends)


def covered(
    segments: Segments, softness: float, points: Array, normals: Array, detail: float
) -> tuple[Index, Array]:
    """Return the places that a stroke covers, (k,), and how much, (k,), up to 1.

    Parameters
    ----------
    segments : Segments
        The stroke.
    softness : float
        Share of the radius over which the edge fades.
    points, normals : (n, 3) float array
        Places on the surface, mm, and unit normals there.
    detail : float
        Distance between the places, mm: no edge is sharper, and what is thinner is fainter.
    """
    if not len(segments.ends) or not len(points):
        return np.zeros(0, np.intp), np.zeros(0)
    cover = np.zeros(len(points))
    every = np.arange(len(points))
    pending = [(segments.ends, every)]
    while pending:
        ends, rows = pending.pop()
        near = rows[_reached(segments, ends, points[rows], detail)]
        if len(ends) <= AT_ONCE:
            _lay(segments, ends, softness, points, normals, near, detail, cover)
        elif len(near):
            size = AT_ONCE * -(-len(ends) // (AT_ONCE * PARTED))
            pending += [(ends[first : first + size], near) for first in range(0, len(ends), size)]
    found = np.flatnonzero(cover)
    return found, cover[found]


def _reached(segments: Segments, ends: Index, points: Array, detail: float) -> Flags:
    """Return which places (n, 3) lie in the box around some segments."""
    reach = segments.radii[ends].max() + 0.5 * detail
    places = segments.points[ends].reshape(-1, 3)
    return _within(points, places.min(axis=0) - reach, places.max(axis=0) + reach)


def _lay(
    segments: Segments,
    ends: Index,
    softness: float,
    points: Array,
    normals: Array,
    near: Index,
    detail: float,
    cover: Array,
) -> None:
    """Raise the cover (n,) of some places to what a few segments give, in place."""
    start, end = segments.points[ends[:, 0]], segments.points[ends[:, 1]]
    radii = segments.radii[ends]
    along = end - start
    square = np.maximum(np.einsum("md,md->m", along, along), 1e-300)
    looks = segments.normals[ends]
    for begin in range(0, len(near), PLACES_AT_ONCE):
        rows = near[begin : begin + PLACES_AT_ONCE]
        away = points[rows, None] - start
        share = np.clip(np.einsum("nmd,md->nm", away, along) / square, 0.0, 1.0)
        away -= share[..., None] * along
        distance = np.sqrt(np.einsum("nmd,nmd->nm", away, away))
        radius = radii[:, 0] + share * (radii[:, 1] - radii[:, 0])
        width = np.maximum(softness * radius, detail)
        edge = radius + 0.5 * (width - softness * radius)
        inside = _smooth_step((edge - distance) / np.maximum(width, 1e-300))
        inside *= np.minimum(1.0, 2.0 * radius / max(detail, 1e-300))
        same = normals[rows] @ looks[:, 0].T * (1.0 - share) + normals[rows] @ looks[:, 1].T * share
        inside *= _smooth_step(same / FACING)
        cover[rows] = np.maximum(cover[rows], inside.max(axis=1))


def _within(points: Array, low: Array, high: Array) -> Flags:
    x, y, z = points.T
    return np.asarray(
        (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1])
        & (z >= low[2]) & (z <= high[2])
    )  # fmt: skip


def _smooth_step(t: Array) -> Array:
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), np.float64)
