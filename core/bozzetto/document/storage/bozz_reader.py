"""The parts of a ``.bozz`` file read, up to the point where modelers have to be asked."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from bozzetto.atomic_files import read_bytes
from bozzetto.document.model import NamedView, Underlay
from bozzetto.document.storage.bozz_parts import (
    CORE,
    FORMAT,
    FROZEN_COLUMNS,
    FROZEN_STROKES,
    MANIFEST,
    MIMETYPE,
    MODELS,
    OWN,
    STROKE_COLUMNS,
    STROKES,
    VIEWS,
    WAITING_COLUMNS,
    WAITING_STROKES,
    FrozenEntry,
    Manifest,
    ModelEntry,
    Promise,
    Views,
    png_name,
)
from bozzetto.document.storage.migrations import FROZEN, VERSION, WAITING, migrate
from bozzetto.document.storage.records import (
    ModelHeader,
    StoredModel,
    UnderlayHeader,
    WaitingHeader,
    with_frozen_models,
)
from bozzetto.document.storage.state_codec import EncodedState
from bozzetto.document.storage.stroke_columns import unpack_strokes
from bozzetto.document.storage.underlays import decode_png
from bozzetto.document.storage.zip_container import (
    MAX_FILE_BYTES,
    ContainerReader,
    decode_json,
    encode_json,
    row_count,
)
from bozzetto.document.waiting_ink import Waiting
from bozzetto.errors import DocumentError
from bozzetto.images.png import pixel_count
from bozzetto.ink.stroke import COLUMNS, Stroke
from bozzetto.json_size import json_values
from bozzetto.view.camera import Camera

Entry = TypeVar("Entry")

MAX_UNDERLAY_PIXELS: Final = 80_000_000
"""Limit for all pictures under the sheet together: a third of a gigabyte unpacked."""

MAX_STATE_VALUES: Final = 4_000_000
"""Values in the JSON of all states: each is an object, and looked at one by one."""


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


def parse_document(content: bytes | memoryview) -> StoredDocument:
    """Read a document's file up to the point where modelers have to be asked.

    Raises
    ------
    DocumentError
        If anything in it is not as it should be.
    """
    reader = ContainerReader(content)
    texts, version = core_texts(reader)
    reader.declare(decode_json(texts[MANIFEST], Manifest).parts)
    strokes = take_strokes(reader, texts[STROKES])
    models = _models(
        _listed(texts[MODELS], ModelEntry, reader),
        strokes,
        _listed(texts[FROZEN], FrozenEntry, reader),
        reader,
    )
    waiting = _waiting(decode_json(texts[WAITING], list[WaitingHeader]), reader)
    views = decode_json(texts[VIEWS], Views)
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
    files = [reader.read(png_name(header.id)) for header in headers]
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
    texts, version = core_texts(reader)
    manifest = decode_json(texts[MANIFEST], Manifest)
    views = decode_json(texts[VIEWS], Views)
    models = _listed(texts[MODELS], ModelEntry, reader)
    headers = [entry.header for entry in models]
    frozen = _listed(texts[FROZEN], FrozenEntry, reader)
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
    header: ModelHeader, models: Sequence[ModelHeader], frozen: Sequence[FrozenEntry]
) -> dict[str, list[str]]:
    """Return the names of what an object follows, and of what it keeps frozen; nothing if none."""
    kept = {entry.header.id: entry.header.name for entry in frozen if entry.within == (header.id,)}
    names = {model.id: model.name for model in models}
    followed = [names.get(s, s) for s in header.sources if s not in kept]
    links = {"follows": followed, "frozen": list(kept.values())}
    return {word: row for word, row in links.items() if row}


def core_texts(reader: ContainerReader) -> tuple[dict[str, bytes], int]:
    """Return the JSON of the core in today's shape, and the version it was written in."""
    promise = decode_json(reader.json(MANIFEST), Promise)
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


def _listed(text: bytes, kind: type[Entry], reader: ContainerReader) -> list[Entry]:
    """Return the rows of a list of objects; each needs a part of the file for its state."""
    if row_count(text) > len(reader):
        raise DocumentError("This document lists more objects than it holds.")
    return decode_json(text, list[kind])  # type: ignore[valid-type]


def _models(
    entries: Sequence[ModelEntry],
    strokes: Sequence[Stroke],
    frozen: Sequence[FrozenEntry],
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
    entries: Sequence[ModelEntry],
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
