"""Documents that were opened or saved lately, and names of files that are free."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Final
from urllib.parse import unquote_to_bytes

from bozzetto_app.settings import settings

RECENT: Final = "recent/files"
MOST_RECENT: Final = 10
URI: Final = "file://"


def recent_files() -> list[Path]:
    """Return the documents that were opened or saved lately, newest first.

    The disk is not asked, for it may be slow or far away; those that are gone are left out
    by the next worker that looks.
    """
    kept = settings().value(RECENT, [])
    names = [kept] if isinstance(kept, str) else kept if isinstance(kept, list) else []
    return [_path_of(str(name)) for name in names]


def keep_recent(recent: Iterable[Path]) -> None:
    """Keep the newest of these documents, given newest first, in the settings."""
    settings().setValue(RECENT, [_name_of(path) for path in recent][:MOST_RECENT])


def _name_of(path: Path) -> str:
    """Return a path as settings can hold it: as text, or as a URI if it is no text."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        return path.as_uri()
    return str(path)


def _path_of(name: str) -> Path:
    return Path(os.fsdecode(unquote_to_bytes(name[7:]))) if name.startswith(URI) else Path(name)


def still_there(recent: Iterable[Path], newest: Path) -> list[Path]:
    """Return a document, and those before it that still exist; in a worker."""
    whole = Path(os.path.abspath(newest))
    return [whole, *(path for path in recent if path != whole and path.is_file())]


def free_name(path: Path) -> Path:
    """Return the next name like this that no file has; in a worker."""
    number = 2
    while (free := path.with_stem(f"{path.stem} {number}")).exists():
        number += 1
    return free
