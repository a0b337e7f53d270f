"""Where the program keeps what it keeps for itself."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QStandardPaths

__all__ = ["cache_folder", "crash_log", "log_file", "recovery_folder", "state_folder"]


def state_folder() -> Path:
    """Return the program's own folder, made if missing; it survives a restart of the machine."""
    kind = QStandardPaths.StandardLocation.AppLocalDataLocation
    folder = Path(QStandardPaths.writableLocation(kind))
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def cache_folder() -> Path:
    """Where lies what can be made again at any time; it need not exist yet."""
    return Path(QStandardPaths.writableLocation(QStandardPaths.StandardLocation.CacheLocation))


def recovery_folder() -> Path:
    """Where the journals of open documents are."""
    return state_folder() / "recovery"


def crash_log() -> Path:
    """Where crashes of native code leave their tracebacks."""
    return state_folder() / "crash.log"


def log_file() -> Path:
    """Where faults are written with their tracebacks."""
    return state_folder() / "bozzetto.log"
