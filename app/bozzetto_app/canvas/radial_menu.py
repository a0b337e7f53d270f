"""The radial menu at the pen: up to eight things in eight directions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple, Protocol

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, QSizeF, Qt, Signal
from PySide6.QtGui import (
    QFont,
    QFontMetricsF,
    QIcon,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
    QPixmap,
)
from PySide6.QtWidgets import QWidget

from bozzetto.scene.palette import LIGHT, Color, Palette
from bozzetto_app.canvas.input.state_machine import FLICK_TRAVEL
from bozzetto_app.canvas.screen_limits import whole_point
from bozzetto_app.i18n import tr
from bozzetto_app.style.colors import tones_of
from bozzetto_app.style.theme import qcolor, small_font

__all__ = ["MOST_ENTRIES", "MenuEntry", "RadialMenu"]

MOST_ENTRIES: Final = 8
RADIUS: Final = 136.0
INNER: Final = 38.0
"""Radius of the hole in the middle, in which nothing is chosen, pixels."""

SHADOW: Final = 12.0
ICON: Final = 22
SPREAD: Final = 3.0
"""Gap between two neighbours, pixels."""

WIDEST: Final = 72
NARROWEST: Final = 36
"""Widths between which a title is broken into lines, pixels."""

GAP: Final = 2.0
"""Between an icon and its title, pixels."""

SHIFTS: Final = tuple(
    sorted(
        (QPointF(x, y) for x in range(-16, 17, 4) for y in range(-16, 17, 4)),
        key=lambda shift: math.hypot(shift.x(), shift.y()),
    )
)
"""How far from the centre of its sector an entry may be laid out, the nearest first, pixels."""

WRAPPED: Final = Qt.AlignmentFlag.AlignHCenter | Qt.TextFlag.TextWordWrap


class MenuEntry(Protocol):
    """Entry of the menu: an action of the program."""

    @property
    def title(self) -> str:
        """Short name."""
        ...

    @property
    def icon(self) -> QIcon:
        """Picture; may be null."""
        ...

    @property
    def enabled(self) -> bool:
        """Whether it can be chosen now."""
        ...

    def trigger(self) -> object:
        """Do it."""
        ...


class RadialMenu(QWidget):
    """A ring of entries around the place where it was opened.

    Signals
    -------
    closed
        The menu is gone, whether something was chosen or not.
    refused : MenuEntry
        An entry was chosen that cannot be done now.
    """

    closed = Signal()
    refused = Signal(object)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setAccessibleName(tr("RadialMenu", "Radial menu"))
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        side = math.ceil(2 * (RADIUS + SHADOW))
        self.resize(side, side)
        self._palette: Palette = LIGHT
        self._entries: tuple[MenuEntry, ...] = ()
        self._hot = -1
        self._origin = QPointF()
        self.hide()

    @property
    def hot(self) -> int:
        """Index of the entry pointed at; −1 for none."""
        return self._hot

    def set_colors(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = palette
        self.update()

    def open_at(self, place: QPointF, entries: Sequence[MenuEntry]) -> bool:
        """Open around a place of the parent, moved inwards where the ring would not fit.

        Returns
        -------
        bool
            False where there is nothing to show.
        """
        self._entries = tuple(entries)[:MOST_ENTRIES]
        if not self._entries:
            return False
        self._hot = -1
        parent = self.parentWidget()
        room = parent.rect() if parent is not None else self.rect()
        half = self.width() / 2
        x = min(max(place.x(), half), max(room.width() - half, half))
        y = min(max(place.y(), half), max(room.height() - half, half))
        self._origin = QPointF(place)
        self.move(whole_point(x - half, y - half))
        self.show()
        self.raise_()
        self.setFocus(Qt.FocusReason.PopupFocusReason)
        return True

    def point(self, place: QPointF) -> None:
        """Highlight the entry that a flick of the pressed pen would choose."""
        if self.isVisible():
            self._heat(self._sector(place - self._origin, FLICK_TRAVEL))

    def lift(self, *, flicked: bool) -> None:
        """Choose the entry that the pen flicked at before it was lifted, or stay open."""
        if flicked and self.isVisible():
            self._choose(self._hot)

    def close_menu(self) -> None:
        """Go away without choosing."""
        if self.isVisible():
            had_focus = self.hasFocus()
            self.hide()
            parent = self.parentWidget()
            if had_focus and parent is not None:
                parent.setFocus(Qt.FocusReason.PopupFocusReason)
            self.closed.emit()

    # -- events -------------------------------------------------------------------------------

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self._heat(self._sector(event.position() - self._middle(), INNER))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        event.accept()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._choose(self._sector(event.position() - self._middle(), INNER))

    def leaveEvent(self, event: QEvent) -> None:
        self._heat(-1)

    def focusOutEvent(self, event: QEvent) -> None:
        self.close_menu()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        key, count = event.key(), len(self._entries)
        if key in (Qt.Key.Key_Escape, Qt.Key.Key_Q):
            self.close_menu()
        elif key in (Qt.Key.Key_Right, Qt.Key.Key_Down):
            self._heat((self._hot + 1) % count)
        elif key in (Qt.Key.Key_Left, Qt.Key.Key_Up):
            self._heat((self._hot - 1) % count)
        elif key in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space):
            self._choose(self._hot)
        elif Qt.Key.Key_1 <= key < Qt.Key.Key_1 + count:
            self._choose(key - Qt.Key.Key_1)
        else:
            super().keyPressEvent(event)

    # -- choosing -----------------------------------------------------------------------------

    def _middle(self) -> QPointF:
        return QPointF(self.width() / 2, self.height() / 2)

    def _sector(self, offset: QPointF, hole: float) -> int:
        """Return the entry in a direction; the first is straight up, the others clockwise."""
        if math.hypot(offset.x(), offset.y()) < hole or not self._entries:
            return -1
        angle = math.degrees(math.atan2(offset.x(), -offset.y())) % 360.0
        width = 360.0 / len(self._entries)
        return int((angle + width / 2) // width) % len(self._entries)

    def _heat(self, index: int) -> None:
        if index != self._hot:
            self._hot = index
            if index >= 0:
                self.setAccessibleDescription(self._entries[index].title)
            self.update()

    def _choose(self, index: int) -> None:
        if index >= 0 and not self._entries[index].enabled:
            self.refused.emit(self._entries[index])
            return
        self.close_menu()
        if index >= 0:
            self._entries[index].trigger()

    # -- painting -----------------------------------------------------------------------------

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = self._middle()
        self._paint_shadow(painter, middle)
        for index in range(len(self._entries)):
            self._paint_entry(painter, middle, index)
        painter.end()

    def _paint_shadow(self, painter: QPainter, middle: QPointF) -> None:
        from PySide6.QtGui import QRadialGradient  # its 170 presets take 4 ms of every start

        reach = RADIUS + SHADOW
        shade = QRadialGradient(middle + QPointF(0, 3), reach)
        shade.setColorAt((RADIUS - 6) / reach, qcolor((0, 0, 0), 0.20))
        shade.setColorAt(1.0, qcolor((0, 0, 0), 0.0))
        ring = QPainterPath()
        ring.setFillRule(Qt.FillRule.OddEvenFill)
        ring.addEllipse(middle, reach, reach)
        ring.addEllipse(middle, INNER, INNER)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(shade)
        painter.drawPath(ring)

    def _paint_entry(self, painter: QPainter, middle: QPointF, index: int) -> None:
        tones = tones_of(self._palette)
        entry, hot = self._entries[index], index == self._hot
        usable = entry.enabled
        painter.setPen(QPen(qcolor(tones.accent_fill if hot and usable else tones.hairline), 1.0))
        painter.setBrush(qcolor(tones.accent_fill if hot and usable else tones.raised))
        painter.drawPath(sector_path(middle, index, len(self._entries)))
        centre = sector_centre(middle, index, len(self._entries))
        color = tones.on_accent if hot and usable else tones.text if usable else tones.disabled
        font = small_font(self.font())
        painter.setFont(font)
        painter.setPen(qcolor(color))
        icon = entry.icon
        has_icon = icon is not None and not icon.isNull()
        sector = sector_path(middle, index, len(self._entries))
        places = entry_places(sector, centre, font, entry.title, has_icon=has_icon)
        if has_icon:
            tinted = _tinted(icon, color, self.devicePixelRatioF())
            painter.drawPixmap(places.icon.topLeft(), tinted)
        painter.drawText(places.words, WRAPPED, entry.title)


def sector_centre(middle: QPointF, index: int, count: int) -> QPointF:
    """Return the point in a sector around which its entry is laid out."""
    angle = math.radians(360.0 / count * index)
    radius = 0.5 * (INNER + RADIUS) + 4.0
    return middle + QPointF(radius * math.sin(angle), -radius * math.cos(angle))


class EntryPlaces(NamedTuple):
    """Where the icon and the title of an entry stand; the icon's is empty where there is none."""

    icon: QRectF
    words: QRectF

    def are_inside(self, sector: QPainterPath) -> bool:
        """Whether both lie in a sector."""
        return sector.contains(self.words) and (self.icon.isEmpty() or sector.contains(self.icon))


def entry_places(
    sector: QPainterPath, centre: QPointF, font: QFont, title: str, *, has_icon: bool
) -> EntryPlaces:
    """Lay an entry out in its sector: near its centre, in as few lines as there is room for.

    Parameters
    ----------
    sector : QPainterPath
        The area of the entry, pixels.
    centre : QPointF
        Of the sector.
    font : QFont
        Of the title.
    title : str
        Wrapped where it is too long.
    has_icon : bool
        Whether there is an icon above the title.
    """
    metrics = QFontMetricsF(font)
    above = ICON + GAP if has_icon else 0.0
    tried: list[QSizeF] = []
    for width in range(WIDEST, NARROWEST - 1, -4):
        room = QRectF(0.0, 0.0, width, 4.0 * metrics.height())
        size = metrics.boundingRect(room, int(WRAPPED), title).size()
        if size.width() > width or any(size == known for known in tried):
            continue
        tried.append(size)
        for shift in SHIFTS:
            at = centre + shift
            top = at.y() - 0.5 * (above + size.height())
            icon = QRectF(at.x() - ICON / 2, top, ICON, ICON) if has_icon else QRectF()
            words = QRectF(at.x() - size.width() / 2, top + above, size.width(), size.height())
            places = EntryPlaces(icon, words)
            if places.are_inside(sector):
                return places
    narrow = QRectF(centre.x() - NARROWEST / 2, centre.y(), NARROWEST, 2.0 * metrics.height())
    return EntryPlaces(QRectF(centre.x() - ICON / 2, centre.y() - ICON - GAP, ICON, ICON), narrow)


def _tinted(icon: QIcon, color: Color, scale: float) -> QPixmap:
    """Return the icon in one colour, legible on a highlighted sector in both themes."""
    picture = icon.pixmap(QSize(ICON, ICON), scale)
    painter = QPainter(picture)
    painter.setCompositionMode(QPainter.CompositionMode.CompositionMode_SourceIn)
    painter.fillRect(picture.rect(), qcolor(color))
    painter.end()
    return picture


def sector_path(middle: QPointF, index: int, count: int) -> QPainterPath:
    """One piece of the ring, with an even gap to its neighbours."""
    span = 360.0 / count
    path = QPainterPath()
    if count == 1:
        path.setFillRule(Qt.FillRule.OddEvenFill)
        path.addEllipse(middle, RADIUS, RADIUS)
        path.addEllipse(middle, INNER, INNER)
        return path
    start = 90.0 - span * (index + 0.5)
    outer_gap = math.degrees(SPREAD / 2 / RADIUS)
    inner_gap = math.degrees(SPREAD / 2 / INNER)
    outer = QRectF(middle.x() - RADIUS, middle.y() - RADIUS, 2 * RADIUS, 2 * RADIUS)
    inner = QRectF(middle.x() - INNER, middle.y() - INNER, 2 * INNER, 2 * INNER)
    path.arcMoveTo(outer, start + outer_gap)
    path.arcTo(outer, start + outer_gap, span - 2 * outer_gap)
    path.arcTo(inner, start + span - inner_gap, -(span - 2 * inner_gap))
    path.closeSubpath()
    return path
