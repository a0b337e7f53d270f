"""A ring drawn over: its nearest stretch gives way to a new stroke.

All lengths are shares of the size of the whole outline.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import arc_length, close_stroke, crossings, is_closed_gesture, signed_area
from bozzetto_silhouette.ink.jitter_filter import filtered
from bozzetto_silhouette.ink.ring_smoothing import softened
from bozzetto_silhouette.ink.rings_from_strokes import rings_from_strokes, thinned, without_hooks
from bozzetto_silhouette.ink.self_intersections import untangled

REACH = 0.1
"""An end of a stroke farther than this from a ring does not belong to it."""

ALIKE = 0.25
"""A closed stroke redraws a ring if they have this share of their area in common."""

TRIMMED = 0.3
"""Share of the stroke that may be cut off at an end where it crosses the ring."""

TRIM_COST = 0.25
"""Cost of a unit of ink cut off, against a unit that an end is moved to the ring."""

MOST_JOINTS = 4
"""Places on the ring that are tried for each end: both walls of a thin limb, and some."""

COMPARED = 64
"""Samples of stroke and stretch that are held against each other."""

FADE = (3.5, 0.06)
"""An end that is moved to the ring carries the stroke with it over this many times the way,
at least over this length."""

SMOOTH_TURN = np.deg2rad(50.0)
"""A joint that turns by less was meant to be smooth; by more it is a corner."""

JOINT = 0.02
"""Over this length at each side the direction at a joint is taken, and smoothed."""

_FAR = (
    "There is no outline at both ends of the stroke. Start and end it on the line that it "
    "is to change."
)
_CROSSED = "The outline would cross itself at the marked place. Draw the piece again."
_NOTHING = "With this piece the outline would enclose nothing. Draw the piece again."


@dataclass(frozen=True, eq=False)
class _Way:
    """One way to put a stroke into a ring.

    Attributes
    ----------
    cost : float
    head, tail : float
        The part of the stroke that is kept, by its length.
    start, end : float
        Where that meets the ring, by its length; the ring from `start` on to `end` goes.
    backwards : bool
        Whether the stroke runs against the ring.
    """

    cost: float
    head: float
    tail: float
    start: float
    end: float
    backwards: bool


@dataclass(frozen=True)
class _Joint:
    """An end of the stroke, cut off at `at`, brought to the ring at `on`."""

    at: float
    on: float
    cost: float


def ring_drawn_over(rings: Sequence[Array | None], line: Array, size: float) -> int:
    """Return the number of the ring that a stroke is meant for.

    Parameters
    ----------
    rings : sequence of (n, 2) float arrays
        None where a ring is gone.
    line : (m, 2) float array
        The stroke.
    size : float
        Longest side of the whole outline, in the same unit.

    Raises
    ------
    UserError
        If no ring is near both ends.
    """
    redrawn = _redrawn(rings, line)
    if redrawn is not None:
        return redrawn
    stroke = _clean(line, line[0], size)
    best, found = np.inf, -1
    for number, ring in enumerate(rings):
        if ring is not None:
            way = _best_way((ring - line[0]) / size, stroke)
            if way is not None and way.cost < best:
                best, found = way.cost, number
    if found < 0:
        raise UserError(_FAR)
    return found


def drawn_over(ring: Array, line: Array, size: float) -> Array:
    """Replace a stretch of a ring by a stroke, or all of it by a closed stroke.

    Parameters
    ----------
    ring : (n, 2) float array
        A closed line; the first vertex is not repeated.
    line : (m, 2) float array
        The stroke, in any direction.
    size : float
        Longest side of the whole outline, in the same unit.

    Returns
    -------
    (k, 2) float array
        Simple.

    Raises
    ------
    UserError
        If an end of the stroke is far from the ring, or the result crosses itself; with the
        crossings in `places`, in the unit of the ring.
    """
    if _redrawn([ring], line) is not None:
        return max(rings_from_strokes([line]), key=lambda new: abs(signed_area(new)))
    middle = line[0]
    inner, stroke = (ring - middle) / size, _clean(line, middle, size)
    way = _best_way(inner, stroke)
    if way is None:
        raise UserError(_FAR)
    simple, places = untangled(_spliced(inner, stroke, way))
    if len(places):
        raise UserError(_CROSSED, places=[(x, y) for x, y in places * size + middle])
    if simple is None:
        raise UserError(_NOTHING)
    return np.asarray(simple * size + middle, np.float64)


def _redrawn(rings: Sequence[Array | None], line: Array) -> int | None:
    """Return the number of the ring that a closed stroke replaces; None for an open stroke."""
    import shapely

    if len(line) < 3 or not is_closed_gesture(line):
        return None
    loop = shapely.Polygon(close_stroke(line)).buffer(0)
    best, found = 0.0, None
    for number, ring in enumerate(rings):
        if ring is None:
            continue
        region = shapely.Polygon(ring).buffer(0)
        common = region.intersection(loop).area
        share = common / max(region.union(loop).area, 1e-300)
        if share > best and (share >= ALIKE or loop.contains(region)):
            best, found = share, number
    return found


def _clean(line: Array, middle: Array, size: float) -> Array:
    """Remove clumps, hooks and jitter from a stroke."""
    stroke = without_hooks(thinned((line - middle) / size))
    if len(stroke) < 2:
        return stroke
    # There and back again it is a ring, whose two turning points are corners and stay.
    calm = filtered(np.vstack([stroke, stroke[-2:0:-1]]))
    if len(calm) == 2 * len(stroke) - 2:
        return stroke
    return np.vstack([calm[: len(calm) // 2 + 1], stroke[-1:]])


def _around(ring: Array) -> tuple[Array, Array]:
    closed = np.vstack([ring, ring[:1]])
    return closed, arc_length(closed)


def _at(line: Array, arc: Array, where: Array) -> Array:
    return np.column_stack([np.interp(where, arc, line[:, axis]) for axis in (0, 1)])


def _best_way(ring: Array, stroke: Array) -> _Way | None:
    """Return the cheapest way: least cut off, least moved, nearest to what it replaces."""
    if len(stroke) < 2:
        return None
    closed, arc = _around(ring)
    run = arc_length(stroke)
    heads = _joints(closed, arc, stroke)
    tails = [_Joint(run[-1] - j.at, j.on, j.cost) for j in _joints(closed, arc, stroke[::-1])]
    ways = [
        way
        for head in heads
        for tail in tails
        if head.at < tail.at
        for way in _ways(closed, arc, stroke, run, head, tail)
    ]
    return min(ways, key=lambda way: way.cost, default=None)


def _joints(closed: Array, arc: Array, stroke: Array) -> list[_Joint]:
    """Find where the beginning of a stroke may meet a ring: at the nearest places, at crossings."""
    begin, step = closed[:-1], np.diff(closed, axis=0)
    squared = np.maximum((step**2).sum(axis=1), 1e-300)
    share = np.clip(((stroke[0] - begin) * step).sum(axis=1) / squared, 0.0, 1.0)
    away = np.hypot(*(begin + share[:, None] * step - stroke[0]).T)
    near = (away <= np.roll(away, 1)) & (away < np.roll(away, -1)) & (away <= REACH)
    closest = np.flatnonzero(near)
    closest = closest[np.argsort(away[closest])][:MOST_JOINTS]
    found = [
        _Joint(0.0, float(arc[k] + share[k] * np.sqrt(squared[k])), float(away[k])) for k in closest
    ]
    met = crossings(stroke, closed)
    run = arc_length(stroke)
    cuts = np.interp(met.first[:MOST_JOINTS], np.arange(len(run)), run)
    places = np.interp(met.second[:MOST_JOINTS], np.arange(len(arc)), arc)
    for at, on in zip(cuts.tolist(), places.tolist(), strict=True):
        if at <= TRIMMED * run[-1]:
            found.append(_Joint(at, on, TRIM_COST * at))
    return found


def _ways(
    closed: Array, arc: Array, stroke: Array, run: Array, head: _Joint, tail: _Joint
) -> Iterator[_Way]:
    """Yield both stretches of the ring between two joints, each with the cost of replacing it."""
    length = float(arc[-1])
    kept = _at(stroke, run, np.linspace(head.at, tail.at, COMPARED))
    for start, end, backwards in ((head.on, tail.on, False), (tail.on, head.on, True)):
        span = (end - start) % length
        at = (start + np.linspace(0.0, span, COMPARED)) % length
        stretch = _at(closed, arc, at)
        gap = np.hypot(*(kept[:, None] - stretch[None]).transpose(2, 0, 1))
        cost = gap.min(axis=0).mean() + gap.min(axis=1).mean() + head.cost + tail.cost
        yield _Way(float(cost), head.at, tail.at, start, end, backwards)


def _spliced(ring: Array, stroke: Array, way: _Way) -> Array:
    """Put the stroke into the ring, its ends on the ring, the joints smooth."""
    closed, arc = _around(ring)
    run = arc_length(stroke)
    inner = (run > way.head) & (run < way.tail)
    ends = _at(stroke, run, np.array([way.head, way.tail]))
    piece = np.vstack([ends[:1], stroke[inner], ends[1:]])
    if way.backwards:
        piece = piece[::-1]
    first, last = _at(closed, arc, np.array([way.start, way.end]))
    piece = _brought(_brought(piece, first)[::-1], last)[::-1]
    length = float(arc[-1])
    rest = (way.start - way.end) % length
    after = (arc[:-1] - way.end) % length
    order = np.argsort(after, kind="stable")
    kept = order[(after[order] > 0.0) & (after[order] < rest)]
    whole = np.vstack([piece, ring[kept]])
    whole = whole[np.any(whole != np.roll(whole, 1, axis=0), axis=1)]
    if len(whole) < 3:
        return whole
    at = float(arc_length(piece)[-1])
    return _smooth_joints(whole, np.array([0.0, at]))


def _brought(piece: Array, to: Array) -> Array:
    """Move the first point of a line to a place; the rest follows less and less."""
    shift = to - piece[0]
    run = arc_length(piece)
    times, least = FADE
    reach = min(max(times * float(np.hypot(*shift)), least), 0.5 * float(run[-1]))
    t = np.clip(1.0 - run / max(reach, 1e-300), 0.0, 1.0)
    moved: Array = piece + (t * t * (3.0 - 2.0 * t))[:, None] * shift
    moved[0] = to
    return moved


def _smooth_joints(ring: Array, joints: Array) -> Array:
    """Smooth a ring at those joints that turn little; corners stay."""
    closed, arc = _around(ring)
    length = float(arc[-1])
    count = int(np.clip(np.ceil(6.0 * length / JOINT), 16, 20_000))
    steps = length * np.arange(count) / count
    covered = np.zeros(count, bool)
    for joint in joints:
        before, at, after = _at(closed, arc, (joint + np.array([-JOINT, 0.0, JOINT])) % length)
        one, other = at - before, after - at
        turn = np.arctan2(one[0] * other[1] - one[1] * other[0], one @ other)
        if abs(turn) < SMOOTH_TURN:
            away = np.abs((steps - joint + 0.5 * length) % length - 0.5 * length)
            covered |= away <= 0.5 * JOINT
    return softened(ring, covered, 0.5 * JOINT) if covered.any() else ring
