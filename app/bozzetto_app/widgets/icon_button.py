"""A button that is only an icon: quiet at rest, named for those who cannot see it."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QToolButton, QWidget

from bozzetto_app.style.icons import GRID, paint_icon
from bozzetto_app.style.theme import qcolor, strong_font, tones

__all__ = ["IconButton", "paint_focus"]

RADIUS = 4.0
"""Corner radius of everything that can be pressed, px."""


def paint_focus(painter: QPainter, place: QRectF, radius: float = RADIUS) -> None:
    """Paint the ring around the widget that has the keyboard focus."""
    painter.setPen(QPen(qcolor(tones().second), 1.5))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawRoundedRect(place.adjusted(0.75, 0.75, -0.75, -0.75), radius, radius)


class IconButton(QToolButton):
    """An icon that can be pressed; its colours follow the theme by themselves.

    Parameters
    ----------
    source : str or Path or None
        Icon of the family, a plugin's SVG, or None for the name's first letter.
    name : str
        What it does; becomes the accessible name and, with the key, the tip.
    on : str, optional
        Another icon while checked; makes the button checkable.
    side : int
        Width and height, px.
    faint : bool
        Shown in the second rank of text until the pointer comes near.
    """

    def __init__(
        self,
        source: str | Path | None,
        name: str,
        parent: QWidget | None = None,
        *,
        on: str | None = None,
        side: int = 28,
        glyph: int = GRID,
        key: str = "",
        faint: bool = False,
    ) -> None:
        super().__init__(parent)
        self._source = source
        self._on = on
        self._glyph = glyph
        self._faint = faint
        self.setFixedSize(QSize(side, side))
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setCheckable(on is not None)
        self.rename(name, key)

    def rename(self, name: str, key: str = "") -> None:
        """Say what it does, and with which key."""
        self.setText(name)
        self.setAccessibleName(name)
        self.setToolTip(f"{name}  ({key})" if key else name)

    def set_source(self, source: str | Path | None) -> None:
        """Show another icon."""
        self._source = source
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self.paint_ground(painter)
        colors = tones()
        color = colors.quiet if self._faint else colors.text
        if not self.isEnabled():
            color = colors.disabled
        elif self.underMouse():
            color = colors.text
        inset = (self.width() - self._glyph) / 2
        place = QRectF(inset, (self.height() - self._glyph) / 2, self._glyph, self._glyph)
        source = self._on if self._on is not None and self.isChecked() else self._source
        painter.setPen(qcolor(color))
        if source is None or not paint_icon(painter, source, place, color):
            painter.setFont(strong_font(self.font()))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, self.text()[:1])
        if self.hasFocus():
            paint_focus(painter, QRectF(self.rect()))

    def paint_ground(self, painter: QPainter) -> None:
        """Paint the background while the pointer is over the icon, or presses it."""
        if not self.isEnabled():
            return
        colors = tones()
        if self.isDown():
            ground = colors.press
        elif self.underMouse():
            ground = colors.hover
        else:
            return
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(qcolor(ground))
        painter.drawRoundedRect(QRectF(self.rect()), RADIUS, RADIUS)
