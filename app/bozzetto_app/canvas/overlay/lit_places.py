"""Places that are lit for a moment, with words beside the first: what went wrong, and where."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QPointF, QRect, QRectF, Qt, QTimer
from PySide6.QtGui import QPainter, QPen
from PySide6.QtWidgets import QWidget

from bozzetto_app.canvas.screen_limits import limited_place, rect_around
from bozzetto_app.style.colors import tones_of
from bozzetto_app.style.theme import qcolor

if TYPE_CHECKING:
    from bozzetto.scene.palette import Palette

__all__ = ["LitPlaces"]

RING_TIME: Final = 1400
"""How long a place stays lit, milliseconds."""

READING_TIME: Final = 5000
"""How long it stays where words stand beside it, milliseconds."""

STEP: Final = 33
RADIUS: Final = 12.0
SWELLING: Final = 5.0
REACH: Final = 22
"""Everything of a ring lies within so many pixels of its place."""

WORDS_WIDTH: Final = 280
WORDS_AWAY: Final = 28
MARGIN: Final = 8
"""Widest line of the words, their distance from the place, the room around them, pixels."""


class LitPlaces:
    """Rings on a sheet that fade by themselves.

    Parameters
    ----------
    sheet : QWidget
        Is asked to paint again where something changed.
    """

    def __init__(self, sheet: QWidget) -> None:
        self._sheet = sheet
        self.places: tuple[tuple[float, float], ...] = ()
        self.words = ""
        self._age = 0
        self._timer = QTimer(sheet, interval=STEP)
        self._timer.timeout.connect(self._grow_older)

    def light_up(self, places: Sequence[tuple[float, float]], words: str = "") -> None:
        """Light these and no others."""
        self._update()
        self.places = tuple(limited_place(x, y) for x, y in places)
        self.words, self._age = words, 0
        if self.places:
            self._timer.start()
        else:
            self._timer.stop()
        self._update()

    @property
    def words_area(self) -> QRect:
        """Where the words stand: under the first place, or above it where there is no room."""
        if not self.places or not self.words:
            return QRect()
        sheet, (x, y) = self._sheet, self.places[0]
        widest = min(WORDS_WIDTH, max(sheet.width() - 4 * MARGIN, 1))
        room = QRect(0, 0, widest, sheet.height())
        box = sheet.fontMetrics().boundingRect(room, Qt.TextFlag.TextWordWrap, self.words)
        wide, tall = box.width() + 2 * MARGIN, box.height() + 2 * MARGIN
        left = min(max(round(x) - wide // 2, MARGIN), max(sheet.width() - wide - MARGIN, 0))
        lowest = sheet.height() - tall - MARGIN
        top = round(y) + WORDS_AWAY
        if top > lowest:
            top = max(min(round(y) - WORDS_AWAY - tall, lowest), 0)
        return QRect(left, top, wide, tall)

    def paint(self, painter: QPainter, palette: Palette) -> None:
        """Paint rings and words as they are now."""
        if not self.places:
            return
        life = self._life
        strength = max(0.0, 1.0 - (self._age / life) ** (3 if life == RING_TIME else 8))
        beat = min(self._age / RING_TIME, 1.0)
        radius = RADIUS + SWELLING * abs(math.sin(3.0 * math.pi * beat))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(qcolor(palette.accent, strength), 2.5))
        for x, y in self.places:
            painter.drawEllipse(QPointF(x, y), radius, radius)
        if self.words:
            painter.setOpacity(strength)
            self._paint_words(painter, palette)
            painter.setOpacity(1.0)

    def _paint_words(self, painter: QPainter, palette: Palette) -> None:
        colors, area = tones_of(palette), self.words_area
        painter.setPen(QPen(qcolor(colors.edge), 1.0))
        painter.setBrush(qcolor(colors.raised))
        painter.drawRoundedRect(QRectF(area).adjusted(0.5, 0.5, -0.5, -0.5), 4, 4)
        painter.setPen(qcolor(colors.text))
        flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
        inside = area.adjusted(MARGIN // 2, 0, -MARGIN // 2, 0)
        painter.drawText(inside, flags, self.words)

    @property
    def _life(self) -> int:
        return READING_TIME if self.words else RING_TIME

    def _grow_older(self) -> None:
        self._age += STEP
        self._update()
        if self._age >= self._life:
            self.light_up(())

    def _update(self) -> None:
        for x, y in self.places:
            self._sheet.update(rect_around(x, y, REACH))
        self._sheet.update(self.words_area)
