"""History: the steps as a line with dots; a click goes there."""

from __future__ import annotations

from itertools import zip_longest
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QModelIndex, QPersistentModelIndex, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFrame,
    QListWidget,
    QListWidgetItem,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from bozzetto_app.i18n import tr
from bozzetto_app.style.theme import qcolor, strong_font, text_height, tones
from bozzetto_app.widgets.icon_button import RADIUS

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["HistoryPanel"]

ROW = 28
"""Height of a step, px."""

LINE = 20
"""Where the line of dots runs, px from the left."""

Index = QModelIndex | QPersistentModelIndex


class _Timeline(QStyledItemDelegate):
    """Paints a step: past steps filled, the current one ringed and heavier, later ones hollow."""

    def __init__(self, panel: HistoryPanel) -> None:
        super().__init__(panel)
        self._panel = panel

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        return QSize(80, text_height(ROW))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        # The option's state is a `QStyle` flag: PySide would make that class's forty enums, which
        # takes a twentieth of every start.
        colors = tones()
        place: QRectF = QRectF(option.rect)
        row, current, last = index.row(), self._panel.current, self._panel.count() - 1
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if row == self._panel.hovered:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(qcolor(colors.hover))
            painter.drawRoundedRect(place.adjusted(4, 0, -4, 0), RADIUS, RADIUS)
        middle = QPointF(place.left() + LINE, place.center().y())
        painter.setPen(QPen(qcolor(colors.edge), 1))
        if row > 0:
            painter.drawLine(QPointF(middle.x(), place.top()), middle)
        if row < last:
            painter.drawLine(middle, QPointF(middle.x(), place.bottom()))
        painter.setPen(QPen(qcolor(colors.accent if row == current else colors.quiet), 1.5))
        painter.setBrush(qcolor(colors.panel if row > current else colors.quiet))
        if row == current:
            painter.setBrush(qcolor(colors.accent))
            painter.drawEllipse(middle, 4.5, 4.5)
        else:
            painter.drawEllipse(middle, 3.0, 3.0)
        painter.setPen(qcolor(colors.quiet if row > current else colors.text))
        painter.setFont(strong_font(self._panel.font()) if row == current else self._panel.font())
        room = place.adjusted(LINE + 16, 0, -8, 0)
        words = painter.fontMetrics().elidedText(
            str(index.data()), Qt.TextElideMode.ElideRight, int(room.width())
        )
        painter.drawText(room, Qt.AlignmentFlag.AlignVCenter, words)
        if index == self._panel.currentIndex() and self._panel.hasFocus():
            painter.setPen(QPen(qcolor(colors.second), 1.5))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(place.adjusted(4.75, 0.75, -4.75, -0.75), RADIUS, RADIUS)
        painter.restore()


class HistoryPanel(QListWidget):
    """The document's steps, oldest first."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._session = session
        self._labels: tuple[str, ...] = ()
        self.current = 0
        self.hovered = -1
        """The step under the pointer; -1 if it is elsewhere."""
        self.setObjectName("history")
        self.setWindowTitle(tr("History", "History"))
        self.setAccessibleName(self.windowTitle())
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setItemDelegate(_Timeline(self))
        self.setUniformItemSizes(True)
        self.setViewportMargins(0, 4, 0, 4)
        self.setMouseTracking(True)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.setMinimumSize(200, ROW)
        self.itemClicked.connect(self._go)
        self.itemActivated.connect(self._go)
        self.itemEntered.connect(lambda item: self._hover(self.row(item)))
        self.viewportEntered.connect(lambda: self._hover(-1))
        session.drawing.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        """Show the steps there are now."""
        history = self._session.drawing.history
        labels, before, was = history.entries, self._labels, self.current
        self._labels, self.current = labels, history.position
        for row, (label, old) in enumerate(zip_longest(labels, before[: len(labels)])):
            if label == old and row not in (was, self.current):
                continue
            item = self.item(row)
            if item is None:
                item = QListWidgetItem(self)
            item.setText(label)
            said = tr("History", "{label}, current", label=label) if row == self.current else label
            item.setData(Qt.ItemDataRole.AccessibleTextRole, said)
            item.setToolTip(label)
        while self.count() > len(labels):
            self.takeItem(self.count() - 1)
        if labels:
            self.setCurrentRow(self.current)
            self.scrollToItem(self.item(self.current))
        if self.isVisible():
            self.viewport().update()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self.count():
            self.scrollToItem(self.item(self.current))

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self._hover(-1)

    def _hover(self, row: int) -> None:
        if row != self.hovered:
            self.hovered = row
            self.viewport().update()

    def _go(self, item: QListWidgetItem) -> None:
        row = self.row(item)
        if row != self.current:
            self._session.drawing.go_to(row)
        else:
            self._session.notices.tell(tr("History", "This step is shown already."))
