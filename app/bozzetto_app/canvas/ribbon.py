"""Ribbons: how ink of varying width becomes an area without jags, gaps or seams.

The sampled points are followed by a chain of parabolas (through the midpoints, with the
samples as control points), fine enough that no corner shows; the outline at half the width
on both sides is filled as one path. One filled path has clean edges; a row of thick lines
would darken its own edges wherever two of them overlap.
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

FINE_STEP: Final = 3.0
"""Length of the straight pieces of a smooth line, pixels."""

MOST_PIECES: Final = 24
"""Straight pieces between two samples at most."""

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
    """Turns samples into a smooth line as they come."""

    def __init__(self) -> None:
        self._last: InkPoint | None = None
        self._middle: InkPoint | None = None

    def push(self, point: InkPoint) -> list[InkPoint]:
        """Add a sample; return the points that are now final, oldest first."""
        last, start = self._last, self._middle
        if last is None or start is None:
            self._last = self._middle = point
            return [point]
        end = (
            0.5 * (last[0] + point[0]),
            0.5 * (last[1] + point[1]),
            0.5 * (last[2] + point[2]),
        )
        length = math.hypot(last[0] - start[0], last[1] - start[1]) + math.hypot(
            end[0] - last[0], end[1] - last[1]
        )
        pieces = min(max(int(length / FINE_STEP) + 1, 1), MOST_PIECES)
        made = []
        for i in range(1, pieces + 1):
            s = i / pieces
            a, b, c = (1 - s) * (1 - s), 2 * s * (1 - s), s * s
            made.append(
                (
                    a * start[0] + b * last[0] + c * end[0],
                    a * start[1] + b * last[1] + c * end[1],
                    a * start[2] + b * last[2] + c * end[2],
                )
            )
        self._last, self._middle = point, end
        return made

    @property
    def tip(self) -> InkPoint | None:
        """The newest sample, to which the line will be drawn."""
        return self._last


def smoothed(points: Iterable[InkPoint]) -> list[InkPoint]:
    """The smooth line through a whole stroke, from its first to its last sample."""
    smoother = Smoother()
    line = [fine for point in points for fine in smoother.push(point)]
    if smoother.tip is not None:
        line.append(smoother.tip)
    return line


def ribbon_path(
    line: Sequence[InkPoint], *, open_start: bool = False, open_end: bool = False
) -> QPainterPath:
    """The area of a line, with round ends and round sharp corners.

    Parameters
    ----------
    line : sequence of (x, y, width)
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
    """What closes an outline beyond its last point: a half disc, or a short reach."""
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
