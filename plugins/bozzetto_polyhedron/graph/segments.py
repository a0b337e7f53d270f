"""From strokes to straight segments: split at their corners, bows taken out, curves set aside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index
from bozzetto.plugin import cached_property

SAMPLES: Final = 48
"""Samples at equal steps by which a stroke is looked at, at least."""

STEP: Final = 0.006
"""Shares of the diagonal between samples of a long stroke: a short edge in it has several."""

MOST_SAMPLES: Final = 320
"""Samples of the longest stroke."""

SLACK: Final = 0.02
"""Shares of the diagonal by which any stroke may leave its chord and is still a line: a hand that
means a line bows by 0.6 % on average."""

BOW: Final = 0.05
"""Share of its length by which a stroke may leave its chord and is still a line."""

DEEPEST_BOW: Final = 0.12
"""Share of the length up to which a stroke without corners is taken for a bowed line."""

DEEPEST_SLACK: Final = 0.035
"""Shares of the diagonal up to which a stroke without corners is taken for a bowed line."""

MOST_PIECES: Final = 12
"""Most pieces of one stroke: once round a face like an H."""

LEAST_SPREAD, SPREAD = 0.0025, 0.004
"""Root mean square distance of a straight run from its line: shares of the diagonal, and of its
length beside that."""

LEAST_RUN, FARTHEST = 3, 8
"""Samples of a run at least, and how far a corner moves at most to where it is sharpest."""

AT_CORNER: Final = 0.012
"""Shares of the diagonal beside a corner along which its turn is measured, at least."""

SHARPEST_CORNER: Final = 0.6
"""Share of the turn between two pieces that takes place close to where they meet, for a corner; on
an arc it is under a half."""

LEAST_TURN: Final = np.radians(15.0)
"""Turn (radians) under which two pieces are one."""

LEAST_BEND: Final = np.radians(13.0)
"""Turn (radians) of a stroke beside the end of another one from which on it is a corner: the halves
of a bowed line seldom differ by more."""

BESIDE: Final = 0.02
"""Distance of such an end from the stroke, in shares of the diagonal, at most."""

LEAST_HALF: Final = 0.03
"""Length of both halves of such a stroke, in shares of the diagonal: dashes shake as much."""

HOOK: Final = 0.08
"""Share of a stroke's length under which a piece at its end is a slip of the pen."""

LONGEST_HOOK: Final = 0.03
"""Shares of the diagonal from which on it is none: it is the last edge of several."""

THERE_AND_BACK: Final = 1.3
"""Length of a straight run, in distances of its ends, from which on it was drawn to and fro."""

LIGHT_PRESSURE: Final = 0.75
"""Pressure, in shares of the median along all ink, under which a stroke is a light one."""

CLEARLY_TWO: Final = 4.0
"""Difference of two pressures, in standard deviations within each, from which on they are two: the
halves of a uniform distribution differ by 3.5, those of a normal one by 2.7."""

SHORTEST: Final = 0.004
"""Shares of the diagonal under which a stroke is a dot."""


class Drawn(Protocol):
    """A stroke, as `bozzetto.ink.Stroke` is one."""

    @property
    def points(self) -> Array:
        """Samples, shape (n, 2), canvas pixels."""
        ...

    @property
    def pressure(self) -> ArrayLike:
        """Of each sample, 0 … 1."""
        ...

    @property
    def t(self) -> ArrayLike:
        """Of each sample, seconds."""
        ...


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight pieces of strokes.

    Parameters
    ----------
    ends : (k, 2, 2) float64
        Both ends of each.
    pressure : (k,) float64
        Mean pressure of the stroke.
    strokes : (k,) intp
        Number of the stroke of each, in the order drawn.
    bow : (k,) float64
        How far the stroke leaves the straight line between the ends, at most.
    """

    ends: Array
    pressure: Array
    strokes: Index
    bow: Array

    def __len__(self) -> int:
        return len(self.ends)

    @property
    def lengths(self) -> Array:
        """Of each, (k,)."""
        made: Array = np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=1)
        return made

    @cached_property
    def light(self) -> Flags:
        """Which ones were drawn lightly, told by pressure, (k,).

        Where there are clearly two pressures it is the lower one, of however much ink; otherwise
        what is far below the median along all ink.
        """
        if not len(self):
            return np.zeros(0, bool)
        low, high, within = _two_pressures(self.pressure, self.lengths)
        if low < LIGHT_PRESSURE * high and high - low > CLEARLY_TWO * within:
            return np.asarray(self.pressure < (low + high) / 2.0)
        order = np.argsort(self.pressure, kind="stable")
        ink = np.cumsum(self.lengths[order])
        middle = float(self.pressure[order][int(np.searchsorted(ink, ink[-1] / 2))])
        return np.asarray(self.pressure < LIGHT_PRESSURE * max(middle, 1e-3))

    def scaled(self, size: float, origin: Array) -> Segments:
        """Return the segments as seen from `origin`, lengths in units of `size`."""
        return Segments((self.ends - origin) / size, self.pressure, self.strokes, self.bow / size)


@dataclass(frozen=True, eq=False)
class Pieces:
    """One stroke in straight pieces, in pixels.

    Parameters
    ----------
    ends : (k, 2, 2) float64
    bow : (k,) float64
    pressure : float
    curved : bool
        Whether the stroke is neither a line nor made of lines; it has no pieces then.
    middle : (2,) float64
        A place on the stroke.
    """

    ends: Array
    bow: Array
    pressure: float
    curved: bool
    middle: Array


def samples_of(stroke: Drawn) -> Array:
    """Return the samples of a stroke that are finite, (n, 2) px.

    Parameters
    ----------
    stroke : Drawn
        One stroke.
    """
    points = np.asarray(stroke.points, float).reshape(-1, 2)
    kept: Array = points[np.isfinite(points).all(1)]
    return kept


def pieces_of(stroke: Drawn, size: float, ends: Array) -> Pieces:
    """Split a stroke at its corners into straight pieces.

    Parameters
    ----------
    stroke : Drawn
        One stroke.
    size : float
        Diagonal of the drawing, px.
    ends : (n, 2) float64
        Where other strokes end, px: a bend is a corner there.
    """
    points = samples_of(stroke)
    pressure = np.asarray(stroke.pressure, float)
    mean = float(pressure.mean()) if pressure.size else 0.5
    if not np.isfinite(mean):
        mean = 0.5
    path = _resampled(points, size)
    if path is None or _path_length(path) < SHORTEST * size:
        place = points.mean(0) if len(points) else np.zeros(2)
        return Pieces(np.zeros((0, 2, 2)), np.zeros(0), mean, False, place)
    middle = path[len(path) // 2]
    runs = _cut_at_ends(path, size, _straight_runs(path, size), ends)
    if runs is None:
        return Pieces(np.zeros((0, 2, 2)), np.zeros(0), mean, True, middle)
    fitted = [_chord(path[first : last + 1]) for first, last in runs]
    ends = np.array([each[0] for each in fitted])
    long = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) >= SHORTEST * size / 2
    return Pieces(ends[long], np.array([each[1] for each in fitted])[long], mean, False, middle)


def segments_of(pieces: Sequence[Pieces]) -> Segments:
    """Put the pieces of all strokes in one table."""
    counts = [len(each.ends) for each in pieces]
    return Segments(
        np.concatenate([np.zeros((0, 2, 2)), *(each.ends for each in pieces)]),
        np.repeat([each.pressure for each in pieces], counts).astype(float),
        np.repeat(np.arange(len(pieces)), counts).astype(np.intp),
        np.concatenate([np.zeros(0), *(each.bow for each in pieces)]),
    )


def _resampled(points: Array, size: float) -> Array | None:
    """Return samples at equal steps along the stroke; None for a dot."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    kept = np.concatenate([[True], steps > 0])[: len(points)]
    points = points[kept]
    if len(points) < 2:
        return None
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if not 0 < at[-1] < np.inf:
        return None
    count = int(min(max(at[-1] / (STEP * size), SAMPLES), MOST_SAMPLES))
    wanted = np.linspace(0.0, at[-1], count)
    return np.column_stack([np.interp(wanted, at, column) for column in points.T])


def _path_length(path: Array) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def is_curved(stroke: Drawn, size: float) -> bool:
    """Return whether a stroke is neither a line nor made of lines.

    Parameters
    ----------
    stroke : Drawn
        One stroke.
    size : float
        Diagonal of the drawing, px.
    """
    path = _resampled(samples_of(stroke), size)
    if path is None or _path_length(path) < SHORTEST * size:
        return False
    return _straight_runs(path, size) is None


def _straight_runs(path: Array, size: float) -> list[tuple[int, int]] | None:
    """First and last sample of each straight run of a stroke; None if it is curved."""
    whole = [(0, len(path) - 1)]
    length = float(np.linalg.norm(path[-1] - path[0]))
    away = _deviation(path)
    if away <= max(SLACK * size, BOW * length) and _path_length(path) < 1.5 * length:
        return whole
    runs = _joined(path, size, _without_hooks(path, size, _polyline(path, size)))
    if len(runs) == 1 or (runs and _are_corners(path, size, runs)):
        return runs
    deepest = max(DEEPEST_SLACK * size, DEEPEST_BOW * length)
    if away <= deepest and _path_length(path) < 1.5 * length:
        return whole
    return None


def _cut_at_ends(
    path: Array, size: float, runs: list[tuple[int, int]] | None, ends: Array
) -> list[tuple[int, int]] | None:
    """Cut runs in two where they bend beside the end of another stroke; None if still curved.

    Traced ink goes on through corners of which the edges bow so that nothing turns sharply there.
    """
    count = len(path)
    close = _apart_squared(path, ends).min(1, initial=np.inf) < (BESIDE * size) ** 2
    beside = np.flatnonzero(close)
    cost: Array | None = None
    made: list[tuple[int, int]] = []
    for first, last in runs or [(0, count - 1)]:
        away = _apart_squared(path[beside], path[[first, last]]).min(1) > (LEAST_HALF * size) ** 2
        inner = beside[(beside > first + 2) & (beside < last - 2) & away]
        if not len(inner):
            made.append((first, last))
            continue
        cost = line_costs(path) if cost is None else cost
        corner = int(inner[int((cost[first, inner] + cost[inner, last]).argmin())])
        halves = [(first, corner), (corner, last)]
        before, after = (_direction(path[a : b + 1]) for a, b in halves)
        straight = all(_straight_runs(path[a : b + 1], size) == [(0, b - a)] for a, b in halves)
        bends = _angle(before, after) >= LEAST_BEND and (
            cost[first, corner] + cost[corner, last] < _bow_cost(path[first : last + 1])
        )
        made += halves if straight and bends else [(first, last)]
    return made if runs or len(made) > 1 else None


def _apart_squared(points: Array, others: Array) -> Array:
    """Return squared distances of points, (n, 2), from others, (m, 2), as (n, m)."""
    x, y = points[:, :1] - others[:, 0], points[:, 1:] - others[:, 1]
    return np.asarray(x * x + y * y)


def _bow_cost(path: Array) -> float:
    """Return the sum of squared distances of a run from the parabola nearest to it, across it."""
    away = path - path.mean(0)
    x, y = np.linalg.svd(away, full_matrices=False)[2] @ away.T
    base = np.linalg.qr(np.column_stack((np.ones_like(x), x, x * x)))[0]
    return float(y @ y - ((y @ base) ** 2).sum())


def _direction(path: Array) -> Array:
    """Return the direction of the line nearest to a run, (2,), the way that it goes."""
    along: Array = np.linalg.svd(path - path.mean(0), full_matrices=False)[2][0]
    return along if along @ (path[-1] - path[0]) >= 0.0 else -along


def _deviation(path: Array) -> float:
    """Return how far samples are from the line through the first and the last one, at most."""
    chord = path[-1] - path[0]
    length = float(np.hypot(*chord))
    away = path - path[0]
    if length == 0.0:
        return float(np.linalg.norm(away, axis=1).max())
    return float(np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0]).max() / length)


def _polyline(path: Array, size: float) -> list[tuple[int, int]]:
    """Fit the fewest straight runs, each as straight as a line of its length; none if too many.

    A tolerance of the whole stroke would take short edges of a long one for slips of the pen.
    """
    count = len(path)
    rows, columns = np.indices((count, count))
    spans = np.maximum(columns - rows, 1)
    spread = LEAST_SPREAD * size + SPREAD * spans * (_path_length(path) / (count - 1))
    cost = line_costs(path) / ((spans + 1) * spread**2)
    cost[cost > 1.0] = np.inf
    best = cost[0]
    came: list[Index] = []
    while not np.isfinite(best[-1]):
        if len(came) == MOST_PIECES - 1:
            return []
        through = best[:, None] + cost
        came.append(through.argmin(0))
        best = through.min(0)
    corners = [count - 1]
    for back in reversed(came):
        corners.append(int(back[corners[-1]]))
    return list(pairwise(_between_bows(path, [0, *corners[::-1]])))


def _between_bows(path: Array, corners: list[int]) -> list[int]:
    """Move each corner a little, to where the runs beside it are two parabolas most nearly.

    A long run may be farther off in each sample than a short one, and takes samples of it; and a
    bowed one turns beside its ends.

    Parameters
    ----------
    path : (n, 2) float64
        Samples of the stroke.
    corners : list of int
        Ends of all runs, the first and the last sample included.
    """
    moved = list(corners)
    for k in range(1, len(corners) - 1):
        before, corner, after = moved[k - 1], corners[k], corners[k + 1]
        costs = {
            at: _bow_cost(path[before : at + 1]) + _bow_cost(path[at : after + 1])
            for at in range(
                max(before + LEAST_RUN, corner - FARTHEST),
                min(after - LEAST_RUN, corner + FARTHEST) + 1,
            )
        }
        moved[k] = min(costs, key=costs.__getitem__, default=corner)
    return moved


def _joined(path: Array, size: float, runs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Join runs that hardly turn and that by themselves would be one bowed line."""
    made: list[tuple[int, int]] = []
    for first, last in runs:
        if made:
            begin, corner = made[-1]
            both = path[begin : last + 1]
            turn = _angle(path[corner] - path[begin], path[last] - path[corner])
            length = float(np.linalg.norm(both[-1] - both[0]))
            if turn < LEAST_TURN and _deviation(both) <= max(SLACK * size, BOW * length):
                made[-1] = (begin, last)
                continue
        made.append((first, last))
    return made


def line_costs(path: Array) -> Array:
    """Return sums of squared distances of samples i … j from their principal axis, (n, n)."""
    values = np.column_stack([np.ones(len(path)), path, path**2, path[:, 0] * path[:, 1]])
    sums = np.vstack([np.zeros(6), np.cumsum(values, axis=0)])
    each = sums[None, 1:] - sums[:-1, None]
    n = np.maximum(each[..., 0], 1.0)
    xx = each[..., 3] - each[..., 1] ** 2 / n
    yy = each[..., 4] - each[..., 2] ** 2 / n
    xy = each[..., 5] - each[..., 1] * each[..., 2] / n
    least = (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2)
    rows, columns = np.indices(least.shape)
    return np.where(columns - rows >= 2, np.maximum(least, 0.0), np.inf)


def _without_hooks(path: Array, size: float, runs: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Drop runs at both ends that are only a slip of the pen."""
    step = _path_length(path) / (len(path) - 1)
    least = min(HOOK * len(path), LONGEST_HOOK * size / step)
    while len(runs) > 1 and runs[0][1] - runs[0][0] < least:
        runs = runs[1:]
    while len(runs) > 1 and runs[-1][1] - runs[-1][0] < least:
        runs = runs[:-1]
    return runs


def _are_corners(path: Array, size: float, runs: list[tuple[int, int]]) -> bool:
    """Whether all runs meet in corners: most of the turn takes place close to them."""
    step = _path_length(path) / (len(path) - 1)
    least = max(2, round(AT_CORNER * size / step))
    for (first, corner), (_, last) in pairwise(runs):
        near = max(least, min(corner - first, last - corner) // 4)
        turn = _angle(path[corner] - path[first], path[last] - path[corner])
        here = _angle(
            path[max(corner - 1, 0)] - path[max(corner - 1 - near, 0)],
            path[min(corner + 1 + near, len(path) - 1)] - path[min(corner + 1, len(path) - 1)],
        )
        if turn < LEAST_TURN or here < SHARPEST_CORNER * turn:
            return False
    return True


def _angle(one: Array, other: Array) -> float:
    """Return the angle between two directions, radians, 0 … π."""
    cross = one[0] * other[1] - one[1] * other[0]
    return float(abs(np.arctan2(cross, one @ other)))


def _chord(path: Array) -> tuple[Array, float]:
    """Both ends of a parabola fitted to a run, and how far it bows.

    The ends of a bowed stroke are where its maker aimed; its principal axis is shifted by
    two thirds of the bow.
    """
    chord = path[-1] - path[0]
    if _path_length(path) > THERE_AND_BACK * np.hypot(*chord):
        chord = path[int(np.linalg.norm(path - path[0], axis=1).argmax())] - path[0]
    length = float(np.hypot(*chord))
    if length == 0.0:
        return np.stack([path[0], path[-1]]), 0.0
    along = chord / length
    across = np.array([-along[1], along[0]])
    x = (path - path[0]) @ along / length
    y = (path - path[0]) @ across
    degree = 2 if len(path) > 4 else 1
    fitted = np.polynomial.Polynomial.fit(x, y, degree, domain=[0.0, 1.0])
    low, high = float(x.min()), float(x.max())
    ends = [path[0] + along * at * length + across * float(fitted(at)) for at in (low, high)]
    bow = float(
        np.abs(
            fitted(np.linspace(low, high, 9))
            - np.interp(np.linspace(0, 1, 9), [0, 1], fitted(np.array([low, high])))
        ).max()
    )
    return np.array(ends), bow


def _two_pressures(pressure: Array, ink: Array) -> tuple[float, float, float]:
    """Return the two means that pressures are nearest to, and the deviation from them.

    The split between them leaves least of the variance, weighted by ink (Otsu 1979).
    """
    order = np.argsort(pressure, kind="stable")
    values, weights = pressure[order], np.maximum(ink[order], 1e-12)
    below, total = np.cumsum(weights)[:-1], float(weights.sum())
    sums, whole = np.cumsum(weights * values)[:-1], float(weights @ values)
    if not len(below):
        return whole / total, whole / total, 0.0
    between = sums**2 / below + (whole - sums) ** 2 / (total - below)
    split = int(between.argmax())
    within = max(0.0, float(weights @ values**2) - float(between[split])) / total
    low, high = sums[split] / below[split], (whole - sums[split]) / (total - below[split])
    return float(low), float(high), within**0.5
