"""An object's colour: a disc that opens a small chart."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QAbstractButton, QColorDialog, QFrame, QGridLayout, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import current_palette, qcolor, tones
from bozzetto_app.widgets.icon_button import RADIUS, paint_focus

if TYPE_CHECKING:
    from bozzetto.scene.palette import Color

__all__ = ["Swatch", "chart", "color_name"]

COLUMNS = 6


def chart() -> tuple[tuple[str, Color | None], ...]:
    """Names and colours to choose from; None is the theme's clay."""
    return (
        (tr("Swatch", "Clay"), None),
        (tr("Swatch", "Terracotta"), (0xB9, 0x67, 0x4B)),
        (tr("Swatch", "Ochre"), (0xC7, 0x9A, 0x4B)),
        (tr("Swatch", "Lichen"), (0xA3, 0xA8, 0x6E)),
        (tr("Swatch", "Pine"), (0x5C, 0x80, 0x6B)),
        (tr("Swatch", "Lagoon"), (0x5B, 0x93, 0x9C)),
        (tr("Swatch", "Slate"), (0x60, 0x7A, 0x9C)),
        (tr("Swatch", "Plum"), (0x82, 0x6A, 0x91)),
        (tr("Swatch", "Rose"), (0xBE, 0x84, 0x8A)),
        (tr("Swatch", "Chalk"), (0xE6, 0xE2, 0xDA)),
        (tr("Swatch", "Graphite"), (0x5A, 0x5A, 0x5C)),
    )


def color_name(color: Color | None) -> str:
    """Return the name of a colour in the chart; its digits if it is not in the chart."""
    named = {value: name for name, value in chart()}
    return named.get(color, "#{:02X}{:02X}{:02X}".format(*(color or (0, 0, 0))))


def place_beside(anchor: QRect, size: QSize, free: QRect) -> QPoint:
    """Return where a pop-up of some size is under its anchor, else above, within what is free."""
    below = anchor.bottom() + 1
    fits = below + size.height() <= free.bottom() + 1
    y = below if fits else anchor.top() - size.height()
    rightmost = free.right() + 1 - size.width()
    return QPoint(max(free.left(), min(anchor.left(), rightmost)), max(free.top(), y))


class _Disc(QAbstractButton):
    """A round colour; a dark rim keeps it apart from any ground."""

    def __init__(self, side: int, radius: float, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._radius = radius
        self.color: Color | None = None
        self.setFixedSize(QSize(side, side))
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = QRectF(self.rect()).center()
        if self.underMouse():
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(qcolor(colors.press))
            painter.drawRoundedRect(QRectF(self.rect()), RADIUS, RADIUS)
        painter.setPen(QPen(qcolor(colors.text, 0.55), 1))
        painter.setBrush(qcolor(self.color or current_palette().clay))
        painter.drawEllipse(middle, self._radius, self._radius)
        if self.isChecked():
            painter.setPen(QPen(qcolor(colors.text), 1.5))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawEllipse(middle, self._radius + 3, self._radius + 3)
        if self.hasFocus():
            paint_focus(painter, QRectF(self.rect()))


class _More(QAbstractButton):
    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setFixedSize(QSize(32, 32))
        self.setAccessibleName(tr("Swatch", "Another colour…"))
        self.setToolTip(self.accessibleName())
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        paint_icon(painter, "palette", QRectF(6, 6, 20, 20), tones().text)
        if self.hasFocus():
            paint_focus(painter, QRectF(self.rect()))


class _Chart(QFrame):
    """The pop-up with the colours."""

    chosen = Signal(object)

    def __init__(self, color: Color | None, parent: QWidget) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self.setProperty("shape", "popover")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._color = color
        grid = QGridLayout(self)
        grid.setContentsMargins(8, 8, 8, 8)
        grid.setSpacing(0)
        for place, (name, value) in enumerate(chart()):
            disc = _Disc(32, 9.0, self)
            disc.color = value
            disc.setCheckable(True)
            disc.setChecked(value == color)
            disc.setAccessibleName(name)
            disc.setToolTip(name)
            disc.clicked.connect(lambda _, value=value: self._take(value))
            grid.addWidget(disc, *divmod(place, COLUMNS))
        more = _More(self)
        more.clicked.connect(self._ask)
        grid.addWidget(more, *divmod(len(chart()), COLUMNS))

    def _take(self, value: Color | None) -> None:
        self.chosen.emit(value)
        self.close()

    def _ask(self) -> None:
        start = qcolor(self._color or current_palette().clay)
        picked = QColorDialog.getColor(start, self.parentWidget(), tr("Swatch", "Colour"))
        if picked.isValid():
            self.chosen.emit((picked.red(), picked.green(), picked.blue()))
        self.close()


class Swatch(_Disc):
    """The colour of one object.

    Signals
    -------
    chosen : (r, g, b) or None
        A person chose another one.
    """

    chosen = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(24, 6.0, parent)
        self.clicked.connect(self.open_chart)

    def show_color(self, color: Color | None, owner: str) -> None:
        """Show an object's colour, and say whose it is."""
        self.color = color
        words = tr("Swatch", "Colour of {owner}: {name}", owner=owner, name=color_name(color))
        self.setAccessibleName(words)
        self.setToolTip(words)
        self.update()

    def open_chart(self) -> QWidget:
        """Open the chart under the disc, or as near to it as the screen has room."""
        popup = _Chart(self.color, self)
        popup.chosen.connect(self.chosen)
        popup.adjustSize()
        disc = QRect(self.mapToGlobal(QPoint(0, 0)), self.size())
        popup.move(place_beside(disc, popup.size(), self.screen().availableGeometry()))
        popup.show()
        return popup
