"""How the end of a line meets the start of the next one, or its own, where an outline closes.

A hand misses: it stops short, runs on beside its own start, or arrives a little beside it and at
an angle. Where the ink on both sides tells one direction, the miss is shared by both ends and the
joint is as smooth as the rest; where it tells two, the corner that was drawn stays one.

Lengths are shares of the drawing's longest side.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.polynomial import polynomial

from bozzetto.arrays import Array
from bozzetto.ink import arc_length, points_along

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

NARROW, WIDE = 0.018, 0.15
"""Least and greatest length of ink at each end that a smooth joint is fitted to."""

SHARE, SHARE_OF_SHORT = 0.2, 0.4
"""The same as a share of the shorter line, and of a stroke between others that is so short that
this would be too little."""

REACH: Final = 2.5
"""That length in widths of the gap."""

CORNER: Final = np.deg2rad(50.0)
"""A joint at which the ink turns by more, and more than it bends on that way, is a corner."""

MOST_TURN: Final = np.deg2rad(110.0)
"""Turn beyond which no smooth joint leads over a gap: it would be no function of the chord."""

SHARP: Final = 0.3
"""Sine of the turn below which lines meet nowhere near: both head the same or the opposite way."""

ROUND: Final = np.deg2rad(30.0)
"""Lines that bend together by more, on the way that is looked at, are a round end and no corner."""

AGREED: Final = 0.5
"""Farthest, in widths of the gap, that the corner for which two lines head may lie from the one
that less of their ink tells."""

LANDING: Final = 0.15
"""Ink right at an end, as a share of the length that is fitted: where the pen lands and lifts it
tells the place, and no direction."""

ROUGH: Final = 0.06
"""Deviation of ink from a parabola, as a share of the length that is fitted, from which on it
holds a corner or a hook of its own."""

LEAST_INK: Final = 4
"""Samples that each end must have in the length that is fitted: fewer are vertices of a polygon."""

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

SAMPLES: Final = 24
"""Points on each side of a smooth joint."""

LONG_GAP: Final = 0.1
"""A gap beyond this is bridged by an arch; what is fitted over it would leave the ink."""

WIDEST_GAP: Final = 0.35
"""A gap beyond this is closed straight: nothing says how it was meant."""

ARCHED: Final = np.cos(np.deg2rad(65.0))
"""The ink on both sides of an arch heads over the gap, up to this angle."""

SPACING: Final = 0.006
"""Distance of the points of an arch."""


class Joint(NamedTuple):
    """Two lines that meet.

    Parameters
    ----------
    before, after : (n, 2), (m, 2) float
        What is kept of them.
    between : (k, 2) float
        Points that lead from one to the other.
    """

    before: Array
    after: Array
    between: Array


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
    if len(line) < FEW or _gap(line, line) <= 1.5 * float(np.diff(arc).max()):
        # A polygon given by its vertices lacks one side, which is like the others.
        import shapely

        if len(line) < FEW or shapely.LinearRing(line).is_simple:
            before, after = line[half:], line[: half + 1]
            smooth = _smooth(before, after, halves=True)
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
    smooth = _smooth(before, after, halves=halves)
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
    if len(one) + len(other) < 2 * BESIDE_SAMPLES or _gap(a, b) > MOST_STEPS * step:
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
    gap = _gap(a, b)
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


def _gap(before: Array, after: Array) -> float:
    return float(np.hypot(*(after[0] - before[-1])))


def _trimmed(a: Array, b: Array) -> tuple[Array, Array, bool]:
    """Cut off where the lines overlap; whether they crossed there."""
    import shapely

    arc_a, arc_b = arc_length(a), arc_length(b)
    shorter = float(min(arc_a[-1], arc_b[-1]))
    gap = _gap(a, b)
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


def _smooth(a: Array, b: Array, *, halves: bool) -> Joint | None:
    """Join two lines smoothly, if that is what their ink says; the miss is shared by both."""
    gap = _gap(a, b)
    back, arc_a, arc_b = a[::-1], arc_length(a[::-1]), arc_length(b)
    shorter = float(min(arc_a[-1], arc_b[-1]))
    longest = SHARE * shorter
    if not halves:
        longest = max(longest, min(3.0 * NARROW, SHARE_OF_SHORT * shorter))
    long_gap = gap > LONG_GAP
    length = min(LONG_GAP if long_gap else max(REACH * gap, 3.0 * NARROW), WIDE, longest)
    while length >= (NARROW if long_gap else max(NARROW, 1.2 * gap)):
        if min(np.searchsorted(arc_a, length), np.searchsorted(arc_b, length)) < LEAST_INK:
            return None
        end, start = _parabola(back, arc_a, length), _parabola(b, arc_b, length)
        if end is not None and start is not None:
            made = (_arch if long_gap else _fitted)(a, b, end, start, length)
            if made is not None:
                return made
        length *= 0.7
    return None


def _parabola(line: Array, arc: Array, length: float) -> Array | None:
    """Fit the ink at the start of a line.

    Returns
    -------
    (3, 2) float or None
        Coefficients of the arc length; None where the ink holds a corner.
    """
    at = np.linspace(LANDING * length, 2.0 * length, 2 * SAMPLES)
    ink = points_along(line, arc, at)
    fit = polynomial.polyfit(at, ink, 2)
    away = ink - polynomial.polyval(at, fit).T
    rough = float(np.sqrt(np.einsum("ij,ij->", away, away) / len(at)))
    return None if rough > ROUGH * length else np.asarray(fit, float)


def _fitted(a: Array, b: Array, end: Array, start: Array, length: float) -> Joint | None:
    """Lead over a short gap by a cubic through the ink on both sides, which blends into it.

    None where the ink turns too much, and the joint is a corner.
    """
    leave, arrive = -end[1], start[1]
    turn = np.arctan2(leave[0] * arrive[1] - leave[1] * arrive[0], leave @ arrive)
    told = 0.5 * (_bend(start) - _bend(end)) * float(np.hypot(*(b[0] - a[-1])))
    if not min(0.0, told) - CORNER < turn < max(0.0, told) + CORNER or abs(turn) > MOST_TURN:
        return None
    along = leave / np.hypot(*leave) + arrive / np.hypot(*arrive)
    along /= np.hypot(*along)
    frame = np.column_stack((along, (-along[1], along[0])))
    middle = 0.5 * (a[-1] + b[0])
    at = np.linspace(0.0, length, SAMPLES)
    back = a[::-1]
    before = (points_along(back, arc_length(back), at)[::-1] - middle) @ frame
    after = (points_along(b, arc_length(b), at) - middle) @ frame
    half = float(min(-before[0, 0], after[-1, 0]))
    if half < 0.5 * length:
        return None
    x, y = np.concatenate((before, after)).T
    share = np.abs(x) / half
    fit = polynomial.polyfit(x / half, y, 3, w=0.1 + 0.9 * np.clip((share - 0.1) / 0.4, 0.0, 1.0))
    grid = np.linspace(before[0, 0], after[-1, 0], 2 * SAMPLES + 1)
    one, other = before[np.argsort(before[:, 0])], after[np.argsort(after[:, 0])]
    ink = np.where(
        grid < 0.0, np.interp(grid, one[:, 0], one[:, 1]), np.interp(grid, other[:, 0], other[:, 1])
    )
    outward = np.where(grid < 0.0, grid / grid[0], grid / grid[-1])
    t = np.clip(2.0 * outward - 1.0, 0.0, 1.0)
    blend = t * t * (3.0 - 2.0 * t)
    height = polynomial.polyval(grid / half, fit) * (1.0 - blend) + ink * blend
    between = middle + np.column_stack((grid, height)) @ frame.T
    return _cut(a, b, length, between)


def _bend(parabola: Array) -> float:
    """Return the curvature at the start of a parabola, to the left positive."""
    (dx, dy), (ddx, ddy) = parabola[1], 2.0 * parabola[2]
    return float((dx * ddy - dy * ddx) / max(np.hypot(dx, dy) ** 3, 1e-12))


def _arch(a: Array, b: Array, end: Array, start: Array, length: float) -> Joint | None:
    """Lead over a long gap by a cubic in the directions of the ink on both sides.

    None where that is not roughly where it has to go.
    """
    if _gap(a, b) > WIDEST_GAP:
        return None
    cut = 2.0 * LANDING * length
    (begin, leave), (finish, arrive) = _at(end, cut), _at(start, cut)
    leave = -leave
    chord = finish - begin
    gap = float(np.hypot(chord[0], chord[1]))
    if min(leave @ chord, arrive @ chord) < ARCHED * gap:
        return None
    t = np.linspace(0.0, 1.0, int(np.ceil(gap / SPACING)) + 2)[:, None]
    between = (
        (1 + 2 * t) * (1 - t) ** 2 * begin
        + t * (1 - t) ** 2 * gap * leave
        + t**2 * (3 - 2 * t) * finish
        - t**2 * (1 - t) * gap * arrive
    )
    return _cut(a, b, cut, between)


def _at(parabola: Array, along: float) -> tuple[Array, Array]:
    """Return the place and the unit direction of a parabola at an arc length."""
    place = parabola[0] + along * (parabola[1] + along * parabola[2])
    way = parabola[1] + 2.0 * along * parabola[2]
    return place, way / np.linalg.norm(way)


def _cut(a: Array, b: Array, length: float, between: Array) -> Joint:
    """Return the joint with ink of a length cut off at both ends."""
    arc_a, arc_b = arc_length(a), arc_length(b)
    before = a[: max(int(np.searchsorted(arc_a, arc_a[-1] - length)), 1)]
    return Joint(before, b[int(np.searchsorted(arc_b, length, side="right")) :], between)


def _corner(a: Array, b: Array) -> Array:
    """Return the corner that both lines head for, if the gap is only what was missed of it."""
    gap = _gap(a, b)
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
    gap = _gap(a, b)
    back, arc_a, arc_b = a[::-1], arc_length(a[::-1]), arc_length(b)
    end, start = _parabola(back, arc_a, length), _parabola(b, arc_b, length)
    if end is None or start is None:
        return None
    ways = np.column_stack((-end[1] / np.hypot(*end[1]), start[1] / np.hypot(*start[1])))
    turn = float(np.linalg.det(ways))
    if abs(turn) < SHARP:
        return None
    if (_bend(start) - _bend(end)) * length * np.sign(turn) > ROUND:
        return None
    missed = np.linalg.solve(ways, b[0] - a[-1])
    if not (0.0 < missed.min() and missed.max() < 1.5 * gap):
        return None
    return np.asarray(a[-1] + missed[0] * ways[:, 0])
