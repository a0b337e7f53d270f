"""Opening, saving, importing and exporting, beside the window's thread.

No dialog is shown here: `bozzetto_app.asking` asks, this does.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from bozzetto.document.lock import FileLock, Locked, document_lock_path
from bozzetto.document.model import Document, Model
from bozzetto.errors import UserError
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.guard import PluginFault
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import Scene
from bozzetto_app.jobs import Channel, Request
from bozzetto_app.saying import Notice
from bozzetto_app.settings import settings
from bozzetto_app.words import tr

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera
    from bozzetto.workbench import Workbench
    from bozzetto_app.session import Session

__all__ = ["DOCUMENT_ENDING", "Claim", "Files", "recent_files"]

DOCUMENT_ENDING = ".bozz"
MESH_MODELER = "bozzetto.mesh"
RECENT = "recent/files"
MOST_RECENT = 10
THUMBNAIL = 256
"""Side of the picture that file managers show, pixels."""

PATIENCE = 2.0
"""Seconds that a save waits for what modelers show of a view in a document's small picture."""

READ_LIMIT = 60.0
"""Seconds that reading or exporting may go on without progress before it counts as hung."""


def recent_files() -> list[Path]:
    """Documents opened or saved lately that are still there, newest first."""
    kept = settings().value(RECENT, [])
    names = [kept] if isinstance(kept, str) else kept if isinstance(kept, list) else []
    return [Path(name) for name in names if Path(name).is_file()]


@dataclass(frozen=True)
class Claim:
    """Whether a document may be written to.

    Attributes
    ----------
    lock : FileLock, optional
        Held if it may.
    refusal : str
        Why it may not; told to the person.
    """

    lock: FileLock | None
    refusal: str = ""


class Files(QObject):
    """What a session does with the disk.

    Signals
    -------
    recent_changed
        The list of recent documents is another one.
    saved : Path
    imported
        Something came in from a file.
    progressed : float, str; busy_changed : bool
        Long work advances, starts, ends.
    """

    recent_changed = Signal()
    imported = Signal()
    saved = Signal(object)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._lock: FileLock | None = None
        # Saving has a channel of its own: a plugin that hangs over an import or an export
        # must not come between a person and their file.
        self._saves = Channel("save", keep_all=True, parent=self)
        self._reads = Channel("file", keep_all=True, time_limit=READ_LIMIT, parent=self)
        for channel in (self._saves, self._reads):
            channel.progressed.connect(self.progressed)
            channel.busy_changed.connect(self.busy_changed)

    @property
    def busy(self) -> bool:
        """Whether a file is being read or written."""
        return self._saves.busy or self._reads.busy

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

    def new(self) -> None:
        """Start on an empty sheet."""
        self._hold(None)
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
            from bozzetto.document.file import read_document

            claim = self.claim(path)
            try:
                document, report = read_document(path, session.registry)
                job.checkpoint(1.0, path.name)
                return claim, document, report
            except BaseException:
                self._give_back(claim.lock)
                raise

        def done(answer: Any) -> None:
            claim, document, report = answer
            if (session.document, session.pending) != before and session.is_modified:
                self._give_back(claim.lock)
                session.tell(
                    tr("Files", "“{name}” was not opened: you were drawing.", name=path.name)
                )
                return
            self.show(claim, document, path, read_only=report.read_only)
            self._remember(path)
            for warning in report.warnings:
                session.tell(warning)

        self._reads.submit(Request(work, done, session.complain))

    def claim(self, path: Path) -> Claim:
        """In a worker: see whether a document may be written to, and keep others from it."""
        place = document_lock_path(path)
        if self._lock is not None and self._lock.path == place:
            return Claim(self._lock)
        try:
            return Claim(FileLock.acquire(place, path.name))
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

    def show(
        self,
        claim: Claim,
        document: Document,
        path: Path | None,
        *,
        read_only: bool = False,
        saved: bool = True,
        pending: tuple[Stroke, ...] = (),
    ) -> None:
        """Make another document the one on the sheet; see `Session.show_document`."""
        self._hold(claim.lock)
        self._session.show_document(
            document,
            path,
            read_only=read_only or bool(claim.refusal),
            saved=saved,
            pending=pending,
        )
        if claim.refusal:
            self._session.noticed.emit(Notice("error", claim.refusal))

    def save(self, path: Path | None = None, then: Callable[[], None] = lambda: None) -> None:
        """Save the document as it is at this moment.

        Parameters
        ----------
        path : Path, optional
            Default: where it was opened from or saved to.
        then : callable
            Called once it is safely on the disk.
        """
        session = self._session
        target = path or session.path
        if target is None:
            raise ValueError("a document without a place needs a path")
        if target.suffix.lower() != DOCUMENT_ENDING:
            target = target.with_name(target.name + DOCUMENT_ENDING)
        snapshot, scene, camera = session.document, session.scene, session.camera
        history = session.history
        backups = int(str(settings().value("files/backups", 3)))

        def work(job: Job) -> FileLock:
            from bozzetto.document.file import write_document
            from bozzetto.scene.picture import framed, thumbnail
            from bozzetto.scene.png import png_bytes

            place = document_lock_path(target)
            mine = self._lock is not None and self._lock.path == place
            lock = self._lock if mine and self._lock else FileLock.acquire(place, target.name)
            view = framed(scene, size=(THUMBNAIL, THUMBNAIL))
            shown = scene.under(_hanging_on_view(session.workbench, snapshot, view))
            try:
                write_document(
                    replace(snapshot, camera=camera),
                    target,
                    thumbnail=png_bytes(thumbnail(shown, THUMBNAIL, camera=view)),
                    backups=backups,
                )
            except BaseException:
                self._give_back(lock)
                raise
            return lock

        def done(lock: FileLock) -> None:
            self._remember(target)
            if session.history is history:
                self._hold(lock)
                session.saved_as(target, snapshot)
                self.saved.emit(target)
            else:
                self._give_back(lock)
            session.tell(tr("Files", "Saved “{name}”.", name=target.name))
            then()

        self._saves.submit(Request(work, done, session.complain))

    def export(self, path: Path) -> None:
        """Hand all visible objects over to other programs."""
        session = self._session
        models = [model for model in session.document if model.visible]
        camera = session.camera

        def work(job: Job) -> tuple[str, ...]:
            from bozzetto.export_document import object_shapes, prepared_file
            from bozzetto.storage import write_bytes

            objects = object_shapes(session.workbench, models, job)
            job.checkpoint(1.0, path.name)
            made = prepared_file(objects, path, camera, whole=False)
            write_bytes(path, made.data)
            return (*objects.warnings(baseless_only=True), *made.warnings())

        def done(warnings: tuple[str, ...]) -> None:
            said = tr("Files", "Exported “{name}”.", name=path.name)
            if warnings:
                # An error stays until the next one: what is missing must not be overlooked.
                session.noticed.emit(Notice("error", " ".join((said, *warnings))))
            else:
                session.tell(said)

        self._reads.submit(Request(work, done, session.complain))

    def import_file(self, path: Path) -> None:
        """Bring a drawing, a mesh or a picture onto the sheet."""
        from bozzetto.exchange.importing import is_picture

        session = self._session
        if is_picture(path):
            session.picturing.take_file(path)
            return
        active = session.active_modeler
        context, history = session.context(), session.history

        def work(job: Job) -> tuple[Model, bool]:
            from bozzetto.exchange.formats import find, readers
            from bozzetto.exchange.importing import read_drawing, read_mesh

            bench = session.workbench
            if "mesh" in find(path, readers()).holds:
                return bench.from_shapes(MESH_MODELER, read_mesh(path), path.stem), False
            drawing = read_drawing(path)
            facts_only = not len(drawing.strokes)
            modeler = (facts_only and session.registry.told_by(drawing.extra)) or active
            if not modeler:
                raise UserError(tr("Files", "Choose a modeler first, then import the drawing."))
            here = context if facts_only else replace(context, camera=drawing.camera)
            return bench.from_drawing(modeler, drawing, {}, here), bool(drawing.pictures)

        def done(answer: tuple[Model, bool]) -> None:
            if session.history is not history:
                return
            model, pictured = answer
            if not pictured:
                self.imported.emit()
            session.take_drawn(tr("Files", "Import {name}", name=path.name), model, is_new=True)
            if pictured:
                session.picturing.taken.emit(model.id)

        self._reads.submit(Request(work, done, session.complain))

    def _hold(self, lock: FileLock | None) -> None:
        """Hold one document's lock, and no other."""
        held, self._lock = self._lock, lock
        if held is not None and held is not lock:
            held.release()

    def _give_back(self, lock: FileLock | None) -> None:
        """Release a lock that came to nothing, unless it is the one of the open document."""
        if lock is not None and lock is not self._lock:
            lock.release()

    def _remember(self, path: Path) -> None:
        whole = path.resolve()
        names = [str(whole), *(str(p) for p in recent_files() if p != whole)]
        settings().setValue(RECENT, names[:MOST_RECENT])
        self.recent_changed.emit()


def _hanging_on_view(bench: Workbench, document: Document, camera: Camera) -> Scene:
    """What hangs on the view of a document's picture; nothing where a plugin takes too long.

    Asked in a thread of its own: no plugin may come between a person and their file.
    """
    found: list[Scene] = []

    def ask() -> None:
        # A fault has been told to whoever listens to the guard.
        with suppress(UserError, PluginFault):
            found.append(bench.advice_scene(document, camera))

    asking = threading.Thread(target=ask, name="bozzetto-thumbnail", daemon=True)
    asking.start()
    asking.join(PATIENCE)
    return found[0] if found else Scene()
