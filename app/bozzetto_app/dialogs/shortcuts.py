"""Keys and gestures: the list, searchable."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRectF, QSize, Qt
from PySide6.QtGui import QFontMetrics, QPainter
from PySide6.QtWidgets import (
    QHeaderView,
    QLineEdit,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from bozzetto_app.actions.registry import ActionRegistry, key_text
from bozzetto_app.dialogs.command_palette import paint_key
from bozzetto_app.dialogs.dialog import Page
from bozzetto_app.dialogs.fuzzy_match import fold
from bozzetto_app.i18n import tr
from bozzetto_app.style.theme import qcolor, small_font, strong_font, text_height, tones

__all__ = ["ShortcutsDialog", "gestures"]

ROW = 28

AS_KEY = Qt.ItemDataRole.UserRole

Index = QModelIndex | QPersistentModelIndex


def gestures() -> tuple[tuple[str, str], ...]:
    """Return the gestures of pen, mouse and fingers on the sheet: the effect and the gesture."""
    return (
        (tr("Gestures", "Draw"), tr("Gestures", "Pen, or left button")),
        (tr("Gestures", "Erase"), tr("Gestures", "Eraser end, or Ctrl + pen or left button")),
        (tr("Gestures", "Turn"), tr("Gestures", "Middle button, Alt + pen, one finger")),
        (tr("Gestures", "Move the view"), tr("Gestures", "Shift + middle button, two fingers")),
        (tr("Gestures", "Zoom"), tr("Gestures", "Wheel, Ctrl + middle button, pinch")),
        (tr("Gestures", "Radial menu"), tr("Gestures", "Barrel button, Q")),
        (tr("Gestures", "Cancel a drag"), tr("Gestures", "Esc")),
        (tr("Gestures", "Constrain a drag"), tr("Gestures", "Shift")),
        (tr("Gestures", "Fine motion"), tr("Gestures", "Ctrl")),
    )


class _Key(QStyledItemDelegate):
    """The key as a small cap at the right; a gesture as words."""

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        width = QFontMetrics(small_font(option.font)).horizontalAdvance(str(index.data() or ""))
        return QSize(width + 32, text_height(ROW))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        key = str(index.data() or "")
        if not key:
            return
        place = QRectF(option.rect).adjusted(0, 0, -8, 0)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(small_font(option.font))
        if index.data(AS_KEY):
            paint_key(painter, place.right(), place.center().y(), key)
        else:
            painter.setPen(qcolor(tones().quiet))
            align = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight
            painter.drawText(place, align, key)
        painter.restore()


class ShortcutsDialog(Page):
    """All keys by menu, then the gestures."""

    def __init__(self, actions: ActionRegistry, parent: QWidget | None = None) -> None:
        super().__init__("shortcuts", tr("Shortcuts", "Keys and gestures"), parent)
        self.field = QLineEdit()
        self.field.setPlaceholderText(tr("Shortcuts", "Search by name or key"))
        self.field.setAccessibleName(tr("Shortcuts", "Search"))
        self.field.textChanged.connect(self._filter)
        self.tree = QTreeWidget()
        self.tree.setAccessibleName(self.windowTitle())
        self.tree.setColumnCount(2)
        self.tree.setHeaderHidden(True)
        self.tree.setRootIsDecorated(False)
        self.tree.setIndentation(0)
        self.tree.setItemsExpandable(False)
        self.tree.setItemDelegateForColumn(1, _Key(self.tree))
        self.tree.setSelectionMode(QTreeWidget.SelectionMode.NoSelection)
        self.tree.header().setStretchLastSection(False)
        self.tree.header().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self.tree.header().setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self._groups: dict[str, QTreeWidgetItem] = {}
        self._rows: dict[str, list[QTreeWidgetItem]] = {}
        groups: dict[str, list[tuple[str, str]]] = {}
        for action in actions.actions():
            if action.keys:
                menu = action.menu[0].replace("&", "") if action.menu else tr("Shortcuts", "Tools")
                groups.setdefault(menu, []).append((action.plain_title, key_text(action)))
        for title, rows in groups.items():
            self._add(title, rows, as_keys=True)
        self._add(tr("Shortcuts", "On the sheet"), gestures(), as_keys=False)
        self.tree.expandAll()
        self.column.addWidget(self.field)
        self.column.addWidget(self.tree, 1)
        self.add_button(tr("Shortcuts", "&Close"), default=True).clicked.connect(self.accept)
        self.resize(520, 560)

    def shown(self) -> list[str]:
        """Return the names that match the search."""
        return [row.text(0) for rows in self._rows.values() for row in rows if not row.isHidden()]

    def _add(self, title: str, rows: Sequence[tuple[str, str]], *, as_keys: bool) -> None:
        group = QTreeWidgetItem(self.tree, [title])
        group.setFirstColumnSpanned(True)
        group.setFont(0, strong_font(self.font()))
        group.setSizeHint(0, QSize(80, ROW + 8))
        group.setTextAlignment(0, Qt.AlignmentFlag.AlignBottom | Qt.AlignmentFlag.AlignLeft)
        self._rows[title] = []
        self._groups[title] = group
        for words, key in rows:
            row = QTreeWidgetItem(group, [words, key])
            self._rows[title].append(row)
            row.setSizeHint(0, QSize(80, ROW))
            row.setData(1, AS_KEY, as_keys)

    def _filter(self, typed: str) -> None:
        wanted = fold(typed).split()
        for title, rows in self._rows.items():
            for row in rows:
                text = fold(f"{row.text(0)} {row.text(1)}")
                row.setHidden(not all(word in text for word in wanted))
            self._groups[title].setHidden(all(row.isHidden() for row in rows))
