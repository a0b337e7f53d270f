"""The hooks: this file is the public API of the plugin system.

A plugin package implements any of them as functions decorated with `hookimpl`. All
arguments are passed by keyword; an implementation may leave out those it does not need.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pluggy

if TYPE_CHECKING:
    from bozzetto.plugin.modeler import Modeler
    from bozzetto.plugin.panel import PanelHost

PROJECT = "bozzetto"

hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


@hookspec
def bozzetto_modelers() -> Sequence[Modeler[Any, Any]]:  # type: ignore[empty-body]
    """Return the modelers of this plugin.

    Called once, when the first of them is used. The ids must be those that the plugin's
    manifest announces under ``[[modeler]]``; others are refused.
    """


@hookspec
def bozzetto_panel(modeler_id: str, parent: object, host: PanelHost) -> object:
    """Return a Qt widget of the plugin's own for one of its modelers, or None.

    Only called where the manifest names "panel" among the modeler's abilities, when an object of
    it is selected. `parent` is a QWidget; the returned widget is shown in a dock, and destroyed
    when an object of another modeler is selected. `host` gives it the object's state. Its
    window title, or else the modeler's, stands above it. It comes to the front when it is first
    shown, unless its Qt property "behind" is true, for what few objects need; a next step with
    `NextStep.panel` brings it to the front, too.
    """


@hookspec
def bozzetto_faults(file: Path) -> Sequence[str] | None:
    """Return the faults of a file of a kind that is the plugin's own, such as a template.

    Only called where the manifest says ``checks_files = true``, by ``bozzetto plugins check
    FILE``. One sentence for each fault, and none for a file that can be used; None for a file of
    another kind. The file comes from anywhere.
    """
