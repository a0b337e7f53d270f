"""The one line on an empty sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from PySide6.QtCore import Qt
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from bozzetto.scene.contrast import readable
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto_app.style.theme import qcolor

if TYPE_CHECKING:
    from PySide6.QtCore import QPropertyAnimation

__all__ = ["SheetHint"]

FADE: Final = 400
"""Length of the fading, milliseconds."""

PLATE: Final = 16
"""How far the plate under the line reaches beyond it, pixels."""

BESIDE: Final = 48
"""Pixels beside the line that stay free, so that its plate is no band across the sheet."""

NARROWER: Final = 4
"""Pixels by which each side is moved in while the line has no more lines of text."""

LOW: Final = 0.6
"""Share of the sheet's height above the line: what a modeler shows on an empty sheet is there."""

LARGER: Final = 1.5
"""Size of the line against the system's type."""


class SheetHint(QWidget):
    """Says what to do first, and fades with the first ink."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.text = ""
        self.left = 0
        """How much of the sheet's left is covered by something else, pixels."""
        self._palette: Palette = LIGHT
        self._fading: QPropertyAnimation | None = None
        self.hide()

    def set_colors(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = palette
        self.update()

    def say(self, text: str) -> None:
        """Show a line; "" shows nothing."""
        if self._fading is not None:
            self._fading.stop()
            self._fading = None
            self.setGraphicsEffect(None)  # type: ignore[arg-type]  # Qt documents null
        self.text = text
        self.setAccessibleName(text)
        self.setVisible(bool(text))
        self.update()

    @property
    def is_read(self) -> bool:
        """Whether the line stands there, and is not fading."""
        return bool(self.text) and self._fading is None

    def fade(self) -> None:
        """Take the line away softly."""
        if not self.isVisible() or self._fading is not None:
            return
        from PySide6.QtCore import QEasingCurve, QPropertyAnimation
        from PySide6.QtWidgets import QGraphicsOpacityEffect

        effect = QGraphicsOpacityEffect(self)
        self.setGraphicsEffect(effect)
        self._fading = QPropertyAnimation(effect, b"opacity", self)
        self._fading.setDuration(FADE)
        self._fading.setStartValue(1.0)
        self._fading.setEndValue(0.0)
        self._fading.setEasingCurve(QEasingCurve.Type.OutCubic)
        self._fading.finished.connect(lambda: self.say(""))
        self._fading.start()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        high = round(LOW * self.height())
        room = self.rect().adjusted(self.left + BESIDE, high, -BESIDE, 0)
        flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
        for larger in (LARGER, 1.0):
            font = self.font()
            font.setPointSizeF(font.pointSizeF() * larger)
            painter.setFont(font)
            words = painter.boundingRect(room, int(flags), self.text)
            if room.contains(words):
                # As narrow as the lines allow: the last one is no lone word.
                while room.width() > 2 * NARROWER:
                    less = room.adjusted(NARROWER, 0, -NARROWER, 0)
                    found = painter.boundingRect(less, int(flags), self.text)
                    if found.height() > words.height() or not less.contains(found):
                        break
                    room, words = less, found
                break
        else:
            return  # a strip beside the panels: the status line says the same
        palette = self._palette
        painter.setPen(qcolor(readable(palette.ghost, palette.ink, palette.paper)))
        # On a plate of paper: a modeler may show a box, or a picture, beneath.
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        ink = painter.pen()
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(qcolor(palette.paper, 0.85))
        painter.drawRoundedRect(words.adjusted(-PLATE, -PLATE // 2, PLATE, PLATE // 2), 8, 8)
        painter.setPen(ink)
        painter.drawText(room, flags, self.text)
        painter.end()
