"""A slim slider over real numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QWheelEvent
from PySide6.QtWidgets import QSlider, QWidget

from bozzetto_app.style.theme import qcolor, tones

if TYPE_CHECKING:
    from bozzetto.scene.palette import Color

__all__ = ["Slider"]

FINENESS = 10_000
"""Positions between the two ends."""

KNOB = 6.0
"""Radius of the knob, px."""


class Slider(QSlider):
    """A line with a disc on it; a notch marks the default.

    Parameters
    ----------
    name : str
        Accessible name.
    minimum, maximum, step : float
    default : float, optional
        Where the notch is; the knob catches there.

    Signals
    -------
    slid : float, bool
        A person changed the value; True while the drag goes on.
    drag_ended
    """

    slid = Signal(float, bool)
    drag_ended = Signal()

    def __init__(
        self,
        name: str,
        minimum: float,
        maximum: float,
        step: float,
        default: float | None = None,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(Qt.Orientation.Horizontal, parent)
        self._low, self._high, self._step = minimum, maximum, step
        self._default = default
        self._started: float | None = None
        self.setRange(0, FINENESS)
        self.setAccessibleName(name)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setFixedHeight(20)
        self.setMinimumWidth(64)

    def sizeHint(self) -> QSize:
        return QSize(120, 20)

    @property
    def number(self) -> float:
        """The value shown."""
        return self._low + (self._high - self._low) * self.value() / FINENESS

    def set_silently(self, number: float) -> None:
        """Show a value that came from elsewhere, unless it is being dragged."""
        if self._started is None:
            self._show(number)

    def _show(self, number: float) -> None:
        share = (number - self._low) / (self._high - self._low)
        self.setValue(round(min(max(share, 0.0), 1.0) * FINENESS))
        self.update()

    def _snapped(self, number: float) -> float:
        number = self._low + round((number - self._low) / self._step) * self._step
        return min(max(round(number, 9), self._low), self._high)

    def _place(self, number: float) -> float:
        share = (number - self._low) / (self._high - self._low)
        return KNOB + 1 + min(max(share, 0.0), 1.0) * (self.width() - 2 * KNOB - 2)

    def _number_at(self, x: float) -> float:
        if self._default is not None and abs(x - self._place(self._default)) < KNOB / 2:
            return self._default
        share = (x - KNOB - 1) / max(self.width() - 2 * KNOB - 2, 1.0)
        return self._snapped(self._low + min(max(share, 0.0), 1.0) * (self._high - self._low))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self._started = self.number
            self._slide_to(self._number_at(event.position().x()))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._started is not None:
            self._slide_to(self._number_at(event.position().x()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._finish()

    def _slide_to(self, number: float) -> None:
        before = self.value()
        self._show(number)
        if self.value() != before:
            self.slid.emit(number, True)

    def _finish(self) -> None:
        if self._started is not None:
            self._started = None
            self.update()
            self.drag_ended.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        steps = {
            Qt.Key.Key_Left: -1,
            Qt.Key.Key_Down: -1,
            Qt.Key.Key_Right: 1,
            Qt.Key.Key_Up: 1,
            Qt.Key.Key_PageDown: -10,
            Qt.Key.Key_PageUp: 10,
        }.get(Qt.Key(event.key()))
        if event.key() == Qt.Key.Key_Escape and self._started is not None:
            self._slide_to(self._started)
            self._finish()
        elif event.key() in (Qt.Key.Key_Home, Qt.Key.Key_End):
            self._step_to(self._low if event.key() == Qt.Key.Key_Home else self._high)
        elif steps is not None:
            self._step_to(self._snapped(self.number + steps * self._step))
        else:
            super().keyPressEvent(event)

    def _step_to(self, number: float) -> None:
        if abs(number - self.number) > (self._high - self._low) / FINENESS / 2:
            self._show(number)
            self.slid.emit(number, False)

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()  # a panel that scrolls must not change numbers on its way

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = self.height() / 2
        knob = self._place(self.number)
        alive = self.isEnabled()
        painter.setPen(_line(colors.edge))
        painter.drawLine(QPointF(KNOB + 1, middle), QPointF(self.width() - KNOB - 1, middle))
        if self._default is not None:
            notch = self._place(self._default)
            painter.setPen(QPen(qcolor(colors.quiet if alive else colors.edge), 1))
            painter.drawLine(QPointF(notch, middle + 5), QPointF(notch, middle + 8))
        near = self.underMouse() or self._started is not None
        painter.setPen(_line(_filled(alive, near)))
        painter.drawLine(QPointF(KNOB + 1, middle), QPointF(knob, middle))
        if self.hasFocus():
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(qcolor(colors.second, 0.35))
            painter.drawEllipse(QPointF(knob, middle), KNOB + 3, KNOB + 3)
        painter.setPen(QPen(qcolor(colors.text if alive else colors.disabled), 1.5))
        painter.setBrush(qcolor(colors.raised))
        radius = KNOB - 0.75 if near else KNOB - 1.5
        painter.drawEllipse(QRectF(knob - radius, middle - radius, 2 * radius, 2 * radius))


def _filled(alive: bool, near: bool) -> Color:
    colors = tones()
    if not alive:
        return colors.disabled
    return colors.accent if near else colors.quiet


def _line(color: Color) -> QPen:
    return QPen(qcolor(color), 2, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap)
