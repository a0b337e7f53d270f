"""Waiting ink with which something is wrong, as the sheet shows it: dashed, with a halo."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import msgspec
import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainter, QPainterPath, QPen

from bozzetto.ink.checked_points import is_seen, seen_through
from bozzetto_app.style.theme import qcolor

if TYPE_CHECKING:
    from bozzetto.document.waiting_ink import WaitingStroke
    from bozzetto.scene.palette import Palette
    from bozzetto.view.camera import Camera

__all__ = ["MarkedLine"]

LINE: Final = 2.2
"""Width of the dashed line, pixels."""

DASHES: Final = (3.0, 2.0)
"""Dash and gap, in widths of the line."""

HALO: Final = 13.0
HALO_OPACITY: Final = 0.28
QUIET_OPACITY: Final = 0.45
"""How strong a line is that another tool has marked."""

RING: Final = 10.0
"""Radius of the ring around a wrong place, pixels."""

FARTHEST_SHOWN: Final = 8000.0
"""Ink farther than this from the sheet's corner is not painted, pixels: dashes cost by length."""

LONGEST_DASHED: Final = 100_000.0
"""A line longer than this is painted without dashes, pixels."""

Points = NDArray[np.float64]


class MarkedLine(msgspec.Struct, frozen=True, eq=False):
    """A stroke as it is seen now, and what is wrong with it.

    Parameters
    ----------
    points : (n, 2) array
        Canvas pixels.
    places : (m, 2) array
        Where it is wrong.
    is_lit : bool
        Whether the tool that marked it is in the hand; else it is shown without a halo.
    """

    points: Points
    places: Points
    is_lit: bool

    @classmethod
    def of(cls, waiting: WaitingStroke, camera: Camera, *, is_lit: bool) -> MarkedLine:
        """Return a waiting stroke as a camera sees it."""
        drawn = waiting.stroke.camera
        points = seen_through(waiting.stroke.points, drawn, camera)
        places = seen_through(np.array(waiting.places, float), drawn, camera)
        return cls(points, places[_is_near(places)], is_lit)

    def pieces(self) -> Iterator[Points]:
        """Return the parts of the line that are near the sheet."""
        near = _is_near(self.points)
        for piece in np.split(self.points, np.flatnonzero(np.diff(near)) + 1):
            if _is_near(piece[:1]).all():
                yield piece

    def paint(self, painter: QPainter, palette: Palette) -> None:
        """Paint the line, its halo and its wrong places."""
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for piece in self.pieces():
            path = _path(piece)
            if self.is_lit:
                painter.setPen(_pen(palette, HALO, HALO_OPACITY))
                painter.drawPath(path)
            ink = qcolor(palette.ink, 1.0 if self.is_lit else QUIET_OPACITY)
            pen = QPen(ink, LINE, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap)
            if np.hypot(*np.diff(piece, axis=0).T).sum() < LONGEST_DASHED:
                pen.setDashPattern(DASHES)
            painter.setPen(pen)
            painter.drawPath(path)
        if self.is_lit:
            painter.setPen(_pen(palette, 2.5, 1.0))
            painter.setBrush(qcolor(palette.warning, 0.25))
            for x, y in self.places:
                painter.drawEllipse(QPointF(x, y), RING, RING)


def _is_near(points: Points) -> NDArray[np.bool_]:
    near = is_seen(points)
    near[near] = (np.abs(points[near]) <= FARTHEST_SHOWN).all(axis=1)
    return near


def _pen(palette: Palette, width: float, opacity: float) -> QPen:
    color = qcolor(palette.warning, opacity)
    return QPen(
        color,
        width,
        Qt.PenStyle.SolidLine,
        Qt.PenCapStyle.RoundCap,
        Qt.PenJoinStyle.RoundJoin,
    )


def _path(points: Points) -> QPainterPath:
    """Return a path through the points; a single point is a dot."""
    path = QPainterPath(QPointF(*points[0]))
    for x, y in points[1:]:
        path.lineTo(x, y)
    if len(points) == 1:
        path.lineTo(points[0][0] + 0.1, points[0][1])
    return path
