"""Intersections of a curve with itself or with another one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Index
from bozzetto.ink.curves.resample import arc_length, distinct, points_along

TOUCH: Final = 1e-9
"""Distance that counts as touching, as a share of the diagonal of all points."""

PARALLEL: Final = 1e-12
"""Sine of the angle below which two segments count as parallel."""

CHUNK: Final = 16
"""Consecutive segments under one box in the coarse search."""

BLOCK: Final = 1 << 19
"""Pairs of segments looked at together; bounds the memory."""

MAX_HITS: Final = 1_000_000
"""Crossings after which the search stops: a scribble this dense has no outline."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """Places where a curve meets itself or another.

    Attributes
    ----------
    places : (k, 2) float
        In the units of the points.
    first, second : (k,) float
        Where on the curve (or on the first and on the second curve): index of the point
        before, plus the share of the way to the next point. Sorted by `first`; on one
        curve ``first < second``.
    """

    places: Array
    first: Array
    second: Array

    def __len__(self) -> int:
        return len(self.first)


@dataclass(frozen=True, eq=False)
class _Segments:
    """Segments without the ones of no length, with their place in the polyline given."""

    start: Array
    step: Array
    number: Array
    along: Array
    closed: bool

    @classmethod
    def of(cls, points: ArrayLike, closed: bool) -> _Segments:
        place = np.reshape(np.asarray(points, float), (-1, 2))
        kept = distinct(place, closed=closed)
        ring = place[kept]
        # A run of equal points is left at its last copy: the numbering counts from there.
        number = (kept[1:] - 1).astype(float)
        if closed and len(ring) > 1:
            ring = np.vstack((ring, ring[:1]))
            tail = place[kept[-1] :]
            number = np.append(number, kept[-1] + int((tail == place[kept[-1]]).all(1).sum()) - 1)
        return cls(ring[:-1], np.diff(ring, axis=0), number, arc_length(ring), closed)

    def boxes(self) -> tuple[Array, Array]:
        end = self.start + self.step
        return np.minimum(self.start, end), np.maximum(self.start, end)


def self_crossings(points: ArrayLike, *, closed: bool = False) -> Crossings:
    """Find where a polyline meets itself.

    Touching counts as crossing. A crossing through a vertex, or a stretch that the curve
    runs along twice, is reported once (the stretch by where it begins). The vertex that
    two neighbouring segments share is no crossing.

    Parameters
    ----------
    points : (n, 2) array_like
        Equal neighbours are allowed.
    closed : bool
        Whether the last point is joined to the first.
    """
    segments = _Segments.of(points, closed)
    return _meetings(segments, segments, itself=True)


def crossings(
    one: ArrayLike, other: ArrayLike, *, one_closed: bool = False, other_closed: bool = False
) -> Crossings:
    """Find where two polylines meet; touching and shared stretches as in `self_crossings`.

    Parameters
    ----------
    one, other : (n, 2) array_like
        Points of the polylines, in any one unit.
    one_closed, other_closed : bool
        Whether the last point is joined to the first.
    """
    first = _Segments.of(one, one_closed)
    second = _Segments.of(other, other_closed)
    return _meetings(first, second, itself=False)


def _meetings(a: _Segments, b: _Segments, *, itself: bool) -> Crossings:
    if not len(a.start) or not len(b.start):
        return Crossings(np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    low = np.minimum(a.boxes()[0].min(0), b.boxes()[0].min(0))
    high = np.maximum(a.boxes()[1].max(0), b.boxes()[1].max(0))
    touch = TOUCH * float(np.linalg.norm(high - low))
    points, stretches = [np.zeros((0, 2))], [np.zeros((0, 4))]
    total = 0
    for i, j in _near_pairs(a, b, touch, itself):
        at, shared = _hits(a, b, i, j, touch)
        at = _wrapped(at, a, b, 4.0 * touch, itself)
        points.append(at)
        stretches.append(shared)
        total += len(at) + len(shared)
        if total > MAX_HITS:
            break
    found = _one_of_each(np.vstack(points), np.vstack(stretches), 4.0 * touch)
    first, second = found[:, 0], found[:, 1]
    places = points_along(_path(a), a.along, first)
    return Crossings(places, _numbers(a, first), _numbers(b, second))


def _path(segments: _Segments) -> Array:
    return np.vstack((segments.start, segments.start[-1:] + segments.step[-1:]))


def _numbers(segments: _Segments, along: Array) -> Array:
    """Return arc lengths as index plus share."""
    at = np.searchsorted(segments.along, along, "right") - 1
    at = np.clip(at, 0, len(segments.start) - 1)
    steps = np.diff(segments.along)[at]  # 0 where a step is lost beside a very long one
    share = (along - segments.along[at]) / np.where(steps > 0.0, steps, 1.0)
    return np.asarray(segments.number[at] + np.clip(share, 0.0, 1.0))


# -- which pairs to look at ----------------------------------------------------------------


def _near_pairs(
    a: _Segments, b: _Segments, touch: float, itself: bool
) -> Iterator[tuple[Index, Index]]:
    """Yield pairs of segments whose boxes meet, in blocks; with i < j on one curve.

    Neighbours on a stroke lie close together, so boxes around a few consecutive segments
    are a good coarse grid without any further sorting.
    """
    low_a, high_a = a.boxes()
    low_b, high_b = b.boxes()
    low_a, high_a = low_a - touch, high_a + touch
    starts_a, starts_b = np.arange(0, len(low_a), CHUNK), np.arange(0, len(low_b), CHUNK)
    chunk_low_a = np.minimum.reduceat(low_a, starts_a)
    chunk_high_a = np.maximum.reduceat(high_a, starts_a)
    chunk_low_b = np.minimum.reduceat(low_b, starts_b)
    chunk_high_b = np.maximum.reduceat(high_b, starts_b)
    rows = max(1, BLOCK // len(starts_b))
    within = np.arange(CHUNK)
    for begin in range(0, len(starts_a), rows):
        part = slice(begin, begin + rows)
        meet = (
            (chunk_low_a[part, None] <= chunk_high_b) & (chunk_high_a[part, None] >= chunk_low_b)
        ).all(axis=2)
        one, other = np.nonzero(meet)
        one = one + begin
        if itself:
            one, other = one[one <= other], other[one <= other]
        for at in range(0, len(one), BLOCK // CHUNK**2):
            some = slice(at, at + BLOCK // CHUNK**2)
            pairs = np.broadcast_arrays(
                one[some, None, None] * CHUNK + within[:, None],
                other[some, None, None] * CHUNK + within,
            )
            i, j = (numbers.ravel() for numbers in pairs)
            real = (i < len(low_a)) & (j < len(low_b))
            if itself:
                real &= i < j
            i, j = i[real], j[real]
            near = ((low_a[i] <= high_b[j]) & (high_a[i] >= low_b[j])).all(axis=1)
            yield i[near], j[near]


# -- where two segments meet ------------------------------------------------------------------


def _cross(u: Array, v: Array) -> Array:
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _hits(a: _Segments, b: _Segments, i: Index, j: Index, touch: float) -> tuple[Array, Array]:
    """Return meetings of pairs of segments, in arc lengths along the two curves.

    Returns
    -------
    points : (k, 2) float
        Arc length on either curve.
    stretches : (m, 4) float
        For a stretch run along twice: begin and end on the first curve, the place on the
        second curve where it begins, and +1 or -1 for the sense in which the second runs.
    """
    step, other = a.step[i], b.step[j]
    between = b.start[j] - a.start[i]
    length = np.hypot(step[:, 0], step[:, 1])
    other_length = np.hypot(other[:, 0], other[:, 1])
    area = _cross(step, other)
    level = np.abs(area) <= PARALLEL * length * other_length

    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        u = _cross(between, other) / area * length
        v = _cross(between, step) / area * other_length
    meet = ~level & (u >= -touch) & (u <= length + touch)
    meet &= (v >= -touch) & (v <= other_length + touch)
    points = np.column_stack((a.along[i] + np.clip(u, 0, length), b.along[j] + v))[meet]

    # Parallel segments on one line: the other's ends as lengths along this one.
    direction = step / length[:, None]
    sense = np.where((other * direction).sum(1) > 0, 1.0, -1.0)
    head = (between * direction).sum(1)
    tail = head + sense * other_length
    low = np.maximum(np.minimum(head, tail), 0.0)
    high = np.minimum(np.maximum(head, tail), length)
    share = level & (np.abs(_cross(direction, between)) <= touch) & (high >= low - touch)
    begin = a.along[i] + low
    rows = np.column_stack((begin, a.along[i] + high, b.along[j] + sense * (low - head), sense))
    rows = rows[share]
    short = rows[:, 1] - rows[:, 0] <= 4.0 * touch
    return np.vstack((points, rows[short][:, [0, 2]])), rows[~short]


def _wrapped(points: Array, a: _Segments, b: _Segments, slack: float, itself: bool) -> Array:
    """Give the closing point of a closed curve one place; leave out shared vertices."""
    for axis, segments in enumerate((a, b)):
        if segments.closed:
            points[points[:, axis] >= segments.along[-1] - slack, axis] = 0.0
    if not itself:
        return points
    points.sort(axis=1)
    return points[points[:, 1] - points[:, 0] > slack]


# -- one report for one meeting -----------------------------------------------------------------


def _one_of_each(points: Array, stretches: Array, slack: float) -> Array:
    """Merge intersections that belong together; rows of arc lengths, sorted."""
    points = _clustered(points, slack)
    if len(stretches):
        stretches = _joined(stretches, slack)
        inside = np.zeros(len(points), bool)
        begins = np.searchsorted(points[:, 0], stretches[:, 0] - slack)
        ends = np.searchsorted(points[:, 0], stretches[:, 1] + slack)
        for (begin, _, other, sense), low, high in zip(stretches, begins, ends, strict=True):
            expected = other + sense * (points[low:high, 0] - begin)
            inside[low:high] |= np.abs(points[low:high, 1] - expected) <= 2.0 * slack
        points = np.vstack((points[~inside], stretches[:, [0, 2]]))
    return points[np.lexsort((points[:, 1], points[:, 0]))]


def _clustered(points: Array, slack: float) -> Array:
    """Cluster by single linkage within `slack`, first along one curve and then along the other."""
    if not len(points):
        return points
    points = points[np.argsort(points[:, 0], kind="stable")]
    group = np.cumsum(np.append(False, np.diff(points[:, 0]) > slack))
    order = np.lexsort((points[:, 1], group))
    points, group = points[order], group[order]
    fresh = np.append(True, (np.diff(group) > 0) | (np.diff(points[:, 1]) > slack))
    points = points[fresh]
    return points[np.argsort(points[:, 0], kind="stable")]


def _joined(stretches: Array, slack: float) -> Array:
    """Join stretches that continue each other.

    While two curves run along together, the difference of their arc lengths (or the sum,
    where they run against each other) stays what it is.
    """
    begin, other, sense = stretches[:, [0, 2, 3]].T
    tie = other - sense * begin
    order = np.lexsort((tie, sense))
    apart = (np.diff(sense[order]) != 0) | (np.diff(tie[order]) > slack)
    group = np.empty(len(order), np.intp)
    group[order] = np.cumsum(np.append(False, apart))
    order = np.lexsort((begin, group))
    joined, group = stretches[order], group[order]
    fresh = np.append(True, (np.diff(group) > 0) | (joined[1:, 0] > joined[:-1, 1] + slack))
    first = np.flatnonzero(fresh)
    last = np.append(first[1:], len(joined)) - 1
    whole = joined[first]
    whole[:, 1] = joined[last, 1]
    return whole
