"""Objects on the clipboard: copied out of one document, pasted into any."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QMimeData, QObject, Signal
from PySide6.QtGui import QGuiApplication

from bozzetto.document import edit
from bozzetto.document.model import Document, new_id
from bozzetto.errors import DocumentError, UserError
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.document.storage.bozz_file import LoadReport
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.object_edits import ObjectEdits
    from bozzetto_app.session.selection import Selection

__all__ = ["OBJECTS", "ObjectClipboard"]

OBJECTS = "application/vnd.bozzetto.document"
"""Media type of copied objects: a document's file, so that another Bozzetto reads them."""

TOKEN = "application/x-bozzetto-copy"
"""Media type of a name for what was copied here, which is pasted without reading a file."""


class ObjectClipboard(QObject):
    """Copies objects to the clipboard of the system, and brings them back.

    What was copied can be pasted here at once; its file, which other windows of the program
    read, is written by a worker.

    Attributes
    ----------
    channel : Channel
        The writing and reading under way.

    Signals
    -------
    pasted
        Objects came onto the sheet.
    """

    pasted = Signal()

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        objects: ObjectEdits,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.channel = Channel("clipboard", keep_all=True, is_patient=True, parent=self)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._objects, self._notices = objects, notices
        self._copied, self._token = Document(), b""

    def copy(self, model_ids: Sequence[str]) -> None:
        """Put objects onto the clipboard."""
        try:
            copied = edit.copied_models(self._drawing.document, model_ids)
        except UserError as problem:
            self._notices.complain(problem)
            return
        token = new_id().encode()
        self._copied, self._token = copied, token
        _put(copied, token)

        def work(job: Job) -> bytes:
            from bozzetto.document.storage.bozz_file import encode_document

            return encode_document(copied)

        def done(content: bytes) -> None:
            now = QGuiApplication.clipboard().mimeData()
            if now is not None and _content(now, TOKEN) == token:
                _put(copied, token, content)

        self.channel.submit(Request(work, done, self._notices.complain))
        names = ", ".join(f"“{model.name}”" for model in copied)
        self._notices.tell(tr("Session", "Copied {names}.", names=names))

    def paste(self, data: QMimeData) -> bool:
        """Bring copied objects onto the sheet, where they stood or beside their like.

        Returns
        -------
        bool
            Whether there were any.
        """
        if not data.hasFormat(OBJECTS):
            return False
        if self._token and _content(data, TOKEN) == self._token:
            self._put_on_sheet(self._copied)
            return True
        content, history = _content(data, OBJECTS), self._drawing.history
        registry = self._workbench.registry

        def work(job: Job) -> tuple[Document, LoadReport]:
            from bozzetto.document.storage.bozz_file import decode_document

            document, report = decode_document(content, registry)
            if not len(document):
                raise DocumentError(tr("Session", "There is no object on the clipboard."))
            return document, report

        def done(answer: tuple[Document, LoadReport]) -> None:
            if self._drawing.history is history:
                self._put_on_sheet(answer[0])
                if answer[1].warnings:
                    self._notices.complain(UserError(" ".join(answer[1].warnings)))

        self.channel.submit(Request(work, done, self._notices.complain))
        return True

    def _put_on_sheet(self, copied: Document) -> None:
        before = self._drawing.document
        self._objects.paste(copied)
        if self._drawing.document is not before:
            self._selection.select(self._drawing.document.models[-1].id)
            self.pasted.emit()


def _put(copied: Document, token: bytes, content: bytes = b"") -> None:
    """Set the clipboard of the system; other programs get the names of the objects."""
    data = QMimeData()
    data.setData(TOKEN, token)
    data.setData(OBJECTS, content)
    data.setText("\n".join(model.name for model in copied))
    QGuiApplication.clipboard().setMimeData(data)


def _content(data: QMimeData, kind: str) -> bytes:
    return bytes(data.data(kind).data())
