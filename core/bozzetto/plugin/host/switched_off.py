"""Plugins that a person switched off: one setting for the window and the command line."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from bozzetto.atomic_files import write_bytes
from bozzetto.errors import UserError

FILE: Final = "plugins.json"
KEY: Final = "disabled"

LARGEST: Final = 1_000_000
"""Bytes of the file beyond which it is none of ours."""


def settings_file() -> Path:
    """Return the file of the setting: in the configuration folder, beside the window's."""
    if sys.platform == "win32":
        folder = Path(os.environ.get("APPDATA") or Path.home() / "AppData/Roaming")
    else:
        folder = Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config")
    return folder / "Bozzetto" / FILE


def switched_off() -> frozenset[str] | None:
    """Return ids of the plugins that are switched off; None where nobody ever switched one.

    A file that cannot be understood counts as none: no plugin is worth not starting for.
    """
    try:
        with settings_file().open("rb") as file:
            told = json.loads(file.read(LARGEST))
    except (OSError, ValueError, RecursionError):
        return None
    ids = told.get(KEY) if isinstance(told, dict) else None
    if not isinstance(ids, list):
        return None
    return frozenset(one for one in ids if isinstance(one, str))


def keep_switched_off(plugins: Iterable[str]) -> None:
    """Remember which plugins are switched off.

    Raises
    ------
    UserError
        If the file cannot be written.
    """
    path = settings_file()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise UserError(
            f"The folder {path.parent} cannot be made: {problem.strerror}. The setting is not kept."
        ) from None
    write_bytes(path, (json.dumps({KEY: sorted(set(plugins))}, indent=2) + "\n").encode())


def switch(plugin: str, on: bool) -> None:
    """Remember that one plugin is on or off; the others stay as they are."""
    before = switched_off() or frozenset()
    keep_switched_off(before - {plugin} if on else before | {plugin})
