"""The ``.bozz`` file: a document in a container.

::

    mimetype                          application/vnd.bozzetto.document
    manifest.json                     version, units, plugins needed, kind and shape of arrays
    core/models.json                  the objects in order, and which strokes are whose
    core/views.json                   the last camera, the named views, the underlays
    core/underlays/<id>.png
    core/strokes.meta.json            cameras, and one row per stroke
    core/strokes/x.f4 …               samples of all strokes, one column each
    core/waiting.json                 ink that no modeler has taken, one entry a stroke
    core/waiting/strokes.meta.json    its strokes, as above; nothing where none waits
    core/waiting/x.f4 …
    core/frozen.json                  sources that followers keep, and which strokes are whose
    core/frozen/strokes.meta.json     their strokes, as above; nothing where there are none
    core/frozen/x.f4 …
    frozen/<model>/<source>/state.json, 0.f4, 1.i4 …
    plugins/<modeler>/<model>/state.json, 0.f4, 1.i4 …
    derived/…                         may be dropped by anyone
    thumbnail.png

Everything else is kept and written back byte for byte.
"""

from __future__ import annotations

import io
import os
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from bozzetto.atomic_files import DISK, Disk, FileStamp, Over, Written, atomic_write, read_stamped
from bozzetto.chunked import Chunked
from bozzetto.damaged_files import as_format_errors
from bozzetto.document.model import Document
from bozzetto.document.storage.bozz_reader import StoredDocument, parse_document
from bozzetto.document.storage.bozz_writer import packed
from bozzetto.document.storage.records import open_model
from bozzetto.document.storage.zip_container import MAX_FILE_BYTES
from bozzetto.errors import DocumentError

if TYPE_CHECKING:
    from bozzetto.document.storage.state_codec import StateTypes


@dataclass(frozen=True)
class LoadReport:
    """Messages about a document that could be opened.

    Attributes
    ----------
    warnings : tuple of str
        For the person: objects that stayed closed, and why.
    read_only : bool
        The file is of a newer version that may be shown, and must not be written over.
    stamp : FileStamp, optional
        Stamp of the content that was read, where it came from a file.
    """

    warnings: tuple[str, ...] = ()
    read_only: bool = False
    stamp: FileStamp | None = None


def write_document(
    document: Document,
    path: str | os.PathLike[str],
    *,
    thumbnail: bytes | None = None,
    backups: int = 3,
    over: FileStamp | Over = Over.ANYTHING,
    disk: Disk = DISK,
) -> Written:
    """Save a document; the file is at every moment either the old one or the new one.

    Parameters
    ----------
    document : Document
        What to save.
    path : path
        The file; what is there is replaced.
    thumbnail : bytes, optional
        A PNG, 256 pixels square, that file managers may show.
    backups : int
        How many earlier versions stay as ``name.bozz~1`` (the newest) ….
    over : FileStamp or Over
        The content that may be replaced; see `bozzetto.atomic_files.atomic_write`.
    disk : Disk
        The operating system; tests give one that fails.

    Raises
    ------
    FileChanged
        If the file has another content by now; it is as it was.
    UserError
        If it cannot be written; the old file is as it was.
    """
    writer = packed(document, thumbnail)
    return atomic_write(path, writer.write, backups=backups, over=over, disk=disk)


def encode_document(document: Document, thumbnail: bytes | None = None) -> bytes:
    """Return the content of a document's file."""
    file = io.BytesIO()
    packed(document, thumbnail).write(file)
    return file.getvalue()


def read_document(path: str | os.PathLike[str], states: StateTypes) -> tuple[Document, LoadReport]:
    """Open a document.

    Parameters
    ----------
    path : path
        The file.
    states : StateTypes
        Who knows the modelers; the registry does. States of modelers it does not know stay
        closed (`OpaqueState`) and are written back as they were.

    Raises
    ------
    DocumentError
        If the file is damaged, not a document, or too new.
    UserError
        If it cannot be read at all.
    """
    content, stamp = read_stamped(path, MAX_FILE_BYTES)
    document, report = decode_document(content, states)
    return document, replace(report, stamp=stamp)


def decode_document(content: bytes | memoryview, states: StateTypes) -> tuple[Document, LoadReport]:
    """Read a document, as `read_document`, from the content of a file."""
    with as_format_errors(DocumentError):
        return open_document(parse_document(content), states)


def open_document(stored: StoredDocument, states: StateTypes) -> tuple[Document, LoadReport]:
    """Ask the modelers to make sense of a document's states."""
    opened = [open_model(model, states) for model in stored.models]
    document = Document(
        Chunked(model for model, _ in opened),
        stored.views,
        stored.underlays,
        stored.camera,
        stored.foreign,
        stored.waiting,
    )
    warnings = [warning for _, warning in opened if warning is not None]
    if stored.read_only:
        warnings.insert(0, "A newer Bozzetto made this document. It can be looked at, not saved.")
    return document, LoadReport(tuple(warnings), stored.read_only)
