"""Files and pictures that are dropped on the sheet, or pasted."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QMimeData, Qt
from PySide6.QtGui import QImage

from bozzetto.errors import UserError
from bozzetto_app.i18n import tr
from bozzetto_app.session.files import DOCUMENT_ENDING

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["carries_something", "dropped_files", "take"]

SVG = "image/svg+xml"

SVG_BEGINNING = 4000
"""Characters in which a text that is an SVG file names its first element: notes may go before."""


def dropped_files(data: QMimeData) -> list[Path]:
    """Return the files on this machine that a drag carries."""
    paths = [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile()]
    return [path for path in paths if path.is_file()]


def carries_something(data: QMimeData) -> bool:
    """Whether there is a file or a picture in a drag, or on the clipboard."""
    return bool(dropped_files(data)) or data.hasImage()


def drawing_in(data: QMimeData) -> bytes:
    """Return the SVG that is carried as such, or as a text; b"" if there is none."""
    if data.hasFormat(SVG):
        return bytes(data.data(SVG).data())
    words = data.text() if data.hasText() else ""
    return words.encode() if "<svg" in words[:SVG_BEGINNING] else b""


def take(session: Session, data: QMimeData | None, *, under: bool = False) -> bool:
    """Take what was dropped or pasted.

    Parameters
    ----------
    session : Session
        Gets the files or the picture.
    data : QMimeData, optional
        A drag out of a browser may carry the picture itself and no file; of a clipboard that
        belongs to nobody there is none at all.
    under : bool
        Whether pictures are to lie under the sheet in any case.

    Returns
    -------
    bool
        Whether there was anything to take.
    """
    if data is None:
        return False
    paths = dropped_files(data)
    if paths:
        _take_files(session, paths, under=under)
        return True
    exchange = session.files.exchange
    if not under and exchange.clipboard.paste(data):
        return True
    drawing = b"" if under else drawing_in(data)
    if drawing:
        exchange.import_text(drawing)
        return True
    image = data.imageData() if data.hasImage() else None
    if isinstance(image, QImage):
        session.pictures.take_image(image, tr("Session", "Picture"), under=under)
    return isinstance(image, QImage)


def _take_files(session: Session, paths: list[Path], *, under: bool) -> None:
    """Open a document, which takes the sheet for itself, or bring all files onto the sheet."""
    document = next((path for path in paths if path.suffix.lower() == DOCUMENT_ENDING), None)
    if document is None:
        session.files.exchange.import_files(paths, under=under)
        return
    left = ", ".join(path.name for path in paths if path != document)
    words = tr("Session", "“{name}” opened alone. Drop the others again: {others}.").format(
        name=document.name, others=left
    )

    def opened() -> None:
        if left and session.drawing.path == document:
            session.notices.complain(UserError(words))

    session.drawing.opened.connect(opened, Qt.ConnectionType.SingleShotConnection)
    session.files.open_safely(document)
