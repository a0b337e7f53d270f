"""The last rows from both sides of a blend: which run along one another, and how."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.numerics.isotropic_remeshing import dot
from bozzetto_silhouette.solids.strip_rings import Ring, zipped

AGREED = 0.95
"""Share of the points of a row that must lie beside the same row of the other side."""


class LastRow(NamedTuple):
    """The last row from a border: where its points come to lie, and which they are."""

    points: Array
    along: Array
    names: Index


def closed(firsts: Sequence[LastRow], seconds: Sequence[LastRow]) -> list[Index] | None:
    """Return the triangles between the last rows from both sides; None where they do not fit."""
    partners = _partners(firsts, seconds)
    if partners is None:
        return None
    faces = []
    for row, end in zip(partners, seconds, strict=True):
        order, along = _matched(end.points[::-1], row.points, row.along)
        if along is None:
            return None
        one, other = (
            Ring.of([some.points])._replace(along=where)
            for some, where in ((row, row.along), (end, along))
        )
        faces.append(zipped(one, row.names, other, end.names[::-1][order]))
    return faces


def _partners(firsts: Sequence[LastRow], seconds: Sequence[LastRow]) -> list[LastRow] | None:
    """Return for each row of one side the row of the other that it runs along, if that is clear."""
    from scipy.spatial import cKDTree

    if len(firsts) != len(seconds):
        return None
    tree = cKDTree(np.concatenate([row.points for row in firsts]))
    which = np.repeat(np.arange(len(firsts)), [len(row.points) for row in firsts])
    found = []
    for row in seconds:
        votes = np.bincount(which[tree.query(row.points)[1]], minlength=len(firsts))
        if votes.max() < AGREED * votes.sum():
            return None
        found.append(int(votes.argmax()))
    return [firsts[k] for k in found] if len(set(found)) == len(found) else None


def _matched(points: Array, row: Array, along: Array) -> tuple[Index, Array | None]:
    """Find where points (m, 3) in a closed row lie on another one, of points (n, 3).

    Returns
    -------
    order : (m,) int array
        In which they are to be taken, so that the first is nearest to the other's first.
    along : (m,) float array or None
        Where on the other row each is then; it never falls. None where they do not run along it
        just once.
    """
    from scipy.spatial import cKDTree

    count = len(row)
    _, near = cKDTree(row).query(points)
    following = np.append(along[1:], 1.0)
    least, where = np.full(len(points), np.inf), np.zeros(len(points))
    for begin in ((near - 1) % count, near):
        way = row[(begin + 1) % count] - row[begin]
        beyond = points - row[begin]
        t = np.clip(dot(beyond, way) / np.maximum(dot(way, way), 1e-300), 0.0, 1.0)
        gap = beyond - t[:, None] * way
        square = dot(gap, gap)
        place = along[begin] + t * (following[begin] - along[begin])
        where = np.where(square < least, place, where)
        least = np.minimum(square, least)
    steps = (np.append(where[1:], where[0]) - where + 0.5) % 1.0 - 0.5
    if round(float(steps.sum())) != 1:
        return np.arange(len(points)), None
    walked = where[0] + np.concatenate([[0.0], np.cumsum(steps[:-1])])
    later = np.minimum.accumulate(walked[::-1])[::-1]
    walked = np.minimum(0.5 * (np.maximum.accumulate(walked) + later), walked[0] + 1.0)
    order = np.roll(np.arange(len(points)), -int(np.argmin(walked % 1.0)))
    return order, np.maximum.accumulate(walked[order] % 1.0)
