"""Submenus whose entries come and go: recent documents, kept views, a modeler's commands."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtGui import QKeySequence

from bozzetto.document import edit
from bozzetto_app.actions.registry import Action, ActionRegistry
from bozzetto_app.i18n import tr
from bozzetto_app.session.recent_files import recent_files

if TYPE_CHECKING:
    from bozzetto.document.model import NamedView
    from bozzetto_app.main_window import Window
    from bozzetto_app.session.modeler_commands import ModelerCommands

__all__ = ["RECENT", "ChangingMenus", "recent_titles"]

RECENT = "file.recent."
"""What the ids of recent documents begin with; the palette lists them in its own way."""

COMMAND = "command."
"""What the ids of a modeler's commands begin with."""

RESERVED = ("Space", "Esc")
"""Keys that the sheet takes for itself, beside those of actions."""

DIGITS = 9
"""The first entries have a digit as their menu letter."""


def recent_titles(paths: Sequence[Path]) -> list[str]:
    """Names of documents; with the folder where two have the same name."""
    count = Counter(path.stem for path in paths)
    return [
        path.stem if count[path.stem] == 1 else f"{path.stem} ({path.parent.name})"
        for path in paths
    ]


def _plain(title: str) -> str:
    """Words that are no menu letter's mark, whatever is in them."""
    return title.replace("&", "&&")


def _not_now(title: str, help_: str, commanding: ModelerCommands) -> str:
    """Return why a command cannot be run: only the modeler knows, so its help is added."""
    if commanding.is_for_none:
        words = tr("Object", "“{title}” needs an object. Draw one first.", title=title)
    else:
        words = tr("Object", "“{title}” cannot be used on this object as it is now.", title=title)
    return f"{words} {help_}".strip()


class ChangingMenus(QObject):
    """Keeps these submenus as they should be now.

    Parameters
    ----------
    window : Window
    actions : ActionRegistry
        Has the window's other commands already.
    """

    def __init__(self, window: Window, actions: ActionRegistry) -> None:
        super().__init__(window)
        self._window = window
        self._actions = actions
        self._dispose: dict[str, Callable[[], None]] = {}
        self._views: tuple[NamedView, ...] = ()
        window.session.files.recent_changed.connect(self.show_recent)
        window.session.drawing.changed.connect(self._show_views)
        window.session.commands.changed.connect(self._show_commands)
        window.session.commands.enabled_changed.connect(actions.refresh)
        window.session.advice.changed.connect(actions.refresh)
        self.show_recent()
        self._show_views()

    def keep_view(self) -> None:
        """Ask for a name, and keep the view under it; an old name is given another view."""
        from PySide6.QtWidgets import QInputDialog

        session = self._window.session
        taken = {view.name for view in session.drawing.document.views}
        number = len(taken) + 1
        while (name := tr("View", "View {number}", number=number)) in taken:
            number += 1
        camera = session.view.camera
        dialog = QInputDialog(self._window)
        dialog.setWindowTitle(tr("View", "Keep this view"))
        dialog.setLabelText(tr("View", "Name of the view"))
        dialog.setTextValue(name)
        dialog.textValueSelected.connect(
            lambda wish: session.objects.edit(edit.add_view, wish.strip() or name, camera)
        )
        dialog.finished.connect(dialog.deleteLater)
        dialog.open()

    def show_recent(self) -> None:
        """List the documents that were opened or saved lately."""
        self._replace("recent", self._recent())

    def _show_views(self) -> None:
        views = self._window.session.drawing.document.views
        if views != self._views:
            self._views = views
            self._replace("views", self._kept())

    def _show_commands(self) -> None:
        self._replace("commands", self._commands())

    def _replace(self, which: str, actions: Iterator[Action]) -> None:
        self._dispose.pop(which, lambda: None)()
        self._dispose[which] = self._actions.register(*actions)

    def _recent(self) -> Iterator[Action]:
        menu = (tr("Menu", "&File"), tr("File", "Open &recent"))
        paths = recent_files()
        for number, (path, title) in enumerate(zip(paths, recent_titles(paths), strict=True), 1):
            digit = f"&{number} " if number <= DIGITS else ""
            yield Action(
                f"{RECENT}{number}",
                f"{digit}{_plain(title)}",
                partial(self._window.open, path),
                menu=menu,
                tip=str(path),
            )

    def _commands(self) -> Iterator[Action]:
        """Yield the commands of the selected or the active modeler, in a menu of their own.

        A key that another action has stays with that action.
        """
        commanding = self._window.session.commands
        if not commanding.commands:
            return
        title = self._window.session.registry.info(commanding.modeler).title
        menu = (tr("Menu", "&Object"), _plain(title))
        own: dict[str, str] = {}
        for command in commanding.commands:
            key = QKeySequence(command.key).toString(QKeySequence.SequenceFormat.PortableText)
            holder = self._actions.holder(key)
            taken = own.get(key) if holder is None else holder.plain_title
            free = key and taken is None and key not in RESERVED
            tip = command.help
            if key and not free:
                tip += " " + tr("Object", "Another command has its key, {key}.", key=key)
            if free:
                own[key] = command.title
            yield Action(
                f"{COMMAND}{command.id}",
                _plain(command.title),
                partial(commanding.run, command.id),
                keys=(key,) if free else (),
                menu=(*menu, _plain(command.menu)) if command.menu else menu,
                enabled=partial(commanding.is_enabled, command.id),
                why_not=partial(_not_now, command.title, command.help, commanding),
                tip=tip.strip(),
            )

    def _kept(self) -> Iterator[Action]:
        session, canvas = self._window.session, self._window.canvas
        menu = (tr("Menu", "&View"), tr("View", "&Kept views"))
        for view in self._views:
            yield Action(
                f"view.kept.{view.name}",
                _plain(view.name),
                partial(canvas.views.show_camera, view.camera),
                "orbit",
                menu=menu,
                group="kept",
            )
        for view in self._views:
            yield Action(
                f"view.forget.{view.name}",
                _plain(view.name),
                partial(session.objects.edit, edit.delete_view, view.name),
                menu=(*menu, tr("View", "&Forget")),
            )
