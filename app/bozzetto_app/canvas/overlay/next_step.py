"""The ring around the place on the sheet where the next step is to be done."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QPointF, QRect, Qt
from PySide6.QtGui import QPainter, QPen

from bozzetto_app.canvas.screen_limits import limited_place, rect_around
from bozzetto_app.style.theme import qcolor

if TYPE_CHECKING:
    from bozzetto.scene.palette import Palette

__all__ = ["NextPlace"]

RADIUS: Final = 15.0
WIDTH: Final = 1.6
GROUND: Final = 4.0
"""Width of the pale line beneath, which parts the ring from a dark picture, pixels."""


class NextPlace:
    """A quiet ring, wide enough to see through to what is marked.

    Attributes
    ----------
    place : (x, y) or None
        Its middle on the sheet, pixels; None shows nothing.
    """

    def __init__(self) -> None:
        self.place: tuple[float, float] | None = None

    def move(self, place: tuple[float, float] | None) -> QRect:
        """Put it at another place; return what must be painted again."""
        before = self._area
        self.place = None if place is None else limited_place(*place)
        return before.united(self._area)

    def paint(self, painter: QPainter, palette: Palette) -> None:
        """Paint the ring."""
        if self.place is None:
            return
        middle = QPointF(*self.place)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for color, opacity, width in (
            (palette.paper, 0.6, GROUND),
            (palette.accent, 0.9, WIDTH),
        ):
            painter.setPen(QPen(qcolor(color, opacity), width))
            painter.drawEllipse(middle, RADIUS, RADIUS)

    @property
    def _area(self) -> QRect:
        if self.place is None:
            return QRect()
        return rect_around(*self.place, RADIUS + GROUND)
