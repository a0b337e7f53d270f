"""A line of text that keeps Enter to itself."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLineEdit

__all__ = ["TextField"]


class TextField(QLineEdit):
    """A line of text; Enter takes what was typed and does nothing else.

    Qt hands Enter on to what the field is in, where it begins a new object.
    """

    def keyPressEvent(self, event: QKeyEvent) -> None:
        super().keyPressEvent(event)
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            event.accept()
