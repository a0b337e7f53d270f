"""Opening and saving documents, in workers.

No dialog is shown here: `bozzetto_app.dialogs.file_dialogs` asks the person.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from PySide6.QtCore import QObject, Signal

from bozzetto.atomic_files import FileChanged, FileStamp, Over, Written
from bozzetto.document.model import Document
from bozzetto.document.recovery.file_lock import FileLock, Locked, document_lock_path
from bozzetto.temporary_files import remove_leftovers
from bozzetto_app.i18n import tr
from bozzetto_app.session.document_locks import Claim, Claims
from bozzetto_app.session.notices import Notice, Notices
from bozzetto_app.session.recent_files import free_name, keep_recent, recent_files, still_there
from bozzetto_app.session.thumbnail import SmallPictures
from bozzetto_app.settings import settings
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.exchange import Exchange
    from bozzetto_app.session.scene_model import SceneModel
    from bozzetto_app.session.view_state import ViewState

__all__ = ["DOCUMENT_ENDING", "LAST_FOLDER", "Claim", "Files", "Hindrance"]

DOCUMENT_ENDING = ".bozz"
LAST_FOLDER = "files/last_folder"


class Hindrance(NamedTuple):
    """Why a document was not saved, and what can be done about it; for the person to choose.

    Attributes
    ----------
    problem : FileChanged or Locked
    path : Path
        Where it was to be saved.
    go_on : callable
        Saves over what is there, or takes the document over.
    keep_both : callable
        Saves beside it, under a name that is free.
    leave : callable
        Saves nothing.
    """

    problem: FileChanged | Locked
    path: Path
    go_on: Callable[[], None]
    keep_both: Callable[[], None]
    leave: Callable[[], None]


class _Known(NamedTuple):
    """The lock of the open document and the recent documents, when work on a file begins."""

    lock: FileLock | None
    recent: list[Path]

    def give_back(self, lock: FileLock | None, claims: Claims) -> None:
        """Release another lock than the one of the open document."""
        if lock is not None and lock is not self.lock:
            claims.give_back(lock)


class _WhenSafe(Protocol):
    def __call__(
        self, then: Callable[[], None], refused: Callable[[], None] | None = None
    ) -> None: ...


def _at_once(then: Callable[[], None], refused: Callable[[], None] | None = None) -> None:
    then()


class Files(QObject):
    """The files of a session.

    Attributes
    ----------
    exchange : Exchange
        What goes to other programs and comes from them.
    lock : FileLock, optional
        Held while the document is open.
    stamp : FileStamp, optional
        Stamp of the file's content when the document was opened or saved last.
    when_safe : callable
        Called with what would lose unsaved work, and with what to do if the person would
        rather stay; the window asks the person first.
    when_hindered : callable
        Called with the obstacle to a save; the window asks the person.

    Signals
    -------
    recent_changed
        The list of recent documents differs.
    saved : Path
    given_up
        The person said that the drawing, as it is now, may be lost.
    locked : Path
        The document that was opened is read-only, for somebody else has it open.
    progressed : float, str; busy_changed : bool
        Long work advances, starts, ends.
    """

    recent_changed = Signal()
    saved = Signal(object)
    given_up = Signal()
    locked = Signal(object)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        view: ViewState,
        scene: SceneModel,
        exchange: Exchange,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.lock: FileLock | None = None
        self.stamp: FileStamp | None = None
        self.when_safe: _WhenSafe = _at_once
        self.when_hindered: Callable[[Hindrance], None] = self._refuse
        self._workbench, self._drawing, self._view = workbench, drawing, view
        self._scene, self._notices = scene, notices
        self.exchange = exchange
        self._claims = Claims()
        self._thumbnails = SmallPictures(workbench)
        self._saves = Channel("save", keep_all=True, parent=self)
        self._reads = Channel("file", keep_all=True, is_patient=True, parent=self)
        notices.watch(self._reads)
        for channel in (self._saves, self._reads):
            channel.progressed.connect(self.progressed)
            channel.busy_changed.connect(self.busy_changed)

    @property
    def busy(self) -> bool:
        """Whether a file is being read or written."""
        channels = (self._saves, self._reads, self._claims)
        return any(channel.busy for channel in channels)

    @property
    def saving(self) -> bool:
        """Whether a document is on its way to the disk."""
        return self._saves.busy

    def cancel(self) -> None:
        """Stop reading; a document that is being saved is not disturbed."""
        self._reads.cancel()

    def close(self) -> None:
        """Give up the document: the program ends, and others may open it."""
        self._hold(None)

    def read(self, request: Request) -> None:
        """Have a document read in the row of this session's files, where it can be stopped."""
        self._reads.submit(request)

    def tidy(self) -> None:
        """Drop recent documents that are gone, and what killed processes left; in a worker.

        Temporary files of processes that are gone are deleted where those documents lie, and
        where something was saved or exported last.
        """
        recent = recent_files()
        last = str(settings().value(LAST_FOLDER, ""))
        folders = {path.parent for path in recent} | ({Path(last)} if last else set())

        def work(job: Job) -> list[Path]:
            remove_leftovers(folders)
            return [path for path in recent if path.is_file()]

        def done(there: list[Path]) -> None:
            if recent_files() == recent != there:
                self._keep_recent(there)

        self._reads.submit(Request(work, done, self._notices.complain))

    def new(self) -> None:
        """Start on an empty sheet."""
        self._hold(None)
        self.stamp = None
        self._drawing.show(Document(), None)

    def open_safely(self, path: Path) -> None:
        """Open a document once unsaved work is safe."""
        self.when_safe(lambda: self.open(path))

    def open(self, path: Path) -> None:
        """Open a document; import any other file into a new one."""
        if path.suffix.lower() != DOCUMENT_ENDING:
            self.new()
            self.exchange.import_file(path)
            return
        drawing, registry = self._drawing, self._workbench.registry
        before = drawing.document, drawing.pending

        def work(job: Job, known: _Known) -> Any:
            from bozzetto.document.storage.bozz_file import read_document

            claim = self._claims.claim(path, known.lock)
            try:
                job.checkpoint(0.0, tr("Files", "Opening {name}", name=path.name))
                document, report = read_document(path, registry)
                job.checkpoint(1.0, path.name)
                return claim, document, report, still_there(known.recent, path)
            except BaseException:
                known.give_back(claim.lock, self._claims)
                raise

        def done(answer: Any) -> None:
            claim, document, report, recent = answer
            if (drawing.document, drawing.pending) != before and drawing.is_modified:
                self._give_back(claim.lock)
                self._notices.tell(
                    tr("Files", "“{name}” was not opened: you were drawing.", name=path.name)
                )
                return
            self.show(claim, document, path, read_only=report.read_only, stamp=report.stamp)
            self._keep_recent(recent)
            if report.warnings:
                self._notices.tell(" ".join(report.warnings))

        self._reads.submit(
            Request(
                work,
                done,
                self._notices.complain,
                inputs=self._known,
                dropped=lambda answer: self.leave(answer[0]),
            )
        )

    def claim(self, path: Path, held: FileLock | None) -> Claim:
        """Keep others from a document, if nobody else has it; in a worker.

        Parameters
        ----------
        path : Path
            The file of the document.
        held : FileLock, optional
            `lock` as it was when the work began.
        """
        return self._claims.claim(path, held)

    def leave(self, claim: Claim) -> None:
        """Give back a claim that was not used."""
        self._give_back(claim.lock)

    def take_over(self, path: Path) -> None:
        """Allow writing to a document that somebody else has open; the person said so."""
        drawing, history = self._drawing, self._drawing.history

        def work(job: Job) -> FileLock:
            return self._claims.acquire(path, force=True)

        def done(lock: FileLock) -> None:
            if drawing.history is not history or drawing.path != path:
                self._give_back(lock)
                return
            self._hold(lock)
            drawing.allow_saving()
            self._notices.tell(tr("Files", "“{name}” is yours to save now.", name=path.name))

        self._reads.submit(Request(work, done, self._notices.complain, dropped=self._give_back))

    def show(
        self,
        claim: Claim,
        document: Document,
        path: Path | None,
        *,
        read_only: bool = False,
        saved: bool = True,
        pending: tuple[Stroke, ...] = (),
        stamp: FileStamp | None = None,
    ) -> None:
        """Put another document on the sheet; see `DocumentModel.show`.

        Parameters
        ----------
        claim : Claim
            The result of `claim` for the file.
        document : Document
            The document to show.
        path : Path, optional
            The file of the document.
        read_only, saved : bool
            As in `DocumentModel.show`.
        pending : tuple of Stroke
            As in `DocumentModel.show`.
        stamp : FileStamp, optional
            Stamp of the content that was read.
        """
        self._hold(claim.lock)
        self.stamp = stamp
        self._drawing.show(
            document,
            path,
            read_only=read_only or bool(claim.refusal),
            saved=saved,
            pending=pending,
        )
        if claim.refusal:
            self._notices.send(Notice("error", claim.refusal))
        if claim.holder is not None and not read_only and path is not None:
            self.locked.emit(path)

    def save(
        self,
        path: Path | None = None,
        then: Callable[[], None] = lambda: None,
        failed: Callable[[], None] = lambda: None,
        *,
        over: FileStamp | Over | None = None,
        force: bool = False,
        beside: bool = False,
    ) -> None:
        """Save the document as it is at this moment.

        Parameters
        ----------
        path : Path, optional
            Default: where it was opened from or saved to.
        then, failed : callable
            Called once it is safely on the disk, or once it is clear that it will not be.
        over : FileStamp or Over, optional
            What may be written over. Default: what was read from there, or saved there, last.
        force : bool
            Take the document over from whoever has it open.
        beside : bool
            Save under the next name that is free.
        """
        drawing = self._drawing
        target = path or drawing.path
        if target is None:
            raise ValueError("a document without a place needs a path")
        if target.suffix.lower() != DOCUMENT_ENDING:
            target = target.with_name(target.name + DOCUMENT_ENDING)
        stamp = self.stamp if target == drawing.path else None
        expected = over or stamp or Over.NOTHING
        snapshot, history = drawing.document, drawing.history
        scene, camera = self._scene.visible, self._view.camera
        backups = int(str(settings().value("files/backups", 3)))

        def work(job: Job, known: _Known) -> tuple[Path, FileLock, Written, list[Path]]:
            from bozzetto.document.storage.bozz_file import write_document

            place = free_name(target) if beside else target
            held = known.lock
            mine = held is not None and held.path == document_lock_path(place) and held.is_held
            lock = held if mine and held else self._claims.acquire(place, force=force)
            try:
                written = write_document(
                    replace(snapshot, camera=camera),
                    place,
                    thumbnail=self._thumbnails.of(snapshot, scene),
                    backups=backups,
                    over=Over.NOTHING if beside else expected,
                )
                remove_leftovers([place.parent])
            except BaseException:
                known.give_back(lock, self._claims)
                raise
            return place, lock, written, still_there(known.recent, place)

        def done(answer: tuple[Path, FileLock, Written, list[Path]]) -> None:
            place, lock, written, recent = answer
            self._keep_recent(recent)
            if drawing.history is history:
                self._hold(lock)
                self.stamp = written.stamp
                drawing.saved_as(place, snapshot)
                self.saved.emit(place)
            else:
                self._give_back(lock)
            self._notices.tell(_saved_text(place, written, expected))
            then()

        def hindered(problem: BaseException) -> None:
            if not isinstance(problem, FileChanged | Locked) or drawing.history is not history:
                self._notices.complain(problem)
                failed()
                return

            def go_on() -> None:
                if isinstance(problem, FileChanged):
                    self.save(target, then, failed, over=problem.found, force=force)
                else:
                    self.save(target, then, failed, over=over, force=True)

            def keep_both() -> None:
                self.save(target, then, failed, beside=True)

            self.when_hindered(Hindrance(problem, target, go_on, keep_both, failed))

        self._saves.submit(
            Request(
                work,
                done,
                hindered,
                inputs=self._known,
                dropped=lambda answer: self._give_back(answer[1]),
            )
        )

    def _refuse(self, hindrance: Hindrance) -> None:
        """Write nothing over: there is nobody to ask."""
        self._notices.complain(hindrance.problem)
        hindrance.leave()

    def _hold(self, lock: FileLock | None) -> None:
        """Hold the lock of one document, and no other."""
        held, self.lock = self.lock, lock
        if held is not None and held is not lock:
            self._claims.give_back(held)

    def _give_back(self, lock: FileLock | None) -> None:
        """Release a lock that is not needed, unless it is the one of the open document."""
        if lock is not None and lock is not self.lock:
            self._claims.give_back(lock)

    def _known(self) -> _Known:
        return _Known(self.lock, recent_files())

    def _keep_recent(self, recent: Iterable[Path]) -> None:
        keep_recent(recent)
        self.recent_changed.emit()


def _saved_text(path: Path, written: Written, expected: FileStamp | Over) -> str:
    said = tr("Files", "Saved “{name}”.", name=path.name)
    if isinstance(expected, FileStamp) and written.is_new:
        said = tr(
            "Files",
            "Saved “{name}” again in {folder}: the file had been moved or deleted.",
            name=path.name,
            folder=str(path.parent),
        )
    if written.other_names:
        said += " " + tr(
            "Files", "Its other names on this disk (hard links) keep the earlier version."
        )
    return said
