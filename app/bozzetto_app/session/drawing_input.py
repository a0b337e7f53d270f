"""Drawings of other files added to the selected object, such as a logo on a surface."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from bozzetto.errors import UserError
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Model
    from bozzetto.ink.drawing import Drawing
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.gesture_context import GestureContext
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection

__all__ = ["DrawingInput"]


class DrawingInput(QObject):
    """Adds drawings to the selected model, where its modeler has a use for them.

    Attributes
    ----------
    channel : Channel
        The reading under way.
    """

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        context: GestureContext,
        edits: Channel,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.channel = Channel("drawing", is_patient=True, parent=self)
        notices.watch(self.channel)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._context, self._edits, self._notices = context, edits, notices

    @property
    def is_wanted(self) -> bool:
        """Whether drawings can be added to the selected model."""
        model = self._selection.model
        if model is None or model.locked:
            return False
        try:
            return self._workbench.sources.takes_drawings(model.modeler)
        except UserError:
            return False  # its plugin is not here

    def take_file(self, path: Path) -> None:
        """Add the drawing of a file to the selected model, as one step of the history."""
        model, history = self._selection.model, self._drawing.history
        if model is None:
            return

        def work(job: Job) -> Drawing:
            from bozzetto.exchange.import_file import read_drawing

            def reading() -> None:
                job.checkpoint(0.0, tr("Files", "Reading {name}", name=path.name))

            return read_drawing(path, checkpoint=reading)

        def done(found: Drawing) -> None:
            if self._drawing.history is history:
                self._add(found, model.id)

        self.channel.submit(Request(work, done, self._notices.complain))

    def _add(self, found: Drawing, base: str) -> None:
        """Add a drawing to a model, in its turn among the gestures."""
        drawing, context = self._drawing, self._context.now()
        history = drawing.history

        def work(job: Job, document: Document) -> tuple[Model, Model] | None:
            known = next((model for model in document if model.id == base), None)
            if known is None:
                return None
            return known, self._workbench.sources.with_drawing(known, found, context)

        def done(answer: tuple[Model, Model] | None) -> None:
            if answer is None or drawing.history is not history:
                return
            before, model = answer
            if all(before is not known for known in drawing.document):
                self._add(found, base)  # the document changed meanwhile
                return
            drawing.apply_model(tr("Session", "Add drawing"), model, is_new=False)

        self._edits.submit(
            Request(work, done, self._notices.complain, inputs=lambda: drawing.document)
        )
