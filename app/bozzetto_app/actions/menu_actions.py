"""Actions of the window: one list, from which menus and keys are made."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import Qt

from bozzetto_app.actions.file_and_edit_actions import edit_commands, file_commands
from bozzetto_app.actions.object_actions import object_commands
from bozzetto_app.actions.registry import Action
from bozzetto_app.actions.view_actions import view_commands
from bozzetto_app.i18n import tr
from bozzetto_app.session.tool_groups import TOOL_KEYS

if TYPE_CHECKING:
    from PySide6.QtGui import QKeyEvent

    from bozzetto_app.main_window import Window

__all__ = ["commands_of", "number_keys", "tool_key_at"]

NUMBER_ROW: Final[Mapping[str, Sequence[int]]] = {
    "linux": range(10, 20),
    "win32": range(2, 12),
    "darwin": (18, 19, 20, 21, 23, 22, 26, 28, 25, 29),
}
"""How systems number the keys of `TOOL_KEYS` above the letters."""


def commands_of(window: Window) -> Iterator[Action]:
    """All commands of a window, in the order of its menus."""
    yield from file_commands(window)
    yield from edit_commands(window)
    yield from object_commands(window)
    yield from view_commands(window)
    yield from _help(window)


def _help(window: Window) -> Iterator[Action]:
    menu = (tr("Menu", "&Help"),)
    yield Action(
        "help.guide",
        tr("Help", "&Guide"),
        window.dialogs.open_guide,
        "help",
        ("Shift+F1",),
        menu,
        tip=tr("Help", "How everything works, with pictures; nothing is fetched from the web"),
    )
    yield Action(
        "help.shortcuts",
        tr("Help", "&Keys and gestures"),
        window.dialogs.open_shortcuts,
        "keyboard",
        ("F1",),
        menu,
    )
    for info in window.session.toolbox.modelers:
        for sample, title in zip(info.samples, info.sample_titles, strict=True):
            yield Action(
                f"help.watch.{info.id}.{sample.stem}",
                f"{info.title}: {title}",
                partial(window.watch, info.id, sample),
                "play",
                (),
                (*menu, tr("Help", "&Watch a drawing")),
            )
    yield Action(
        "help.pen",
        tr("Help", "&Pen tester"),
        window.dialogs.open_pen_tester,
        "pen-tester",
        (),
        menu,
    )
    yield Action(
        "help.plugins", tr("Help", "P&lugins"), window.dialogs.open_plugins, "plugin", (), menu
    )
    yield Action(
        "help.about", tr("Help", "&About Bozzetto"), window.dialogs.open_about, "info", (), menu
    )


def number_keys(window: Window) -> Iterator[Action]:
    """1 … 9 and 0 take what the buttons of the tool rail show, and then the next of their group."""

    def there_is(place: int) -> bool:
        return place < len(window.session.toolbox.groups)

    def take(place: int) -> None:
        if there_is(place):
            window.session.toolbox.take_group(place)

    def too_few() -> str:
        session = window.session
        if not session.toolbox.modeler:
            return tr("Tool", "Choose a modeler at the top right first.")
        title = session.registry.info(session.toolbox.modeler).title
        count = len(session.toolbox.groups)
        return tr(
            "Tool",
            "{title} has fewer tools: their keys are 1 to {count}.",
            title=title,
            count=count,
        )

    for number, key in enumerate(TOOL_KEYS, 1):
        yield Action(
            f"tool.{number}",
            tr("Tool", "Tool {number}").format(number=number),
            partial(take, number - 1),
            keys=(key,),
            enabled=partial(there_is, number - 1),
            why_not=too_few,
        )


def tool_key_at(event: QKeyEvent) -> str:
    """Return the tool key at whose place above the letters a key lies; "" elsewhere.

    French, Belgian, Czech and some other keyboards have signs or letters there, and the numbers
    only with Shift.
    """
    is_mac = sys.platform == "darwin"
    code = event.nativeVirtualKey() if is_mac else event.nativeScanCode()
    row = NUMBER_ROW.get(sys.platform, ())
    if event.modifiers() != Qt.KeyboardModifier.NoModifier or code not in row:
        return ""
    return TOOL_KEYS[row.index(code)]
