"""Recovery after a crash: one folder per open document, with a base and a journal.

::

    <store>/<session>/lock            who is alive in there
                      session.json    the document's name and path
                      base-1.bozz     a whole document …
                      journal-1.bin   … and every change since

A save starts a new pair; the old one goes only after the new base is on the disk. Nothing
is ever deleted here without an answer from the person, or their closing the document. What
is deleted is first renamed to ``.discarded-<session>``, so that a process that dies
meanwhile leaves no half of it to be offered.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from bozzetto.atomic_files import DISK, FileStamp, explain
from bozzetto.document.model import Document
from bozzetto.document.recovery.file_lock import FileLock, abandoned_holder
from bozzetto.document.recovery.journal import JournalReader
from bozzetto.document.recovery.journal_records import Replay, record_time
from bozzetto.document.recovery.recovery_session import (
    DISCARDED,
    FACTS,
    LOCK,
    Facts,
    RecoverySession,
    delete,
    facts_of,
)
from bozzetto.document.storage.bozz_file import open_document
from bozzetto.document.storage.bozz_reader import parse_document
from bozzetto.document.storage.zip_container import decode_json
from bozzetto.errors import DocumentError, UserError, words_of
from bozzetto.ink.stroke import Stroke
from bozzetto.temporary_files import remove_leftovers

if TYPE_CHECKING:
    from bozzetto.document.storage.state_codec import StateTypes

__all__ = ["CrashedSession", "Recovered", "RecoverySession", "RecoveryStore"]

UNNAMED: Final = "Untitled"
"""Name of a drawing whose facts cannot be read."""

YOUNG_SECONDS: Final = 60.0
"""A folder without a base that is younger may just be being made."""


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
    host : str
        The other machine that it was open on, where it may still be; "" for this one.
    stamp : FileStamp, optional
        Content of the file at `path` when it was opened or saved last.
    """

    id: str
    name: str
    path: Path | None
    began: float
    complete_to: float
    host: str = ""
    stamp: FileStamp | None = None


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
    is_whole : bool
        Whether everything that was kept could be read.
    """

    document: Document
    pending: tuple[Stroke, ...]
    complete_to: float
    warnings: tuple[str, ...] = ()
    is_whole: bool = True


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
        self._closed = False

    def begin(
        self,
        name: str,
        path: str | os.PathLike[str] | None,
        document: Document,
        stamp: FileStamp | None = None,
    ) -> RecoverySession:
        """Start keeping recovery data of a document.

        Raises
        ------
        UserError
            If the folder cannot be written to.
        """
        folder = self.folder / f"{time.strftime('%Y%m%d-%H%M%S')}-{os.urandom(4).hex()}"
        try:
            folder.mkdir(parents=True)
            DISK.sync_folder(self.folder)
        except OSError as problem:
            raise UserError(explain(problem, str(self.folder))) from problem
        lock = FileLock.acquire(folder / LOCK, name)
        try:
            facts = facts_of(name, path, time.time(), stamp)
            return RecoverySession(folder, lock, facts, document)
        except BaseException:  # nothing of the document's is in there yet
            lock.release()
            shutil.rmtree(folder, ignore_errors=True)
            raise

    def crashed_sessions(self) -> list[CrashedSession]:
        """Return the documents that were open in a process that is gone; the latest change first.

        Those of which all is in their files are left out.

        Raises
        ------
        UserError
            If the folder cannot be read.
        """
        found = []
        for folder in self._folders():
            owner = abandoned_holder(folder / LOCK)
            if folder.name in self._claims or owner is None:
                continue
            try:
                bases = _generations(folder)
            except (FileNotFoundError, NotADirectoryError):  # being discarded
                continue
            except OSError:
                bases = [0]  # it says so when it is opened
            facts = _read_facts(folder)
            if bases and not _is_in_file(folder, facts, bases):
                found.append(
                    CrashedSession(
                        folder.name,
                        facts.name,
                        facts.file(),
                        facts.began,
                        _complete_to(folder, facts.began),
                        owner.host if owner.is_elsewhere else "",
                        facts.stamp,
                    )
                )
        return sorted(found, key=lambda session: -session.complete_to)

    def recover(
        self,
        session: CrashedSession,
        states: StateTypes,
        progress: Callable[[], object] = lambda: None,
    ) -> Recovered:
        """Bring a document back, complete to its last whole record.

        The session is claimed, so that no other window offers it too, until `keep` or
        `discard`. Its data stay where they are: `discard` it once the document that was
        brought back has recovery data of its own, or is saved.

        Parameters
        ----------
        session : CrashedSession
            The session to recover; no other process may have claimed it.
        states : StateTypes
            Source of the modelers' state types.
        progress : callable
            Called whenever another piece was read.

        Raises
        ------
        DocumentError
            If not even a base can be read; the data stay.
        UserError
            If it was claimed already, or the disk fails.
        """
        folder = self.folder / session.id
        with _disk_errors(session, folder, "read"):
            self._claim(session)
            try:
                return _recovered(folder, session, states, progress)
            except BaseException:
                self.keep(session)
                raise

    def keep(self, session: CrashedSession) -> None:
        """Release a session whose recovery the person put off; it is offered again next time."""
        claim = self._claims.pop(session.id, None)
        if claim is not None:
            claim.release()

    def close(self) -> None:
        """Release all claimed sessions, which are offered again; no other is claimed any more.

        Whoever brought one back has recovery data of its own by then, or shows it no longer.
        """
        self._closed = True
        while self._claims:
            with contextlib.suppress(KeyError):  # another thread keeps or discards it
                self._claims.popitem()[1].release()

    def discard(self, session: CrashedSession) -> None:
        """Discard a session that the person gave up, or whose document is open again.

        Raises
        ------
        UserError
            If the data cannot be deleted, or another process has claimed them.
        """
        folder = self.folder / session.id
        with _disk_errors(session, folder, "deleted"):
            if session.id not in self._claims:
                self._claim(session)
            try:
                delete(folder, self._claims[session.id])
            finally:
                self.keep(session)

    def tidy(self) -> None:
        """Delete what a process that died has half deleted, or had not yet begun to fill.

        So is what holds nothing that is not in the file of its document.
        """
        with contextlib.suppress(OSError):
            for folder in self.folder.glob(f"{DISCARDED}*"):
                shutil.rmtree(folder, ignore_errors=True)
        with contextlib.suppress(UserError):
            folders = self._folders()
            for folder in folders:
                with contextlib.suppress(OSError):
                    age = abs(time.time() - folder.stat().st_mtime)
                    is_needless = (age > YOUNG_SECONDS and _is_empty(folder)) or _is_in_file(
                        folder, _read_facts(folder), _generations(folder)
                    )
                    if is_needless and abandoned_holder(folder / LOCK):
                        shutil.rmtree(folder, ignore_errors=True)
            remove_leftovers(folders)

    def _folders(self) -> list[Path]:
        try:
            with os.scandir(self.folder) as entries:
                names = [entry.name for entry in entries]
        except FileNotFoundError:
            return []
        except OSError as problem:
            raise UserError(
                f"The folder of recovered drawings, {self.folder}, cannot be read "
                f"({problem.strerror}). Check its permissions."
            ) from problem
        return [self.folder / name for name in sorted(names) if not name.startswith(".")]

    def _claim(self, session: CrashedSession) -> None:
        if session.id in self._claims:
            raise UserError(f"“{session.name}” is being brought back already.")
        folder = self.folder / session.id
        if not folder.is_dir():
            raise UserError(f"“{session.name}” was brought back, or discarded, already.")
        # A lock of another machine is taken over: the person was told of it, and chose it.
        force = session.host != "" and abandoned_holder(folder / LOCK) is not None
        self._claims[session.id] = FileLock.acquire(folder / LOCK, session.name, force=force)
        if self._closed:
            self.keep(session)
            raise UserError(f"The window that brings “{session.name}” back is closed.")


@contextlib.contextmanager
def _disk_errors(session: CrashedSession, folder: Path, what: str) -> Iterator[None]:
    """Say what the disk refused, and where the data are."""
    try:
        yield
    except OSError as problem:
        raise UserError(
            f"The recovery data of “{session.name}” cannot be {what} now "
            f"({problem.strerror or problem}). They stay in {folder}."
        ) from problem


def _recovered(
    folder: Path, session: CrashedSession, states: StateTypes, progress: Callable[[], object]
) -> Recovered:
    problems: list[str] = []
    unread: OSError | None = None
    for generation in reversed(_generations(folder)):
        place = folder / f"base-{generation}.bozz"
        try:
            base = parse_document(place.read_bytes())
        except (DocumentError, OSError) as problem:
            unread = problem if isinstance(problem, OSError) else unread
            problems.append(f"A later state could not be read: {words_of(problem)}.")
            continue
        progress()
        replay = Replay(base)
        journal = JournalReader(folder / f"journal-{generation}.bin")
        try:
            with contextlib.suppress(FileNotFoundError):  # it came between base and journal
                for record in journal:
                    replay.feed(record)
                    progress()
            if journal.is_damaged:
                problems.append("Later changes could not be read: the journal is damaged.")
        except (DocumentError, OSError) as problem:
            problems.append(f"Later changes could not be read: {words_of(problem)}.")
        document, report = open_document(replay.stored, states)
        last = session.complete_to if replay.time is None else replay.time
        warnings = (*problems, *report.warnings)
        return Recovered(document, replay.pending, last, warnings, not problems)
    if unread is not None:
        raise unread
    raise DocumentError(
        f"The recovery data of “{session.name}” are damaged. They stay in {folder}."
    )


def _read_facts(folder: Path) -> Facts:
    """Read the facts of a session; a drawing without a name where they cannot be read."""
    try:
        return decode_json((folder / FACTS).read_bytes(), Facts)
    except (OSError, DocumentError):
        began = 0.0
        with contextlib.suppress(OSError):
            began = folder.stat().st_mtime
        return Facts(UNNAMED, None, began)


def _generations(folder: Path) -> list[int]:
    """Return the numbers of the bases in a session's folder, ascending."""
    names = (re.fullmatch(r"base-(\d{1,9})\.bozz", path.name) for path in folder.iterdir())
    return sorted(int(found[1]) for found in names if found)


def _is_empty(folder: Path) -> bool:
    """Whether a session died before its first base was whole."""
    return not any(re.match(r"(base|journal)-", path.name) for path in folder.iterdir())


def _is_in_file(folder: Path, facts: Facts, bases: Sequence[int]) -> bool:
    """Whether nothing came after a document was saved, and its file is as it was written."""
    path, stamp = facts.file(), facts.stamp
    if path is None or stamp is None or not bases or facts.saved_as != bases[-1]:
        return False
    try:
        now = path.stat()
        journal = JournalReader(folder / f"journal-{bases[-1]}.bin")
        is_kept = (now.st_size, now.st_mtime_ns) == (stamp.size, stamp.modified)
        return is_kept and next(iter(journal), None) is None and not journal.is_damaged
    except (OSError, DocumentError):
        return False


def _complete_to(folder: Path, otherwise: float) -> float:
    """Return the time of the last change that is kept; the other time where none is recorded."""
    try:
        generation = _generations(folder)[-1]
        last = None
        with contextlib.suppress(FileNotFoundError):
            for last in JournalReader(folder / f"journal-{generation}.bin"):  # noqa: B007
                pass
        if last is not None:
            return record_time(last)
        return (folder / f"base-{generation}.bozz").stat().st_mtime
    except (OSError, IndexError, DocumentError):
        return otherwise
