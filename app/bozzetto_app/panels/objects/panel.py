"""Objects: the models in their order with what they are made of, and below them the underlays."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import QPoint, QSize, Qt, QTimer, Signal
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QListWidgetItem,
    QMenu,
    QVBoxLayout,
    QWidget,
)

from bozzetto_app.i18n import tr
from bozzetto_app.panels.objects.list_widget import GROUP_KEY, KIND, ROW, ObjectList
from bozzetto_app.panels.objects.rows import Entry, entries_of, link_words, place_of_drop
from bozzetto_app.style.theme import text_height
from bozzetto_app.widgets.icon_button import IconButton
from bozzetto_app.widgets.tab_order import last_stop, put_in_tab_order

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.plugin.part_tree import PartTree
    from bozzetto_app.session.session import Session

__all__ = ["ObjectsPanel"]

FLAGS = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable

AT_ONCE: Final = 16
"""Rows in sight that are made before the window is painted again."""

SLICE: Final = 0.008
"""Time for which others are made between two turns of the event loop, seconds."""


class ObjectsPanel(QWidget):
    """The list, and under it what can be done with the chosen row.

    The parts of a model are listed while it is selected and has several, or while a person
    has unfolded it.

    Signals
    -------
    reading_wanted : str
        Other modelers are to read the ink of an object (id).
    """

    reading_wanted = Signal(str)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._session = session
        self._filling = False
        self._entries: list[Entry] = []
        self._shown: dict[Entry, tuple[object, ...]] = {}
        self._tree: PartTree | None = None
        self._parts: dict[str, tuple[Any, int]] = {}
        self._soon = QTimer(self, singleShot=True, interval=0)
        self._soon.timeout.connect(self._make_more)
        self._unfolded: dict[str, bool] = {}
        self._folded_groups: set[tuple[str, str]] = set()
        self.setObjectName("objects")
        self.setWindowTitle(tr("Objects", "Objects"))
        self.setAccessibleName(self.windowTitle())
        self.setMinimumSize(240, 2 * ROW + 8)  # a row and the buttons
        self.list = ObjectList(self)
        self.list.setAccessibleName(self.windowTitle())
        self.list.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.list.customContextMenuRequested.connect(self._open_menu)
        self.list.currentItemChanged.connect(self._chosen)
        self.list.itemClicked.connect(self._clicked)
        self.list.dropped.connect(self.drop)
        self.list.rename_asked.connect(self.rename_current)
        self.list.delete_asked.connect(self.delete_current)
        self.list.group_asked.connect(self.group_chosen)
        self.list.fold_asked.connect(self._fold_current)
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
        session.drawing.changed.connect(self.refresh)
        session.selection.changed.connect(self.refresh)
        session.pictures.placing.changed.connect(self._mark)
        self.refresh()

    def refresh(self) -> None:
        """Show the document as it is now; rows are only rebuilt if the list differs."""
        document = self._session.drawing.document
        wanted = list(
            entries_of(document, self._session.parts.of_model, self._is_open, self._folded_groups)
        )
        if wanted != self._entries:
            self._exchange(wanted)
        models = {model.id: model for model in document}
        for row, entry in enumerate(self._entries):
            if entry.kind != "model" or not self._is_shown(entry, models[entry.id]):
                self._show_row(row, models)
        empty = not document.models and not document.underlays
        self._empty.setVisible(empty)
        self.list.setVisible(not empty)
        self._mark()

    def _show_row(self, row: int, models: Mapping[str, Model]) -> None:
        """Show a row as what it stands for is now, unless it is shown so or still to be made.

        Parameters
        ----------
        row : int
            Its place in the list.
        models : mapping of str to Model
            The objects of the document by their ids.
        """
        from bozzetto_app.panels.objects.object_row import ModelRow, UnderlayRow
        from bozzetto_app.panels.objects.part_row import PartRow

        entry, item = self._entries[row], self.list.item(row)
        document = self._session.drawing.document
        widget = self.list.itemWidget(item)
        if isinstance(widget, ModelRow):
            model = models[entry.id]
            tree = self._session.parts.of_model(model)
            is_open = self._is_open(entry.id) if tree is not None and tree.parts else None
            link = link_words(model, document)
            if self._differs(entry, model, is_open, link):
                widget.show_model(model, is_open, link)
                self._name(item, model.name, link)
        elif isinstance(widget, PartRow):
            tree = self._session.parts.of_model(models[entry.model])
            if tree is None or entry.id not in (places := self._places(tree)):
                return
            part, depth = places[entry.id]
            group = part.id in tree.groups
            is_open = (entry.model, part.id) not in self._folded_groups if group else None
            if self._differs(entry, part, depth, is_open):
                widget.show_part(part, depth, is_open)
                flags = FLAGS | Qt.ItemFlag.ItemIsDragEnabled
                item.setFlags(flags | Qt.ItemFlag.ItemIsDropEnabled if group else flags)
                self._name(item, part.name, widget.sign.accessibleName())
        elif isinstance(widget, UnderlayRow):
            underlay = next(u for u in document.underlays if u.id == entry.id)
            if self._differs(entry, underlay):
                widget.show_underlay(underlay)
                self._name(item, underlay.name)

    def _places(self, tree: PartTree) -> dict[str, tuple[Any, int]]:
        """Return the parts of a tree, and how deep they lie, by their ids."""
        if self._tree is not tree:
            self._tree = tree
            self._parts = {part.id: (part, depth) for part, depth in tree.rows()}
        return self._parts

    def _is_shown(self, entry: Entry, model: Model) -> bool:
        """Whether a row shows an object already, as is soon seen: of a thousand, few differ."""
        before = self._shown.get(entry)
        if before is None or before[0] is not model or model.followed or model.frozen:
            return False
        return before[1] is not None and before[1] is self._is_open(entry.id)

    def _differs(self, entry: Entry, shown: object, *how: object) -> bool:
        """Whether a row does not show this yet; it is taken to show it from now on."""
        before = self._shown.get(entry)
        self._shown[entry] = (shown, *how)
        return before is None or before[0] is not shown or before[1:] != how

    @staticmethod
    def _name(item: QListWidgetItem, *words: str) -> None:
        """Give a row its name for those who cannot see it."""
        name = ", ".join(word for word in words if word)
        item.setData(Qt.ItemDataRole.AccessibleTextRole, name)

    # -- what a person can do --

    def rename_current(self) -> None:
        """Edit the name of what is chosen in place."""
        from bozzetto_app.panels.objects.object_row import NamedRow

        widget = self._current_widget()
        if isinstance(widget, NamedRow):
            widget.edit_name()

    def delete_current(self) -> None:
        """Take what is chosen out: all rows at once where there are several."""
        entry = self._current()
        chosen = self._chosen_entries()
        if len(chosen) > 1 and entry in chosen:
            parts: dict[str, list[str]] = {}
            for other in chosen:
                if other.kind == "part":
                    parts.setdefault(other.model, []).append(other.id)
            models = [other.id for other in chosen if other.kind == "model"]
            underlays = [other.id for other in chosen if other.kind == "underlay"]
            self._session.parts.delete_several(models, parts, underlays)
        elif entry.kind == "model":
            self._session.objects.delete(entry.id)
        elif entry.kind == "part":
            self._session.parts.delete(entry.model, entry.id)
        elif entry.kind == "underlay":
            self._session.objects.delete_underlay(entry.id)

    def group_chosen(self) -> None:
        """Put the chosen parts into a group of their own."""
        entry = self._current()
        if entry.kind == "part":
            chosen = self._chosen_entries()
            ids = [other.id for other in chosen if other.model == entry.model]
            self._session.parts.group(entry.model, ids)

    def ungroup_current(self) -> None:
        """Dissolve the group that is chosen."""
        entry = self._current()
        if entry.kind == "part":
            self._session.parts.ungroup(entry.model, entry.id)

    def chosen_models(self) -> list[str]:
        """Return the ids of the objects of the chosen rows, or that of the selected one."""
        chosen = (
            entry.model if entry.kind == "part" else entry.id
            for entry in self._chosen_entries()
            if entry.kind in ("model", "part")
        )
        models = list(dict.fromkeys(chosen))
        selected = self._session.selection.id
        return models if selected in models else [one for one in (selected,) if one]

    def use_chosen(self, modeler_id: str) -> None:
        """Let the chosen rows be the input of a modeler."""
        chosen = self._chosen_entries()
        whole = [entry.id for entry in chosen if entry.kind == "model"]
        parts: dict[str, list[str]] = {}
        for entry in chosen:
            if entry.kind == "part" and entry.model not in whole:
                parts.setdefault(entry.model, []).append(entry.id)
        if whole or parts:
            self._session.shapes.use(modeler_id, [*whole, *parts], parts)

    def drop(self, source: int, target: int, on: bool) -> None:
        """Move what was dragged from one row to the gap above another, or onto it."""
        entry = self._entries[source]
        if entry.kind == "model" and not on:
            above = [other.id for other in self._entries[:target] if other.kind == "model"]
            place = len(above) - (entry.id in above)
            if place != self._session.drawing.document.place_of(entry.id):
                self._session.objects.move_to(entry.id, place)
        elif entry.kind == "part":
            tree = self._session.parts.of(entry.model)
            goal = None if tree is None else place_of_drop(self._entries, tree, source, target, on)
            if goal is not None:
                self._session.parts.move(entry.model, entry.id, *goal)

    def fold(self, entry: Entry, is_open: bool) -> None:
        """List what a model or a group is made of, or not."""
        if entry.kind == "model":
            self._unfolded[entry.id] = is_open
        elif is_open:
            self._folded_groups.discard((entry.model, entry.id))
        else:
            self._folded_groups.add((entry.model, entry.id))
        self.refresh()

    def _fold_current(self, is_open: bool) -> None:
        from bozzetto_app.panels.objects.object_row import ModelRow
        from bozzetto_app.panels.objects.part_row import PartRow

        widget = self._current_widget()
        if isinstance(widget, ModelRow | PartRow) and widget.fold.isVisibleTo(widget):
            self.fold(self._current(), is_open)

    def _duplicate_current(self) -> None:
        entry = self._current()
        chosen = self._chosen_entries()
        models = [other.id for other in chosen if other.kind == "model"]
        if len(models) > 1 and entry in chosen:
            self._session.objects.duplicate(*models)
        elif entry.kind == "model":
            self._session.objects.duplicate(entry.id)
        elif entry.kind == "part":
            self._session.parts.duplicate(entry.model, entry.id)

    # -- rows --

    def _is_open(self, model_id: str) -> bool:
        """Whether the parts of a model are listed."""
        if model_id in self._unfolded:
            return self._unfolded[model_id]
        tree = self._session.parts.of(model_id) if model_id == self._session.selection.id else None
        # An only part says no more than its object does, unless it is a picture.
        return tree is not None and (
            len(tree.parts) > 1 or any(hasattr(part, "opacity") for part in tree.parts)
        )

    def _current(self) -> Entry:
        row = self.list.currentRow()
        return self._entries[row] if 0 <= row < len(self._entries) else Entry("heading")

    def _chosen_entries(self) -> list[Entry]:
        """Return the chosen objects and parts, in the order of the rows."""
        rows = sorted(self.list.row(item) for item in self.list.selectedItems())
        return [self._entries[row] for row in rows]

    def _exchange(self, wanted: list[Entry]) -> None:
        """Make the rows those that are wanted; the others stay, with the keyboard on them."""
        from difflib import SequenceMatcher

        self._filling = True
        changes = SequenceMatcher(None, self._entries, wanted, autojunk=False).get_opcodes()
        for change, low, high, begin, end in reversed(changes):
            if change == "equal":
                continue
            for row in reversed(range(low, high)):
                self.list.takeItem(row)
                self._shown.pop(self._entries[row], None)
            for place, entry in enumerate(wanted[begin:end]):
                self._insert(low + place, entry)
        self._entries = wanted
        self._filling = False
        self._make_more(AT_ONCE)

    def _insert(self, row: int, entry: Entry) -> None:
        item = QListWidgetItem()
        item.setData(KIND, entry.kind)
        item.setFlags(FLAGS if entry.kind != "heading" else Qt.ItemFlag.NoItemFlags)
        if entry.kind == "model":
            # Parts are dropped on their model to leave all groups.
            drags = Qt.ItemFlag.ItemIsDragEnabled | Qt.ItemFlag.ItemIsDropEnabled
            item.setFlags(FLAGS | drags)
        item.setSizeHint(QSize(80, text_height(ROW)))
        self.list.insertItem(row, item)

    def _make_more(self, least: int = 0) -> None:
        """Make what stands in rows for a moment, those in sight first and at least so many."""
        count = len(self._entries)
        first = max(0, self.list.indexAt(QPoint(1, 1)).row())
        end = monotonic() + SLICE
        models = {model.id: model for model in self._session.drawing.document}
        for row in (*range(first, count), *range(first)):
            if self.list.itemWidget(self.list.item(row)) is not None:
                continue
            if not first <= row < first + least and monotonic() > end:
                self._soon.start()
                return
            self._make_row(row, models)

    def _make_row(self, row: int, models: Mapping[str, Model]) -> None:
        widget = self._widget(self._entries[row])
        self.list.setItemWidget(self.list.item(row), widget)
        above = (self.list.itemWidget(self.list.item(other)) for other in reversed(range(row)))
        before = next(filter(None, map(last_stop, above)), self.list)
        self._show_row(row, models)
        put_in_tab_order(before, (widget,))

    def _current_widget(self) -> QWidget | None:
        """Return what stands in the chosen row."""
        row = self.list.currentRow()
        if row >= 0 and self.list.itemWidget(self.list.item(row)) is None:
            self._make_row(row, {model.id: model for model in self._session.drawing.document})
        return self.list.itemWidget(self.list.currentItem())

    def _widget(self, entry: Entry) -> QWidget:
        from bozzetto_app.panels.objects.object_row import ModelRow, UnderlayRow
        from bozzetto_app.panels.objects.part_row import PartRow

        session = self._session
        if entry.kind == "underlay":
            underlay = next(u for u in session.drawing.document.underlays if u.id == entry.id)
            return UnderlayRow(session, underlay)
        if entry.kind == "heading":
            heading = QLabel(tr("Objects", "Underlays"))
            heading.setProperty("type", "heading")
            heading.setContentsMargins(12, 4, 12, 0)
            return heading
        row = (
            ModelRow(session, session.drawing.document.model(entry.id))
            if entry.kind == "model"
            else PartRow(session, entry.model, entry.id)
        )
        row.folded.connect(lambda is_open: self.fold(entry, is_open))
        return row

    # -- what is chosen --

    def _mark(self) -> None:
        """Let the list say what the session says is chosen."""
        wanted = self._wanted()
        if wanted is None and self._current().kind not in ("model", "part"):
            self._enable()
            return
        self._filling = True
        row = -1 if wanted is None else self._entries.index(wanted)
        if row != self.list.currentRow():
            self.list.choose(row)
        elif row >= 0:
            self.list.item(row).setSelected(True)
        self._filling = False
        self._enable()

    def _wanted(self) -> Entry | None:
        """Return the row of the chosen underlay, of the chosen part, or of the selected model."""
        underlay = self._session.pictures.placing.underlay
        if underlay is not None and (found := Entry("underlay", underlay.id)) in self._entries:
            return found
        selected = self._session.selection.id
        if selected is None:
            return None
        tree = self._session.parts.of(selected)
        part = None if tree is None else Entry("part", tree.selected, selected)
        if part is not None and part in self._entries:
            return part
        model = Entry("model", selected)
        return model if model in self._entries else None

    def _enable(self) -> None:
        kind = self._current().kind
        self._duplicate.setEnabled(kind in ("model", "part"))
        self._delete.setEnabled(kind != "heading")
        nothing = tr("Objects", "Click an object first.")
        for button in (self._duplicate, self._delete):
            name = button.accessibleName()
            button.setToolTip(name if button.isEnabled() else f"{name}\n{nothing}")

    def _chosen(self) -> None:
        """Select the object or part of a row that the person went to."""
        if self._filling:
            return
        entry = self._current()
        if entry.kind == "part":
            self._session.parts.select(entry.model, entry.id)
        elif entry.kind == "model":
            self._session.selection.select(entry.id)
            if self._is_open(entry.id):
                self._session.parts.select(entry.id, "")
        self._session.pictures.placing.choose(entry.id if entry.kind == "underlay" else "")
        self._enable()

    def _clicked(self) -> None:
        """Show the handles of the underlay again, which went when something was drawn."""
        entry = self._current()
        if entry.kind == "underlay":
            self._session.pictures.placing.choose(entry.id)

    # -- the menu --

    def _open_menu(self, place: QPoint) -> None:
        menu = self.menu_for_current()
        if not menu.isEmpty():
            menu.popup(self.list.viewport().mapToGlobal(place))

    def menu_for_current(self) -> QMenu:
        """Return the menu of the chosen row."""
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        entry = self._current()
        if entry.kind in ("model", "part"):
            menu.addAction(tr("Objects", "Rename"), self.rename_current)
            menu.addAction(tr("Objects", "Duplicate"), self._duplicate_current)
        if entry.kind == "model":
            self._add_for_model(menu, self._session.drawing.document.model(entry.id))
        elif entry.kind == "part":
            self._add_for_part(menu, entry, self._session.parts.of(entry.model))
        if entry.kind in ("model", "part"):
            self._add_uses(menu)
        elif entry.kind == "underlay":
            self._add_for_underlay(menu, entry.id)
        if entry.kind != "heading":
            menu.addAction(tr("Objects", "Delete"), self.delete_current)
        return menu

    def _add_for_model(self, menu: QMenu, model: Model) -> None:
        hide = tr("Objects", "Hide") if model.visible else tr("Objects", "Show")
        lock = tr("Objects", "Unlock") if model.locked else tr("Objects", "Lock")
        menu.addSeparator()
        menu.addAction(
            tr("Objects", "Read this ink as…"), lambda: self.reading_wanted.emit(model.id)
        )
        menu.addAction(hide, lambda: self._session.objects.set_visible(model.id, not model.visible))
        menu.addAction(lock, lambda: self._session.objects.set_locked(model.id, not model.locked))
        if model.followed:
            unlink = tr("Objects", "Unlink")
            menu.addAction(unlink, lambda: self._session.objects.unlink(model.id))
        if model.frozen:
            link = tr("Objects", "Link again")
            menu.addAction(link, lambda: self._session.objects.link(model.id))
        menu.addSeparator()

    def _add_for_underlay(self, menu: QMenu, underlay_id: str) -> None:
        pictures = self._session.pictures

        def align() -> None:
            pictures.placing.choose(underlay_id)
            pictures.placing.begin_alignment()

        menu.addAction(tr("Underlay", "Align by two places"), align)
        if pictures.sketch_taker:
            menu.addAction(
                tr("Objects", "Use as sketch for {modeler}", modeler=pictures.sketch_taker),
                lambda: pictures.take_underlay(underlay_id),
            )

    def _add_for_part(self, menu: QMenu, entry: Entry, tree: PartTree | None) -> None:
        if tree is None:
            return
        part = tree.part(entry.id)
        group = menu.addAction(tr("Objects", "Group"), self.group_chosen)
        group.setShortcut(GROUP_KEY)
        if entry.id in tree.groups:
            menu.addAction(tr("Objects", "Ungroup"), self.ungroup_current)
        hide = tr("Objects", "Hide") if part.visible else tr("Objects", "Show")
        menu.addSeparator()
        menu.addAction(
            hide,
            lambda: self._session.parts.set_visible(entry.model, entry.id, not part.visible),
        )
        menu.addSeparator()

    def _add_uses(self, menu: QMenu) -> None:
        takers = self._session.shapes.takers
        if takers:
            uses = menu.addMenu(tr("Objects", "Use as input for"))
            for info in takers:
                uses.addAction(info.title, partial(self.use_chosen, info.id))
            menu.addSeparator()
