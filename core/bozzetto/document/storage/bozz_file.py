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
from collections.abc import Iterator, Sequence
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
from bozzetto.document.storage.migrations import FROZEN, VERSION, WAITING, migrate
from bozzetto.document.storage.records import (
    Id,
    ModelHeader,
    StoredModel,
    UnderlayHeader,
    WaitingHeader,
    open_model,
    store_model,
    store_underlay,
    store_waiting,
    with_frozen_models,
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
FROZEN_STROKES, FROZEN_COLUMNS = "core/frozen/strokes.meta.json", "core/frozen/"
CORE: Final = (MANIFEST, MODELS, VIEWS, STROKES, WAITING, FROZEN)
OWN: Final = {"mimetype", *CORE, "thumbnail.png"}


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

    @property
    def folder(self) -> str:
        """Where its state lies in the file."""
        return self.header.folder


class _FrozenEntry(_ModelEntry):
    """A source that a model keeps; `within` leads to what it is frozen in, from a model on."""

    within: Annotated[tuple[Id, ...], Meta(min_length=1)]

    @property
    def folder(self) -> str:
        return "/".join(("frozen", *self.within, self.header.id))


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
    frozen: list[_FrozenEntry] = []
    strokes: list[Stroke] = []
    frozen_strokes: list[Stroke] = []
    for model in document:
        for path, stored in store_model(model).with_paths():
            within, row = path[:-1], frozen_strokes if path[:-1] else strokes
            span = (len(row), len(stored.encoded.strokes))
            row += stored.encoded.strokes
            if within:
                frozen.append(_FrozenEntry(stored.header, span, [], within))
                _put_state(writer, frozen[-1], stored.encoded)
            else:
                models.append(_ModelEntry(stored.header, span, []))
                _put_state(writer, models[-1], stored.encoded)
    writer.add_json(MODELS, models)
    writer.add_json(FROZEN, frozen)
    if frozen_strokes:
        put_strokes(writer, frozen_strokes, FROZEN_STROKES, FROZEN_COLUMNS)
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
        sorted({entry.header.modeler for entry in (*models, *frozen)}),
        writer.parts,
    )
    writer.add_json(MANIFEST, manifest)
    return writer


def _put_state(writer: ContainerWriter, entry: _ModelEntry, encoded: EncodedState) -> None:
    """Add a state to a container, and the names of its arrays to its entry."""
    writer.add(f"{entry.folder}/state.json", encoded.json)
    for place, array in enumerate(encoded.arrays):
        entry.arrays.append(writer.add_array(f"{entry.folder}/{place}", array))


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
    models = _models(
        decode_json(texts[MODELS], list[_ModelEntry]),
        strokes,
        decode_json(texts[FROZEN], list[_FrozenEntry]),
        reader,
    )
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
    models = decode_json(texts[MODELS], list[_ModelEntry])
    headers = [entry.header for entry in models]
    frozen = decode_json(texts[FROZEN], list[_FrozenEntry])
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
                **_links_of(entry.header, headers, frozen),
                "strokes": entry.strokes[1],
                "arrays": len(entry.arrays),
            }
            for entry in models
        ],
        "views": [view.name for view in views.views],
        "underlays": [underlay.name for underlay in views.underlays],
        "waiting_strokes": len(decode_json(texts[WAITING], list[WaitingHeader])),
    }


def _links_of(
    header: ModelHeader, models: Sequence[ModelHeader], frozen: Sequence[_FrozenEntry]
) -> dict[str, list[str]]:
    """Return the names of what an object follows, and of what it keeps frozen; nothing if none."""
    kept = {entry.header.id: entry.header.name for entry in frozen if entry.within == (header.id,)}
    names = {model.id: model.name for model in models}
    followed = [names.get(s, s) for s in header.sources if s not in kept]
    links = {"follows": followed, "frozen": list(kept.values())}
    return {word: row for word, row in links.items() if row}


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
    names = [name for name in CORE if name in reader]
    texts = {name: reader.json(name) for name in names}
    if promise.version < VERSION:
        trees = {name: decode_json(text, object) for name, text in texts.items()}
        trees = migrate(trees, promise.version)
        texts = {name: encode_json(tree) for name, tree in trees.items()}
    for name in CORE:
        if name not in texts:
            raise DocumentError(f"This document lacks its part {name}.")
    return texts, promise.version


def _models(
    entries: Sequence[_ModelEntry],
    strokes: Sequence[Stroke],
    frozen: Sequence[_FrozenEntry],
    reader: ContainerReader,
) -> tuple[StoredModel, ...]:
    """Read the models with what is frozen in them."""
    texts = [reader.read(f"{entry.folder}/state.json") for entry in (*entries, *frozen)]
    if sum(map(json_values, texts)) > MAX_STATE_VALUES:
        raise DocumentError("The states of this document's objects are too long together.")
    found: dict[tuple[str, ...], StoredModel] = {}
    for model in _in_turn(entries, strokes, texts[: len(entries)], reader):
        found[(model.header.id,)] = model
    count = sum(entry.strokes[1] for entry in frozen)
    kept = take_strokes(reader, reader.json(FROZEN_STROKES), FROZEN_COLUMNS) if count > 0 else []
    sources = _in_turn(frozen, kept, texts[len(entries) :], reader)
    for entry, model in zip(frozen, sources, strict=True):
        found[(*entry.within, model.header.id)] = model
    if len(found) < len(texts):
        raise DocumentError("This document has two objects with one id.")
    return with_frozen_models(found)


def _in_turn(
    entries: Sequence[_ModelEntry],
    strokes: Sequence[Stroke],
    texts: Sequence[bytes],
    reader: ContainerReader,
) -> Iterator[StoredModel]:
    """Read models; each owns the strokes that follow those of the one before."""
    end = 0
    for entry, text in zip(entries, texts, strict=True):
        first, count = entry.strokes
        if first != end or count < 0 or first + count > len(strokes):
            raise DocumentError(f"The strokes of “{entry.header.name}” are not its own.")
        if len(set(entry.arrays)) < len(entry.arrays) or any(
            not name.startswith(f"{entry.folder}/") for name in entry.arrays
        ):
            raise DocumentError(f"The arrays of “{entry.header.name}” are not its own.")
        end = first + count
        encoded = EncodedState(
            text,
            tuple(strokes[first:end]),
            tuple(reader.array(name) for name in entry.arrays),
        )
        yield StoredModel(entry.header, encoded)
    if end != len(strokes):
        raise DocumentError("This document has strokes that belong to no object.")


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
