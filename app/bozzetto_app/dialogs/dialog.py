"""The common shape of dialogs: a title, a column, buttons at the lower right."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from bozzetto_app.style.theme import FRAME
from bozzetto_app.toolkit.panel_scroll import PanelScroll

__all__ = ["Page", "label", "quiet"]


def label(words: str, *, kind: str = "", tone: str = "") -> QLabel:
    """Return a label whose words wrap, as plain text: names in them may contain anything.

    Parameters
    ----------
    words : str
        The text of the label.
    kind : {"", "heading", "small"}
        Its rank in the style sheet, such as “heading”.
    tone : {"", "quiet", "warning"}
        Its colour in the style sheet, such as “quiet”.
    """
    made = QLabel(words)
    made.setTextFormat(Qt.TextFormat.PlainText)
    made.setProperty("type", kind)
    made.setProperty("tone", tone)
    made.setWordWrap(True)
    return made


def quiet(words: str) -> QLabel:
    """Return a label in the quiet colour of secondary text."""
    return label(words, tone="quiet")


class Page(QDialog):
    """A dialog with a column to fill and a row of buttons.

    On a screen that is too low for it the column is scrolled, so that the buttons are in reach.

    Parameters
    ----------
    name : str
        Object name.
    title : str
        Of the window.
    """

    def __init__(self, name: str, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.setWindowTitle(title)
        self.setAccessibleName(title)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(20, 20, 20, 16)
        outer.setSpacing(16)
        self.column = QVBoxLayout()
        self.column.setSpacing(12)
        outer.addLayout(self.column, 1)
        self._buttons = QHBoxLayout()
        self._buttons.setSpacing(8)
        self._buttons.addStretch(1)
        outer.addLayout(self._buttons)

    def add_button(self, words: str, *, default: bool = False) -> QPushButton:
        """Add a button at the lower right; Enter presses the default one."""
        button = QPushButton(words)
        button.setDefault(default)
        button.setAutoDefault(default)
        self._buttons.addWidget(button)
        return button

    def showEvent(self, event: QShowEvent) -> None:
        free = self.screen().availableGeometry().size() - QSize(*FRAME)
        outer = self.layout()
        if outer is not None and outer.totalMinimumSize().height() > free.height():
            self._scroll()
        self.resize(self.size().boundedTo(free))
        super().showEvent(event)

    def _scroll(self) -> None:
        """Put the column into an area that is scrolled."""
        outer, inner, area = self.layout(), QWidget(), PanelScroll(self)
        if not isinstance(outer, QVBoxLayout) or self.column.parentWidget() is not self:
            return  # it is there already
        outer.removeItem(self.column)
        self.column.setParent(None)
        self.column.setContentsMargins(0, 0, 8, 0)
        inner.setLayout(self.column)
        area.setWidget(inner)
        area.setMinimumWidth(inner.minimumSizeHint().width() + area.verticalScrollBar().width())
        outer.insertWidget(0, area, 1)
        outer.activate()
