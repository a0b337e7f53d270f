"""Ribbons: how ink of varying width becomes an area without jags, gaps or seams.

What is shown is what is kept: the straight pieces between the samples, with their corners
rounded by less than the line is wide. A dense stroke looks smooth, and a sparse one sparse. The
outline at half the width on both sides is filled as one path. One filled path has clean edges; a
row of thick lines would darken its own edges wherever two of them overlap.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Final

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainterPath, QPolygonF

__all__ = ["InkPoint", "Smoother", "ribbon_path", "smoothed"]

InkPoint = tuple[float, float, float]
"""x, y and width, pixels."""

CORNER: Final = 2.0
"""How far from a sample its rounded corner begins and ends at most, pixels.

The line passes a sample at half of that at most, one pixel, a quarter of its full width.
"""

FINE_STEP: Final = 2.0
"""Length of a rounded corner beyond which it is made of two pieces, pixels."""

SHARP_CORNER: Final = math.cos(math.radians(50.0))
"""Cosine of the turn beyond which a line has a round corner instead of a mitre."""

JOINT: Final = 0.4
"""How far a ribbon reaches over a joint, pixels."""

ROUND: Final = math.inf
"""Stands for a round end."""

HALF_DISC: Final = tuple(
    (math.cos(math.pi * i / 10.0), math.sin(math.pi * i / 10.0)) for i in range(1, 10)
)

SAME_PLACE: Final = 0.05
"""Distance below which two points of a line count as one, pixels."""


class Smoother:
    """Rounds the corners of the line through the samples as they come."""

    def __init__(self) -> None:
        self._last: InkPoint | None = None
        self._before: InkPoint | None = None

    def push(self, point: InkPoint) -> list[InkPoint]:
        """Add a sample; return the points that are now final, oldest first."""
        before, last = self._before, self._last
        if last is not None and math.dist(last[:2], point[:2]) < SAME_PLACE:
            # A pause is no corner, and has no direction; it may be pressed harder.
            self._last = (*last[:2], point[2])
            return []
        self._before, self._last = last, point
        if last is None:
            return [point]
        return [] if before is None else _corner(before, last, point)

    @property
    def tip(self) -> InkPoint | None:
        """The newest sample, to which the line will be drawn."""
        return self._last


def _corner(before: InkPoint, at: InkPoint, after: InkPoint) -> list[InkPoint]:
    """Return a parabola around a sample that ends on the straight lines to its neighbours."""
    start, end = _towards(at, before), _towards(at, after)
    length = math.dist(start[:2], at[:2]) + math.dist(at[:2], end[:2])
    pieces = 1 if length <= FINE_STEP else 2  # never longer than twice CORNER
    made = []
    for i in range(pieces + 1):
        s = i / pieces
        a, b, c = (1 - s) * (1 - s), 2 * s * (1 - s), s * s
        x, y, width = (a * p + b * q + c * r for p, q, r in zip(start, at, end, strict=True))
        made.append((x, y, width))
    return made


def _towards(point: InkPoint, other: InkPoint) -> InkPoint:
    """Return the point where a corner ends: half way to the next sample, or at `CORNER`."""
    share = min(0.5, CORNER / math.dist(point[:2], other[:2]))
    x, y, width = (p + share * (q - p) for p, q in zip(point, other, strict=True))
    return x, y, width


def smoothed(points: Iterable[InkPoint]) -> list[InkPoint]:
    """Return the line of a whole stroke with rounded corners, from first to last sample."""
    smoother = Smoother()
    line = [fine for point in points for fine in smoother.push(point)]
    if smoother.tip is not None:
        line.append(smoother.tip)
    return line


def ribbon_path(
    line: Sequence[InkPoint], *, open_start: bool = False, open_end: bool = False
) -> QPainterPath:
    """Return the area of a line, with round ends and round sharp corners.

    Parameters
    ----------
    line : sequence of (x, y, width)
        Points of the line with its width at each, pixels.
    open_start, open_end : bool
        The end is a joint with a ribbon painted before or after: instead of a round cap it
        reaches `JOINT` pixels into the other one, which leaves neither a gap nor a bead.
    """
    path = QPainterPath()
    path.setFillRule(Qt.FillRule.WindingFill)
    kept = [line[0]] if line else []
    for point in line[1:]:
        if math.hypot(point[0] - kept[-1][0], point[1] - kept[-1][1]) > SAME_PLACE:
            kept.append(point)
    if len(kept) < 2:
        if kept and not open_start:
            _add_disc(path, kept[0])
        return path
    directions = []
    for (x0, y0, _), (x1, y1, _) in pairwise(kept):
        length = math.hypot(x1 - x0, y1 - y0)
        directions.append(((x1 - x0) / length, (y1 - y0) / length))
    begin = 0
    for i in range(1, len(directions)):
        (ux, uy), (vx, vy) = directions[i - 1], directions[i]
        if ux * vx + uy * vy < SHARP_CORNER:
            start = JOINT if begin or open_start else ROUND
            _add_run(path, kept[begin : i + 1], directions[begin:i], start, JOINT)
            _add_disc(path, kept[i])
            begin = i
    start = JOINT if begin or open_start else ROUND
    _add_run(path, kept[begin:], directions[begin:], start, JOINT if open_end else ROUND)
    return path


def _add_disc(path: QPainterPath, point: InkPoint) -> None:
    radius = 0.5 * point[2]
    path.addEllipse(QPointF(point[0], point[1]), radius, radius)


def _add_run(
    path: QPainterPath,
    points: Sequence[InkPoint],
    directions: Sequence[tuple[float, float]],
    start: float,
    end: float,
) -> None:
    """One outline along a run without sharp corners, clockwise on the sheet as discs are."""
    left, right = [], []
    last = len(directions) - 1
    for i, (x, y, width) in enumerate(points):
        ux, uy = directions[max(i - 1, 0)]
        vx, vy = directions[min(i, last)]
        tx, ty = ux + vx, uy + vy
        half = 0.5 * width / math.hypot(tx, ty)
        left.append(QPointF(x + ty * half, y - tx * half))
        right.append(QPointF(x - ty * half, y + tx * half))
    ahead, behind = directions[-1], (-directions[0][0], -directions[0][1])
    right.reverse()
    outline = left + _end(points[-1], ahead, end) + right + _end(points[0], behind, start)
    path.addPolygon(QPolygonF(outline))
    path.closeSubpath()


def _end(point: InkPoint, ahead: tuple[float, float], kind: float) -> list[QPointF]:
    """Return the points that close an outline beyond its end: a half disc, or a short reach."""
    (x, y, width), (ux, uy) = point, ahead
    half = 0.5 * width
    if kind != ROUND:
        return [
            QPointF(x + kind * ux + half * uy, y + kind * uy - half * ux),
            QPointF(x + kind * ux - half * uy, y + kind * uy + half * ux),
        ]
    return [
        QPointF(x + half * (s * ux + c * uy), y + half * (s * uy - c * ux)) for c, s in HALF_DISC
    ]
