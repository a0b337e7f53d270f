"""One of several: a row of segments where the words fit, else a drop-down list."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QPen, QWheelEvent
from PySide6.QtWidgets import QAbstractButton, QButtonGroup, QComboBox, QHBoxLayout, QWidget

from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import qcolor, strong_font, text_height, tones
from bozzetto_app.widgets.icon_button import RADIUS, paint_focus

__all__ = ["ChoiceBox", "Segments", "make_choice"]

HEIGHT = 28
"""Height of a choice, px."""


class _Segment(QAbstractButton):
    def __init__(self, words: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setText(words)
        self.setAccessibleName(words)
        self.setToolTip(words)
        self.setCheckable(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)

    def sizeHint(self) -> QSize:
        metrics = self.fontMetrics()
        return QSize(metrics.horizontalAdvance(self.text()) + 20, text_height(HEIGHT))

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        place = QRectF(self.rect()).adjusted(2, 2, -2, -2)
        if self.isChecked():
            painter.setPen(QPen(qcolor(colors.edge), 1))
            painter.setBrush(qcolor(colors.raised))
            painter.drawRoundedRect(place.adjusted(0.5, 0.5, -0.5, -0.5), 3, 3)
            painter.setFont(strong_font(self.font()))
        if not self.isEnabled():
            color = colors.disabled
        else:
            color = colors.text if self.isChecked() or self.underMouse() else colors.quiet
        painter.setPen(qcolor(color))
        words = painter.fontMetrics().elidedText(
            self.text(), Qt.TextElideMode.ElideRight, self.width() - 8
        )
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, words)
        if self.hasFocus():
            paint_focus(painter, place, 3)


class Segments(QWidget):
    """A row of words of which one is chosen.

    Signals
    -------
    chosen : str
        The value a person chose.
    """

    chosen = Signal(str)

    def __init__(
        self, name: str, options: Sequence[tuple[str, str]], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self.setAccessibleName(name)
        self._buttons = {value: _Segment(words, self) for value, words in options}
        self._group = QButtonGroup(self)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        for value, button in self._buttons.items():
            self._group.addButton(button)
            row.addWidget(button, 1)
            button.clicked.connect(lambda _, value=value: self.chosen.emit(value))
        self.setFixedHeight(text_height(HEIGHT))

    def set_silently(self, value: str) -> None:
        """Show a value that came from elsewhere."""
        self._buttons[value].setChecked(True)
        self.setFocusProxy(self._buttons[value])

    @property
    def value(self) -> str:
        """The chosen value; "" before any was shown."""
        return next((v for v, button in self._buttons.items() if button.isChecked()), "")

    def needed_width(self) -> int:
        """Width at which no word is cut, px."""
        metrics = QFontMetrics(strong_font(self.font()))
        widest = max(metrics.horizontalAdvance(b.text()) for b in self._buttons.values())
        return len(self._buttons) * (widest + 16)

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(qcolor(colors.hairline), 1))
        painter.setBrush(qcolor(colors.press))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5), RADIUS, RADIUS)


class ChoiceBox(QComboBox):
    """A drop-down list in the program's look.

    Signals
    -------
    chosen : str
        The value a person chose.
    """

    chosen = Signal(str)

    def __init__(
        self, name: str, options: Sequence[tuple[str, str]], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self.setAccessibleName(name)
        self.setToolTip(name)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        for value, words in options:
            self.addItem(words, value)
        self.setFixedHeight(text_height(HEIGHT))
        self.setMinimumContentsLength(4)
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.activated.connect(lambda: self.chosen.emit(self.value))

    @property
    def value(self) -> str:
        """The chosen value."""
        return str(self.currentData())

    def set_silently(self, value: str) -> None:
        """Show a value that came from elsewhere."""
        self.setCurrentIndex(self.findData(value))

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()  # a panel that scrolls must not change choices on its way

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        place = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        painter.setPen(QPen(qcolor(colors.edge), 1))
        painter.setBrush(qcolor(colors.hover if self.underMouse() else colors.field))
        painter.drawRoundedRect(place, RADIUS, RADIUS)
        color = colors.text if self.isEnabled() else colors.disabled
        painter.setPen(qcolor(color))
        room = self.rect().adjusted(8, 0, -24, 0)
        words = painter.fontMetrics().elidedText(
            self.currentText(), Qt.TextElideMode.ElideRight, room.width()
        )
        painter.drawText(room, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, words)
        side = 16
        paint_icon(
            painter,
            "chevron-down",
            QRectF(self.width() - side - 6, (self.height() - side) / 2, side, side),
            color,
        )
        if self.hasFocus():
            paint_focus(painter, QRectF(self.rect()))


def make_choice(
    name: str, options: Sequence[tuple[str, str]], width: int, parent: QWidget | None = None
) -> Segments | ChoiceBox:
    """Segments where all words fit into `width` (px), else a drop-down list."""
    if 2 <= len(options) <= 4:
        segments = Segments(name, options, parent)
        if segments.needed_width() <= width:
            return segments
        segments.setParent(None)  # nobody must see it, or find it in the row, until it is gone
        segments.deleteLater()
    return ChoiceBox(name, options, parent)
