"""A badge while what moves is slower than time: a step takes longer than it stands for."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QRect, QRectF, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from bozzetto.scene.contrast import readable
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto_app.i18n import tr
from bozzetto_app.style.colors import tones_of
from bozzetto_app.style.theme import qcolor, text_height

__all__ = ["PaceBadge"]

MARGIN: Final = 12
"""Distance from the sheet's lower edge, px."""

HEIGHT: Final = 26
PADDING: Final = 12


class PaceBadge(QWidget):
    """Words at the foot of the sheet: how much slower than time things move.

    Every touch passes through it.
    """

    def __init__(self, canvas: QWidget) -> None:
        super().__init__(canvas)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.words = ""
        self._palette: Palette = LIGHT
        self._area = QRect()
        self.hide()

    def set_colors(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = palette
        self.update()

    def lie_on(self, area: QRect) -> None:
        """Stay at the foot of an area of the canvas, in the middle."""
        self._area = area
        width = QFontMetrics(self.font()).horizontalAdvance(self.words) + 2 * PADDING
        height = text_height(HEIGHT)
        left = area.left() + (area.width() - width) // 2
        self.setGeometry(left, area.bottom() + 1 - MARGIN - height, width, height)

    def show_pace(self, pace: float | None) -> None:
        """Show seconds moved per second passed; None where things move as fast as time."""
        self.setVisible(pace is not None)
        if pace is None:
            return
        self.words = tr("Pace", "Slow motion: {pace} of real time", pace=f"{100.0 * pace:.0f} %")
        self.setAccessibleName(self.words)
        self.lie_on(self._area)
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        tones = tones_of(self._palette)
        ground = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        painter.setPen(QPen(qcolor(tones.edge), 1.0))
        painter.setBrush(qcolor(tones.raised, 0.94))
        painter.drawRoundedRect(ground, ground.height() / 2, ground.height() / 2)
        painter.setPen(qcolor(readable(tones.text, tones.text, tones.raised)))
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, self.words)
        painter.end()
