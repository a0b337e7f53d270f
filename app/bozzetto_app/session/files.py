"""Opening, saving, importing and exporting, beside the window's thread.

No dialog is shown here: `bozzetto_app.dialogs.file_dialogs` asks, this does.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote_to_bytes

from PySide6.QtCore import QObject, Signal

from bozzetto.atomic_files import FileChanged, FileStamp, Over, Written
from bozzetto.document.model import Document, Model
from bozzetto.document.recovery.file_lock import FileLock, Locked, document_lock_path
from bozzetto.errors import UserError
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.job import Job
from bozzetto.temporary_files import remove_leftovers
from bozzetto_app.i18n import tr
from bozzetto_app.session.document_locks import Claim, Claims
from bozzetto_app.session.notices import Notice
from bozzetto_app.session.thumbnail import SmallPictures
from bozzetto_app.settings import settings
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["DOCUMENT_ENDING", "LAST_FOLDER", "Claim", "Files", "Hindrance", "recent_files"]

DOCUMENT_ENDING = ".bozz"
MESH_MODELER = "bozzetto.mesh"
RECENT = "recent/files"
LAST_FOLDER = "files/last_folder"
MOST_RECENT = 10
URI = "file://"
SLOW_AFTER = 60.0
"""Seconds without progress after which reading or exporting is told as slow."""


def recent_files() -> list[Path]:
    """Documents opened or saved lately, newest first.

    The disk is not asked, for it may be slow or far away; those that are gone are left out
    by the next worker that looks.
    """
    kept = settings().value(RECENT, [])
    names = [kept] if isinstance(kept, str) else kept if isinstance(kept, list) else []
    return [_path_of(str(name)) for name in names]


def _name_of(path: Path) -> str:
    """A path as settings can hold it: as text, or as an address where it is not text."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        return path.as_uri()
    return str(path)


def _path_of(name: str) -> Path:
    return Path(os.fsdecode(unquote_to_bytes(name[7:]))) if name.startswith(URI) else Path(name)


@dataclass(frozen=True)
class Hindrance:
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


class Files(QObject):
    """What a session does with the disk.

    Attributes
    ----------
    stamp : FileStamp, optional
        Of the content that the document's file had when it was opened or saved last.
    when_hindered : callable
        Called with what stands in the way of a save; the window asks the person.

    Signals
    -------
    recent_changed
        The list of recent documents is another one.
    saved : Path
    given_up
        The person said that what is on the sheet, as it is now, may go.
    locked : Path
        What was opened can be looked at only, for somebody else has it open.
    imported
        Something came in from a file.
    progressed : float, str; busy_changed : bool
        Long work advances, starts, ends.
    """

    recent_changed = Signal()
    imported = Signal()
    saved = Signal(object)
    given_up = Signal()
    locked = Signal(object)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.stamp: FileStamp | None = None
        self.when_hindered: Callable[[Hindrance], None] = self._refuse
        self._lock: FileLock | None = None
        self._claims = Claims()
        self._pictures = SmallPictures(session.workbench)
        # Saving has a channel of its own: a plugin that hangs over an import or an export
        # must not come between a person and their file.
        self._saves = Channel("save", keep_all=True, parent=self)
        self._reads = Channel(
            "file", keep_all=True, time_limit=SLOW_AFTER, is_patient=True, parent=self
        )
        self._reads.slow.connect(session.tell_slow)
        for channel in (self._saves, self._reads):
            channel.progressed.connect(self.progressed)
            channel.busy_changed.connect(self.busy_changed)

    @property
    def busy(self) -> bool:
        """Whether a file is being read or written."""
        return self._saves.busy or self._reads.busy or self._claims.busy

    @property
    def saving(self) -> bool:
        """Whether a document is on its way to the disk."""
        return self._saves.busy

    def cancel(self) -> None:
        """Stop reading and exporting; a document that is being saved is not disturbed."""
        self._reads.cancel()

    def close(self) -> None:
        """The program ends: others may have the document."""
        self._hold(None)

    def tidy(self) -> None:
        """Beside the window: see which recent documents are there, and what killed processes left.

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

        self._reads.submit(Request(work, done, self._session.complain))

    def new(self) -> None:
        """Start on an empty sheet."""
        self._hold(None)
        self.stamp = None
        self._session.show_document(Document(), None)

    def open(self, path: Path) -> None:
        """Open a document; anything else comes into a new one."""
        session = self._session
        if path.suffix.lower() != DOCUMENT_ENDING:
            self.new()
            self.import_file(path)
            return
        before = session.document, session.pending

        def work(job: Job) -> Any:
            from bozzetto.document.storage.bozz_file import read_document

            claim = self.claim(path)
            try:
                document, report = read_document(path, session.registry)
                job.checkpoint(1.0, path.name)
                return claim, document, report, still_there(recent_files(), path)
            except BaseException:
                self._give_back(claim.lock)
                raise

        def done(answer: Any) -> None:
            claim, document, report, recent = answer
            if (session.document, session.pending) != before and session.is_modified:
                self._give_back(claim.lock)
                session.tell(
                    tr("Files", "“{name}” was not opened: you were drawing.", name=path.name)
                )
                return
            self.show(claim, document, path, read_only=report.read_only, stamp=report.stamp)
            self._keep_recent(recent)
            for warning in report.warnings:
                session.tell(warning)

        self._reads.submit(Request(work, done, session.complain))

    def claim(self, path: Path) -> Claim:
        """In a worker: see whether a document may be written to, and keep others from it."""
        return self._claims.claim(path, self._lock)

    def leave(self, claim: Claim) -> None:
        """Give back a claim that nothing came of."""
        self._give_back(claim.lock)

    def take_over(self, path: Path) -> None:
        """Write to a document that somebody else has open; the person said so."""
        session, history = self._session, self._session.history

        def work(job: Job) -> FileLock:
            return self._claims.acquire(path, force=True)

        def done(lock: FileLock) -> None:
            if session.history is not history or session.path != path:
                self._give_back(lock)
                return
            self._hold(lock)
            session.allow_saving()
            session.tell(tr("Files", "“{name}” is yours to save now.", name=path.name))

        self._reads.submit(Request(work, done, session.complain))

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
        """Make another document the one on the sheet; see `Session.show_document`.

        Parameters
        ----------
        claim : Claim
        document : Document
        path : Path, optional
        read_only, saved : bool
        pending : tuple of Stroke
        stamp : FileStamp, optional
            Of the content that the file had when it was read.
        """
        self._hold(claim.lock)
        self.stamp = stamp
        self._session.show_document(
            document,
            path,
            read_only=read_only or bool(claim.refusal),
            saved=saved,
            pending=pending,
        )
        if claim.refusal:
            self._session.noticed.emit(Notice("error", claim.refusal))
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
        session = self._session
        target = path or session.path
        if target is None:
            raise ValueError("a document without a place needs a path")
        if target.suffix.lower() != DOCUMENT_ENDING:
            target = target.with_name(target.name + DOCUMENT_ENDING)
        known = self.stamp if target == session.path else None
        expected = over or known or Over.NOTHING
        snapshot, scene, camera = session.document, session.scene, session.camera
        history = session.history
        backups = int(str(settings().value("files/backups", 3)))

        def work(job: Job) -> tuple[Path, FileLock, Written, list[Path]]:
            from bozzetto.document.storage.bozz_file import write_document

            place = free_name(target) if beside else target
            held = self._lock
            mine = held is not None and held.path == document_lock_path(place) and held.is_held
            lock = held if mine and held else self._claims.acquire(place, force=force)
            try:
                written = write_document(
                    replace(snapshot, camera=camera),
                    place,
                    thumbnail=self._pictures.of(snapshot, scene),
                    backups=backups,
                    over=Over.NOTHING if beside else expected,
                )
                remove_leftovers([place.parent])
            except BaseException:
                self._give_back(lock)
                raise
            return place, lock, written, still_there(recent_files(), place)

        def done(answer: tuple[Path, FileLock, Written, list[Path]]) -> None:
            place, lock, written, recent = answer
            self._keep_recent(recent)
            if session.history is history:
                self._hold(lock)
                self.stamp = written.stamp
                session.saved_as(place, snapshot)
                self.saved.emit(place)
            else:
                self._give_back(lock)
            session.tell(_said(place, written, was_known=isinstance(expected, FileStamp)))
            then()

        def hindered(problem: BaseException) -> None:
            if not isinstance(problem, FileChanged | Locked) or session.history is not history:
                session.complain(problem)
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

        self._saves.submit(Request(work, done, hindered))

    def export(self, path: Path) -> None:
        """Hand all visible objects over to other programs."""
        session = self._session
        models = [model for model in session.document if model.visible]
        camera, waiting = session.camera, session.document.waiting

        def work(job: Job) -> tuple[str, ...]:
            from bozzetto.atomic_files import write_bytes
            from bozzetto.workbench.export_document import object_shapes, prepared_file

            objects = object_shapes(session.workbench, models, job)
            job.checkpoint(1.0, path.name)
            made = prepared_file(objects, path, camera, whole=False)
            write_bytes(path, made.data)
            return (*objects.warnings(baseless_only=True), *made.warnings())

        def done(warnings: tuple[str, ...]) -> None:
            said = [tr("Files", "Exported “{name}”.", name=path.name)]
            if waiting:
                said.append(tr("Files", "The ink that waits is no part of it."))
            if warnings:
                # An error stays until the next one: what is missing must not be overlooked.
                session.noticed.emit(Notice("error", " ".join((*said, *warnings))))
            else:
                session.tell(" ".join(said))

        self._reads.submit(Request(work, done, session.complain))

    def import_file(self, path: Path) -> None:
        """Bring a drawing, a mesh or a picture onto the sheet."""
        from bozzetto.exchange.import_file import is_picture

        session = self._session
        if is_picture(path):
            session.picturing.take_file(path)
            return
        active = session.active_modeler
        context, history = session.context(), session.history

        def work(job: Job) -> tuple[Model, bool, tuple[str, ...]]:
            from bozzetto.exchange.formats import find, readers
            from bozzetto.exchange.import_file import read_drawing, read_mesh

            def reading() -> None:
                job.checkpoint(0.0, tr("Files", "Reading {name}", name=path.name))

            bench = session.workbench
            if "mesh" in find(path, readers()).holds:
                shapes = read_mesh(path, checkpoint=reading)
                return bench.sources.from_shapes(MESH_MODELER, shapes, path.stem), False, ()
            drawing = read_drawing(path, checkpoint=reading)
            facts_only = not len(drawing.strokes)
            modeler = (facts_only and session.registry.told_by(drawing.extra)) or active
            if not modeler:
                raise UserError(tr("Files", "Choose a modeler first, then import the drawing."))
            here = context if facts_only else replace(context, camera=drawing.camera)
            model = bench.sources.from_drawing(modeler, drawing, {}, here)
            return model, bool(drawing.pictures), drawing.left_out

        def done(answer: tuple[Model, bool, tuple[str, ...]]) -> None:
            if session.history is not history:
                return
            model, pictured, left_out = answer
            if not pictured:
                self.imported.emit()
            session.take_drawn(tr("Files", "Import {name}", name=path.name), model, is_new=True)
            if pictured:
                session.picturing.taken.emit(model.id)
            if left_out:  # stays until the next one, as with exports
                session.noticed.emit(Notice("error", " ".join(left_out)))

        self._reads.submit(Request(work, done, session.complain))

    def _refuse(self, hindrance: Hindrance) -> None:
        """Nobody can be asked: nothing is written over."""
        self._session.complain(hindrance.problem)
        hindrance.leave()

    def _hold(self, lock: FileLock | None) -> None:
        """Hold one document's lock, and no other."""
        held, self._lock = self._lock, lock
        if held is not None and held is not lock:
            self._claims.give_back(held)

    def _give_back(self, lock: FileLock | None) -> None:
        """Release a lock that came to nothing, unless it is the one of the open document."""
        if lock is not None and lock is not self._lock:
            self._claims.give_back(lock)

    def _keep_recent(self, recent: Iterable[Path]) -> None:
        settings().setValue(RECENT, [_name_of(path) for path in recent][:MOST_RECENT])
        self.recent_changed.emit()


def still_there(recent: Iterable[Path], newest: Path) -> list[Path]:
    """In a worker: a document, and those before it that still exist."""
    whole = Path(os.path.abspath(newest))
    return [whole, *(path for path in recent if path != whole and path.is_file())]


def free_name(path: Path) -> Path:
    """In a worker: the next name like this that no file has."""
    number = 2
    while (free := path.with_stem(f"{path.stem} {number}")).exists():
        number += 1
    return free


def _said(path: Path, written: Written, *, was_known: bool) -> str:
    """What there is to say about a save."""
    said = tr("Files", "Saved “{name}”.", name=path.name)
    if was_known and written.is_new:
        said = tr(
            "Files",
            "Saved “{name}” anew in {folder}: it had been moved or deleted.",
            name=path.name,
            folder=str(path.parent),
        )
    if written.other_names:
        said += " " + tr(
            "Files", "Its other names on this disk (hard links) keep the earlier version."
        )
    return said
