"""The command palette: everything by name, with its key beside it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import (
    QEvent,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QPoint,
    QRectF,
    QSize,
    Qt,
)
from PySide6.QtGui import QFontMetricsF, QKeyEvent, QPainter, QPen
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QVBoxLayout,
    QWidget,
)

from bozzetto_app.dialogs.palette_entries import Entry, Found, entries_of, search
from bozzetto_app.i18n import tr
from bozzetto_app.settings import settings
from bozzetto_app.style.icons import GRID, paint_icon
from bozzetto_app.style.theme import qcolor, small_font, strong_font, text_height, tones
from bozzetto_app.widgets.icon_button import RADIUS
from bozzetto_app.widgets.section import hairline

if TYPE_CHECKING:
    from bozzetto_app.actions.registry import ActionRegistry
    from bozzetto_app.session.session import Session

__all__ = ["CommandPalette", "paint_key"]

WIDTH = 560
ROW = 36
MOST_ROWS = 10
"""Rows shown without scrolling."""

MOST_USED = 5
"""How many used entries are remembered."""

USED = "palette/used"
"""Setting: ids of the entries used last."""

FOUND = Qt.ItemDataRole.UserRole

Index = QModelIndex | QPersistentModelIndex


def _used() -> list[str]:
    kept = settings().value(USED, [])
    if isinstance(kept, str):
        return [kept]
    return [str(one) for one in kept] if isinstance(kept, list) else []


def paint_key(painter: QPainter, right: float, middle: float, key: str) -> float:
    """Paint a key as a small cap; return its left edge, px."""
    colors = tones()
    metrics = QFontMetricsF(painter.font())
    width = metrics.horizontalAdvance(key) + 12
    cap = QRectF(right - width, middle - 10, width, 20)
    painter.setPen(QPen(qcolor(colors.edge), 1))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawRoundedRect(cap.adjusted(0.5, 0.5, -0.5, -0.5), RADIUS, RADIUS)
    painter.setPen(qcolor(colors.quiet))
    painter.drawText(cap, Qt.AlignmentFlag.AlignCenter, key)
    return cap.left()


class _Line(QStyledItemDelegate):
    """Icon, name with the matched letters heavier, kind, key."""

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        return QSize(WIDTH, text_height(ROW))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        found: Found = index.data(FOUND)
        entry, colors = found.entry, tones()
        state: QStyle.StateFlag = option.state
        place = QRectF(option.rect)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if state & QStyle.StateFlag.State_Selected:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(qcolor(colors.chosen))
            painter.drawRoundedRect(place.adjusted(4, 1, -4, -1), RADIUS, RADIUS)
            painter.setBrush(qcolor(colors.accent))
            painter.drawRoundedRect(QRectF(4, place.top() + 8, 3, place.height() - 16), 1.5, 1.5)
        color = colors.text if entry.enabled else colors.disabled
        glyph = QRectF(16, place.center().y() - GRID / 2, GRID, GRID)
        paint_icon(painter, entry.icon, glyph, color if entry.enabled else colors.disabled)
        right = place.right() - 16
        plain = painter.font()
        painter.setFont(small_font(plain))
        if entry.key:
            right = paint_key(painter, right, place.center().y(), entry.key) - 12
        painter.setPen(qcolor(colors.quiet))
        width = QFontMetricsF(painter.font()).horizontalAdvance(entry.kind)
        painter.drawText(
            QRectF(right - width, place.top(), width, place.height()),
            Qt.AlignmentFlag.AlignVCenter,
            entry.kind,
        )
        painter.setFont(plain)
        painter.setPen(qcolor(color))
        self._paint_title(
            painter, found, QRectF(48, place.top(), right - width - 60, place.height())
        )
        painter.restore()

    def _paint_title(self, painter: QPainter, found: Found, room: QRectF) -> None:
        plain, strong = painter.font(), strong_font(painter.font())
        x = room.left()
        for place, letter in enumerate(found.entry.title):
            hit = place in found.match.places
            painter.setFont(strong if hit else plain)
            width = QFontMetricsF(painter.font()).horizontalAdvance(letter)
            if x + width > room.right():
                break
            at = QRectF(x, room.top(), width + 2, room.height())
            painter.drawText(at, Qt.AlignmentFlag.AlignVCenter, letter)
            if hit:
                painter.fillRect(QRectF(x, room.center().y() + 8, width, 1), painter.pen().color())
            x += width


class CommandPalette(QFrame):
    """A pop-up that is used with the keyboard alone: type, arrows, Enter, Esc.

    Parameters
    ----------
    actions : ActionRegistry
    session : Session
    recent : callable
        Recent documents, newest first.
    open_document : callable
        Opens one of them.
    focus_parameter : callable
        Brings a parameter (by field name) under the keyboard.
    """

    def __init__(
        self,
        actions: ActionRegistry,
        session: Session,
        parent: QWidget | None = None,
        *,
        recent: Callable[[], Sequence[Path]] = tuple,
        open_document: Callable[[Path], object] = lambda path: None,
        focus_parameter: Callable[[str], object] = lambda name: None,
    ) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self._actions = actions
        self._session = session
        self._recent = recent
        self._open_document = open_document
        self._focus_parameter = focus_parameter
        self._entries: list[Entry] = []
        self._most_rows = MOST_ROWS
        self.setObjectName("palette")
        self.setWindowTitle(tr("Palette", "Find a command"))
        self.setAccessibleName(self.windowTitle())
        self.setProperty("shape", "popover")
        self.field = QLineEdit()
        self.field.setProperty("frameless", "true")
        self.field.setPlaceholderText(
            tr("Palette", "Find a command, tool, parameter, object or document")
        )
        self.field.setAccessibleName(self.windowTitle())
        self.field.textChanged.connect(self._search)
        self.field.installEventFilter(self)
        self.list = QListWidget()
        self.list.setAccessibleName(tr("Palette", "What was found"))
        self.list.setItemDelegate(_Line(self.list))
        self.list.setUniformItemSizes(True)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.list.setMouseTracking(True)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setStyleSheet("background: transparent")
        self.list.itemEntered.connect(self.list.setCurrentItem)
        self.list.itemClicked.connect(lambda item: self._run())
        self._nothing = QLabel(tr("Palette", "Nothing has that name."))
        self._nothing.setProperty("tone", "quiet")
        self._nothing.setContentsMargins(16, 8, 16, 12)
        top = QHBoxLayout()
        top.setContentsMargins(16, 12, 16, 8)
        top.addWidget(self.field)
        column = QVBoxLayout(self)
        column.setContentsMargins(1, 1, 1, 5)
        column.setSpacing(4)
        column.addLayout(top)
        column.addWidget(hairline())
        column.addWidget(self.list)
        column.addWidget(self._nothing)

    def open_over(self, window: QWidget) -> None:
        """Open it under the top of a window, empty."""
        self._actions.refresh()
        self._look()
        self._actions.changed.connect(self._follow)
        self._session.toolbox.tool_changed.connect(self._follow)
        self.field.clear()
        width = min(WIDTH, window.width() - 32)
        self.setFixedWidth(width)
        corner = QPoint((window.width() - width) // 2, min(96, window.height() // 8))
        self._search()
        left = window.height() - corner.y() - (self.height() - self.list.height())
        self._most_rows = max(1, min(MOST_ROWS, left // ROW))
        self._search()
        self.move(window.mapToGlobal(corner))
        self.show()
        self.field.setFocus(Qt.FocusReason.PopupFocusReason)

    def _look(self) -> None:
        self._entries = list(
            entries_of(
                self._actions,
                self._session,
                recent=self._recent(),
                open_document=self._open_document,
                focus_parameter=self._focus_parameter,
            )
        )

    def _follow(self) -> None:
        """Find what came meanwhile, too: a modeler names its commands once it is imported."""
        if not self.isVisible():
            return
        item = self.list.currentItem()
        chosen = "" if item is None else item.data(FOUND).entry.id
        before = [entry.id for entry in self._entries]
        self._look()
        if before == [entry.id for entry in self._entries]:
            return
        self._search()
        for row in range(self.list.count()):
            if self.list.item(row).data(FOUND).entry.id == chosen:
                self.list.setCurrentRow(row)

    def _search(self) -> None:
        found = search(self.field.text(), self._entries, _used())
        self.list.clear()
        for one in found:
            item = QListWidgetItem(self.list)
            item.setData(FOUND, one)
            said = f"{one.entry.title}, {one.entry.kind}"
            item.setData(
                Qt.ItemDataRole.AccessibleTextRole,
                f"{said}, {one.entry.key}" if one.entry.key else said,
            )
        rows = min(len(found), self._most_rows)
        self.list.setVisible(rows > 0)
        self.list.setFixedHeight(rows * ROW)
        self._nothing.setVisible(rows == 0)
        self.list.setCurrentRow(0)
        self.adjustSize()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self.field and isinstance(event, QKeyEvent):
            if event.type() == QEvent.Type.KeyPress:
                return self._key(event)
        return super().eventFilter(watched, event)

    def _key(self, event: QKeyEvent) -> bool:
        count = self.list.count()
        steps = {
            Qt.Key.Key_Down: 1,
            Qt.Key.Key_Tab: 1,
            Qt.Key.Key_Up: -1,
            Qt.Key.Key_Backtab: -1,
            Qt.Key.Key_PageDown: MOST_ROWS,
            Qt.Key.Key_PageUp: -MOST_ROWS,
        }.get(Qt.Key(event.key()))
        if steps is not None and count:
            row = self.list.currentRow() + steps
            if abs(steps) == 1:
                row %= count
            self.list.setCurrentRow(min(max(row, 0), count - 1))
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._run()
        elif event.key() == Qt.Key.Key_Escape:
            self.close()
        else:
            return False
        return True

    def _run(self) -> None:
        item = self.list.currentItem()
        if item is None:
            return
        entry: Entry = item.data(FOUND).entry
        if entry.enabled:
            used = [entry.id, *(one for one in _used() if one != entry.id)]
            settings().setValue(USED, used[:MOST_USED])
        self.close()
        entry.run()  # what cannot be done says why
