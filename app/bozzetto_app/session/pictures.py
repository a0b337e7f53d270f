"""Pictures from files and the clipboard: for a modeler that works on them, or under the sheet."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QImage

from bozzetto.document import edit
from bozzetto.document.model import Document, Model, Underlay, new_id
from bozzetto.errors import UserError
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.images.stored_picture import Picture
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.gesture_context import GestureContext
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.object_edits import ObjectEdits
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.toolbox import Toolbox
    from bozzetto_app.session.tracing import Tracing
    from bozzetto_app.session.underlay_placing import UnderlayPlacing

__all__ = ["PictureInput"]

UNDERLAY_WIDTH = 200.0
"""Width of a picture to trace on the sheet, mm."""


class PictureInput(QObject):
    """Takes pictures from files and from the clipboard.

    If a model is selected whose modeler works on pictures, the picture goes to that model; if
    nothing is selected, the active modeler makes a new model of it. All other pictures, and
    those that the person wants there, lie under the sheet to be traced.

    Attributes
    ----------
    channel : Channel
        The reading under way.
    tracing : Tracing
        Makes waiting ink of the lines in a picture.
    placing : UnderlayPlacing
        Moves, turns and scales the underlay that is chosen.

    Signals
    -------
    taken : str
        A model (id) has got a picture.
    busy_changed : bool
        Reading or handing over starts, ends.
    """

    taken = Signal(str)
    busy_changed = Signal(bool)

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        toolbox: Toolbox,
        objects: ObjectEdits,
        context: GestureContext,
        edits: Channel,
        tracing: Tracing,
        placing: UnderlayPlacing,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.channel = Channel("picture", keep_all=True, is_patient=True, parent=self)
        notices.watch(self.channel)
        self.tracing, self.placing = tracing, placing
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._toolbox, self._objects, self._context = toolbox, objects, context
        self._edits, self._notices = edits, notices
        for work in (self.channel, edits):
            work.busy_changed.connect(self.busy_changed)
        self.taken.connect(toolbox.take_first_tool)

    @property
    def busy(self) -> bool:
        """Whether a picture is being read or handed over."""
        return self.channel.busy or self._edits.busy

    def take_file(self, path: Path, *, under: bool = False) -> None:
        """Bring in a picture from a file.

        Parameters
        ----------
        path : Path
            The file of the picture.
        under : bool
            Whether it lies under the sheet in any case.
        """
        modeler, base = ("", None) if under else self._taker()

        def work(job: Job) -> Picture | Underlay:
            from bozzetto.exchange.import_file import read_image, read_picture

            def reading() -> None:
                job.checkpoint(0.0, tr("Files", "Reading {name}", name=path.name))

            if self._takes(modeler):
                return read_picture(path, checkpoint=reading)
            return laid_on_sheet(read_image(path, checkpoint=reading), path.stem)

        self._read(work, modeler, base)

    def take_image(self, image: QImage, name: str, *, under: bool = False) -> None:
        """Bring in a picture that is in no file, such as one from the clipboard.

        Parameters
        ----------
        image : QImage
            The picture.
        name : str
            Its name in the lists of objects and parts.
        under : bool
            Whether it lies under the sheet in any case.
        """
        modeler, base = ("", None) if under else self._taker()

        def work(job: Job) -> Picture | Underlay:
            from bozzetto.images.stored_picture import Picture

            pixels = pixels_of(image)
            if self._takes(modeler):
                return Picture.of(pixels, name)
            return laid_on_sheet(pixels, name)

        self._read(work, modeler, base)

    @property
    def sketch_taker(self) -> str:
        """Title of the modeler that a picture would go to now; "" if it would be an underlay."""
        modeler, _ = self._taker()
        return self._workbench.registry.info(modeler).title if self._takes(modeler) else ""

    def take_underlay(self, underlay_id: str) -> None:
        """Give the picture of an underlay to the modeler that a dropped one would go to.

        The underlay is hidden in the same step of the history.
        """
        modeler, base = self._taker()
        found = next((u for u in self._drawing.document.underlays if u.id == underlay_id), None)
        if found is None:
            return

        def work(job: Job) -> Picture:
            from bozzetto.images.stored_picture import Picture

            if not self._takes(modeler):
                raise UserError(
                    tr(
                        "Session",
                        "The chosen object takes no sketch. Choose Car, or another modeler that "
                        "works on pictures.",
                    )
                )
            return Picture.of(found.pixels, found.name)

        self._read(work, modeler, base, underlay_id)

    def _taker(self) -> tuple[str, str | None]:
        """Return the modeler to ask first, and the model (id) that would get the picture."""
        model = self._selection.model
        if model is None:
            return self._toolbox.modeler, None
        foreign = self._workbench.is_foreign(model)
        usable = model.visible and not model.locked and not foreign
        return (model.modeler, model.id) if usable else ("", None)

    def _takes(self, modeler: str) -> bool:
        """Return whether a modeler works on pictures; in a worker, for it may be imported."""
        try:
            return bool(modeler) and self._workbench.sources.takes_pictures(modeler)
        except UserError:
            return False  # it cannot be used at all, which is reported elsewhere

    def _read(self, work: Any, modeler: str, base: str | None, under: str = "") -> None:
        history = self._drawing.history

        def done(found: Picture | Underlay) -> None:
            if self._drawing.history is not history:
                return
            if isinstance(found, Underlay):
                self._objects.edit(edit.add_underlay, found)
                self.placing.choose(found.id)
                words = tr(
                    "Session",
                    "The picture lies under the sheet. Drag its handles, or type its width under "
                    "Parameters; Ctrl+T traces it into ink.",
                )
                self._notices.tell(words)
            else:
                self._hand_over(found, modeler, base, under)

        self.channel.submit(Request(work, done, self._notices.complain))

    def _hand_over(self, picture: Picture, modeler: str, base: str | None, under: str) -> None:
        """Give a picture to a model, in its turn among the gestures, and hide its underlay."""
        bench, drawing, context = self._workbench, self._drawing, self._context.now()
        history = drawing.history

        def work(job: Job, document: Document) -> tuple[Model | None, Model] | None:
            if base is None:
                made = bench.sources.from_picture(modeler, picture, {}, context)
                return None, bench.sources.beside(made, document, job)
            known = next((model for model in document if model.id == base), None)
            if known is None:
                return None
            return known, bench.sources.with_picture(known, picture, context)

        def done(answer: tuple[Model | None, Model] | None) -> None:
            if answer is None or drawing.history is not history:
                return
            before, model = answer
            if before is not None and all(before is not known for known in drawing.document):
                self._hand_over(picture, modeler, base, under)  # the document changed meanwhile
                return
            drawing.apply_model(
                tr("Session", "Add sketch"),
                model,
                is_new=before is None,
                hidden=(under,) if under else (),
            )
            self.taken.emit(model.id)
            self._notices.tell(
                tr(
                    "Session",
                    "Sketch added. With Shift, a dropped picture lies under the sheet instead.",
                )
                if before is None
                else tr(
                    "Session",
                    "Sketch added to “{name}”. For another object take it back with Ctrl+Z, press "
                    "Enter, and drop it again.",
                    name=model.name,
                )
            )

        self._edits.submit(
            Request(work, done, self._notices.complain, inputs=lambda: drawing.document)
        )


def pixels_of(image: QImage) -> NDArray[np.uint8]:
    """Return the pixels of a Qt picture, (h, w, 4) RGBA, straight alpha.

    Raises
    ------
    UserError
        If the picture is empty.
    """
    if image.isNull():
        raise UserError(tr("Session", "There is no picture in the clipboard. Copy one first."))
    plain = image.convertToFormat(QImage.Format.Format_RGBA8888)
    rows = np.frombuffer(plain.constBits(), np.uint8).reshape(plain.height(), -1)
    return rows[:, : 4 * plain.width()].reshape(plain.height(), plain.width(), 4).copy()


def laid_on_sheet(pixels: NDArray[np.uint8], name: str) -> Underlay:
    """Return a picture in the plane y = 0, on the ground, centred."""
    height, width = pixels.shape[:2]
    tall = UNDERLAY_WIDTH * height / width
    return Underlay(
        new_id(),
        name,
        pixels,
        corner=(-UNDERLAY_WIDTH / 2, 0.0, tall),
        across=(UNDERLAY_WIDTH, 0.0, 0.0),
        down=(0.0, 0.0, -tall),
    )
