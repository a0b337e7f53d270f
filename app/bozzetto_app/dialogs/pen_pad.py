"""A pad that says what the pen says."""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QImage,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPointingDevice,
    QResizeEvent,
    QTabletEvent,
)
from PySide6.QtWidgets import QWidget

from bozzetto_app.canvas.input.stroke_samples import PressureCurve
from bozzetto_app.i18n import tr
from bozzetto_app.style.theme import qcolor, tones

__all__ = ["PenPad", "PressureGraph", "Reading", "rate_of"]

GRAPH_SECONDS = 5.0
"""Length of the pressure graph."""

RATE_SECONDS = 1.0
"""Over how long the sample rate is counted."""

THINNEST, THICKEST = 1.0, 9.0
"""Width of the ink without pressure and under full pressure, px."""


@dataclass(frozen=True)
class Reading:
    """One sample as the pad shows it.

    Attributes
    ----------
    device, tool : str
    pressure : float or None
        0 … 1; None where the device has none.
    tilt_x, tilt_y, twist : float
        Degrees.
    rate : float
        Samples a second.
    """

    device: str
    tool: str
    pressure: float | None
    tilt_x: float
    tilt_y: float
    twist: float
    rate: float


def rate_of(times: deque[float]) -> float:
    """Return the samples per second over the last second; 0 for fewer than two samples.

    Times older than `RATE_SECONDS` before the last one are dropped from the queue.
    """
    while times and times[-1] - times[0] > RATE_SECONDS:
        times.popleft()
    span = times[-1] - times[0] if len(times) > 1 else 0.0
    return (len(times) - 1) / span if span > 0 else 0.0


class PressureGraph(QWidget):
    """The pressure of the last seconds."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._samples: deque[tuple[float, float]] = deque()
        self.setMinimumHeight(72)
        self.setAccessibleName(tr("Pen", "Pressure of the last seconds"))

    def add(self, when: float, pressure: float) -> None:
        """Add a sample; `when` in seconds."""
        self._samples.append((when, pressure))
        while self._samples and when - self._samples[0][0] > GRAPH_SECONDS:
            self._samples.popleft()
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        frame = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        painter.setPen(QPen(qcolor(colors.hairline), 1))
        painter.setBrush(qcolor(colors.field))
        painter.drawRoundedRect(frame, 6, 6)
        room = frame.adjusted(8, 8, -8, -8)
        for part in (0.0, 0.5, 1.0):
            y = room.bottom() - part * room.height()
            painter.drawLine(QPointF(room.left(), y), QPointF(room.right(), y))
        if len(self._samples) < 2:
            return
        last = self._samples[-1][0]
        points = [
            QPointF(
                room.right() - (last - when) / GRAPH_SECONDS * room.width(),
                room.bottom() - pressure * room.height(),
            )
            for when, pressure in self._samples
        ]
        painter.setPen(QPen(qcolor(colors.accent), 1.5))
        painter.drawPolyline(points)


class PenPad(QWidget):
    """Draw here: ink as wide as the hand presses.

    Signals
    -------
    read : Reading
    sampled : float, float
        Time in seconds and pressure as it counts.
    """

    read = Signal(object)
    sampled = Signal(float, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.curve = PressureCurve()
        self._ink = QImage()
        self._last: QPointF | None = None
        self._times: deque[float] = deque()
        self.setMinimumSize(QSize(320, 200))
        self.setTabletTracking(True)
        self.setCursor(Qt.CursorShape.CrossCursor)
        self.setAccessibleName(tr("Pen", "Drawing pad"))

    def clear(self) -> None:
        """Wipe the pad."""
        self._ink = QImage()
        self.update()

    def tabletEvent(self, event: QTabletEvent) -> None:
        event.accept()
        device = event.pointingDevice()
        eraser = device.pointerType() == QPointingDevice.PointerType.Eraser
        tool = tr("Pen", "eraser end") if eraser else tr("Pen", "pen")
        down = event.type() != QEvent.Type.TabletRelease and bool(event.buttons())
        tilt = (event.xTilt(), event.yTilt(), event.rotation())
        self._take(event.position(), down, device.name(), tool, event.pressure(), tilt)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._from_mouse(event, down=True)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self._from_mouse(event, down=True)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._from_mouse(event, down=False)

    def _from_mouse(self, event: QMouseEvent, *, down: bool) -> None:
        device = event.pointingDevice().name() or tr("Pen", "mouse")
        none = (0.0, 0.0, 0.0)
        self._take(event.position(), down, device, tr("Pen", "mouse"), None, none)

    def _take(
        self,
        place: QPointF,
        down: bool,
        device: str,
        tool: str,
        pressure: float | None,
        tilt: tuple[float, float, float],
    ) -> None:
        now = time.monotonic()
        self._times.append(now)
        counts = self.curve(0.5 if pressure is None else pressure)
        if down and self._last is not None:
            self._draw(self._last, place, counts)
        self._last = place if down else None
        self.read.emit(Reading(device, tool, pressure, *tilt, rate_of(self._times)))
        if pressure is not None:
            self.sampled.emit(now, counts if down else 0.0)

    def _draw(self, start: QPointF, end: QPointF, pressure: float) -> None:
        if self._ink.isNull():
            scale = self.devicePixelRatioF()
            self._ink = QImage(self.size() * scale, QImage.Format.Format_ARGB32_Premultiplied)
            self._ink.setDevicePixelRatio(scale)
            self._ink.fill(Qt.GlobalColor.transparent)
        painter = QPainter(self._ink)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        width = THINNEST + (THICKEST - THINNEST) * pressure
        color = qcolor(tones().text)
        painter.setPen(QPen(color, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        painter.drawLine(start, end)
        painter.end()
        self.update()

    def resizeEvent(self, event: QResizeEvent) -> None:
        self.clear()

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(qcolor(colors.hairline), 1))
        painter.setBrush(qcolor(colors.field))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5), 6, 6)
        if self._ink.isNull():
            painter.setPen(qcolor(colors.quiet))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, tr("Pen", "Draw here."))
        else:
            painter.drawImage(0, 0, self._ink)
