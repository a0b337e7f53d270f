"""The common shape of dialogs: a title, a column, buttons at the lower right."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

__all__ = ["Page", "label", "quiet"]


def label(words: str, *, kind: str = "", tone: str = "") -> QLabel:
    """Words that wrap, taken as they are: names in them may contain anything.

    Parameters
    ----------
    kind : {"", "heading", "small"}
    tone : {"", "quiet", "warning"}
    """
    made = QLabel(words)
    made.setTextFormat(Qt.TextFormat.PlainText)
    made.setProperty("type", kind)
    made.setProperty("tone", tone)
    made.setWordWrap(True)
    return made


def quiet(words: str) -> QLabel:
    """A label in the second rank of text."""
    return label(words, tone="quiet")


class Page(QDialog):
    """A dialog with a column to fill and a row of buttons.

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
        """A button at the lower right; the default one is pressed by Enter."""
        button = QPushButton(words)
        button.setDefault(default)
        button.setAutoDefault(default)
        self._buttons.addWidget(button)
        return button
