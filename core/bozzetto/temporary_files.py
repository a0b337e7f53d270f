"""Temporary files beside the files being written, and what a killed process left of them.

A name tells the machine and the process, ``.bozzetto-MACHINE-PID-TOKEN.tmp``, and its file is
locked while it is written. Only a file of this machine whose process is gone, and which
nobody has locked, is a leftover.
"""

from __future__ import annotations

import contextlib
import os
import re
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from bozzetto.file_locks import Taken, take
from bozzetto.processes import is_running, machine_id

NAME: Final = re.compile(r"\.bozzetto-([0-9a-f]{8})-(\d{1,10})-[0-9a-f]{12}\.tmp")


def temporary_path(target: Path) -> Path:
    """Return an unused name in the folder of the file that is to be written."""
    return target.with_name(f".bozzetto-{_machine()}-{os.getpid()}-{os.urandom(6).hex()}.tmp")


def remove_leftovers(folders: Iterable[Path]) -> int:
    """Delete temporary files of processes that are gone; return how many there were.

    A folder that cannot be read, or a file that cannot be deleted, is skipped.
    """
    removed = 0
    for folder in set(folders):
        with contextlib.suppress(OSError), os.scandir(folder) as entries:
            for entry in [entry.name for entry in entries]:
                found = NAME.fullmatch(entry)
                if found and found[1] == _machine() and not is_running(int(found[2])):
                    removed += _removed_if_free(folder / entry)
    return removed


def _removed_if_free(path: Path) -> bool:
    try:
        with open(path, "rb") as file:
            if take(file.fileno()) is Taken.BUSY:
                return False
        path.unlink()
    except OSError:
        return False
    return True


def _machine() -> str:
    return f"{zlib.crc32(machine_id().encode()):08x}"
