"""Recovery data: every change of the document goes to a journal at once.

After a crash at most the stroke under the pen is lost, and the last second of a drag. One
thread writes, in order; of several snapshots that wait only the newest need be written. Nothing
of a plugin's runs in it, so nothing can hold it up but the disk.
"""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer

from bozzetto.document.recovery.recovery import CrashedSession, Recovered, RecoveryStore
from bozzetto.errors import UserError
from bozzetto_app.i18n import tr
from bozzetto_app.paths import crash_log
from bozzetto_app.session.crash_log import files_at_crash
from bozzetto_app.session.document_locks import Claim
from bozzetto_app.session.drawing_record import (
    BroughtBack,
    DrawingRecord,
    NotKept,
    Snapshot,
    State,
)
from bozzetto_app.workers.channel import Channel, Request
from bozzetto_app.workers.main_thread import call_on_main_thread

if TYPE_CHECKING:
    from bozzetto.document.history import History
    from bozzetto.document.recovery.file_lock import FileLock
    from bozzetto.plugin.job import Job
    from bozzetto_app.session.session import Session

__all__ = ["Keeper"]

log = logging.getLogger(__name__)

LATEST_IN_DRAG = 700
"""How old a value of a drag may be before it is written down, ms; the disk may take the rest of a
second. Other changes are written at once."""

LAST_WRITES = 10.0
"""Seconds that the end of the program waits for the disk; later the data are found at the
next start."""


class _OnSheet:
    """The drawing on the sheet, as the window's thread sees it.

    Attributes
    ----------
    last, written : Snapshot, optional
        How it is, set by the window's thread; and what of it the writing thread has written.
    is_unsaved : bool
        Whether something of it is in no file.
    given_up : Snapshot, optional
        What the person said may go; what was drawn since may not.
    """

    def __init__(self, history: History, record: DrawingRecord) -> None:
        self.history = history
        self.record = record
        self.last: Snapshot | None = None
        self.written: Snapshot | None = None
        self.is_unsaved = False
        self.given_up: Snapshot | None = None

    @property
    def may_go(self) -> bool:
        """Whether it is safe in a file, or the person said that it may go as it is."""
        return not self.is_unsaved or (
            self.last is not None
            and self.given_up is not None
            and self.last.document is self.given_up.document
        )


class Keeper(QObject):
    """Writes recovery data of one session, and brings back what others left behind.

    Parameters
    ----------
    session : Session
    folder : Path
        Where recovery data lie; survives a restart of the machine.
    tasks : Queue, optional
        From which the thread that writes takes what it does, in order; None ends it. By default
        one of its own.

    Attributes
    ----------
    files_at_crash : tuple of str
        Source files in which the thread was that crashed last, the innermost first; known once
        `find_crashed` has found something.
    """

    def __init__(
        self,
        session: Session,
        folder: Path,
        tasks: queue.Queue[Callable[[], None] | None] | None = None,
    ) -> None:
        super().__init__(session)
        self._drawing, self._files = session.drawing, session.files
        self._notices, self._registry = session.notices, session.registry
        self.files_at_crash: tuple[str, ...] = ()
        self._store = RecoveryStore(folder)
        self._sheet = _OnSheet(session.drawing.history, DrawingRecord(self._store))
        self._restored: BroughtBack | None = None
        self._coming: set[str] = set()
        self._unwritten: list[_OnSheet] = []
        self._is_told = False
        self._tasks = queue.Queue() if tasks is None else tasks
        self._thread = threading.Thread(target=self._run, name="bozzetto-journal", daemon=True)
        self._thread.start()
        tasks = self._tasks
        self.destroyed.connect(lambda: tasks.put(None))  # whatever way the window ends
        self._looks = Channel("recover", keep_all=True, parent=self)
        self._in_drag = QTimer(self, singleShot=True, interval=LATEST_IN_DRAG)
        self._in_drag.timeout.connect(self._record)
        session.drawing.changed.connect(self._record)
        session.drawing.models_changed.connect(self._value_dragged)
        session.drawing.waiting_changed.connect(self._record)
        session.files.saved.connect(self._saved)
        session.files.given_up.connect(self._given_up)
        if session.drawing.is_modified:
            self._record()

    @property
    def busy(self) -> bool:
        """Whether something is being written, looked for or discarded."""
        return self._tasks.unfinished_tasks > 0 or self._looks.busy

    # -- what a crash left behind --

    def find_crashed(self, found: Callable[[list[CrashedSession]], None]) -> None:
        """Look for documents that were open when their program died."""

        def work(job: Job) -> list[CrashedSession]:
            self._store.tidy()
            crashed = self._store.crashed_sessions()
            if crashed:
                self.files_at_crash = files_at_crash(
                    crash_log(), min(session.complete_to for session in crashed)
                )
            return crashed

        self._looks.submit(Request(work, found, self._complain))

    def recover(
        self, crashed: CrashedSession, ended: Callable[[bool], None] = lambda shown: None
    ) -> None:
        """Bring a crashed drawing back onto the sheet, complete to its last stroke.

        What is on the sheet by then is asked about first, if it is not saved. If it takes long,
        the person is told and may stop it, as with every file.

        Parameters
        ----------
        crashed : CrashedSession
            One of those that were found.
        ended : callable
            Called with whether it is on the sheet; if not, it is offered again.
        """
        files = self._files
        if crashed.id in self._coming:
            return
        self._coming.add(crashed.id)

        def work(job: Job, held: FileLock | None) -> tuple[Recovered, Claim]:
            recovered = self._store.recover(
                crashed, self._registry, lambda: job.checkpoint(0.5, crashed.name)
            )
            claim = Claim(None)
            try:
                if crashed.path is not None:
                    claim = files.claim(crashed.path, held)
                job.checkpoint(1.0, crashed.name)
            except BaseException:  # nobody waits for it any more
                files.leave(claim)
                self._store.keep(crashed)
                raise
            return recovered, claim

        def arrived(answer: tuple[Recovered, Claim]) -> None:
            recovered, claim = answer

            def show() -> None:
                self._coming.discard(crashed.id)
                self._restored = BroughtBack(crashed, recovered.is_whole)
                files.show(
                    claim,
                    recovered.document,
                    crashed.path,
                    saved=False,
                    pending=recovered.pending,
                    stamp=crashed.stamp,
                )
                if recovered.warnings:
                    self._notices.tell(" ".join(recovered.warnings))
                ended(True)

            def refused() -> None:
                self._coming.discard(crashed.id)
                files.leave(claim)
                self._keep_soon(crashed)
                ended(False)

            files.when_safe(show, refused)

        def failed(problem: BaseException) -> None:
            self._coming.discard(crashed.id)
            self._notices.complain(problem)
            ended(False)

        def dropped(answer: tuple[Recovered, Claim]) -> None:
            files.leave(answer[1])
            self._keep_soon(crashed)

        def stopped() -> None:
            self._coming.discard(crashed.id)
            ended(False)

        files.read(
            Request(
                work,
                arrived,
                failed,
                inputs=lambda: files.lock,
                dropped=dropped,
                stopped=stopped,
            )
        )

    def discard(self, crashed: CrashedSession, ended: Callable[[bool], None]) -> None:
        """Delete what a crash left behind; the person said so.

        Parameters
        ----------
        crashed : CrashedSession
            One of those that were found.
        ended : callable
            Called with whether it is gone.
        """

        def failed(problem: BaseException) -> None:
            self._notices.complain(problem)
            ended(False)

        self._looks.submit(
            Request(lambda job: self._store.discard(crashed), lambda _: ended(True), failed)
        )

    # -- what is drawn now --

    def close(self) -> None:
        """Write down what is left: the drawing leaves the sheet, and the program ends."""
        self._leave(self._sheet)
        self._tasks.put(None)

    def wait(self) -> None:
        """Wait for the last writes, at the end of the program."""
        self._thread.join(LAST_WRITES)

    def _value_dragged(self) -> None:
        """Write a drag down now and then: `changed` comes only when it ends or pauses."""
        if self._drawing.is_dragging and not self._in_drag.isActive():
            self._in_drag.start()

    def _record(self) -> None:
        """Write down the document as it is, with the ink that waits."""
        self._in_drag.stop()
        drawing = self._drawing
        if drawing.history is not self._sheet.history:
            self._leave(self._sheet)
            restored, self._restored = self._restored, None
            self._sheet = _OnSheet(drawing.history, DrawingRecord(self._store, restored))
        sheet = self._sheet
        sheet.is_unsaved = drawing.is_modified
        if sheet.last is None and not sheet.is_unsaved:
            return
        sheet.last = self._snapshot()
        self._tasks.put(lambda: self._write(sheet))

    def _snapshot(self) -> Snapshot:
        drawing = self._drawing
        return Snapshot(drawing.title, drawing.path, self._files.stamp, drawing.document)

    def _given_up(self) -> None:
        self._sheet.given_up = self._snapshot()

    def _saved(self, path: Path) -> None:
        sheet, now = self._sheet, self._snapshot()
        if sheet.last is not None:
            self._tasks.put(lambda: self._begin_again(sheet, now))
            self._record()

    def _leave(self, sheet: _OnSheet) -> None:
        """Another drawing takes the place of one; it goes only if the person has answered."""
        if sheet.may_go:
            self._tasks.put(sheet.record.give_up)
            return
        self._tasks.put(lambda: self._set_aside(sheet))

    # -- in the writing thread --

    def _run(self) -> None:
        while True:
            task = self._tasks.get()
            try:
                if task is None:
                    self._let_go()
                    return
                task()
            except NotKept as problem:  # told once, not at each stroke
                if not self._is_told:
                    self._is_told = True
                    call_on_main_thread(self, self._complain, problem)
            except Exception as problem:
                call_on_main_thread(self, self._complain, problem)
            finally:
                self._tasks.task_done()

    def _write(self, sheet: _OnSheet) -> None:
        """Write the newest snapshot, if it is not written yet."""
        for late in tuple(self._unwritten):
            self._unwritten.remove(late)
            self._set_aside(late)
        now = sheet.last
        if now is not None and now is not sheet.written:
            sheet.record.write(now)
            sheet.written = now
            if self._is_told:
                self._is_told = False
                again = tr("Recovery", "What you draw is safe from a crash again.")
                call_on_main_thread(self, self._notices.tell, again)

    def _begin_again(self, sheet: _OnSheet, saved: Snapshot) -> None:
        """Keep only what is in no file: from now on that is what came after a save.

        A later snapshot may have been written already, and is then in no recovery data.
        """
        sheet.written = None
        sheet.record.saved(saved, saved.document)

    def _let_go(self) -> None:
        """Leave a drawing that is still on the sheet to be offered again: nobody has answered.

        So is one that was on its way there.
        """
        try:
            if self._sheet.record.state is not State.LEFT:
                self._set_aside(self._sheet)
        finally:
            self._store.close()

    def _set_aside(self, sheet: _OnSheet) -> None:
        """Leave a drawing to be offered again, with all that was not yet written of it."""
        try:
            self._write(sheet)
        except UserError:
            self._unwritten.append(sheet)  # its turn comes with the next write
            raise
        sheet.record.set_aside()
        name = "" if sheet.last is None else sheet.last.name
        said = tr("Recovery", "“{name}” is kept, and offered at the next start.", name=name)
        call_on_main_thread(self, self._notices.tell, said)

    def _keep_soon(self, crashed: CrashedSession) -> None:
        """Offer again what a crash left behind, without waiting for the disk.

        In a thread of its own, for the one that writes may have ended.
        """
        threading.Thread(
            target=self._store.keep, args=(crashed,), name="bozzetto-unlock", daemon=True
        ).start()

    def _complain(self, problem: BaseException) -> None:
        if not isinstance(problem, UserError):
            log.error("the journal cannot be written", exc_info=problem)
        self._notices.complain(problem)
