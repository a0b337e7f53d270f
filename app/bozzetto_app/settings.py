"""What the program remembers between two starts."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QSettings

__all__ = ["ORGANISATION", "PROGRAM", "disabled_plugins", "keep_disabled_plugins", "settings"]

ORGANISATION = "Bozzetto"
PROGRAM = "Bozzetto"
DISABLED_PLUGINS = "plugins/disabled"


def settings() -> QSettings:
    """The program's settings store (an INI file in the user's configuration folder)."""
    return QSettings(QSettings.Format.IniFormat, QSettings.Scope.UserScope, ORGANISATION, PROGRAM)


def disabled_plugins() -> set[str]:
    """Ids of the plugins that the person switched off."""
    kept = settings().value(DISABLED_PLUGINS, [])
    if isinstance(kept, str):
        return {kept}
    return {str(plugin) for plugin in kept} if isinstance(kept, list) else set()


def keep_disabled_plugins(plugins: Iterable[str]) -> None:
    """Remember which plugins are switched off."""
    settings().setValue(DISABLED_PLUGINS, sorted(plugins))
