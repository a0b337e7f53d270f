"""The scale of thickness at the foot of the sheet, with the thinnest wall in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from PySide6.QtCore import QPointF, QRect, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from bozzetto.scene.contrast import readable
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto_app.i18n import tr
from bozzetto_app.style.colors import tones_of
from bozzetto_app.style.theme import qcolor

if TYPE_CHECKING:
    from bozzetto.scene.thickness_view import ThicknessView

__all__ = ["ThicknessScale"]

SIZE: Final = (300, 74)
"""Least width and height, px; it is as large as its words."""

MARGIN: Final = 12
"""Distance from the sheet's lower left corner, px."""

PADDING: Final = 14

BAR: Final = 8
"""Height of the bar of colours, px."""

MARKS: Final = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Thicknesses that are written, mm."""


class ThicknessScale(QWidget):
    """Legend of the colours of thickness, with the thinnest wall.

    Every touch passes through it.
    """

    def __init__(self, canvas: QWidget) -> None:
        super().__init__(canvas)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.words = ""
        self._palette: Palette = LIGHT
        self.hide()

    def set_colors(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = palette
        self.update()

    def lie_on(self, area: QRect, left: int = 0) -> None:
        """Stay in the lower left corner of an area, beside what covers so much of its left."""
        height = self._height()
        corner = (left + MARGIN, area.bottom() + 1 - MARGIN - height)
        self.setGeometry(*corner, self._width(), height)

    def _height(self) -> int:
        return max(SIZE[1], 2 * self.fontMetrics().height() + 2 * BAR + PADDING)

    def _width(self) -> int:
        return max(SIZE[0], self.fontMetrics().horizontalAdvance(self.words) + 2 * PADDING + 2)

    def say(self, view: ThicknessView | None) -> None:
        """Tell of what was measured; None while it is measured."""
        if view is None:
            self.words = tr("Thickness", "Measuring walls…")
        elif view.thinnest is None:
            self.words = tr("Thickness", "Nothing here is closed, so no wall can be measured.")
        else:
            from bozzetto.scene.thickness_view import written_thickness

            thickness = written_thickness(view.thinnest.thinnest)
            self.words = tr("Thickness", "Thinnest wall: {thickness}", thickness=thickness)
        self.setAccessibleName(self.words)
        self.resize(self._width(), self._height())
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        from PySide6.QtGui import QLinearGradient

        from bozzetto.scene.thickness_view import THICK, THIN, thickness_colors

        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        tones = tones_of(self._palette)
        painter.setPen(QPen(qcolor(tones.edge), 1.0))
        painter.setBrush(qcolor(tones.raised, 0.94))
        ground = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        painter.drawRoundedRect(ground, 8.0, 8.0)
        painter.setPen(qcolor(readable(tones.text, tones.text, tones.raised)))
        inner = ground.adjusted(PADDING, PADDING / 2, -PADDING, -PADDING / 2)
        painter.drawText(inner, Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft, self.words)
        below = inner.top() + self.fontMetrics().height() + BAR / 2
        bar = QRectF(inner.left(), max(inner.center().y(), below), inner.width(), BAR)
        octaves = np.log2(THICK / THIN)
        colors = QLinearGradient(bar.topLeft(), bar.topRight())
        for share in np.linspace(0.0, 1.0, 17).tolist():
            row = thickness_colors(np.array([THIN * 2.0 ** (octaves * share)]), self._palette)[0]
            colors.setColorAt(share, QColor(*(round(float(part)) for part in row)))
        for mark in MARKS:
            x = bar.left() + float(np.log2(mark / THIN) / octaves) * bar.width()
            words = f"{mark:g}" + (" mm" if mark == MARKS[-1] else "")
            width = float(painter.fontMetrics().horizontalAdvance(words))
            left = min(max(x - width / 2, bar.left()), bar.right() - width)
            painter.drawText(QPointF(left, inner.bottom()), words)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(colors)
        painter.drawRoundedRect(bar, BAR / 2, BAR / 2)
        painter.end()
