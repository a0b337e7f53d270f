"""Small pictures of drawings and documents, without building anything.

They are made in a worker, which must not let Qt decode a picture: the first time Qt makes objects
of its decoders, and waits for a lock while it holds the interpreter. The window's thread may hold
that lock, and wait for the interpreter, while it deletes a widget: then neither goes on.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen, QPolygonF

from bozzetto.document.storage.zip_container import ContainerReader
from bozzetto.errors import UserError
from bozzetto.images.png import decode_picture
from bozzetto_app.session.files import DOCUMENT_ENDING
from bozzetto_app.style.theme import current_palette

if TYPE_CHECKING:
    from bozzetto.images.stored_picture import Picture

__all__ = ["thumbnail_of"]

SIZE = (144, 108)
"""Pixels: twice what a card shows, for screens of double density."""

MARGIN = 12.0
LARGEST = 32 << 20
"""Bytes of a document beyond which it is not opened for the sake of a small picture."""


def thumbnail_of(path: Path) -> QImage | None:
    """Return the picture that a drawing names, or its ink, or the picture kept in a document.

    None if there is none.
    """
    try:
        return _of_document(path) if path.suffix == DOCUMENT_ENDING else _of_ink(path)
    except (UserError, OSError):
        return None


def _of_document(path: Path) -> QImage | None:
    if path.stat().st_size > LARGEST:
        return None
    reader = ContainerReader(path.read_bytes())
    if "thumbnail.png" not in reader:
        return None
    return _image_of(decode_picture(reader.read("thumbnail.png")))


def _image_of(pixels: NDArray[np.uint8]) -> QImage:
    """Return RGBA pixels (h, w, 4) as an image of its own."""
    height, width = pixels.shape[:2]
    rows = np.ascontiguousarray(pixels)
    return QImage(rows.data, width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()


def _of_ink(path: Path) -> QImage | None:
    from bozzetto.exchange.import_file import read_drawing

    drawing = read_drawing(path, trusted=True)  # a sample that came with its plugin
    if drawing.pictures or not len(drawing.strokes):
        return _of_picture(next(iter(drawing.pictures.values()), None))
    strokes = [stroke.points for stroke in drawing.strokes]
    points = np.concatenate(strokes)
    low, extent = points.min(0), np.maximum(np.ptp(points, axis=0), 1e-9)
    scale = float(((np.array(SIZE) - 2 * MARGIN) / extent).min())
    shift = (np.array(SIZE) - scale * extent) / 2
    image = QImage(*SIZE, QImage.Format.Format_ARGB32_Premultiplied)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    ink = QColor(*current_palette().ink)
    painter.setPen(QPen(ink, 2.5, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    for stroke in strokes:
        placed = (stroke - low) * scale + shift
        painter.drawPolyline(QPolygonF([QPointF(x, y) for x, y in placed]))
    painter.end()
    return image


def _of_picture(picture: Picture | None) -> QImage | None:
    """Return a sketch, as large as the small picture has room for."""
    if picture is None:
        return None
    fitted = _image_of(picture.pixels).scaled(
        QSize(*SIZE),
        Qt.AspectRatioMode.KeepAspectRatio,
        Qt.TransformationMode.SmoothTransformation,
    )
    image = QImage(*SIZE, QImage.Format.Format_ARGB32_Premultiplied)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    painter.drawImage((SIZE[0] - fitted.width()) // 2, (SIZE[1] - fitted.height()) // 2, fitted)
    painter.end()
    return image
