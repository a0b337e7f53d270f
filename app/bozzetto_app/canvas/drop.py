"""Files that are dropped on the sheet."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QMimeData

from bozzetto_app.files import DOCUMENT_ENDING

if TYPE_CHECKING:
    from bozzetto_app.session import Session

__all__ = ["dropped_files", "take_file"]


def dropped_files(data: QMimeData) -> list[Path]:
    """The files on this machine that a drag carries."""
    paths = [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile()]
    return [path for path in paths if path.is_file()]


def take_file(session: Session, path: Path) -> None:
    """Open a document; bring anything else into the one that is open."""
    if path.suffix.lower() == DOCUMENT_ENDING:
        session.open(path)
    else:
        session.import_file(path)
