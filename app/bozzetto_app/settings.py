"""What the program remembers between two starts."""

from __future__ import annotations

from PySide6.QtCore import QSettings

__all__ = ["ORGANISATION", "PROGRAM", "settings"]

ORGANISATION = "Bozzetto"
PROGRAM = "Bozzetto"


def settings() -> QSettings:
    """The program's settings store (an INI file in the user's configuration folder)."""
    return QSettings(QSettings.Format.IniFormat, QSettings.Scope.UserScope, ORGANISATION, PROGRAM)
