"""What survives a crash: one folder per open document, with a base and a journal.

::

    <store>/<session>/lock            who is alive in there
                      session.json    the document's name and path
                      base-1.bozz     a whole document …
                      journal-1.bin   … and every change since

A save starts a new pair; the old one goes only after the new base is on the disk. Nothing
is ever deleted here without an answer from the person, or their closing the document.
"""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from bozzetto.document.changes import ChangeWriter, Replay, record_time
from bozzetto.document.codec import StateTypes
from bozzetto.document.container import decode_json, encode_json
from bozzetto.document.file import open_document, parse_document, write_document
from bozzetto.document.journal import JournalWriter, read_records
from bozzetto.document.lock import FileLock, holder
from bozzetto.document.model import Document
from bozzetto.errors import DocumentError, UserError, words_of
from bozzetto.ink.stroke import Stroke
from bozzetto.storage import atomic_write, explain

__all__ = ["CrashedSession", "Recovered", "RecoverySession", "RecoveryStore"]

REBASE_BYTES: Final = 64 << 20
"""A journal longer than this (and than four times its base) makes room for a new base."""

LOCK, FACTS = "lock", "session.json"


class _Facts(msgspec.Struct):
    name: str
    path: str | None
    began: float


@dataclass(frozen=True)
class CrashedSession:
    """A document whose session did not come to its end.

    Attributes
    ----------
    id : str
    name : str
        The document's, as the person knows it.
    path : Path, optional
        Where it was saved last; None if it never was.
    began, complete_to : float
        When it was opened, and when the last change was made that is kept; seconds since
        1970.
    """

    id: str
    name: str
    path: Path | None
    began: float
    complete_to: float


@dataclass(frozen=True)
class Recovered:
    """A document brought back.

    Attributes
    ----------
    document : Document
    pending : tuple of Stroke
        Ink that was not applied yet.
    complete_to : float
    warnings : tuple of str
        As in `LoadReport`; and where a part of the journal could not be used.
    """

    document: Document
    pending: tuple[Stroke, ...]
    complete_to: float
    warnings: tuple[str, ...] = ()


class RecoverySession:
    """The recovery data of one open document. May be called from any thread.

    Made by `RecoveryStore.begin`.

    Raises
    ------
    UserError
        By every method but `close`: if the disk is full or fails.
    """

    def __init__(self, folder: Path, lock: FileLock, facts: _Facts, document: Document) -> None:
        self.folder = folder
        self._lock = lock
        self._facts = facts
        self._generation = 0
        self._guard = threading.Lock()
        self._journal: JournalWriter | None = None
        self._closed = False
        atomic_write(folder / FACTS, lambda file: file.write(encode_json(facts)))
        self._rebase(document)

    def record(self, document: Document, pending: Sequence[Stroke] = ()) -> None:
        """Keep a snapshot and the ink that waits; what did not change costs nothing.

        After a failure the next call starts over with a whole document.
        """
        with self._guard:
            if self._closed:
                return
            if self._journal is None or len(self._journal) > self._longest:
                self._rebase(document)
            assert self._journal is not None
            content = self._changes.record(document, pending, time.time())
            if content is not None:
                try:
                    self._journal.append(content)
                except UserError:
                    self._stop()
                    raise

    def saved(self, document: Document, name: str, path: str | os.PathLike[str]) -> None:
        """Start afresh after the person saved: under which name, and where."""
        with self._guard:
            if self._closed:
                return
            self._facts = _facts(name, path, self._facts.began)
            facts = encode_json(self._facts)
            atomic_write(self.folder / FACTS, lambda file: file.write(facts))
            self._rebase(document)

    def close(self) -> None:
        """The person closed the document and knows what happened to it: forget all this.

        Calls that come later, from a thread that has not heard of it, do nothing.
        """
        with self._guard:
            self._closed = True
            self._stop()
            self._lock.release()
            shutil.rmtree(self.folder, ignore_errors=True)

    def _rebase(self, document: Document) -> None:
        """Begin a new pair of base and journal; the old one goes when the new one is safe."""
        self._stop()
        self._generation += 1
        base = self.folder / f"base-{self._generation}.bozz"
        write_document(document, base, backups=0)
        self._changes = ChangeWriter(document)
        self._journal = JournalWriter(self.folder / f"journal-{self._generation}.bin")
        self._longest = max(REBASE_BYTES, 4 * base.stat().st_size)
        for old in _generations(self.folder):
            if old < self._generation:
                for stem in ("journal-{}.bin", "base-{}.bozz"):
                    with contextlib.suppress(OSError):
                        (self.folder / stem.format(old)).unlink(missing_ok=True)

    def _stop(self) -> None:
        if self._journal is not None:
            self._journal.close()
            self._journal = None


class RecoveryStore:
    """The folder with the recovery data of all documents that are, or were, open.

    Parameters
    ----------
    folder : path
        Should survive a restart of the machine. Is made where it does not exist.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        self._claims: dict[str, FileLock] = {}

    def begin(
        self, name: str, path: str | os.PathLike[str] | None, document: Document
    ) -> RecoverySession:
        """Start keeping recovery data of a document.

        Raises
        ------
        UserError
            If the folder cannot be written to.
        """
        folder = self.folder / f"{time.strftime('%Y%m%d-%H%M%S')}-{secrets.token_hex(4)}"
        try:
            folder.mkdir(parents=True)
        except OSError as problem:
            raise UserError(explain(problem, str(self.folder))) from problem
        lock = FileLock.acquire(folder / LOCK, name)
        try:
            return RecoverySession(folder, lock, _facts(name, path, time.time()), document)
        except BaseException:  # nothing of the document's is in there yet
            lock.release()
            shutil.rmtree(folder, ignore_errors=True)
            raise

    def crashed_sessions(self) -> list[CrashedSession]:
        """Documents that were open in a process that is gone; the latest change first."""
        found = []
        for folder in self.folder.glob("*/"):
            owner = holder(folder / LOCK)
            if folder.name in self._claims or (owner is not None and not owner.is_gone):
                continue
            with contextlib.suppress(OSError, DocumentError):  # being made, or being discarded
                facts = decode_json((folder / FACTS).read_bytes(), _Facts)
                found.append(
                    CrashedSession(
                        folder.name,
                        facts.name,
                        None if facts.path is None else Path(facts.path),
                        facts.began,
                        _complete_to(folder),
                    )
                )
        return sorted(found, key=lambda session: -session.complete_to)

    def recover(self, session: CrashedSession, states: StateTypes) -> Recovered:
        """Bring a document back, complete to its last whole record.

        The session is claimed, so that no other window offers it too, until `keep` or
        `discard`. Its data stay where they are: `discard` it once the document that was
        brought back has recovery data of its own, or is saved.

        Raises
        ------
        DocumentError
            If not even a base can be read; the data stay.
        UserError
            If another process has claimed it, or the disk fails.
        """
        folder = self.folder / session.id
        self._claims[session.id] = FileLock.acquire(folder / LOCK, session.name)
        problems = []
        for generation in reversed(_generations(folder)):
            try:
                base = parse_document((folder / f"base-{generation}.bozz").read_bytes())
            except (DocumentError, OSError) as problem:
                problems.append(f"A later state could not be read: {words_of(problem)}.")
                continue
            replay = Replay(base)
            try:
                for record in _records(folder, generation):
                    replay.feed(record)
            except DocumentError as problem:
                problems.append(f"Later changes could not be read: {words_of(problem)}.")
            document, report = open_document(replay.stored, states)
            began = (folder / f"base-{generation}.bozz").stat().st_mtime
            time_of_last = began if replay.time is None else replay.time
            return Recovered(document, replay.pending, time_of_last, (*problems, *report.warnings))
        self.keep(session)
        raise DocumentError(
            f"The recovery data of “{session.name}” are damaged. They stay in {folder}."
        )

    def keep(self, session: CrashedSession) -> None:
        """The person said: not now. The session is offered again next time."""
        claim = self._claims.pop(session.id, None)
        if claim is not None:
            claim.release()

    def discard(self, session: CrashedSession) -> None:
        """The person said: away with it, or has the document open again.

        Raises
        ------
        UserError
            If the data cannot be deleted, or another process has claimed them.
        """
        folder = self.folder / session.id
        if session.id not in self._claims:
            self._claims[session.id] = FileLock.acquire(folder / LOCK, session.name)
        try:
            shutil.rmtree(folder)
        except OSError as problem:
            raise UserError(
                f"The recovery data of “{session.name}” cannot be deleted ({problem.strerror}). "
                f"They are in {folder}."
            ) from problem
        del self._claims[session.id]


def _facts(name: str, path: str | os.PathLike[str] | None, began: float) -> _Facts:
    """Facts as JSON can hold them: file names need not be text on every system."""
    shown = None if path is None else os.fspath(path).encode("utf-8", "replace").decode()
    return _Facts(name.encode("utf-8", "replace").decode(), shown, began)


def _generations(folder: Path) -> list[int]:
    """Numbers of the bases in a session's folder, ascending."""
    names = (re.fullmatch(r"base-(\d{1,9})\.bozz", path.name) for path in folder.iterdir())
    return sorted(int(found[1]) for found in names if found)


def _records(folder: Path, generation: int) -> Iterator[bytes]:
    with contextlib.suppress(FileNotFoundError):  # the crash came between base and journal
        yield from read_records(folder / f"journal-{generation}.bin")


def _complete_to(folder: Path) -> float:
    """When the last change that is kept was made."""
    generation = _generations(folder)[-1:]
    if not generation:
        raise DocumentError("There is no base.")
    last = None
    for record in _records(folder, generation[0]):
        last = record
    if last is not None:
        return record_time(last)
    return (folder / f"base-{generation[0]}.bozz").stat().st_mtime
