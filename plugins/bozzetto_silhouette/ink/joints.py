"""How the end of a line meets the start of the next one, or its own, where an outline closes.

A hand misses: it stops short, runs on beside its own start, or arrives a little beside it and at
an angle. Where the ink on both sides tells one direction, the miss is shared by both ends and the
joint is as smooth as the rest; where it tells two, the corner that was drawn stays one.

Lengths are shares of the drawing's longest side.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import arc_length, points_along
from bozzetto_silhouette.ink.smooth_joint import (
    CORNER,
    LEAST_INK,
    NARROW,
    Joint,
    bend,
    fitted_parabola,
    gap_between,
    smooth_joint,
)

FEW: Final = 12
"""A line of fewer samples is a polygon, not ink."""

WINDOW: Final = 0.16
"""Length of ink at an end in which an overlap with the next line is looked for, as a share
of the shorter line."""

BESIDE: Final = 0.05
"""Ink that overlaps without crossing runs side by side no farther apart than this."""

FOLDED_BESIDE: Final = 0.1
"""The same where the way from one to the other would go back against both: nobody means a fold."""

ALIKE: Final = float(np.cos(np.deg2rad(40.0)))
"""Lines side by side run in one direction, up to this angle."""

SHARP: Final = 0.3
"""Sine of the turn below which lines meet nowhere near: both head the same or the opposite way."""

ROUND: Final = np.deg2rad(30.0)
"""Lines that bend together by more, on the way that is looked at, are a round end and no corner."""

AGREED: Final = 0.5
"""Farthest, in widths of the gap, that the corner for which two lines head may lie from the one
that less of their ink tells."""

STEP: Final = 2.0
"""Ink that is moved at both ends where they lie beside each other, in widths of the gap."""

WIDEST_STEP: Final = 0.012
"""Widest gap that counts as a step: the ink that is moved must be nearly straight."""

RUNS_ON: Final = float(np.cos(np.deg2rad(35.0)))
"""The way over a gap leads on as the ink does, up to this angle; else it is a step."""

BESIDE_SAMPLES: Final = 4
"""Samples at each end that tell whether ink of few samples runs on."""

MOST_STEPS: Final = 4.0
"""Widest gap, in steps from sample to sample, over which such ink is brought together."""

SHARED: Final = 0.4
"""Share of the move of an end that its neighbour makes."""


_NOTHING: Final = np.zeros((0, 2))


def self_joint(line: Array) -> tuple[Array, Array]:
    """Close a line onto itself: its halves are joined like two lines.

    Returns
    -------
    line, between : (n, 2), (k, 2) float
        What is kept of it, and points that lead from its end to its start.
    """
    arc = arc_length(line)
    half = int(np.clip(np.searchsorted(arc, 0.5 * arc[-1]), 1, len(line) - 1))
    if len(line) < FEW or gap_between(line, line) <= 1.5 * float(np.diff(arc).max()):
        # A polygon given by its vertices lacks one side, which is like the others.
        import shapely

        if len(line) < FEW or shapely.LinearRing(line).is_simple:
            before, after = line[half:], line[: half + 1]
            smooth = smooth_joint(before, after, halves=True)
            if smooth is None:
                smooth = Joint(*_brought_together(before, after), _NOTHING)
            return np.concatenate([smooth.after[:-1], smooth.before]), smooth.between
    tail, head, between = joint(line[half:], line[: half + 1], halves=True)
    return np.concatenate([head[:-1], tail]), between


def joint(before: Array, after: Array, *, halves: bool = False) -> Joint:
    """Join the end of one line and the start of another: overlaps go, gaps are bridged.

    Parameters
    ----------
    before, after : (n, 2), (m, 2) float array
        The lines.
    halves : bool
        Whether they are those of one line that closes.
    """
    before, after, crossed = _trimmed(before, after)
    smooth = smooth_joint(before, after, halves=halves)
    if smooth is not None:
        return smooth
    if crossed:
        return Joint(before, after, _NOTHING)
    corner = _corner(before, after)
    if len(corner):
        return Joint(before, after, corner)
    return Joint(*_brought_together(before, after), _NOTHING)


def _brought_together(a: Array, b: Array) -> tuple[Array, Array]:
    """Move or drop samples at the ends of lines that run on, where they miss each other.

    Ink is too short there, or too near a corner, for a smooth joint.
    """
    if len(a) + len(b) <= FEW:  # with the sample that halves share, a polygon by its vertices
        return a, b
    moved = _without_step(a, b)
    return moved if moved[0] is not a else _without_overlap(a, b)


def _without_overlap(a: Array, b: Array) -> tuple[Array, Array]:
    """Let lines of few samples run into each other: what overlaps goes, the last two become one.

    A small shape has few samples, an eye thirty, so that hardly one lies in the ink that a smooth
    joint is fitted to. Left alone, the way back from an end that ran on would be a fold. Lines that
    bend near their ends, as polygons do, stay as they are.
    """
    one, other = a[-BESIDE_SAMPLES:], b[:BESIDE_SAMPLES]
    steps = np.concatenate([np.diff(one, axis=0), np.diff(other, axis=0)])
    step = float(np.median(np.hypot(*steps.T)))
    if len(one) + len(other) < 2 * BESIDE_SAMPLES or gap_between(a, b) > MOST_STEPS * step:
        return a, b
    if min(_straightness(one), _straightness(other)) < np.cos(CORNER):
        return a, b
    leave, arrive = (way / np.hypot(*way) for way in (one[-1] - one[-2], other[1] - other[0]))
    ahead = 0.5 * (leave + arrive)
    if float(np.hypot(*ahead)) < np.cos(0.5 * CORNER):
        return a, b
    ahead /= np.hypot(*ahead)
    while len(a) > BESIDE_SAMPLES and float((b[0] - a[-1]) @ ahead) < -0.5 * step:
        a = a[:-1]
    if float((b[0] - a[-1]) @ ahead) > 0.5 * step:
        return a, b
    away = 0.5 * (b[0] - a[-1])
    a, b = a[:-1].copy(), b.copy()
    b[0] -= away
    a[-1] += SHARED * away
    b[1] -= SHARED * away
    return a, b


def _straightness(line: Array) -> float:
    """Return the least cosine of the turns of a line."""
    way = np.diff(line, axis=0)
    way /= np.maximum(np.hypot(*way.T), 1e-300)[:, None]
    return float((way[1:] * way[:-1]).sum(axis=1).min())


def _without_step(a: Array, b: Array) -> tuple[Array, Array]:
    """Move the ends of lines that run on but miss each other sideways until the step is none.

    Their samples stay: to cut them off would leave an edge so long that the corner beside it is
    taken for jitter.
    """
    gap = gap_between(a, b)
    arc_a, arc_b = arc_length(a), arc_length(b)
    way = STEP * gap
    if not 0.0 < gap < WIDEST_STEP or min(arc_a[-1], arc_b[-1]) < 2.0 * way:
        return a, b
    leave = a[-1] - points_along(a, arc_a, arc_a[-1] - way)
    arrive = points_along(b, arc_b, way) - b[0]
    long = float(np.hypot(*leave) * np.hypot(*arrive))
    if float(leave @ arrive) < np.cos(CORNER) * long:
        return a, b
    ahead = leave + arrive
    if float((b[0] - a[-1]) @ ahead) > RUNS_ON * gap * float(np.hypot(*ahead)):
        return a, b
    middle = 0.5 * (a[-1] + b[0])
    return _led_to(middle, a[::-1], way)[:0:-1], _led_to(middle, b, way)


def _led_to(place: Array, line: Array, way: float) -> Array:
    """Return a line that begins at a place; the miss fades over some of its length."""
    arc = arc_length(line)
    at = np.searchsorted(arc, way)
    line = np.insert(line, at, points_along(line, arc, way), axis=0)
    share = np.maximum(1.0 - np.insert(arc, at, way) / way, 0.0)
    led: Array = line + share[:, None] * (place - line[0])
    return led


def _trimmed(a: Array, b: Array) -> tuple[Array, Array, bool]:
    """Cut off where the lines overlap; whether they crossed there."""
    import shapely

    arc_a, arc_b = arc_length(a), arc_length(b)
    shorter = float(min(arc_a[-1], arc_b[-1]))
    gap = gap_between(a, b)
    window = max(WINDOW * shorter, 1.5 * gap) if gap < 0.25 * shorter else WINDOW * shorter
    first = max(int(np.searchsorted(arc_a, arc_a[-1] - window, side="right")) - 1, 0)
    last = int(np.searchsorted(arc_b, window)) + 1
    tail, head = a[first:], b[:last]
    if len(tail) < 2 or len(head) < 2:
        return a, b, False
    line_a, line_b = shapely.LineString(tail), shapely.LineString(head)
    meet = shapely.get_coordinates(shapely.intersection(line_a, line_b))
    if len(meet):
        # The earliest crossing on `a`: what follows of `a` falls away, so no other is left.
        along = shapely.line_locate_point(line_a, shapely.points(meet))
        k = int(along.argmin())
        start = float(shapely.line_locate_point(line_b, shapely.Point(meet[k])))
        a = np.vstack([_upto(a, arc_a, arc_a[first] + along[k]), meet[k]])
        return a, np.vstack([meet[k], _from(b, arc_b, start)]), True
    # Side by side: the end of one lies beside the other's ink.
    end, start = shapely.Point(a[-1]), shapely.Point(b[0])
    on_b, beside_b = float(line_b.project(end)), float(line_b.distance(end))
    on_a, beside_a = float(line_a.project(start)), float(line_a.distance(start))
    folded = _is_fold(tail, head)
    beside = FOLDED_BESIDE if folded else BESIDE
    if min(beside_a, beside_b) >= min(np.inf if folded else 0.35 * gap, beside):
        return a, b, False
    if beside_b <= beside_a and 0.0 < on_b < 0.98 * line_b.length:
        if _alike(tail, head, on_b, beside):
            b = _from(b, arc_b, on_b + 1.5 * beside_b)
    elif 0.02 * line_a.length < on_a < line_a.length:
        if _alike(tail, head, line_a.length - on_a, beside):
            a = _upto(a, arc_a, arc_a[first] + on_a - 1.5 * beside_a)
    return a, b, False


def _upto(line: Array, arc: Array, cut: float) -> Array:
    return line[: max(int(np.searchsorted(arc, cut)), 2)]


def _from(line: Array, arc: Array, cut: float) -> Array:
    return line[min(int(np.searchsorted(arc, cut, side="right")), len(line) - 2) :]


def _is_fold(tail: Array, head: Array) -> bool:
    """Whether the way from one line to the next goes back against both."""
    arc_a, arc_b = arc_length(tail), arc_length(head)
    leave = tail[-1] - points_along(tail, arc_a, max(arc_a[-1] - NARROW, 0.0))
    arrive = points_along(head, arc_b, min(NARROW, arc_b[-1])) - head[0]
    way = head[0] - tail[-1]
    return bool(way @ leave < 0.0 and way @ arrive < 0.0)


def _alike(tail: Array, head: Array, length: float, beside: float) -> bool:
    """Whether the end of one line runs side by side with the start of another all the way."""
    import shapely

    arc_a, arc_b = arc_length(tail), arc_length(head)
    over = points_along(tail, arc_a, np.linspace(max(arc_a[-1] - length, 0.0), arc_a[-1], 9))
    one, two = over[-1] - over[0], points_along(head, arc_b, min(length, arc_b[-1])) - head[0]
    if float(one @ two) <= float(ALIKE * np.hypot(*one) * np.hypot(*two)):
        return False
    return float(shapely.LineString(head).distance(shapely.points(over)).max()) < beside


def _corner(a: Array, b: Array) -> Array:
    """Return the corner that both lines head for, if the gap is only what was missed of it."""
    gap = gap_between(a, b)
    length = max(2.0 * gap, NARROW)
    if _samples_within(a, b, length) < LEAST_INK:
        return _NOTHING
    corner = _headed_for(a, b, length)
    if corner is None:
        return _NOTHING
    half = max(gap, NARROW)
    if _samples_within(a, b, half) >= LEAST_INK // 2:
        nearer = _headed_for(a, b, half)
        if nearer is None or np.hypot(*(nearer - corner)) > AGREED * gap:
            return _NOTHING  # round ends, which head for anywhere
    return corner[None]


def _samples_within(a: Array, b: Array, length: float) -> int:
    """Return how many samples both lines have at least within a length of where they are joined."""
    back, ahead = arc_length(a[::-1]), arc_length(b)
    return int(min(np.searchsorted(back, length), np.searchsorted(ahead, length)))


def _headed_for(a: Array, b: Array, length: float) -> Array | None:
    """Return where two lines would meet, as ink of some length at their ends tells it."""
    gap = gap_between(a, b)
    back, arc_a, arc_b = a[::-1], arc_length(a[::-1]), arc_length(b)
    end, start = fitted_parabola(back, arc_a, length), fitted_parabola(b, arc_b, length)
    if end is None or start is None:
        return None
    ways = np.column_stack((-end[1] / np.hypot(*end[1]), start[1] / np.hypot(*start[1])))
    turn = float(np.linalg.det(ways))
    if abs(turn) < SHARP:
        return None
    if (bend(start) - bend(end)) * length * np.sign(turn) > ROUND:
        return None
    missed = np.linalg.solve(ways, b[0] - a[-1])
    if not (0.0 < missed.min() and missed.max() < 1.5 * gap):
        return None
    return np.asarray(a[-1] + missed[0] * ways[:, 0])
