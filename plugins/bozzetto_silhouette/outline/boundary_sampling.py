"""Sampling an outline: corners kept, steps as fine as the outline is thin."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import ring_links

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

_Ring = tuple[Array, Array, Index, float]
"""Points on a ring, their arc length, their vertex number or -1, and the ring's length."""

CORNER_TURN = np.deg2rad(18.0)
"""A vertex of the drawn polygon that turns by more is a corner and is kept."""

GRADATION = 0.35
"""How fast the step may grow along the outline, per unit of length."""

CALM = 0.3
"""Half width, in local radii, over which what varies along the outline is averaged before
it acts on the inside."""

_SEPARATION = 0.45
"""Chord between the two touching points of a ball, in radii, below which it is not shrunk
any more."""

_SHRINKS = 12
"""Rounds of the shrinking ball; it converges in about five."""


@dataclass(frozen=True, eq=False)
class Rim:
    """An outline sampled for meshing.

    Attributes
    ----------
    points : (m, 2) float array
        Samples, ring after ring, the inside to the left.
    after, before : (m,) int array
        Successor and predecessor on the ring.
    inward : (m, 2) float array
        Unit normals to the inside.
    turn : (m,) float array
        Exterior angle in radians, positive at convex corners.
    step : (m,) float array
        Wanted spacing.
    radius : (m,) float array
        Radius of the largest ball inside that touches the outline here.
    """

    points: Array
    after: Index
    before: Index
    inward: Array
    turn: Array
    step: Array
    radius: Array

    @property
    def rings(self) -> tuple[Array, ...]:
        """The samples ring by ring."""
        ends = np.flatnonzero(self.after <= np.arange(len(self.points))) + 1
        return tuple(np.split(self.points, ends[:-1]))

    @property
    def simple(self) -> bool:
        """Whether no two rings cross or touch, themselves or each other."""
        import shapely

        closed = [np.vstack([ring, ring[:1]]) for ring in self.rings]
        return bool(shapely.is_simple(shapely.MultiLineString(closed)))

    def averaged(self, values: Array) -> Array:
        """Average values at the samples along the outline, over `CALM` radii."""
        result = np.empty_like(values)
        ends = np.flatnonzero(self.after <= np.arange(len(values)))
        first = 0
        for end in ends.tolist():
            ring = np.arange(first, end + 1)
            edge = self.points[self.after[ring]] - self.points[ring]
            stops = np.cumsum(np.hypot(edge[:, 0], edge[:, 1]))
            arc = np.concatenate([[0.0], stops[:-1]])
            width = CALM * self.radius[ring]
            result[ring] = smoothed(values[ring], arc, float(stops[-1]), width)
            first = end + 1
        return result


def corner_mask(ring: Array) -> Flags:
    """Mark vertices of a closed ring (n, 2) that turn by more than `CORNER_TURN`."""
    edge = np.roll(ring, -1, axis=0) - ring
    back = np.roll(edge, 1, axis=0)
    turn = np.arctan2(back[:, 0] * edge[:, 1] - back[:, 1] * edge[:, 0], (back * edge).sum(axis=1))
    return np.asarray(np.abs(turn) > CORNER_TURN)


def _frames(points: Array, after: Index, before: Index) -> tuple[Array, Array]:
    """Return inward unit normals and exterior angles at the vertices of rings."""
    edge = points[after] - points
    edge /= np.maximum(np.hypot(edge[:, 0], edge[:, 1]), 1e-300)[:, None]
    back = edge[before]
    tangent = edge + back
    length = np.hypot(tangent[:, 0], tangent[:, 1])
    tangent = np.where(length[:, None] > 1e-9, tangent, edge)
    tangent /= np.maximum(np.hypot(tangent[:, 0], tangent[:, 1]), 1e-300)[:, None]
    turn = np.arctan2(back[:, 0] * edge[:, 1] - back[:, 1] * edge[:, 0], (back * edge).sum(axis=1))
    return np.stack([-tangent[:, 1], tangent[:, 0]], axis=1), turn


def tangent_radii(
    points: Array,
    inward: Array,
    limit: float,
    asked: Index | None = None,
    tree: cKDTree | None = None,
) -> Array:
    """Return the radius of the largest ball on one side of the outline that touches each point.

    The shrinking ball of Ma, Bae and Choi, "3D medial axis point approximation using
    nearest neighbors and the normal field", 2012, in the plane.

    Parameters
    ----------
    points, inward : (m, 2) float arrays
        Dense samples and unit normals towards the side wanted.
    limit : float
        Radius to begin with, which is also the largest answer.
    asked : (k,) int array, optional
        The points whose radii are wanted; all of them when not given.
    tree : cKDTree, optional
        Of the points, where it is at hand.

    Returns
    -------
    (k,) or (m,) float array
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(points) if tree is None else tree
    radius = np.full(len(points), limit)
    asked = np.arange(len(points)) if asked is None else asked
    active = asked
    for _ in range(_SHRINKS):
        centre = points[active] + radius[active, None] * inward[active]
        gap, near = (np.asarray(column) for column in tree.query(centre))
        # A hair inside the ball is the point itself, seen through rounding.
        shrinks = (gap < radius[active] * (1.0 - 1e-3)) & (near != active)
        active, near = active[shrinks], near[shrinks]
        chord = points[near] - points[active]
        height = (chord * inward[active]).sum(axis=1)
        size2 = (chord**2).sum(axis=1)
        smaller = np.where(height > 1e-12, size2 / (2.0 * np.maximum(height, 1e-12)), limit)
        # Seen from the centre, a touching point right beside the sample itself tells of
        # noise or of curvature, not of another side.
        shrinks = (smaller < radius[active]) & (size2 > np.square(_SEPARATION * smaller))
        active, smaller = active[shrinks], smaller[shrinks]
        if not len(active):
            break
        radius[active] = smaller
    return radius[asked]


def _graded(values: Array, arc: Array, length: float, slope: float) -> Array:
    """Lower `values` on a closed ring until they grow by at most `slope` per length."""
    a = np.concatenate([arc - length, arc, arc + length])
    v = np.tile(values, 3)
    ahead = np.minimum.accumulate(v - slope * a) + slope * a
    back = (np.minimum.accumulate((v + slope * a)[::-1]) - slope * a[::-1])[::-1]
    n = len(values)
    return np.minimum(ahead, back)[n : 2 * n]


def smoothed(values: Array, arc: Array, length: float, width: Array) -> Array:
    """Average of `values` on a closed ring over arcs of half width `width`, three times.

    Parameters
    ----------
    values, arc, width : (n,) float arrays
        Samples, their arc length from the ring's start, and half widths.
    length : float
        Of the ring.
    """
    n = len(values)
    width = np.minimum(width, 0.45 * length)
    position = np.concatenate([arc - length, arc, arc + length, [2.0 * length]])
    for _ in range(3):
        v = np.append(np.tile(values, 3), values[0])
        total = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(position))])
        ahead, back = (np.interp(arc + s * width, position, total) for s in (1.0, -1.0))
        values = np.where(width > 0.0, (ahead - back) / np.maximum(2.0 * width, 1e-300), values)
    return values[:n]


def _arc_sample(ring: Array, step: float) -> _Ring:
    """Return the vertices of the ring and points in between, no farther apart than `step`.

    Returns points, arc length, the original vertex index or -1, and the ring's length.
    """
    edge = np.roll(ring, -1, axis=0) - ring
    length = np.hypot(edge[:, 0], edge[:, 1])
    pieces = np.maximum(1, np.ceil(length / step)).astype(np.intp)
    index = np.repeat(np.arange(len(ring)), pieces)
    part = np.arange(len(index)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = part / pieces[index]
    start = np.cumsum(length) - length
    points = ring[index] + share[:, None] * edge[index]
    arc = start[index] + share * length[index]
    return points, arc, np.where(part == 0, index, -1), float(length.sum())


def _spread(arc: Array, spacing: float, corners: Index) -> Index:
    """Choose samples of a ring, about `spacing` apart where it has more, and all corners."""
    place = np.floor(arc / spacing)
    first = np.flatnonzero(np.diff(place, prepend=-1.0))
    return np.union1d(first, corners)


def _radii(
    tree: cKDTree, inward: Array, limit: float, dense: list[_Ring], asked: list[Index]
) -> Array:
    """Return `tangent_radii` at the samples asked for, and interpolate by the arc in between."""
    firsts = np.cumsum([0] + [len(ring[0]) for ring in dense[:-1]])
    places = np.concatenate([at + first for at, first in zip(asked, firsts, strict=True)])
    known = tangent_radii(tree.data, inward, limit, places, tree)
    ends = np.cumsum([len(at) for at in asked])[:-1]
    return np.concatenate([
        np.interp(arc, arc[at], radius, period=length)
        for (_, arc, _, length), at, radius in zip(dense, asked, np.split(known, ends), strict=True)
    ])  # fmt: skip


def sample_rim(
    rings: tuple[Array, ...],
    step: float,
    finest: float,
    *,
    thinness: float = 0.55,
    every_vertex: bool = False,
) -> Rim:
    """Sample rings with a step that follows the local thickness of walls and gaps.

    Parameters
    ----------
    rings : tuple of (n, 2) float arrays
        Closed rings, the inside to the left.
    step : float
        Spacing where the shape is thick.
    finest : float
        No spacing is smaller than this.
    thinness : float
        Spacing as a share of the inscribed radius where the shape is thin.
    every_vertex : bool
        Keep all vertices, not only corners: on a jagged line the samples alone might cross.
    """
    from scipy.spatial import cKDTree

    low = np.min([r.min(axis=0) for r in rings], axis=0)
    high = np.max([r.max(axis=0) for r in rings], axis=0)
    dense = [_arc_sample(ring, step) for ring in rings]
    points = np.concatenate([d[0] for d in dense])
    after, before = ring_links([len(d[0]) for d in dense])
    inward, _ = _frames(points, after, before)
    corners = [
        np.flatnonzero((origin >= 0) & corner_mask(ring)[origin])
        for ring, (_, _, origin, _) in zip(rings, dense, strict=True)
    ]
    asked = [
        _spread(arc, step / 3.0, at) for (_, arc, _, _), at in zip(dense, corners, strict=True)
    ]
    # Nothing larger fits into the box; and a gap wider than a step asks for no finer one.
    tree = cKDTree(points)
    inside = _radii(tree, inward, 0.51 * float((high - low).min()), dense, asked)
    outside = _radii(tree, -inward, step, dense, asked)
    wanted = np.clip(np.minimum(thinness * inside, 1.2 * outside), finest, step)

    samples, counts, steps, radii = [], [], [], []
    first = 0
    for (own, arc, origin, length), turns in zip(dense, corners, strict=True):
        part = slice(first, first + len(own))
        first += len(own)
        size = _graded(wanted[part], arc, length, GRADATION)
        reach = _graded(np.maximum(inside[part], finest), arc, length, 0.6)
        reach = smoothed(reach, arc, length, CALM * reach)
        stay = np.flatnonzero(origin >= 0) if every_vertex else turns
        if not len(stay):
            stay = np.array([0])
        position = np.append(arc, length)
        density = np.append(1.0 / size, 1.0 / size[0])
        filled = np.concatenate(
            [[0.0], np.cumsum(np.diff(position) * 0.5 * (density[1:] + density[:-1]))]
        )
        stops = np.append(stay, stay[0] + len(arc))
        marks = []
        for a, b in itertools.pairwise(stops):
            begin = filled[a]
            end = filled[b] if b <= len(arc) else filled[-1] + filled[b - len(arc)]
            minimum = 3 if len(stay) == 1 else 2 if len(stay) == 2 else 1
            n = max(minimum, int(np.ceil(end - begin - 0.2)))
            marks.append(begin + (end - begin) * np.arange(n) / n)
        mark = np.concatenate(marks)
        mark = np.where(mark >= filled[-1], mark - filled[-1], mark)
        at = np.interp(mark, filled, position)
        closed = np.vstack([own, own[:1]])
        samples.append(np.stack([np.interp(at, position, closed[:, k]) for k in (0, 1)], axis=1))
        steps.append(np.interp(at, position, np.append(size, size[0])))
        radii.append(np.interp(at, position, np.append(reach, reach[0])))
        counts.append(len(at))
    points = np.concatenate(samples)
    after, before = ring_links(counts)
    inward, turn = _frames(points, after, before)
    return Rim(points, after, before, inward, turn, np.concatenate(steps), np.concatenate(radii))
