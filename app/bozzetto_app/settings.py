"""Settings that last from one start to the next."""

from __future__ import annotations

from PySide6.QtCore import QSettings

from bozzetto.plugin.host.switched_off import keep_switched_off, switched_off

__all__ = ["ORGANISATION", "PROGRAM", "disabled_plugins", "keep_plugin_disabled", "settings"]

ORGANISATION = "Bozzetto"
PROGRAM = "Bozzetto"
DISABLED_PLUGINS = "plugins/disabled"


def settings() -> QSettings:
    """Return the program's settings (an INI file in the user's configuration folder)."""
    return QSettings(QSettings.Format.IniFormat, QSettings.Scope.UserScope, ORGANISATION, PROGRAM)


def disabled_plugins() -> frozenset[str]:
    """Ids of the plugins that the person switched off, here or on the command line."""
    kept = switched_off()
    if kept is not None:
        return kept
    # Versions before 0.2 kept them among the window's own settings.
    before = settings().value(DISABLED_PLUGINS, [])
    names = [before] if isinstance(before, str) else before if isinstance(before, list) else []
    return frozenset(map(str, names))


def keep_plugin_disabled(plugin: str, disabled: bool) -> None:
    """Remember that a plugin is switched off, or on again; the others stay as they are."""
    kept = disabled_plugins()
    keep_switched_off(kept | {plugin} if disabled else kept - {plugin})
