"""Keeping every stroke: the session's changes go to a journal as they are made.

After a crash at most the stroke under the pen is lost. One thread writes, in order; of
several snapshots that wait only the newest need be written. Nothing of a plugin's runs in
it, so nothing can hold it up but the disk.
"""

from __future__ import annotations

import logging
import queue
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from PySide6.QtCore import QObject

from bozzetto.document.history import History
from bozzetto.document.model import Document
from bozzetto.document.recovery import CrashedSession, Recovered, RecoverySession, RecoveryStore
from bozzetto.errors import UserError
from bozzetto.plugin.job import Job
from bozzetto_app.doorbell import ring
from bozzetto_app.files import Claim
from bozzetto_app.jobs import Channel, Request
from bozzetto_app.session import Session

__all__ = ["Keeper"]

log = logging.getLogger(__name__)

RECOVER_LIMIT = 60.0
"""Seconds that bringing a drawing back may take before it counts as hung."""

LAST_WRITES = 10.0
"""Seconds that closing waits for the disk; later the data are found at the next start."""


class _Snapshot(NamedTuple):
    name: str
    path: Path | None
    document: Document


@dataclass(eq=False)
class _Book:
    """What is kept of one document while it is open.

    Attributes
    ----------
    newest : deque
        The snapshot to be written, if there is one: a newer one takes its place.
    kept : RecoverySession, optional
        Used by the writing thread alone.
    brought_back : CrashedSession, optional
        Forgotten once this book has everything that was in it.
    """

    history: History
    brought_back: CrashedSession | None = None
    begun: bool = False
    newest: deque[_Snapshot] = field(default_factory=lambda: deque(maxlen=1))
    kept: RecoverySession | None = None


class Keeper(QObject):
    """Writes recovery data of one session, and brings back what others left behind.

    Parameters
    ----------
    session : Session
    folder : Path
        Where recovery data lie; survives a restart of the machine.
    """

    def __init__(self, session: Session, folder: Path) -> None:
        super().__init__(session)
        self._session = session
        self._store = RecoveryStore(folder)
        self._book = _Book(session.history)
        self._coming: CrashedSession | None = None
        self._tasks: queue.Queue[Callable[[], None] | None] = queue.Queue()
        self._thread = threading.Thread(target=self._run, name="bozzetto-journal", daemon=True)
        self._thread.start()
        self._reads = Channel("recover", keep_all=True, time_limit=RECOVER_LIMIT, parent=self)
        session.document_changed.connect(self._record)
        session.pending_changed.connect(self._record)
        session.files.saved.connect(self._saved)

    @property
    def busy(self) -> bool:
        """Whether something is being written or brought back."""
        return self._tasks.unfinished_tasks > 0 or self._reads.busy

    # -- what a crash left behind --

    def find_crashed(self, found: Callable[[list[CrashedSession]], None]) -> None:
        """Look for documents that were open when their program died."""
        self._reads.submit(
            Request(lambda job: self._store.crashed_sessions(), found, self._complain)
        )

    def recover(self, crashed: CrashedSession) -> None:
        """Bring one back onto the sheet, complete to its last stroke."""
        session = self._session

        def work(job: Job) -> tuple[Recovered, Claim]:
            recovered = self._store.recover(crashed, session.registry)
            path = crashed.path
            return recovered, session.files.claim(path) if path is not None else Claim(None)

        def shown(answer: tuple[Recovered, Claim]) -> None:
            recovered, claim = answer
            self._coming = crashed
            session.files.show(
                claim, recovered.document, crashed.path, saved=False, pending=recovered.pending
            )
            for warning in recovered.warnings:
                session.tell(warning)

        self._reads.submit(Request(work, shown, session.complain))

    # -- what is drawn now --

    def close(self) -> None:
        """The person closed the document and knows what became of it."""
        self._end_book(self._book)
        self._tasks.put(None)
        self._thread.join(LAST_WRITES)

    def _record(self) -> None:
        """Write down the document as it is, with the ink that waits."""
        session = self._session
        if session.history is not self._book.history:
            self._end_book(self._book)
            self._book = _Book(session.history, self._coming)
            self._coming = None
        book = self._book
        if not book.begun and not session.is_modified:
            return
        book.begun = True
        book.newest.append(_Snapshot(session.title, session.path, session.document))
        self._tasks.put(lambda: self._write(book))

    def _saved(self, path: Path) -> None:
        book, document = self._book, self._session.document

        def begin_afresh() -> None:
            if book.kept is not None:
                book.kept.saved(document, path.stem, path)

        if book.begun:
            self._tasks.put(begin_afresh)
            self._record()

    def _end_book(self, book: _Book) -> None:
        def end() -> None:
            book.newest.clear()
            if book.kept is not None:
                book.kept.close()
                book.kept = None

        self._tasks.put(end)

    # -- in the writing thread --

    def _run(self) -> None:
        while True:
            task = self._tasks.get()
            try:
                if task is None:
                    return
                task()
            except Exception as problem:
                ring(self, self._complain, problem)
            finally:
                self._tasks.task_done()

    def _write(self, book: _Book) -> None:
        if not book.newest:
            return
        now = book.newest.pop()
        if book.kept is None:
            book.kept = self._store.begin(now.name, now.path, now.document)
        book.kept.record(now.document)
        if book.brought_back is not None:
            crashed, book.brought_back = book.brought_back, None
            self._store.discard(crashed)

    def _complain(self, problem: BaseException) -> None:
        if isinstance(problem, UserError):
            self._session.complain(problem)
        else:
            log.error("the journal cannot be written", exc_info=problem)
