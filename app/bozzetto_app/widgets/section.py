"""A part of a panel under a heading that folds."""

from __future__ import annotations

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QAbstractButton, QFrame, QVBoxLayout, QWidget

from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import qcolor, strong_font, text_height, tones
from bozzetto_app.widgets.icon_button import RADIUS, paint_focus

__all__ = ["Section", "hairline"]

HEIGHT = 28
"""Of the heading, px."""


def hairline(parent: QWidget | None = None) -> QFrame:
    """Return a line one pixel high."""
    line = QFrame(parent)
    line.setProperty("shape", "hairline")
    return line


class _Heading(QAbstractButton):
    def __init__(self, title: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setText(title)
        self.setAccessibleName(title)
        self.setCheckable(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setFixedHeight(text_height(HEIGHT))

    def sizeHint(self) -> QSize:
        return QSize(self.fontMetrics().horizontalAdvance(self.text()) + 48, text_height(HEIGHT))

    def minimumSizeHint(self) -> QSize:
        return QSize(96, text_height(HEIGHT))

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.underMouse():
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(qcolor(colors.hover))
            painter.drawRoundedRect(QRectF(self.rect()), RADIUS, RADIUS)
        chevron = "chevron-down" if self.isChecked() else "chevron-right"
        paint_icon(painter, chevron, QRectF(0, (self.height() - 16) / 2, 16, 16), colors.quiet)
        painter.setPen(qcolor(colors.text))
        painter.setFont(strong_font(self.font()))
        place = self.rect().adjusted(20, 0, -4, 0)
        words = painter.fontMetrics().elidedText(
            self.text(), Qt.TextElideMode.ElideMiddle, place.width()
        )
        painter.drawText(place, Qt.AlignmentFlag.AlignVCenter, words)
        if self.hasFocus():
            paint_focus(painter, QRectF(self.rect()))


class Section(QWidget):
    """A heading and what is under it.

    Parameters
    ----------
    title : str
    content : QWidget
    open_ : bool
        Whether it is unfolded at first.

    Signals
    -------
    folded : bool
        Unfolded (True) or folded by a person.
    """

    folded = Signal(bool)

    def __init__(
        self, title: str, content: QWidget, parent: QWidget | None = None, *, open_: bool = True
    ) -> None:
        super().__init__(parent)
        self._heading = _Heading(title, self)
        self._content = content
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self._heading)
        column.addWidget(content)
        self._heading.toggled.connect(content.setVisible)
        self._heading.clicked.connect(self.folded)
        self._heading.setChecked(open_)
        content.setVisible(open_)

    @property
    def is_open(self) -> bool:
        """Whether the content is shown."""
        return self._heading.isChecked()

    @property
    def heading_height(self) -> int:
        """Height of the heading, px."""
        return self._heading.height()

    def rename(self, title: str) -> None:
        """Give it another heading."""
        self._heading.setText(title)
        self._heading.setAccessibleName(title)
        self._heading.updateGeometry()

    def set_open(self, shown: bool) -> None:
        """Unfold or fold it."""
        self._heading.setChecked(shown)
