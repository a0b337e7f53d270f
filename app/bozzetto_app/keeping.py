"""Keeping every stroke: the session's changes go to a journal as they are made.

After a crash at most the stroke under the pen is lost. The journal is written beside the
window's thread; of several changes that wait only the newest snapshot need be written.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject

from bozzetto.document.model import Document
from bozzetto.document.recovery import CrashedSession, Recovered, RecoverySession, RecoveryStore
from bozzetto.errors import UserError
from bozzetto.plugin.job import Job
from bozzetto_app.jobs import Channel, Request
from bozzetto_app.session import Session

__all__ = ["Keeper"]

log = logging.getLogger(__name__)


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
        self._kept: RecoverySession | None = None
        self._recovered: CrashedSession | None = None
        self._channel = Channel("journal", parent=self)
        self._saves = Channel("journal-base", keep_all=True, parent=self)
        session.document_changed.connect(self._record)
        session.pending_changed.connect(self._record)
        session.opened.connect(self._another_document)
        session.files.saved.connect(self._saved)

    @property
    def busy(self) -> bool:
        """Whether something is being written."""
        return self._channel.busy or self._saves.busy

    def crashed(self) -> list[CrashedSession]:
        """Documents that were open when their program died."""
        return self._store.crashed_sessions()

    def recover(self, crashed: CrashedSession, done: Callable[[Recovered], None]) -> None:
        """Bring one back onto the sheet, complete to its last stroke."""

        def work(job: Job) -> Recovered:
            return self._store.recover(crashed, self._session.registry)

        def shown(recovered: Recovered) -> None:
            self._recovered = crashed
            self._session.show_document(
                recovered.document, crashed.path, saved=False, pending=recovered.pending
            )
            done(recovered)

        self._saves.submit(Request(work, shown, self._session.complain))

    def close(self) -> None:
        """The person closed the document and knows what became of it."""
        self._channel.cancel()
        if self._kept is not None:
            self._kept.close()
            self._kept = None

    def _another_document(self) -> None:
        self.close()
        self._record()

    def _record(self) -> None:
        """Write down the document as it is, and the ink that waits."""
        session = self._session
        if self._kept is None and not session.is_modified:
            return
        name, path, document, pending = (
            session.title,
            session.path,
            session.document,
            session.pending,
        )

        def work(job: Job) -> None:
            self._write(name, path, document, pending)

        self._channel.submit(Request(work, self._written, self._failed))

    def _write(
        self, name: str, path: Path | None, document: Document, pending: tuple[object, ...]
    ) -> None:
        if self._kept is None:
            self._kept = self._store.begin(name, path, document)
        self._kept.record(document, pending)  # type: ignore[arg-type]

    def _written(self, answer: None) -> None:
        if self._recovered is not None:
            recovered, self._recovered = self._recovered, None
            self._store.discard(recovered)

    def _failed(self, problem: BaseException) -> None:
        if isinstance(problem, UserError):
            self._session.complain(problem)
        else:
            log.error("the journal cannot be written", exc_info=problem)

    def _saved(self, path: Path) -> None:
        kept, document = self._kept, self._session.document
        if kept is not None:
            self._saves.submit(
                Request(
                    lambda job: kept.saved(document, path.stem, path),
                    lambda answer: None,
                    self._failed,
                )
            )
