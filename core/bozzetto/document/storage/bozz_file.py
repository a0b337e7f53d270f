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
    plugins/<modeler>/<model>/state.json, 0.f4, 1.i4 …
    derived/…                         may be dropped by anyone
    thumbnail.png

Everything else is kept and written back byte for byte.
"""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Final

import msgspec
from msgspec import Meta

from bozzetto import __version__
from bozzetto.atomic_files import (
    DISK,
    Disk,
    FileStamp,
    Over,
    Written,
    atomic_write,
    read_bytes,
    read_stamped,
)
from bozzetto.chunked import Chunked
from bozzetto.damaged_files import as_format_errors
from bozzetto.document.model import Document, NamedView, Underlay
from bozzetto.document.storage.migrations import VERSION, WAITING, migrate
from bozzetto.document.storage.records import (
    ModelHeader,
    StoredModel,
    UnderlayHeader,
    WaitingHeader,
    open_model,
    store_model,
    store_underlay,
    store_waiting,
)
from bozzetto.document.storage.state_codec import EncodedState, StateTypes
from bozzetto.document.storage.stroke_columns import pack_strokes, unpack_strokes
from bozzetto.document.storage.underlays import decode_png, encode_png
from bozzetto.document.storage.zip_container import (
    MAX_FILE_BYTES,
    ContainerReader,
    ContainerWriter,
    Part,
    decode_json,
    encode_json,
)
from bozzetto.document.waiting_ink import Waiting, strokes_of
from bozzetto.errors import DocumentError
from bozzetto.images.png import pixel_count
from bozzetto.ink.stroke import COLUMNS, Stroke
from bozzetto.json_size import json_values
from bozzetto.view.camera import Camera

MIMETYPE: Final = b"application/vnd.bozzetto.document"
FORMAT: Final = "bozzetto.document"
MIN_READER: Final = 1

MAX_UNDERLAY_PIXELS: Final = 80_000_000
"""Limit for all pictures under the sheet together: a third of a gigabyte unpacked."""

MAX_STATE_VALUES: Final = 4_000_000
"""Values in the JSON of all states: each is an object, and looked at one by one."""

"""The oldest version of this program that may show what is written here."""

MANIFEST, MODELS, VIEWS = "manifest.json", "core/models.json", "core/views.json"
STROKES, STROKE_COLUMNS = "core/strokes.meta.json", "core/strokes/"
WAITING_STROKES, WAITING_COLUMNS = "core/waiting/strokes.meta.json", "core/waiting/"
OWN: Final = {"mimetype", MANIFEST, MODELS, VIEWS, STROKES, WAITING, "thumbnail.png"}


class _Manifest(msgspec.Struct):
    format: str
    version: Annotated[int, Meta(ge=1)]
    min_reader: Annotated[int, Meta(ge=1)]
    generator: str
    units: str
    up: str
    requires: list[str]
    parts: list[Part]


class _Promise(msgspec.Struct):
    """The part of a manifest that every version has in common."""

    format: str
    version: Annotated[int, Meta(ge=1)]
    min_reader: Annotated[int, Meta(ge=1)] = 1
    generator: str = "another program"


class _ModelEntry(msgspec.Struct):
    header: ModelHeader
    strokes: tuple[int, int]
    arrays: list[str]


class _Views(msgspec.Struct):
    camera: Camera | None
    views: list[NamedView]
    underlays: list[UnderlayHeader]


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


@dataclass(frozen=True)
class StoredDocument:
    """A document as its file holds it, before any modeler is asked."""

    models: tuple[StoredModel, ...]
    views: tuple[NamedView, ...]
    underlays: tuple[Underlay, ...]
    camera: Camera | None
    foreign: tuple[tuple[str, bytes], ...]
    read_only: bool
    waiting: Waiting = ()


# -- writing --------------------------------------------------------------------------------------


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
    writer = _packed(document, thumbnail)
    return atomic_write(path, writer.write, backups=backups, over=over, disk=disk)


def encode_document(document: Document, thumbnail: bytes | None = None) -> bytes:
    """Return the content of a document's file."""
    file = io.BytesIO()
    _packed(document, thumbnail).write(file)
    return file.getvalue()


def _packed(document: Document, thumbnail: bytes | None) -> ContainerWriter:
    writer = ContainerWriter(first=("mimetype", MANIFEST))
    writer.add("mimetype", MIMETYPE)
    models: list[_ModelEntry] = []
    strokes: list[Stroke] = []
    for model in document:
        stored = store_model(model)
        encoded, folder = stored.encoded, stored.header.folder
        writer.add(f"{folder}/state.json", encoded.json)
        names = [
            writer.add_array(f"{folder}/{place}", array)
            for place, array in enumerate(encoded.arrays)
        ]
        span = (len(strokes), len(encoded.strokes))
        models.append(_ModelEntry(stored.header, span, names))
        strokes += encoded.strokes
    writer.add_json(MODELS, models)
    for underlay in document.underlays:
        writer.add(_png_name(underlay.id), encode_png(underlay.pixels))
    headers = [store_underlay(underlay) for underlay in document.underlays]
    writer.add_json(VIEWS, _Views(document.camera, list(document.views), headers))
    put_strokes(writer, strokes)
    writer.add_json(WAITING, store_waiting(document.waiting))
    if document.waiting:
        ink = strokes_of(document.waiting)
        put_strokes(writer, ink, WAITING_STROKES, WAITING_COLUMNS)
    for name, content in document.foreign:
        if name not in writer:
            writer.add(name, content)
    if thumbnail is not None:
        writer.add("thumbnail.png", thumbnail)
    manifest = _Manifest(
        FORMAT,
        VERSION,
        MIN_READER,
        f"Bozzetto {__version__}",
        "mm",
        "+Z",
        sorted({model.modeler for model in document}),
        writer.parts,
    )
    writer.add_json(MANIFEST, manifest)
    return writer


def put_strokes(
    writer: ContainerWriter,
    strokes: Sequence[Stroke],
    meta_name: str = STROKES,
    folder: str = STROKE_COLUMNS,
) -> None:
    """Add strokes to a container, their facts under one name and their columns in a folder."""
    meta, columns = pack_strokes(strokes)
    writer.add_json(meta_name, meta)
    for name, column in columns.items():
        writer.add_array(folder + name, column)


# -- reading --------------------------------------------------------------------------------------


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


def parse_document(content: bytes | memoryview) -> StoredDocument:
    """Read a document's file up to the point where modelers have to be asked.

    Raises
    ------
    DocumentError
        If anything in it is not as it should be.
    """
    reader = ContainerReader(content)
    texts, version = _core_texts(reader)
    reader.declare(decode_json(texts[MANIFEST], _Manifest).parts)
    strokes = take_strokes(reader, texts[STROKES])
    models = _models(decode_json(texts[MODELS], list[_ModelEntry]), strokes, reader)
    waiting = _waiting(decode_json(texts[WAITING], list[WaitingHeader]), reader)
    views = decode_json(texts[VIEWS], _Views)
    underlays = _underlays(views.underlays, reader)
    foreign = tuple(
        (name, reader.read(name))
        for name in reader.unread()
        if name not in OWN and not name.startswith("derived/")
    )
    return StoredDocument(
        models, tuple(views.views), underlays, views.camera, foreign, version > VERSION, waiting
    )


def _underlays(headers: Sequence[UnderlayHeader], reader: ContainerReader) -> tuple[Underlay, ...]:
    """Read the underlays; their sizes are added up before the first one is unpacked."""
    files = [reader.read(_png_name(header.id)) for header in headers]
    if sum(map(pixel_count, files)) > MAX_UNDERLAY_PIXELS:
        raise DocumentError("The pictures under this document's sheet are too large together.")
    return tuple(
        header.with_pixels(decode_png(content))
        for header, content in zip(headers, files, strict=True)
    )


def take_strokes(
    reader: ContainerReader, meta: bytes, folder: str = STROKE_COLUMNS
) -> list[Stroke]:
    """Read the strokes that `put_strokes` added to a container."""
    names = {"offsets": f"{folder}offsets.u4"}
    names |= {name: f"{folder}{name}.f4" for name in COLUMNS}
    columns = {name: reader.array(entry) for name, entry in names.items() if entry in reader}
    return unpack_strokes(meta, columns)


def document_info(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return facts about a document's file, as plain JSON values; no plugin is asked.

    Raises
    ------
    DocumentError, UserError
        As `read_document`.
    """
    content = read_bytes(path, MAX_FILE_BYTES)
    reader = ContainerReader(content)
    texts, version = _core_texts(reader)
    manifest = decode_json(texts[MANIFEST], _Manifest)
    views = decode_json(texts[VIEWS], _Views)
    return {
        "format": manifest.format,
        "version": version,
        "generator": manifest.generator,
        "units": manifest.units,
        "up": manifest.up,
        "bytes": len(content),
        "plugins": manifest.requires,
        "objects": [
            {
                "name": entry.header.name,
                "modeler": entry.header.modeler,
                "visible": entry.header.visible,
                "locked": entry.header.locked,
                "strokes": entry.strokes[1],
                "arrays": len(entry.arrays),
            }
            for entry in decode_json(texts[MODELS], list[_ModelEntry])
        ],
        "views": [view.name for view in views.views],
        "underlays": [underlay.name for underlay in views.underlays],
        "waiting_strokes": len(decode_json(texts[WAITING], list[WaitingHeader])),
    }


def _core_texts(reader: ContainerReader) -> tuple[dict[str, bytes], int]:
    """Return the JSON of the core in today's shape, and the version it was written in."""
    promise = decode_json(reader.json(MANIFEST), _Promise)
    if promise.format != FORMAT or reader.read("mimetype", len(MIMETYPE)) != MIMETYPE:
        raise DocumentError("This is not a Bozzetto document.")
    if promise.min_reader > VERSION:
        raise DocumentError(
            f"This document was made with a newer Bozzetto ({promise.generator}). Update "
            "Bozzetto to open it."
        )
    names = [name for name in (MANIFEST, MODELS, VIEWS, STROKES, WAITING) if name in reader]
    texts = {name: reader.json(name) for name in names}
    if promise.version < VERSION:
        trees = {name: decode_json(text, object) for name, text in texts.items()}
        trees = migrate(trees, promise.version)
        texts = {name: encode_json(tree) for name, tree in trees.items()}
    for name in (MODELS, VIEWS, STROKES, WAITING):
        if name not in texts:
            raise DocumentError(f"This document lacks its part {name}.")
    return texts, promise.version


def _models(
    entries: Sequence[_ModelEntry],
    strokes: Sequence[Stroke],
    reader: ContainerReader,
) -> tuple[StoredModel, ...]:
    """Read the models; each owns the strokes that follow those of the one before."""
    if len({entry.header.id for entry in entries}) < len(entries):
        raise DocumentError("This document has two objects with one id.")
    models = []
    end = values = 0
    for entry in entries:
        first, count = entry.strokes
        folder = entry.header.folder
        if first != end or count < 0 or first + count > len(strokes):
            raise DocumentError(f"The strokes of “{entry.header.name}” are not its own.")
        if len(set(entry.arrays)) < len(entry.arrays) or any(
            not name.startswith(f"{folder}/") for name in entry.arrays
        ):
            raise DocumentError(f"The arrays of “{entry.header.name}” are not its own.")
        end = first + count
        text = reader.read(f"{folder}/state.json")
        values += json_values(text)
        if values > MAX_STATE_VALUES:
            raise DocumentError("The states of this document's objects are too long together.")
        encoded = EncodedState(
            text,
            tuple(strokes[first:end]),
            tuple(reader.array(name) for name in entry.arrays),
        )
        models.append(StoredModel(entry.header, encoded))
    if end != len(strokes):
        raise DocumentError("This document has strokes that belong to no object.")
    return tuple(models)


def _waiting(entries: Sequence[WaitingHeader], reader: ContainerReader) -> Waiting:
    """Read the waiting ink."""
    if not entries:
        return ()
    strokes = take_strokes(reader, reader.json(WAITING_STROKES), WAITING_COLUMNS)
    if len(strokes) != len(entries):
        raise DocumentError("This document's list of waiting ink does not fit its strokes.")
    return tuple(entry.with_stroke(stroke) for entry, stroke in zip(entries, strokes, strict=True))


def _png_name(underlay_id: str) -> str:
    return f"core/underlays/{underlay_id}.png"
