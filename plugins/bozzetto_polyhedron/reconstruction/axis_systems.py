"""Orthogonal axes that the lines of a drawing run along.

Algorithm 1 of Masry et al. 2004 begins like this: peaks of a histogram of the angles, weighted by
length, are taken by threes as the pictures of three orthogonal axes. Here a triple is refined as a
rotation, so that it stays orthogonal exactly, together with the perspective of the drawing; what
it does not explain is searched for a further system.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from scipy.optimize import least_squares

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.reconstruction.drawing import Drawing, drawing_of
from bozzetto_polyhedron.reconstruction.metric_upgrade import orthogonal_rises
from bozzetto_polyhedron.reconstruction.parallel_classes import angle_between, angle_deviations

BINS: Final = 180
"""Angles at which the histogram is evaluated."""

BLUR: Final = np.radians(4.0)
"""Standard deviation by which each line is spread in the histogram."""

MOST_PEAKS: Final = 7
"""Peaks of which triples are tried."""

EXPLAINED: Final = np.radians(5.0)
"""Angle from an axis, beyond the noise, up to which a line is explained."""

CUBIC: Final = 0.75
"""Cost that is saved for each line where all corners are those of a box."""

STEADY: Final = np.radians(3.0)
"""Standard deviation of a line from its peak, beside that of the hand."""

SHARED: Final = 0.25
"""Weight of lines that an earlier system explains: a turned block often shares an axis with it."""

REFINED: Final = 4
"""Triples that are refined."""

TOWARDS_EYE: Final = 0.985
"""Largest part of an axis along the line of sight."""

LEAST_LINES: Final = 4
"""Lines that a system is fitted to at least."""

MOST_SYSTEMS: Final = 3
"""Systems that are looked for."""

LEAST_SHARE: Final = 0.15
"""Share of the length of all lines that a further system explains at least."""


@dataclass(frozen=True, eq=False)
class AxisSystem:
    """Three orthogonal axes, and the lines along them.

    Parameters
    ----------
    axes : (3, 3) float64
        Rows: unit vectors right, up and away from the eye. The mirrored reading has the last
        column negative.
    lines : (m,) intp
        Axis of each line, -1 for those that run along none.
    share : float
        Share of the length of all lines that runs along the axes, 0 … 1.
    perspective : float
        Reciprocal of the distance of the eye, 1/diagonal; 0 for a parallel view.
    cost : float
        Sum of squared robust residuals: what perspective is judged by.
    """

    axes: Array
    lines: Array
    share: float
    perspective: float
    cost: float


def axis_systems(graph: LineGraph) -> tuple[AxisSystem, ...]:
    """Find the axis systems of a drawing, the one that explains most first.

    Parameters
    ----------
    graph : LineGraph
        Corners and lines.

    Returns
    -------
    tuple of AxisSystem
        At most three; empty where no three directions look like orthogonal axes.
    """
    drawing = drawing_of(graph)
    weights = np.ones(len(drawing.lines))
    found: list[AxisSystem] = []
    while len(found) < MOST_SYSTEMS:
        system = axis_system(drawing, weights, perspective=False)
        if system is None:
            break
        new = (system.lines >= 0) & (weights == 1.0)
        if drawing.lengths[new].sum() < LEAST_SHARE * drawing.lengths.sum():
            break
        found.append(system)
        weights = np.where(new, SHARED, weights)
    return tuple(sorted(found, key=lambda each: -each.share))


def axis_system(
    drawing: Drawing, weights: Array, *, perspective: bool, starts: Sequence[float] = (0.0,)
) -> AxisSystem | None:
    """Fit one system of orthogonal axes to some of the lines.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    weights : (m,) array
        How much each line counts.
    perspective : bool
        Whether the distance of the eye is fitted as well.
    starts : sequence of float
        Perspectives from which the fit starts, or at which it stays.
    """
    if weights.sum() < LEAST_LINES:
        return None
    best: AxisSystem | None = None
    least = np.inf
    for start in starts:
        for axes in _frames(drawing, weights, start)[:REFINED]:
            system = _refined(drawing, weights, axes, start, perspective)
            corners = _cubic_corners(drawing, weights, system.lines)
            value = system.cost - CUBIC * float(weights.sum()) * corners
            if value < least:
                best, least = system, value
    return best


def directions_at(axes: Array, perspective: float, places: Array) -> Array:
    """Return the angle of each axis at places of the sheet, (k, 3), radians.

    An axis A is seen at a place q in the direction A_xy - k A_z q.

    Parameters
    ----------
    axes : (3, 3) array
        Rows: unit vectors.
    perspective : float
        1/diagonal.
    places : (k, 2) array
        Diagonals.
    """
    seen = axes[None, :, :2] - perspective * axes[None, :, 2:] * places[:, None]
    return np.asarray(np.arctan2(seen[..., 1], seen[..., 0]))


def _frames(drawing: Drawing, weights: Array, perspective: float) -> list[Array]:
    """Return frames whose axes are seen at three peaks of the histogram, the best first."""
    spans, lengths = drawing.spans, drawing.lengths * weights
    steady = np.hypot(STEADY, angle_deviations(drawing)) * (1.0 + 2.0 * perspective)
    angles = np.arctan2(spans[:, 1], spans[:, 0]) % np.pi
    found: list[tuple[float, Array]] = []
    blur = BLUR * (1.0 + 2.0 * perspective)
    for triple in combinations(_peaks(angles, lengths, blur), 3):
        seen = np.array(triple)
        flat = np.column_stack((np.cos(seen), np.sin(seen)))
        rises = orthogonal_rises(flat)
        if rises is None:
            continue
        axes = np.column_stack((flat, rises))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        if np.abs(axes[:, 2]).max() > TOWARDS_EYE:
            continue
        turned = angle_between(angles[:, None], seen[None])
        off = turned.min(1)
        axis = np.where(off < 2.0 * steady, turned.argmin(1), -1)
        near = np.exp(-0.5 * (off / steady) ** 2)
        score = lengths @ near / lengths.sum() + weights @ near / weights.sum()
        found.append((float(score) + _cubic_corners(drawing, weights, axis), axes))
    frames = [axes for _, axes in sorted(found, key=lambda each: -each[0])]
    if perspective == 0.0:
        return frames
    return [side for axes in frames for side in (axes, axes * (1.0, 1.0, -1.0))]


def _cubic_corners(drawing: Drawing, weights: Array, axis: Array) -> float:
    """Return the share of corners at which lines along all three axes meet."""
    count = np.zeros((len(drawing.points), 3))
    weight = np.zeros(len(drawing.points))
    for end in drawing.lines.T:
        np.maximum.at(weight, end, weights)
        along = axis >= 0
        count[end[along], axis[along]] = 1.0
    return float(weight @ count.all(1) / weight.sum())


def _peaks(angles: Array, lengths: Array, blur: float) -> list[float]:
    """Return the angles at which a blurred histogram has its largest peaks."""
    grid = np.arange(BINS) * np.pi / BINS
    spread = np.exp(-0.5 * (angle_between(grid[:, None], angles[None]) / blur) ** 2) @ lengths
    top = (spread >= np.roll(spread, 1)) & (spread > np.roll(spread, -1))
    peaks = np.flatnonzero(top)
    order = np.argsort(-spread[peaks], kind="stable")[:MOST_PEAKS]
    return [float(grid[peak]) for peak in peaks[order]]


def _refined(
    drawing: Drawing, weights: Array, axes: Array, start: float, perspective: bool
) -> AxisSystem:
    """Turn a frame, and move the eye, so that lines run along the axes; wrong ones count little."""
    places = (drawing.points[drawing.lines[:, 0]] + drawing.points[drawing.lines[:, 1]]) / 2.0
    spans = drawing.spans
    angles = np.arctan2(spans[:, 1], spans[:, 0])
    scale = 3.0 * angle_deviations(drawing)

    def off(values: Array) -> Array:
        eye = float(values[3]) if perspective else start
        seen = directions_at(axes @ _rotation(values[:3]), eye, places)
        turned = (angles[:, None] - seen + np.pi / 2.0) % np.pi - np.pi / 2.0
        nearest = np.abs(turned).argmin(1)
        return np.asarray(turned[np.arange(len(turned)), nearest])

    def residuals(values: Array) -> Array:
        robust = np.sqrt(weights) * np.tanh(off(values) / scale)
        return np.append(robust, 0.05 * values[3]) if perspective else robust

    first = np.append(np.zeros(3), start) if perspective else np.zeros(3)
    solved = least_squares(residuals, first, method="lm", max_nfev=150)
    found = axes @ _rotation(solved.x[:3])
    eye = float(solved.x[3]) if perspective else start
    if eye < 0.0:
        found, eye = found * (1.0, 1.0, -1.0), -eye
    seen = directions_at(found, eye, places)
    turned = angle_between(angles[:, None], seen)
    explained = turned.min(1) < np.hypot(EXPLAINED / 2.0, scale)
    along = np.where(explained, turned.argmin(1), -1)
    share = drawing.lengths[explained].sum() / drawing.lengths.sum()
    return AxisSystem(found, along, float(share), eye, float(2.0 * solved.cost))


def _rotation(turn: Array) -> Array:
    """Return the rotation matrix about a vector by its length (Rodrigues)."""
    angle = float(np.linalg.norm(turn))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = turn / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)
