"""Opening, saving, importing and exporting, beside the window's thread.

No dialog is shown here: `bozzetto_app.asking` asks, this does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from bozzetto.document.model import Document, Model, Underlay, new_id
from bozzetto.errors import UserError
from bozzetto.plugin.job import Job
from bozzetto_app.jobs import Channel, Request
from bozzetto_app.settings import settings
from bozzetto_app.words import tr

if TYPE_CHECKING:
    from bozzetto_app.session import Session

__all__ = ["DOCUMENT_ENDING", "Files", "recent_files"]

DOCUMENT_ENDING = ".bozz"
MESH_MODELER = "bozzetto.mesh"
RECENT = "recent/files"
MOST_RECENT = 10
THUMBNAIL = 256
"""Side of the picture that file managers show, pixels."""

UNDERLAY_WIDTH = 200.0
"""Width at which a picture to trace is laid on the sheet, mm."""


def recent_files() -> list[Path]:
    """Documents opened or saved lately that are still there, newest first."""
    kept = settings().value(RECENT, [])
    names = [kept] if isinstance(kept, str) else list(kept or [])
    return [Path(name) for name in names if Path(name).is_file()]


class Files(QObject):
    """What a session does with the disk.

    Signals
    -------
    recent_changed
        The list of recent documents is another one.
    saved : Path
    """

    recent_changed = Signal()
    saved = Signal(object)

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self._channel = Channel("file", keep_all=True, parent=self)
        self._channel.progressed.connect(session.progressed)
        self._channel.busy_changed.connect(session.busy_changed)

    @property
    def busy(self) -> bool:
        """Whether a file is being read or written."""
        return self._channel.busy

    def new(self) -> None:
        """Start on an empty sheet."""
        self._session.show_document(Document(), None)

    def open(self, path: Path) -> None:
        """Open a document; anything else comes into a new one."""
        session = self._session
        if path.suffix.lower() != DOCUMENT_ENDING:
            self.new()
            self.import_file(path)
            return

        def work(job: Job) -> Any:
            from bozzetto.document.file import read_document

            return read_document(path, session.registry)

        def done(answer: Any) -> None:
            document, report = answer
            session.show_document(document, path, read_only=report.read_only)
            self._remember(path)
            for warning in report.warnings:
                session.tell(warning)

        self._submit(work, done)

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
        snapshot, scene = session.document, session.scene
        backups = int(str(settings().value("files/backups", 3)))

        def work(job: Job) -> None:
            from bozzetto.document.file import write_document
            from bozzetto.document.underlays import encode_png
            from bozzetto.scene.picture import thumbnail

            write_document(
                replace(snapshot, camera=session.camera),
                target,
                thumbnail=encode_png(thumbnail(scene, THUMBNAIL)),
                backups=backups,
            )

        def done(answer: None) -> None:
            session.saved_as(target, snapshot)
            self._remember(target)
            self.saved.emit(target)
            session.tell(tr("Files", "Saved “{name}”.").format(name=target.name))
            then()

        self._submit(work, done)

    def export(self, path: Path) -> None:
        """Hand all visible objects over to other programs."""
        session = self._session
        models = [model for model in session.document if model.visible]

        def work(job: Job) -> None:
            from bozzetto.exchange.export import export

            export(session.workbench.shapes(models, job), path, camera=session.camera)

        def done(answer: None) -> None:
            session.tell(tr("Files", "Exported “{name}”.").format(name=path.name))

        self._submit(work, done)

    def import_file(self, path: Path) -> None:
        """Bring a drawing, a mesh or a picture onto the sheet."""
        session = self._session
        modeler = session.active_modeler
        context = session.context()

        def work(job: Job) -> Model | Underlay:
            from bozzetto.exchange.formats import find, readers
            from bozzetto.exchange.importing import read_drawing, read_image, read_mesh

            holds = find(path, readers()).holds
            if "image" in holds:
                return _laid_on_sheet(read_image(path), path.stem)
            if "mesh" in holds:
                return session.workbench.from_shapes(MESH_MODELER, read_mesh(path), path.stem)
            if not modeler:
                raise UserError(tr("Files", "Choose a modeler first, then import the drawing."))
            drawing = read_drawing(path)
            here = replace(context, camera=drawing.camera)
            return session.workbench.from_drawing(modeler, drawing, {}, here)

        def done(answer: Model | Underlay) -> None:
            session.take_in(answer, tr("Files", "Import {name}").format(name=path.name))

        self._submit(work, done)

    def _submit(self, work: Callable[[Job], Any], done: Callable[[Any], None]) -> None:
        self._channel.submit(Request(work, done, self._session.complain))

    def _remember(self, path: Path) -> None:
        whole = path.resolve()
        names = [str(whole), *(str(p) for p in recent_files() if p != whole)]
        settings().setValue(RECENT, names[:MOST_RECENT])
        self.recent_changed.emit()


def _laid_on_sheet(pixels: Any, name: str) -> Underlay:
    """A picture in the plane y = 0, standing on the ground, centred."""
    height, width = pixels.shape[:2]
    tall = UNDERLAY_WIDTH * height / width
    return Underlay(
        new_id(),
        name,
        pixels,
        corner=(-UNDERLAY_WIDTH / 2, 0.0, tall / 2),
        across=(UNDERLAY_WIDTH, 0.0, 0.0),
        down=(0.0, 0.0, -tall),
    )
