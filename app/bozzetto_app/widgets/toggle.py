"""A switch: on or off by the place of its knob, not by colour alone."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QCheckBox, QWidget

from bozzetto_app.style.theme import qcolor, tones

__all__ = ["Toggle"]


class Toggle(QCheckBox):
    """A pill with a knob.

    Parameters
    ----------
    name : str
        Accessible name; the words stand beside it in a label of their own.
    """

    def __init__(self, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(name)
        self.setToolTip(name)
        self.setFixedSize(self.sizeHint())
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)

    def sizeHint(self) -> QSize:
        return QSize(36, 24)

    def hitButton(self, place: QPoint) -> bool:
        return self.rect().contains(place)

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        pill = QRectF(2.5, 4.5, 31, 15)
        on, alive = self.isChecked(), self.isEnabled()
        if on:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(qcolor(colors.accent_fill if alive else colors.disabled))
        else:
            painter.setPen(QPen(qcolor(colors.quiet if alive else colors.edge), 1))
            painter.setBrush(qcolor(colors.hover if self.underMouse() else colors.field))
        painter.drawRoundedRect(pill, 7.5, 7.5)
        knob = QPointF(pill.right() - 7.5 if on else pill.left() + 7.5, pill.center().y())
        painter.setPen(Qt.PenStyle.NoPen)
        off = colors.quiet if alive else colors.disabled
        painter.setBrush(qcolor(colors.on_accent if on else off))
        painter.drawEllipse(knob, 5.0, 5.0)
        if self.hasFocus():
            painter.setPen(QPen(qcolor(colors.second), 1.5))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(pill.adjusted(-1.75, -1.75, 1.75, 1.75), 9, 9)
