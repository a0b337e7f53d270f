"""Locks of documents, taken in workers and given back beside the window.

Giving a lock back asks the disk, which may be slow; the window must not wait for it.
"""

from __future__ import annotations

import queue
import threading
import time
from pathlib import Path
from typing import NamedTuple

from bozzetto.document.recovery.file_lock import FileLock, Holder, Locked, document_lock_path
from bozzetto.errors import UserError
from bozzetto_app.i18n import tr

__all__ = ["Claim", "Claims"]


class Claim(NamedTuple):
    """Whether a document may be written to.

    Attributes
    ----------
    lock : FileLock, optional
        Held if it may.
    refusal : str
        Why it may not, in words for the person.
    holder : Holder, optional
        Who has it open, where that is the reason.
    """

    lock: FileLock | None
    refusal: str = ""
    holder: Holder | None = None


class Claims:
    """The locks of one session's documents; may be called from any thread."""

    def __init__(self) -> None:
        self._given_back: queue.SimpleQueue[FileLock] = queue.SimpleQueue()
        self._turn = threading.Lock()

    @property
    def busy(self) -> bool:
        """Whether a lock is being given back."""
        return self._turn.locked() or not self._given_back.empty()

    def acquire(self, path: Path, *, force: bool = False) -> FileLock:
        """In a worker: keep others off a document; see `FileLock.acquire`."""
        self._release_all()  # it may be the one that is being given back
        return FileLock.acquire(document_lock_path(path), path.name, force=force)

    def claim(self, path: Path, held: FileLock | None) -> Claim:
        """In a worker: see whether a document may be written to, and keep others off it.

        Parameters
        ----------
        path : Path
            The file of the document.
        held : FileLock, optional
            The lock of the open document, which may be the same.
        """
        if held is not None and held.path == document_lock_path(path) and held.is_held:
            return Claim(held)
        try:
            return Claim(self.acquire(path))
        except Locked as locked:
            since = time.strftime("%H:%M", time.localtime(locked.holder.since))
            return Claim(
                None,
                tr(
                    "Files",
                    "{user} on {host} has had “{name}” open since {time}. You can look at it "
                    "and save it under another name.",
                    user=locked.holder.user,
                    host=locked.holder.host,
                    name=path.name,
                    time=since,
                ),
                locked.holder,
            )
        except UserError:
            return Claim(
                None,
                tr(
                    "Files",
                    "“{name}” lies where nothing can be written. You can look at it and save "
                    "it elsewhere.",
                    name=path.name,
                ),
            )

    def give_back(self, lock: FileLock) -> None:
        """Release a lock soon, without waiting for the disk."""
        self._given_back.put(lock)
        threading.Thread(target=self._release_all, name="bozzetto-unlock", daemon=True).start()

    def _release_all(self) -> None:
        with self._turn:
            while not self._given_back.empty():
                self._given_back.get().release()
