"""Actions: one record each, from which menus, shortcuts and the command palette are made."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QAction, QIcon, QKeySequence
from PySide6.QtWidgets import QMenu, QMenuBar, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.style.icons import icon
from bozzetto_app.style.theme import current_palette

__all__ = ["Action", "ActionConflict", "ActionRegistry", "key_text"]

MenuPath = tuple[str, ...]
"""Titles of a menu and the submenus on the way to it."""


def _always() -> bool:
    return True


def _no_reason() -> str:
    return ""


class Action(NamedTuple):
    """Something the program can do on request.

    Parameters
    ----------
    id : str
        "file.save"; unique.
    title : str
        The person's words, translated.
    callback : callable
        Called without arguments.
    icon : str
        Name in the icon family, or "".
    keys : tuple of str
        Portable key sequences ("Ctrl+Shift+S"); the first one is shown.
    menu : tuple of str
        Titles of the menu and its submenus; empty means the palette only.
    group : str
        Actions of one group stand together, between hairlines; submenus stand in the group
        without a name, where their first action was registered.
    enabled : callable
        Whether it can be done now.
    why_not : callable
        Why it cannot be done now and what to do first, in one sentence. Asked only while
        `enabled` says no.
    checked : callable, optional
        Whether it is on; None for actions that are not switches.
    tip : str
        One sentence more, for the status line and the palette.
    on_sheet : bool
        What has the focus gets the keys first: Return, Tab and Backspace mean there what they
        always mean.
    repeats : bool
        Whether it is done again and again while its key is held down. A key that deletes, or
        switches something, must be pressed anew each time.
    """

    id: str
    title: str
    callback: Callable[[], object]
    icon: str = ""
    keys: tuple[str, ...] = ()
    menu: tuple[str, ...] = ()
    group: str = ""
    enabled: Callable[[], bool] = _always
    why_not: Callable[[], str] = _no_reason
    checked: Callable[[], bool] | None = None
    tip: str = ""
    on_sheet: bool = False
    repeats: bool = False

    @property
    def plain_title(self) -> str:
        """The title without the mark of its menu letter."""
        return self.title.replace("&", "")


class ActionConflict(ValueError):
    """Two actions want one id or one key: a mistake of whoever registers them."""


def _portable(key: str) -> str:
    return QKeySequence(key).toString(QKeySequence.SequenceFormat.PortableText)


def key_text(action: Action) -> str:
    """Return the first key of an action as this platform writes it; "" if it has none."""
    if not action.keys:
        return ""
    return QKeySequence(action.keys[0]).toString(QKeySequence.SequenceFormat.NativeText)


class ActionRegistry(QObject):
    """All actions of one window.

    Parameters
    ----------
    window : QWidget
        Its keyboard focus makes the shortcuts work.
    sheet : QWidget, optional
        The part of it whose focus gives the keys of `on_sheet` actions to them first.

    Signals
    -------
    changed
        Actions came or went.
    refused : str
        An action was asked for that cannot be done now: why.
    is_so : str
        A choice was made that had been made before: its words.
    """

    changed = Signal()
    refused = Signal(str)
    is_so = Signal(str)

    def __init__(self, window: QWidget, sheet: QWidget | None = None) -> None:
        super().__init__(window)
        self._window = window
        self._sheet = sheet or window
        self._actions: dict[str, Action] = {}
        self._made: dict[str, QAction] = {}
        self._keys: dict[str, str] = {}
        self._bar: QMenuBar | None = None
        self._menus: dict[MenuPath, QMenu] = {}

    def register(self, *actions: Action) -> Callable[[], None]:
        """Add actions; call what is returned to take them out again.

        Raises
        ------
        ActionConflict
            If an id or a key is taken; then nothing was added.
        """
        keys = dict(self._keys)
        names = set(self._actions)
        for action in actions:
            if action.id in names:
                raise ActionConflict(f"there is an action {action.id!r} already")
            names.add(action.id)
            for key in map(_portable, action.keys):
                if not key or key in keys:
                    raise ActionConflict(
                        f"{action.id!r} wants {key or 'an unknown key'}, "
                        f"which is {keys.get(key, 'no')!r}'s"
                    )
                keys[key] = action.id
        self._keys = keys
        for action in actions:
            self._actions[action.id] = action
            self._made[action.id] = self._make(action)
        self._rebuilt()

        def dispose() -> None:
            for action in actions:
                if self._actions.pop(action.id, None) is None:
                    continue
                made = self._made.pop(action.id)
                self._home(action).removeAction(made)
                made.deleteLater()
                for key in map(_portable, action.keys):
                    del self._keys[key]
            self._rebuilt()

        return dispose

    def holder(self, key: str) -> Action | None:
        """Return the action that has a key; None if the key is free."""
        return self._actions.get(self._keys.get(_portable(key), ""))

    def actions(self) -> tuple[Action, ...]:
        """All actions in the order of their registration."""
        return tuple(self._actions.values())

    def qaction(self, action_id: str) -> QAction:
        """Return the Qt action made from a record."""
        return self._made[action_id]

    def icon(self, action_id: str) -> QIcon:
        """Return the icon of an action in the colours of the theme.

        Menus show none, so it is painted only where one is wanted: it takes milliseconds.
        """
        name = self._actions[action_id].icon
        return icon(name, current_palette()) if name else QIcon()

    def run(self, action_id: str) -> None:
        """Do it, if it can be done now; else say why not."""
        self.refresh()
        if self._made[action_id].isEnabled():
            self._made[action_id].trigger()
        else:
            self.refuse(action_id)

    def refuse(self, action_id: str) -> None:
        """Say why an action cannot be done now."""
        action = self._actions[action_id]
        cannot = tr("Actions", "“{title}” cannot be done now.", title=action.plain_title)
        self.refused.emit(action.why_not() or cannot)

    def take_key(self, key: str, *, again: bool = False) -> bool:
        """Do the action of a key that nothing else wanted, or say why it cannot be done now.

        Parameters
        ----------
        key : str
            As it came to the window: what has the focus had no use for it. So a key of the sheet
            means the same wherever the last click went.
        again : bool
            Whether the key is still held down since an earlier call.

        Returns
        -------
        bool
            Whether any action has the key.
        """
        action = self.holder(key)
        if action is None:
            return False
        if action.repeats or not again:
            self.run(action.id)
        return True

    def refresh(self) -> None:
        """Ask every action whether it can be done and whether it is on."""
        for action_id, action in self._actions.items():
            made = self._made[action_id]
            enabled = action.enabled()
            made.setEnabled(enabled)
            tip = action.tip if enabled else action.why_not() or action.tip
            made.setToolTip(tip or action.plain_title)
            made.setStatusTip(tip)
            if action.checked is not None:
                made.setChecked(action.checked())

    def attach(self, bar: QMenuBar) -> None:
        """Keep a menu bar filled."""
        self._bar = bar
        self._rebuilt()

    def _make(self, action: Action) -> QAction:
        made = QAction(action.title, self._window)
        made.setObjectName(action.id)
        made.setToolTip(action.tip or action.plain_title)
        made.setStatusTip(action.tip)
        made.setShortcuts([QKeySequence(key) for key in action.keys])
        made.setAutoRepeat(action.repeats)
        made.setMenuRole(QAction.MenuRole.NoRole)
        if action.checked is not None:
            made.setCheckable(True)
            made.setChecked(action.checked())
        made.setEnabled(action.enabled())
        made.triggered.connect(lambda: self._do(action))
        if action.on_sheet:
            made.setShortcutContext(Qt.ShortcutContext.WidgetWithChildrenShortcut)
        self._home(action).addAction(made)
        return made

    def _home(self, action: Action) -> QWidget:
        return self._sheet if action.on_sheet else self._window

    def _do(self, action: Action) -> None:
        was_on = action.checked is not None and action.checked()
        action.callback()
        self.refresh()
        if was_on and action.checked is not None and action.checked():
            self.is_so.emit(tr("Actions", "“{title}” is on already.", title=action.plain_title))

    def _rebuilt(self) -> None:
        if self._bar is not None:
            self._fill(self._bar)
        self.changed.emit()

    def _fill(self, bar: QMenuBar) -> None:
        bar.clear()
        for menu in self._menus.values():
            menu.clear()
        entries: dict[MenuPath, dict[str, list[Action | MenuPath]]] = {(): {}}
        for action in self._actions.values():
            for depth in range(1, len(action.menu) + 1):
                path = action.menu[:depth]
                if path not in entries:
                    entries[path] = {}
                    entries[path[:-1]].setdefault("", []).append(path)
            if action.menu:
                entries[action.menu].setdefault(action.group, []).append(action)
        for path in set(self._menus).difference(entries):
            self._menus.pop(path).deleteLater()
        self._add(bar, (), entries)

    def _add(
        self,
        menu: QMenu | QMenuBar,
        path: MenuPath,
        entries: dict[MenuPath, dict[str, list[Action | MenuPath]]],
    ) -> None:
        """Fill a menu, and the menus in it, with hairlines between groups."""
        for number, group in enumerate(entries[path].values()):
            if number:
                menu.addSeparator()
            for entry in group:
                if isinstance(entry, Action):
                    menu.addAction(self._made[entry.id])
                    continue
                inner = self._menu(entry)
                menu.addMenu(inner)
                self._add(inner, entry, entries)

    def _menu(self, path: MenuPath) -> QMenu:
        """Return the menu of a path: filled again and again, for the bar keeps hold of each."""
        if path not in self._menus:
            made = QMenu(path[-1], self._bar)
            made.setToolTipsVisible(True)
            made.aboutToShow.connect(self.refresh)
            self._menus[path] = made
        return self._menus[path]
