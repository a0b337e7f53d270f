"""The pressure curve, drawn and draggable."""

from __future__ import annotations

import math

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from bozzetto_app.canvas.input.stroke_samples import PressureCurve
from bozzetto_app.i18n import tr
from bozzetto_app.style.theme import qcolor, tones
from bozzetto_app.widgets.icon_button import paint_focus

__all__ = ["PressureEditor"]

SIDE = 176
MARGIN = 12
KEY_STEP = 1.05
"""Factor by which an arrow key changes the exponent."""


class PressureEditor(QWidget):
    """Curve from the pressure of the hand (across) to the pressure that counts (upwards).

    Drag the curve up for a light hand, down for a heavy one; double-click straightens it.

    Signals
    -------
    edited : float
        The exponent, while it changes.
    """

    edited = Signal(float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.gamma = 1.0
        self._now: float | None = None
        self.setFixedSize(QSize(SIDE, SIDE))
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setCursor(Qt.CursorShape.SizeVerCursor)
        self.setAccessibleName(tr("Pen", "Pressure curve"))
        self.setToolTip(tr("Pen", "Drag up for a light hand, down for a heavy one."))

    def show_gamma(self, gamma: float) -> None:
        """Show another exponent."""
        self.gamma = PressureCurve(gamma).gamma
        self.setAccessibleDescription(f"{self.gamma:.2f}")
        self.update()

    def show_pressure(self, pressure: float | None) -> None:
        """Mark where the hand is on the curve now."""
        self._now = pressure
        self.update()

    def _change(self, gamma: float) -> None:
        self.show_gamma(gamma)
        self.edited.emit(self.gamma)

    def _room(self) -> QRectF:
        return QRectF(self.rect()).adjusted(MARGIN, MARGIN, -MARGIN, -MARGIN)

    def _bend_to(self, place: QPointF) -> None:
        room = self._room()
        across = min(max((place.x() - room.left()) / room.width(), 0.1), 0.9)
        up = min(max((room.bottom() - place.y()) / room.height(), 0.02), 0.98)
        self._change(math.log(up) / math.log(across))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self._bend_to(event.position())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            self._bend_to(event.position())

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self._change(1.0)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Up:
            self._change(self.gamma / KEY_STEP)
        elif event.key() == Qt.Key.Key_Down:
            self._change(self.gamma * KEY_STEP)
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        frame = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        painter.setPen(QPen(qcolor(colors.hairline), 1))
        painter.setBrush(qcolor(colors.field))
        painter.drawRoundedRect(frame, 6, 6)
        room = self._room()
        painter.setPen(QPen(qcolor(colors.edge), 1, Qt.PenStyle.DotLine))
        painter.drawLine(room.bottomLeft(), room.topRight())
        curve = PressureCurve(self.gamma)

        def at(pressure: float) -> QPointF:
            return QPointF(
                room.left() + pressure * room.width(),
                room.bottom() - curve(pressure) * room.height(),
            )

        line = QPainterPath(at(0.0))
        for step in range(1, 65):
            line.lineTo(at(step / 64))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(qcolor(colors.text), 2))
        painter.drawPath(line)
        if self._now is not None:
            painter.setPen(QPen(qcolor(colors.text), 1.5))
            painter.setBrush(qcolor(colors.accent))
            painter.drawEllipse(at(self._now), 5, 5)
        if self.hasFocus():
            paint_focus(painter, QRectF(self.rect()), 6)
