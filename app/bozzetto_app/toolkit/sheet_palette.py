"""The colours of the sheet that go with those of a widget."""

from __future__ import annotations

from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QWidget

from bozzetto.scene.palette import DARK, LIGHT, Palette

__all__ = ["palette_of"]


def palette_of(widget: QWidget) -> Palette:
    """Return the palette of the sheet that goes with a widget's: dark where text is light."""
    colors = widget.palette()
    window = colors.color(QPalette.ColorRole.Window)
    text = colors.color(QPalette.ColorRole.WindowText)
    return DARK if window.lightness() < text.lightness() else LIGHT
