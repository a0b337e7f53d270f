"""The colours of the guide panel: those that the program gives every widget."""

from __future__ import annotations

from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QWidget

from bozzetto_app.toolkit import palette_of


def role(widget: QWidget, which: QPalette.ColorRole, opacity: float = 1.0) -> QColor:
    """Return a colour of a widget's palette; opacity 0 … 1."""
    color = QColor(widget.palette().color(which))
    color.setAlphaF(opacity)
    return color


def warning_of(widget: QWidget) -> QColor:
    """Return the colour of warnings."""
    return QColor(*palette_of(widget).warning)


TEXT = QPalette.ColorRole.WindowText
