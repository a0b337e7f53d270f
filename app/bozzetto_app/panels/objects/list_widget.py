"""The list of objects as a widget: the ground of its rows, its keys, and what is dropped."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import (
    QEvent,
    QItemSelectionModel,
    QKeyCombination,
    QModelIndex,
    QPersistentModelIndex,
    QRectF,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QDropEvent, QKeyEvent, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFrame,
    QListWidget,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QWidget,
)

from bozzetto_app.style.theme import qcolor, text_height, tones
from bozzetto_app.widgets.icon_button import RADIUS

__all__ = ["GROUP_KEY", "KIND", "ROW", "ObjectList"]

ROW: Final = 32
"""Height of a row, px."""

KIND: Final = Qt.ItemDataRole.UserRole
"""Where an item keeps what it stands for."""

GROUP_KEY: Final = QKeyCombination(Qt.KeyboardModifier.ControlModifier, Qt.Key.Key_G)

Index = QModelIndex | QPersistentModelIndex


class _Ground(QStyledItemDelegate):
    """The ground of a row: chosen rows have a bar besides their colour."""

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        return QSize(80, text_height(ROW))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        from PySide6.QtWidgets import QStyle  # its forty enums take 4 ms of every start

        if index.data(KIND) == "heading":
            return
        colors = tones()
        place = QRectF(option.rect).adjusted(4, 1, -4, -1)
        state: QStyle.StateFlag = option.state
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(Qt.PenStyle.NoPen)
        if state & QStyle.StateFlag.State_Selected:
            painter.setBrush(qcolor(colors.chosen))
            painter.drawRoundedRect(place, RADIUS, RADIUS)
            painter.setBrush(qcolor(colors.accent))
            painter.drawRoundedRect(
                QRectF(place.left(), place.top() + 6, 3, place.height() - 12), 1.5, 1.5
            )
        elif state & QStyle.StateFlag.State_MouseOver:
            painter.setBrush(qcolor(colors.hover))
            painter.drawRoundedRect(place, RADIUS, RADIUS)
        painter.restore()


class ObjectList(QListWidget):
    """The list itself; it only reports what a person does to its rows.

    Signals
    -------
    dropped : int, int, bool
        The row of that number was let go in the gap above another, or on that one.
    rename_asked, delete_asked, group_asked
        F2, Del, Ctrl+G.
    fold_asked : bool
        The arrow key to the right unfolds (True), the one to the left folds.
    """

    dropped = Signal(int, int, bool)
    rename_asked = Signal()
    delete_asked = Signal()
    group_asked = Signal()
    fold_asked = Signal(bool)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setItemDelegate(_Ground(self))
        self.setUniformItemSizes(True)
        self.setMouseTracking(True)
        self.setDragDropMode(QAbstractItemView.DragDropMode.InternalMove)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setDefaultDropAction(Qt.DropAction.MoveAction)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)

    def choose(self, row: int) -> None:
        """Choose this row and no other; -1 is none.

        `setCurrentRow` leaves what was chosen before chosen, too.
        """
        index = self.model().index(row, 0)
        self.selectionModel().setCurrentIndex(
            index, QItemSelectionModel.SelectionFlag.ClearAndSelect
        )

    def selectionCommand(
        self, index: Index, event: QEvent | None = None
    ) -> QItemSelectionModel.SelectionFlag:
        """Leave the rows chosen that are, where a press is beside all of them.

        What is selected in the document stays selected then, too.
        """
        if not index.isValid():
            return QItemSelectionModel.SelectionFlag.NoUpdate
        return super().selectionCommand(index, event)

    def dropEvent(self, event: QDropEvent) -> None:
        source = self.currentRow()
        target = self.indexAt(event.position().toPoint()).row()
        where = self.dropIndicatorPosition()
        event.setDropAction(Qt.DropAction.IgnoreAction)
        event.accept()
        if source < 0:
            return
        if target < 0 or where == QAbstractItemView.DropIndicatorPosition.OnViewport:
            self.dropped.emit(source, self.count(), False)
        elif where == QAbstractItemView.DropIndicatorPosition.OnItem:
            self.dropped.emit(source, target, True)
        else:
            below = where == QAbstractItemView.DropIndicatorPosition.BelowItem
            self.dropped.emit(source, target + below, False)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_F2:
            self.rename_asked.emit()
        elif event.key() in (Qt.Key.Key_Delete, Qt.Key.Key_Backspace):
            if not event.isAutoRepeat():  # a key that is held would delete all rows
                self.delete_asked.emit()
        elif event.key() in (Qt.Key.Key_Left, Qt.Key.Key_Right):
            self.fold_asked.emit(event.key() == Qt.Key.Key_Right)
        elif event.keyCombination() == GROUP_KEY:
            self.group_asked.emit()
        else:
            super().keyPressEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self.currentItem() is not None:
            self.scrollToItem(self.currentItem())

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.hasFocus() and self.currentItem() is not None:
            place = QRectF(self.visualItemRect(self.currentItem())).adjusted(4, 1, -4, -1)
            painter = QPainter(self.viewport())
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(qcolor(tones().second))
            painter.drawRoundedRect(place.adjusted(0.5, 0.5, -0.5, -0.5), RADIUS, RADIUS)
