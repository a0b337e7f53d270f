"""A process that dies: its files stay, its lock files too, and nobody holds them."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bozzetto.document.recovery.recovery import RecoverySession
from bozzetto.document.recovery.recovery_session import LOCK

__all__ = ["crash", "left_behind"]


@contextmanager
def left_behind(folder: Path) -> Iterator[list[str]]:
    """Let a process die that keeps recovery data in a folder.

    In the block it lets go of them in an orderly way. Afterwards those that it deleted or
    released there are as they were before, with lock files that nobody holds.

    Yields
    ------
    list of str
        After the block: the names of these recovery data.
    """
    names: list[str] = []
    with tempfile.TemporaryDirectory(prefix="bozzetto-left-") as place:
        before = Path(place, "before")
        if folder.is_dir():
            shutil.copytree(folder, before)
        yield names
        for lock in before.glob(f"[!.]*/{LOCK}"):
            data, now = lock.parent, folder / lock.parent.name
            if not (now / LOCK).exists():
                shutil.rmtree(now, ignore_errors=True)
                shutil.move(data, now)
                names.append(data.name)


def crash(session: RecoverySession) -> None:
    """Let the process die that keeps the recovery data of a session."""
    with left_behind(session.folder.parent):
        session.set_aside()
