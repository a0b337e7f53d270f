"""A document as the parts of a ``.bozz`` file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from bozzetto import __version__
from bozzetto.document.storage.bozz_parts import (
    FORMAT,
    FROZEN_COLUMNS,
    FROZEN_STROKES,
    MANIFEST,
    MIMETYPE,
    MIN_READER,
    MODELS,
    STROKE_COLUMNS,
    STROKES,
    VIEWS,
    WAITING_COLUMNS,
    WAITING_STROKES,
    FrozenEntry,
    Manifest,
    ModelEntry,
    Views,
    png_name,
)
from bozzetto.document.storage.migrations import FROZEN, VERSION, WAITING
from bozzetto.document.storage.records import store_model, store_underlay, store_waiting
from bozzetto.document.storage.stroke_columns import pack_strokes
from bozzetto.document.storage.underlays import encode_png
from bozzetto.document.storage.zip_container import ContainerWriter
from bozzetto.document.waiting_ink import strokes_of

if TYPE_CHECKING:
    from bozzetto.document.model import Document
    from bozzetto.document.storage.state_codec import EncodedState
    from bozzetto.ink.stroke import Stroke


def packed(document: Document, thumbnail: bytes | None) -> ContainerWriter:
    """Return the container of a document, with a PNG that file managers may show."""
    writer = ContainerWriter(first=("mimetype", MANIFEST))
    writer.add("mimetype", MIMETYPE)
    models: list[ModelEntry] = []
    frozen: list[FrozenEntry] = []
    strokes: list[Stroke] = []
    frozen_strokes: list[Stroke] = []
    for model in document:
        for path, stored in store_model(model).with_paths():
            within, row = path[:-1], frozen_strokes if path[:-1] else strokes
            span = (len(row), len(stored.encoded.strokes))
            row += stored.encoded.strokes
            if within:
                frozen.append(FrozenEntry(stored.header, span, [], within))
                _put_state(writer, frozen[-1], stored.encoded)
            else:
                models.append(ModelEntry(stored.header, span, []))
                _put_state(writer, models[-1], stored.encoded)
    writer.add_json(MODELS, models)
    writer.add_json(FROZEN, frozen)
    if frozen_strokes:
        put_strokes(writer, frozen_strokes, FROZEN_STROKES, FROZEN_COLUMNS)
    for underlay in document.underlays:
        writer.add(png_name(underlay.id), encode_png(underlay.pixels))
    headers = [store_underlay(underlay) for underlay in document.underlays]
    writer.add_json(VIEWS, Views(document.camera, list(document.views), headers))
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
    manifest = Manifest(
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


def _put_state(writer: ContainerWriter, entry: ModelEntry, encoded: EncodedState) -> None:
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
