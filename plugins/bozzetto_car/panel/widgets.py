"""Widgets of the guide panel: a heading that folds, a progress bar, rows to choose."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QAbstractButton, QLabel, QSizePolicy, QVBoxLayout, QWidget

from bozzetto.plugin import override
from bozzetto_car.panel.colors import role, warning_of
from bozzetto_car.panel.view_model import SketchRow

Role = QPalette.ColorRole

CHEVRON: Final = [QPointF(-2.0, -4.0), QPointF(2.0, 0.0), QPointF(-2.0, 4.0)]
"""Chevron that points to the right; it is turned down where the content shows."""


def label(parent: QWidget, *, kind: str = "", tone: str = "") -> QLabel:
    """Return a line of text in the program's type: `kind` "heading" or "small", `tone` "quiet"."""
    made = QLabel(parent)
    made.setWordWrap(True)
    made.setTextFormat(Qt.TextFormat.PlainText)
    made.setProperty("type", kind)
    made.setProperty("tone", tone)
    return made


class Progress(QWidget):
    """A bar that shows how many of all points are marked."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setFixedHeight(4)
        self._share = 0.0

    def set_share(self, share: float) -> None:
        """Show a share, 0 … 1."""
        self._share = share
        self.update()

    @override
    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        whole = QRectF(self.rect())
        painter.setBrush(role(self, Role.WindowText, 0.12))
        painter.drawRoundedRect(whole, 2.0, 2.0)
        if self._share > 0.0:
            whole.setWidth(max(self._share * whole.width(), 4.0))
            painter.setBrush(role(self, Role.Link))
            painter.drawRoundedRect(whole, 2.0, 2.0)


class Fold(QWidget):
    """A heading that shows or hides its content."""

    def __init__(self, title: str, content: QWidget, parent: QWidget, *, is_open: bool) -> None:
        super().__init__(parent)
        self.heading = _Heading(title, self)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.heading)
        column.addWidget(content)
        self.heading.toggled.connect(content.setVisible)
        self.heading.setChecked(is_open)
        content.setVisible(is_open)


class _Heading(QAbstractButton):
    def __init__(self, title: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setText(title)
        self.setAccessibleName(title)
        self.setCheckable(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setFixedHeight(26)

    @override
    def sizeHint(self) -> QSize:
        return QSize(160, 26)

    @override
    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        _paint_ground(painter, self)
        painter.setPen(QPen(role(self, Role.WindowText, 0.6), 1.5))
        painter.save()
        painter.translate(8.0, 13.0)
        painter.rotate(90.0 if self.isChecked() else 0.0)
        painter.drawPolyline(CHEVRON)
        painter.restore()
        font = self.font()
        font.setBold(True)
        painter.setFont(font)
        painter.setPen(role(self, Role.WindowText))
        painter.drawText(
            self.rect().adjusted(20, 0, -4, 0), Qt.AlignmentFlag.AlignVCenter, self.text()
        )


class SketchButton(QAbstractButton):
    """A sketch to choose: its name, its camera and its residual."""

    def __init__(self, row: SketchRow, parent: QWidget) -> None:
        super().__init__(parent)
        self.row = row
        self.setAccessibleName(f"{row.name}: {row.summary}")
        self.setCheckable(True)
        self.setChecked(row.in_work)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setFixedHeight(40)

    @override
    def sizeHint(self) -> QSize:
        return QSize(200, 40)

    @override
    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        _paint_ground(painter, self)
        if self.row.in_work:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(role(self, Role.Accent, 0.14))
            painter.drawRoundedRect(QRectF(self.rect()), 4.0, 4.0)
            painter.fillRect(QRectF(0.0, 8.0, 3.0, 24.0), role(self, Role.Accent))
        name, below = self.rect().adjusted(12, 4, -8, -20), self.rect().adjusted(12, 20, -8, -4)
        metrics = painter.fontMetrics()
        painter.setPen(role(self, Role.WindowText))
        cut = Qt.TextElideMode.ElideRight
        painter.drawText(
            name,
            Qt.AlignmentFlag.AlignVCenter,
            metrics.elidedText(self.row.name, cut, name.width()),
        )
        font = self.font()
        font.setPixelSize(max(10, round(0.86 * self.fontInfo().pixelSize())))
        painter.setFont(font)
        painter.setPen(warning_of(self) if self.row.wrong else role(self, Role.WindowText, 0.65))
        painter.drawText(
            below,
            Qt.AlignmentFlag.AlignVCenter,
            painter.fontMetrics().elidedText(self.row.summary, cut, below.width()),
        )


def _paint_ground(painter: QPainter, button: QAbstractButton) -> None:
    if button.underMouse():
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(role(button, Role.WindowText, 0.06))
        painter.drawRoundedRect(QRectF(button.rect()), 4.0, 4.0)
    if button.hasFocus():
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(role(button, Role.Link), 1.0))
        painter.drawRoundedRect(QRectF(button.rect()).adjusted(0.5, 0.5, -0.5, -0.5), 4.0, 4.0)
