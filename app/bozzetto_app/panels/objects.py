"""Objects: the models in their order, and under their own heading the underlays."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QPoint, QRectF, QSize, Qt
from PySide6.QtGui import QDropEvent, QKeyEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFrame,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QMenu,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QVBoxLayout,
    QWidget,
)

from bozzetto_app.panels.icon_button import RADIUS, IconButton
from bozzetto_app.panels.object_row import ROW, ModelRow, UnderlayRow
from bozzetto_app.panels.tab_order import put_in_tab_order
from bozzetto_app.theme import qcolor, tones
from bozzetto_app.words import tr

if TYPE_CHECKING:
    from bozzetto_app.session import Session

__all__ = ["ObjectsPanel"]

KIND = Qt.ItemDataRole.UserRole
ID = Qt.ItemDataRole.UserRole + 1

Index = QModelIndex | QPersistentModelIndex


class _Ground(QStyledItemDelegate):
    """The ground of a row: chosen rows have a bar besides their colour."""

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        return QSize(80, ROW)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
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


class _List(QListWidget):
    """The list itself: rows are moved by dragging, but only the session moves models."""

    def __init__(self, panel: ObjectsPanel) -> None:
        super().__init__(panel)
        self._panel = panel
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setItemDelegate(_Ground(self))
        self.setMouseTracking(True)
        self.setDragDropMode(QAbstractItemView.DragDropMode.InternalMove)
        self.setDefaultDropAction(Qt.DropAction.MoveAction)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)

    def dropEvent(self, event: QDropEvent) -> None:
        item = self.currentItem()
        target = self.indexAt(event.position().toPoint()).row()
        if self.dropIndicatorPosition() == QAbstractItemView.DropIndicatorPosition.BelowItem:
            target += 1
        event.setDropAction(Qt.DropAction.IgnoreAction)
        event.accept()
        if item is not None and item.data(KIND) == "model":
            self._panel.drop_at(str(item.data(ID)), target if target >= 0 else self.count())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_F2:
            self._panel.rename_current()
        elif event.key() in (Qt.Key.Key_Delete, Qt.Key.Key_Backspace):
            self._panel.delete_current()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.hasFocus() and self.currentItem() is not None:
            place = QRectF(self.visualItemRect(self.currentItem())).adjusted(4, 1, -4, -1)
            painter = QPainter(self.viewport())
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(qcolor(tones().second))
            painter.drawRoundedRect(place.adjusted(0.5, 0.5, -0.5, -0.5), RADIUS, RADIUS)


class ObjectsPanel(QWidget):
    """The list, and under it what can be done with the chosen object."""

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._session = session
        self._filling = False
        self._shape: tuple[str, ...] = ()
        self.setObjectName("objects")
        self.setWindowTitle(tr("Objects", "Objects"))
        self.setAccessibleName(self.windowTitle())
        self.setMinimumSize(240, 4 * ROW)
        self.list = _List(self)
        self.list.setAccessibleName(self.windowTitle())
        self.list.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.list.customContextMenuRequested.connect(self._open_menu)
        self.list.currentItemChanged.connect(self._chosen)
        self._empty = QLabel(tr("Objects", "Nothing drawn yet."))
        self._empty.setProperty("tone", "quiet")
        self._empty.setContentsMargins(12, 4, 12, 4)
        self._empty.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._duplicate = IconButton("duplicate", tr("Objects", "Duplicate"), faint=True)
        self._delete = IconButton("trash", tr("Objects", "Delete"), faint=True)
        self._duplicate.clicked.connect(self._duplicate_current)
        self._delete.clicked.connect(self.delete_current)
        foot = QHBoxLayout()
        foot.setContentsMargins(8, 0, 8, 4)
        foot.setSpacing(0)
        foot.addStretch(1)
        foot.addWidget(self._duplicate)
        foot.addWidget(self._delete)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 4, 0, 0)
        column.setSpacing(4)
        column.addWidget(self._empty, 1)
        column.addWidget(self.list, 1)
        column.addLayout(foot)
        session.document_changed.connect(self.refresh)
        session.selection_changed.connect(self._mark)
        self.refresh()

    def refresh(self) -> None:
        """Show the document as it is now; rows are only made anew where the list differs."""
        document = self._session.document
        shape = (*(m.id for m in document), "", *(u.id for u in document.underlays))
        if shape != self._shape:
            self._shape = shape
            self._rebuild()
        for row in range(self.list.count()):
            item = self.list.item(row)
            widget = self.list.itemWidget(item)
            if isinstance(widget, ModelRow):
                model = document.model(item.data(ID))
                widget.show_model(model)
                item.setData(Qt.ItemDataRole.AccessibleTextRole, model.name)
            elif isinstance(widget, UnderlayRow):
                underlay = next(u for u in document.underlays if u.id == item.data(ID))
                widget.show_underlay(underlay)
                item.setData(Qt.ItemDataRole.AccessibleTextRole, underlay.name)
        empty = not document.models and not document.underlays
        self._empty.setVisible(empty)
        self.list.setVisible(not empty)
        self._mark()

    def rename_current(self) -> None:
        """Edit the chosen model's name in place."""
        widget = self.list.itemWidget(self.list.currentItem())
        if isinstance(widget, ModelRow):
            widget.edit_name()

    def delete_current(self) -> None:
        """Take the chosen model or underlay out."""
        kind, name = self._current()
        if kind == "model":
            self._session.delete(name)
        elif kind == "underlay":
            self._session.delete_underlay(name)

    def drop_at(self, model_id: str, row: int) -> None:
        """Move a model to the gap above a row of the list."""
        order = [model.id for model in self._session.document]
        place = order.index(model_id)
        target = min(row, len(order))
        target = target - 1 if target > place else target
        if target != place:
            self._session.move_to(model_id, target)

    def _current(self) -> tuple[str, str]:
        item = self.list.currentItem()
        return ("", "") if item is None else (str(item.data(KIND)), str(item.data(ID)))

    def _duplicate_current(self) -> None:
        kind, name = self._current()
        if kind == "model":
            self._session.duplicate(name)

    def _rebuild(self) -> None:
        document = self._session.document
        self._filling = True
        self.list.clear()
        for model in document:
            self._add("model", model.id, ModelRow(self._session, model))
        if document.underlays:
            heading = QLabel(tr("Objects", "Underlays"))
            heading.setProperty("type", "heading")
            heading.setContentsMargins(12, 4, 12, 0)
            self._add("heading", "", heading)
            for underlay in document.underlays:
                self._add("underlay", underlay.id, UnderlayRow(self._session, underlay))
        self._filling = False
        put_in_tab_order(self.list, (self.list, self._duplicate, self._delete))

    def _add(self, kind: str, name: str, widget: QWidget) -> None:
        item = QListWidgetItem(self.list)
        item.setData(KIND, kind)
        item.setData(ID, name)
        flags = Qt.ItemFlag.NoItemFlags
        if kind != "heading":
            flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        if kind == "model":
            flags |= Qt.ItemFlag.ItemIsDragEnabled
        item.setFlags(flags)
        item.setSizeHint(QSize(80, ROW))
        self.list.setItemWidget(item, widget)

    def _mark(self) -> None:
        self._filling = True
        selected = self._session.selected
        for row in range(self.list.count()):
            item = self.list.item(row)
            if item.data(KIND) == "model" and item.data(ID) == selected:
                self.list.setCurrentItem(item)
                break
        else:
            if self._current()[0] == "model":
                self.list.setCurrentItem(None)  # type: ignore[call-overload]
        self._filling = False
        self._enable()

    def _enable(self) -> None:
        kind, _ = self._current()
        self._duplicate.setEnabled(kind == "model")
        self._delete.setEnabled(bool(kind))

    def _chosen(self) -> None:
        if self._filling:
            return
        kind, name = self._current()
        if kind == "model":
            self._session.select(name)
        self._enable()

    def _open_menu(self, place: QPoint) -> None:
        menu = self.menu_for_current()
        if not menu.isEmpty():
            menu.popup(self.list.viewport().mapToGlobal(place))

    def menu_for_current(self) -> QMenu:
        """What can be done with the chosen row."""
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        kind, name = self._current()
        if kind == "model":
            model = self._session.document.model(name)
            hide = tr("Objects", "Hide") if model.visible else tr("Objects", "Show")
            lock = tr("Objects", "Unlock") if model.locked else tr("Objects", "Lock")
            menu.addAction(tr("Objects", "Rename"), self.rename_current)
            menu.addAction(tr("Objects", "Duplicate"), self._duplicate_current)
            menu.addSeparator()
            menu.addAction(hide, lambda: self._session.set_visible(name, not model.visible))
            menu.addAction(lock, lambda: self._session.set_locked(name, not model.locked))
            menu.addSeparator()
        if kind:
            menu.addAction(tr("Objects", "Delete"), self.delete_current)
        return menu
