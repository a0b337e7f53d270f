"""The recovery data of one open document: a base and a journal in a folder of their own."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import msgspec

from bozzetto.atomic_files import FileStamp, atomic_write
from bozzetto.document.recovery.journal import JournalWriter
from bozzetto.document.recovery.journal_records import ChangeWriter
from bozzetto.document.storage.bozz_file import write_document
from bozzetto.document.storage.zip_container import encode_json
from bozzetto.errors import UserError

if TYPE_CHECKING:
    from bozzetto.document.model import Document
    from bozzetto.document.recovery.file_lock import FileLock
    from bozzetto.ink.stroke import Stroke

REBASE_BYTES: Final = 64 << 20
"""A journal longer than this (and than four times its base) makes room for a new base."""

LOCK, FACTS = "lock", "session.json"
DISCARDED: Final = ".discarded-"


class Facts(msgspec.Struct):
    """Facts about the document of a session.

    Attributes
    ----------
    name : str
    path : str or None
        Where it was saved last, as text.
    began : float
        Seconds since 1970.
    raw_path : bytes, optional
        The same place where it is no text.
    stamp : FileStamp, optional
        Of the file there.
    saved_as : int
        Number of the base that holds what the file does; 0 for none.
    """

    name: str
    path: str | None
    began: float
    raw_path: bytes | None = None
    stamp: FileStamp | None = None
    saved_as: int = 0

    def file(self) -> Path | None:
        """Path at which the document was saved last, byte for byte."""
        if self.raw_path is not None:
            return Path(os.fsdecode(self.raw_path))
        return None if self.path is None else Path(self.path)


class RecoverySession:
    """The recovery data of one open document. May be called from any thread.

    Made by `RecoveryStore.begin`.

    Raises
    ------
    UserError
        By every method but `close`: if the disk is full or fails.
    """

    def __init__(self, folder: Path, lock: FileLock, facts: Facts, document: Document) -> None:
        self.folder = folder
        self._lock = lock
        self._facts = facts
        self._generation = 0
        self._guard = threading.Lock()
        self._journal: JournalWriter | None = None
        self._closed = False
        self._pending: tuple[Stroke, ...] = ()
        atomic_write(folder / FACTS, lambda file: file.write(encode_json(facts)))
        self._rebase(document)

    def record(self, document: Document, pending: Sequence[Stroke] = ()) -> None:
        """Keep a snapshot and the ink that waits; what did not change costs nothing.

        After a failure the next call starts over with a whole document.
        """
        with self._guard:
            if self._closed:
                return
            self._pending = tuple(pending)
            journal = self._journal
            if journal is None or journal.is_gone or len(journal) > self._longest:
                self._rebase(document)
            assert self._journal is not None
            content = self._changes.record(document, pending, time.time())
            if content is not None:
                try:
                    self._journal.append(content)
                except UserError:
                    self._stop()
                    raise

    @property
    def is_gone(self) -> bool:
        """Whether the folder was deleted or its disk taken away: nothing is kept there then."""
        try:
            return not self.folder.is_dir()
        except OSError:  # nobody knows; the next write says what is wrong
            return False

    def sync(self) -> None:
        """Bring all that was recorded to the disk before going on."""
        with self._guard:
            if self._journal is not None:
                self._journal.sync()

    def saved(
        self,
        document: Document,
        name: str,
        path: str | os.PathLike[str],
        stamp: FileStamp | None = None,
    ) -> None:
        """Start afresh after the person saved: under which name, and where."""
        with self._guard:
            if self._closed:
                return
            number = self._generation + 1  # of the base that follows
            self._facts = facts_of(name, path, self._facts.began, stamp, number)
            facts = encode_json(self._facts)
            atomic_write(self.folder / FACTS, lambda file: file.write(facts))
            self._rebase(document)

    def close(self) -> None:
        """Delete the recovery data: the person closed the document and knows what happened to it.

        Calls that come later, from a thread that has not heard of it, do nothing.
        """
        with self._guard:
            if self._closed:
                return
            self._closed = True
            self._stop()
            with contextlib.suppress(OSError):  # then it is offered once more
                delete(self.folder, self._lock)

    def set_aside(self) -> None:
        """Keep the recovery data and offer them again: nobody has said that they may go."""
        with self._guard:
            if not self._closed:
                self._closed = True
                self._stop()
                self._lock.release()

    def _rebase(self, document: Document) -> None:
        """Begin a new pair of base and journal; the old one goes when the new one is safe.

        The pair counts from when its base is there. So the ink that waits, which is in no
        base, is brought to the disk before.
        """
        self._stop()
        self._generation += 1
        self._changes = ChangeWriter(document)
        journal = JournalWriter(self.folder / f"journal-{self._generation}.bin")
        try:
            waiting = self._changes.record(document, self._pending, time.time())
            if waiting is not None:
                journal.append(waiting)
                journal.sync()
            base = self.folder / f"base-{self._generation}.bozz"
            written = write_document(document, base, backups=0)
        except BaseException:
            journal.close()
            with contextlib.suppress(OSError):  # without a base it counts for nothing
                os.unlink(journal.path)
            raise
        self._journal = journal
        self._longest = max(REBASE_BYTES, 4 * written.stamp.size)
        with contextlib.suppress(OSError):  # older ones do no harm
            for path in self.folder.iterdir():
                found = re.fullmatch(r"(?:base|journal)-(\d{1,9})\.b.*", path.name)
                if found and int(found[1]) < self._generation:
                    path.unlink()

    def _stop(self) -> None:
        if self._journal is not None:
            self._journal.close()
            self._journal = None


def delete(folder: Path, lock: FileLock) -> None:
    """Delete a session that this process holds: all of it at once, as others see it."""
    if os.name == "nt":  # where a folder with an open file cannot be renamed
        lock.release()
    gone = folder.with_name(DISCARDED + folder.name)
    folder.rename(gone)
    lock.release()
    shutil.rmtree(gone, ignore_errors=True)


def facts_of(
    name: str,
    path: str | os.PathLike[str] | None,
    began: float,
    stamp: FileStamp | None,
    saved_as: int = 0,
) -> Facts:
    """Return facts as JSON can hold them: file names need not be text on every system."""
    shown = None if path is None else _as_text(os.fspath(path))
    raw = None if path is None or shown == os.fspath(path) else os.fsencode(path)
    return Facts(_as_text(name), shown, began, raw, stamp, saved_as)


def _as_text(name: str) -> str:
    return name.encode("utf-8", "replace").decode()
