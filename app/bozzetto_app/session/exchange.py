"""Files of other programs, written and read in workers.

No dialog is shown here: `bozzetto_app.dialogs` asks the person.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakSet

from PySide6.QtCore import QObject, Signal

from bozzetto.document.links import resolved
from bozzetto.errors import UserError
from bozzetto_app.i18n import tr
from bozzetto_app.session.films import Films
from bozzetto_app.session.notices import Notice, Notices
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from bozzetto.document.model import Document, Model
    from bozzetto.exchange.export import Exported
    from bozzetto.exchange.handover import Handover
    from bozzetto.exchange.reading import MeshFile
    from bozzetto.exchange.ready_shapes import Ready
    from bozzetto.plugin.job import Job
    from bozzetto.scene.palette import Palette
    from bozzetto.view.camera import Camera
    from bozzetto.workbench.export_document import ObjectShapes
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.drawing_input import DrawingInput
    from bozzetto_app.session.gesture_context import GestureContext
    from bozzetto_app.session.object_clipboard import ObjectClipboard
    from bozzetto_app.session.pictures import PictureInput
    from bozzetto_app.session.toolbox import Toolbox
    from bozzetto_app.session.view_state import ViewState

__all__ = ["Exchange", "Foreseen", "PictureCanvas"]

MESH_MODELER = "bozzetto.mesh"


class Foreseen(NamedTuple):
    """Forecast of a hand-over, before anything is written.

    Attributes
    ----------
    size : (x, y, z)
        Of everything together, mm.
    triangles : int
        Of all meshes; of quads those that are left between them.
    quads : int
        Of all meshes.
    files : tuple of (str, int)
        The ending of each file, and its size in bytes.
    warnings : tuple of str
        What would be missing.
    picture : (h, w, 4) uint8 array, optional
        Of the triangles and curves, or of the drawing where nothing else is written.
    """

    size: tuple[float, float, float]
    triangles: int
    quads: int
    files: tuple[tuple[str, int], ...]
    warnings: tuple[str, ...]
    picture: NDArray[np.uint8] | None = None


class PictureCanvas(NamedTuple):
    """Colours and size of a small picture: of the window, and how many pixels each of its has."""

    palette: Palette
    size: tuple[int, int]
    scale: float


class Exchange(QObject):
    """Import and export: files of other programs.

    Attributes
    ----------
    drawings : DrawingInput
        Adds drawings of files to the selected model.
    clipboard : ObjectClipboard
        Copies and pastes objects.

    Signals
    -------
    imported
        Something was imported from a file, with the view that it was drawn in, or None.
    foreseen : Foreseen
        The answer to `foresee`.
    not_foreseen : str
        Why there is none.
    progressed : float, str; busy_changed : bool
        Long work advances, starts, ends.
    """

    imported = Signal(object)
    foreseen = Signal(object)
    not_foreseen = Signal(str)
    progressed = Signal(float, str)
    busy_changed = Signal(bool)

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        view: ViewState,
        toolbox: Toolbox,
        context: GestureContext,
        pictures: PictureInput,
        drawings: DrawingInput,
        clipboard: ObjectClipboard,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._workbench, self._drawing, self._view = workbench, drawing, view
        self._toolbox, self._context = toolbox, context
        self._pictures, self._notices = pictures, notices
        self.drawings = drawings
        self.clipboard = clipboard
        # A channel of its own: a plugin that hangs over an import or an export must not come
        # between a person and their document.
        self._work = Channel("exchange", keep_all=True, is_patient=True, parent=self)
        notices.watch(self._work)
        self._imports: WeakSet[Request] = WeakSet()
        self._foresight = Channel("foresee", is_patient=True, parent=self)
        self._newest_look: object = None
        self._looked_at: tuple[Document, Sequence[str] | None, ObjectShapes] | None = None
        drawing.closing.connect(self._drop_imports)
        self.films = Films(workbench, drawing, view, notices, self)
        for work in (self._work, pictures):
            work.busy_changed.connect(self._look_if_read)
        for channel in (self._work, self.films.channel):
            channel.progressed.connect(self.progressed)
            channel.busy_changed.connect(self.busy_changed)

    @property
    def busy(self) -> bool:
        """Whether a file is being read or written."""
        return self._work.busy or self.films.channel.busy

    def cancel(self) -> None:
        """Stop reading and exporting."""
        self._work.cancel()
        self._foresight.cancel()
        self.films.channel.cancel()

    def forget(self) -> None:
        """Stop looking what a hand-over would be: nobody waits for it, and its shapes may go."""
        self._foresight.cancel()
        self._looked_at = None

    def export(
        self,
        *paths: Path,
        handover: Handover | None = None,
        names: Sequence[str] | None = None,
    ) -> None:
        """Export objects to files of other programs; all from one solve.

        Parameters
        ----------
        *paths : Path
            Their endings name the formats.
        handover : Handover, optional
            How; by default as usual.
        names : sequence of str, optional
            Names of the objects; by default all that are visible.
        """
        work = self._making(names, handover)
        waiting = self._drawing.document.waiting

        def write(job: Job) -> tuple[str, ...]:
            objects, made, _ = work(job, paths)
            # Making files asks nobody; who stopped it meanwhile was told that nothing is changed.
            job.checkpoint(1.0, ", ".join(path.name for path in paths))
            for path, file in zip(paths, made, strict=True):
                file.write(path)
            told = (*objects.warnings(baseless_only=True), *_warnings(made))
            return tuple(dict.fromkeys(told))

        def done(warnings: tuple[str, ...]) -> None:
            listed = ", ".join(f"“{path.name}”" for path in paths)
            said = [tr("Files", "Exported {names}.", names=listed)]
            if waiting:
                said.append(tr("Files", "Waiting ink is not exported."))
            if warnings:
                # An error stays until the next one: what is missing must not be overlooked.
                self._notices.send(Notice("error", " ".join((*said, *warnings))))
            else:
                self._notices.tell(" ".join(said))

        self._work.submit(Request(write, done, self._notices.complain))

    def foresee(
        self,
        endings: Sequence[str],
        handover: Handover | None = None,
        names: Sequence[str] | None = None,
        canvas: PictureCanvas | None = None,
    ) -> None:
        """Look what an export would be, and tell by `foreseen`; nothing is written.

        Until `forget` the next look at the same objects, and their export, are made of the same
        shapes: a complete car is seconds of work.

        Parameters
        ----------
        endings : sequence of str
            Of the files.
        handover, names
            As in `export`.
        canvas : PictureCanvas, optional
            What a small picture is to be made for.
        """
        work = self._making(names, handover, keep=True)
        paths = tuple(Path(f"a{ending}") for ending in endings)
        newest = self._newest_look = object()

        def look(job: Job) -> Foreseen:
            from bozzetto.exchange.triangle_budget import triangle_count

            objects, made, ready = work(job, paths)
            sizes = [len(file.data) + sum(len(data) for _, data in file.beside) for file in made]
            told = (*objects.warnings(), *_warnings(made))
            quads = ready.quads
            return Foreseen(
                ready.size,
                triangle_count(ready.triangles) if quads is None else quads.triangles,
                0 if quads is None else quads.quads,
                tuple(zip(endings, sizes, strict=True)),
                tuple(dict.fromkeys(told)),
                None if canvas is None else _picture(ready, made, canvas),
            )

        def done(seen: Foreseen) -> None:
            if self._newest_look is newest:
                self.foreseen.emit(seen)

        def refused(problem: BaseException) -> None:
            if not isinstance(problem, UserError):
                self._notices.complain(problem)
            elif self._newest_look is newest:
                self.not_foreseen.emit(problem.message)

        self._foresight.submit(Request(look, done, refused))

    def _making(
        self, names: Sequence[str] | None, handover: Handover | None, *, keep: bool = False
    ) -> Any:
        """Return the work of a worker that makes files of the document as it is now.

        Where asked to it keeps the shapes until `forget`. Those that are kept are taken.
        """
        bench, camera, document = self._workbench, self._view.camera, self._drawing.document
        known = self._kept_shapes(document, names)
        models = [
            model
            for model in resolved(document).values()
            if (model.visible if names is None else model.name in names)
        ]

        def work(job: Job, paths: Sequence[Path]) -> Any:
            from bozzetto.exchange.handover import AS_USUAL
            from bozzetto.exchange.ready_shapes import Ready
            from bozzetto.workbench.export_document import object_shapes, prepared_files
            from bozzetto.workbench.films import with_recording

            objects = known or self._kept_shapes(document, names)
            if objects is None:
                objects = object_shapes(bench, models, job)
            objects = with_recording(bench, document, objects, names, paths, job)
            job.checkpoint(1.0, ", ".join(path.name for path in paths))
            if keep:
                self._looked_at = document, names, objects
            asked = handover or AS_USUAL
            ready = Ready(objects.shapes, asked, job.checkpoint, objects.recording)
            made = prepared_files(objects, paths, camera, whole=False, handover=asked, ready=ready)
            return objects, made, ready

        return work

    def _kept_shapes(self, document: Document, names: Sequence[str] | None) -> ObjectShapes | None:
        """Return the shapes of objects of a document that the last look has made; None if none."""
        kept = self._looked_at
        is_same = kept is not None and kept[0] is document and kept[1] == names
        return kept[2] if kept is not None and is_same else None

    def import_text(self, content: bytes) -> None:
        """Bring a drawing in SVG onto the sheet that is in no file, as from the clipboard."""
        self._import(Path(tr("Files", "Drawing") + ".svg"), "", content)

    def import_file(self, path: Path, title: str = "") -> None:
        """Bring a drawing, a mesh or a picture onto the sheet.

        A drawing with a title is called by it, any other one by its file.
        """
        from bozzetto.exchange.import_file import is_picture

        if is_picture(path):
            self._pictures.take_file(path)
        else:
            self._import(path, title)

    def import_files(self, paths: Sequence[Path], *, under: bool = False) -> None:
        """Bring several files onto the sheet; what there is to say of them is said as one.

        Parameters
        ----------
        paths : sequence of Path
            Drawings, meshes and pictures.
        under : bool
            Whether pictures are to lie under the sheet in any case.
        """
        from bozzetto.exchange.import_file import is_picture

        if len(paths) > 1:
            self._notices.gather()
        for path in paths:
            if under and is_picture(path):
                self._pictures.take_file(path, under=True)
            else:
                self.import_file(path)

    def _look_if_read(self) -> None:
        """Say what there is to say of several files, once all of them are read."""
        if not self._work.busy and not self._pictures.busy:
            self._notices.tell_gathered()

    def _import(self, path: Path, title: str, content: bytes | None = None) -> None:
        bench, drawing, active = self._workbench, self._drawing, self._toolbox.modeler
        context, history, document = self._context.now(), drawing.history, drawing.document

        def work(job: Job) -> tuple[Model, bool, Camera | None, Notice | None]:
            from bozzetto.exchange.cad.curves_drawing import are_flat
            from bozzetto.exchange.import_file import is_mesh, read_drawing, read_mesh_file
            from bozzetto.ink.drawing import MODELER_FACT

            def reading() -> None:
                job.checkpoint(0.0, tr("Files", "Reading {name}", name=path.name))

            if is_mesh(path):
                mesh = read_mesh_file(path, checkpoint=reading)
                curves = mesh.shapes.curves
                modeler = active if active and curves and are_flat(curves) else MESH_MODELER
                drawing = bench.sources.ink_of_file(modeler, mesh, path.stem)
                if drawing is None:
                    model = bench.sources.from_mesh_file(MESH_MODELER, mesh, path.stem)
                    return model, False, None, _told_of(mesh)
                here = replace(context, camera=drawing.camera)
                model = bench.sources.from_drawing(modeler, drawing, {}, here, job)
                told = " ".join((*mesh.told(), *drawing.left_out))
                return model, False, drawing.camera, Notice("error", told) if told else None
            with _as_file(path, content) as place:
                ink = read_drawing(place, checkpoint=reading)
            ink = replace(ink, name=title or ink.name)
            facts_only = not len(ink.strokes)
            named = ink.facts.get(MODELER_FACT)
            if isinstance(named, str):
                modeler = bench.registry.resolve(named)
            else:
                modeler = (facts_only and bench.registry.told_by(ink.facts)) or active
            if not modeler:
                raise UserError(tr("Files", "Choose a modeler first, then import the drawing."))
            here = context if facts_only else replace(context, camera=ink.camera)
            model = bench.sources.from_drawing(modeler, ink, {}, here, job)
            if facts_only:
                model = bench.sources.beside(model, document, job)
            view = None if facts_only else ink.camera
            said = Notice("error", " ".join(ink.left_out)) if ink.left_out else None
            return model, bool(ink.pictures), view, said

        def done(answer: tuple[Model, bool, Camera | None, Notice | None]) -> None:
            if drawing.history is not history:
                return
            model, pictured, view, said = answer
            if not pictured:
                self.imported.emit(view)
            drawing.apply_model(
                tr("Files", "Import {name}", name=title or path.name), model, is_new=True
            )
            if pictured:
                self._pictures.taken.emit(model.id)
            if said is not None:  # what is missing stays until the next one, as with exports
                self._notices.send(said)

        def failed(problem: BaseException) -> None:
            if isinstance(problem, UserError):  # its ink is not on this sheet: no place to light
                problem = UserError(problem.message)
            self._notices.complain(problem)

        self._imports.add(self._work.submit(Request(work, done, failed)))

    def _drop_imports(self) -> None:
        """Stop reading for a document that is closed; what it hands over is still written."""
        for request in tuple(self._imports):
            request.abandon()


@contextmanager
def _as_file(path: Path, content: bytes | None) -> Iterator[Path]:
    """Give the place of a file; content that is in none is in one of that name meanwhile."""
    if content is None:
        yield path
        return
    with TemporaryDirectory() as folder:
        place = Path(folder, path.name)
        place.write_bytes(content)
        yield place


def _told_of(mesh: MeshFile) -> Notice | None:
    """Return what is said of a mesh file: how it was read, and what is missing."""
    said = mesh.told()
    return Notice("error" if mesh.left_out else "info", " ".join(said)) if said else None


def _picture(ready: Ready, made: Sequence[Exported], canvas: PictureCanvas) -> NDArray[np.uint8]:
    """Return a small picture of what files hold."""
    from bozzetto.exchange.export_picture import picture_of_page, picture_of_shapes

    pages = [file.page for file in made if file.page is not None]
    if len(pages) == len(made):
        return picture_of_page(pages[0], *canvas)
    return picture_of_shapes(ready.triangles, *canvas)


def _warnings(made: Sequence[Any]) -> list[str]:
    """Return what the files warn of."""
    return [warning for file in made for warning in file.warnings()]
