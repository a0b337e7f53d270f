"""A line of text that keeps Enter to itself."""

from __future__ import annotations

from typing import cast

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QKeyEvent, QKeySequence
from PySide6.QtWidgets import QLineEdit

__all__ = ["TextField"]

WHILE_TYPING = (QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo)
"""Keys that are the field's own only while somebody types: what was typed is a step by then."""


class TextField(QLineEdit):
    """A line of text; Enter takes what was typed and does nothing else, Esc restores.

    Qt hands Enter on to what the field is in, where it begins a new object.
    """

    shown = ""
    """The text that was shown last, and that Esc restores."""

    def show_text(self, text: str) -> None:
        """Show what the field stands for; what somebody is typing stays."""
        self.shown = text
        if text == self.text():
            self.setModified(False)  # it was taken: undo is the document's from here on
        elif not self.isModified() or not self.hasFocus():
            self.setText(text)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.ShortcutOverride and not self.isModified():
            key = cast(QKeyEvent, event)
            if any(key.matches(other) for other in WHILE_TYPING):
                event.ignore()
                return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and self.isModified():
            self.setText(self.shown)
            event.accept()
            return
        super().keyPressEvent(event)
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            event.accept()
