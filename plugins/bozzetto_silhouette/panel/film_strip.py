"""The key poses of a motion as small figures in a row, with the time that is shown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from PySide6.QtCore import QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from bozzetto.arrays import Array, Faces
from bozzetto.plugin import override
from bozzetto_app.toolkit import palette_of

FRAME: Final = (52, 64)
"""Width and height of a figure's frame, px."""

GAP: Final = 4
"""Between frames, px."""

MARGIN: Final = 7.0
"""Between a frame and its figure, px."""

BAR: Final = 22
"""Height of the bar on which the time is dragged, px."""

SNAP: Final = 5.0
"""Distance on the bar at which the time jumps to a key, px."""

THINNEST: Final = 1.2
"""Line of the thinnest bone, px."""


@dataclass(frozen=True, eq=False)
class Strip:
    """Content of the strip.

    Attributes
    ----------
    places : (k, n, 2) float array
        Joints of every key pose, mm, y up.
    parents : (n,) int array
        Of the joints; -1 for roots.
    radii : (n,) float array
        Of the body there, mm.
    """

    places: Array
    parents: Faces
    radii: Array


class FilmStrip(QWidget):
    """A bar of time with a dot for every key, and below it the figure of every key.

    Signals
    -------
    key_chosen : int
        A figure was touched.
    time_dragged : float, bool
        The time was dragged to so many keys, 0 … the number of keys; whether the hand goes on.
    """

    key_chosen = Signal(int)
    time_dragged = Signal(float, bool)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("film-strip")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        policy = QSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)
        self._strip: Strip | None = None
        self.count = 0
        self.time = 0.0
        self._dragging = False

    def show_keys(self, count: int, time: float) -> None:
        """Show so many keys, and the time in keys from the first."""
        if count != self.count:
            self.count = count
            self.updateGeometry()
        self.time = time
        self.setAccessibleName(f"Key pose {self.key + 1} of {count}" if count else "No key poses")
        self.update()

    @property
    def key(self) -> int:
        """The number of the key that is shown, or of the last one before the time."""
        return int(np.floor(self.time + 1e-6))

    def show_figures(self, strip: Strip | None) -> None:
        """Show the figures of all keys; None while they are not known."""
        self._strip = strip
        self.update()

    # -- its size --

    @override
    def hasHeightForWidth(self) -> bool:
        return True

    @override
    def heightForWidth(self, width: int) -> int:
        if not self.count:
            return 0
        rows = -(-self.count // self._columns(width))
        return BAR + rows * (FRAME[1] + GAP)

    @override
    def sizeHint(self) -> QSize:
        return QSize(260, self.heightForWidth(260))

    @staticmethod
    def _columns(width: int) -> int:
        return max(1, (width + GAP) // (FRAME[0] + GAP))

    def frame(self, key: int) -> QRect:
        """Return where the figure of a key is."""
        row, column = divmod(key, self._columns(self.width()))
        left, top = column * (FRAME[0] + GAP), BAR + row * (FRAME[1] + GAP)
        return QRect(left, top, *FRAME)

    def place_of(self, time: float) -> float:
        """Return where a time in keys is on the bar, px from the left."""
        return MARGIN + (self.width() - 2 * MARGIN) * time / max(self.count, 1)

    # -- what the hand does --

    @override
    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton or not self.count:
            return
        place = event.position()
        if place.y() < BAR:
            self._dragging = True
            self._drag_to(place.x(), going=True)
            return
        for key in range(self.count):
            if self.frame(key).contains(place.toPoint()):
                self.key_chosen.emit(key)
                return

    @override
    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._dragging:
            self._drag_to(event.position().x(), going=True)

    @override
    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if self._dragging:
            self._dragging = False
            self._drag_to(event.position().x(), going=False)

    @override
    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}.get(Qt.Key(event.key()))
        if step is None or not self.count:
            super().keyPressEvent(event)
            return
        self.key_chosen.emit((self.key + step) % self.count)

    def _drag_to(self, x: float, *, going: bool) -> None:
        share = (x - MARGIN) / max(self.width() - 2 * MARGIN, 1.0)
        time = min(max(share, 0.0), 1.0) * self.count
        nearest = round(time)
        if abs(self.place_of(nearest) - self.place_of(time)) < SNAP:
            time = float(nearest)
        self.time_dragged.emit(min(time, self.count - 1e-3), going)

    # -- what is seen --

    @override
    def paintEvent(self, event: QPaintEvent) -> None:
        if not self.count:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        text = QColor(self.palette().color(QPalette.ColorRole.WindowText))
        accent = QColor(*palette_of(self).accent)
        self._paint_bar(painter, text, accent)
        for key in range(self.count):
            place = QRectF(self.frame(key)).adjusted(0.75, 0.75, -0.75, -0.75)
            painter.setPen(QPen(accent if key == self.key else _faint(text, 0.18), 1.5))
            painter.setBrush(_faint(text, 0.04))
            painter.drawRoundedRect(place, 4.0, 4.0)
            if self._strip is not None and key < len(self._strip.places):
                self._paint_figure(painter, place, key, accent if key == self.key else text)
        if self.hasFocus():
            painter.setPen(QPen(QColor(*palette_of(self).second), 1.0))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, BAR - 3), 4.0, 4.0)
        painter.end()

    def _paint_bar(self, painter: QPainter, text: QColor, accent: QColor) -> None:
        middle = (BAR - 2) / 2
        painter.setPen(QPen(_faint(text, 0.3), 1.5))
        painter.drawLine(QPointF(MARGIN, middle), QPointF(self.width() - MARGIN, middle))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(_faint(text, 0.55))
        for key in range(self.count):
            painter.drawEllipse(QPointF(self.place_of(key), middle), 2.5, 2.5)
        painter.setBrush(accent)
        painter.drawEllipse(QPointF(self.place_of(self.time), middle), 5.5, 5.5)

    def _paint_figure(self, painter: QPainter, frame: QRectF, key: int, color: QColor) -> None:
        strip = self._strip
        assert strip is not None
        low = strip.places.min(axis=(0, 1))
        size = np.maximum(strip.places.max(axis=(0, 1)) - low, 1e-9)
        room = np.array((frame.width(), frame.height())) - 2 * MARGIN
        scale = float((room / size).min())
        middle = np.array((frame.center().x(), frame.center().y()))
        places = middle + scale * (strip.places[key] - low - 0.5 * size) * (1.0, -1.0)
        for joint, parent in enumerate(strip.parents.tolist()):
            if parent >= 0:
                width = max(THINNEST, scale * float(strip.radii[joint] + strip.radii[parent]) / 2)
                pen = QPen(color, min(width, MARGIN), Qt.PenStyle.SolidLine)
                pen.setCapStyle(Qt.PenCapStyle.RoundCap)
                painter.setPen(pen)
                painter.drawLine(QPointF(*places[parent]), QPointF(*places[joint]))


def _faint(color: QColor, opacity: float) -> QColor:
    made = QColor(color)
    made.setAlphaF(opacity)
    return made
