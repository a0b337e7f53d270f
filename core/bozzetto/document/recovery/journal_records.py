"""Changes of a document as journal records, and the document put together from them.

A record is a small container with what is new: strokes and arrays that no earlier record
(nor the base) held, and the models that changed, which refer to strokes and arrays by
number. Numbers count through the base in the order of its file, then through the records.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import msgspec
from numpy.typing import NDArray

from bozzetto.document.model import Document, NamedView
from bozzetto.document.storage.bozz_parts import STROKES
from bozzetto.document.storage.bozz_reader import StoredDocument, take_strokes
from bozzetto.document.storage.bozz_writer import put_strokes
from bozzetto.document.storage.records import (
    Id,
    ModelHeader,
    StoredModel,
    UnderlayHeader,
    WaitingHeader,
    store_model,
    store_underlay,
    store_waiting,
    with_frozen_models,
)
from bozzetto.document.storage.side_tables import runs
from bozzetto.document.storage.state_codec import EncodedState
from bozzetto.document.storage.zip_container import (
    ContainerReader,
    ContainerWriter,
    Part,
    decode_json,
)
from bozzetto.document.waiting_ink import Waiting, strokes_of
from bozzetto.errors import DocumentError
from bozzetto.view.camera import Camera

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke

CHANGE, PARTS = "change.json", "parts.json"
MAX_NAMED: Final = 16
"""Greatest number of times that a record may name each stroke, on average."""

Runs = list[tuple[int, int]]


class _ModelChange(msgspec.Struct):
    """A model, or a source that one keeps; `within` leads to what that is frozen in."""

    header: ModelHeader
    strokes: Runs
    arrays: list[int]
    within: tuple[Id, ...] = ()


class _Surroundings(msgspec.Struct):
    """All that is not a model; written whole when any of it changed."""

    camera: Camera | None
    views: list[NamedView]
    underlays: list[tuple[UnderlayHeader, int]]


class _WaitingInk(msgspec.Struct):
    """The document's waiting ink; written whole when any of it changed."""

    entries: list[WaitingHeader]
    strokes: Runs


class _Change(msgspec.Struct):
    time: float
    models: list[_ModelChange]
    order: list[str] | None
    surroundings: _Surroundings | None
    pending: Runs
    waiting: _WaitingInk | None = None


class _Shelf:
    """Things that have been written, by identity; `fresh` ones go into the next record."""

    def __init__(self) -> None:
        # The thing is kept beside its number, so that no other gets the same id().
        self._known: dict[int, tuple[int, Any]] = {}
        self._count = 0
        self.fresh: list[Any] = []

    def add(self, thing: object) -> int:
        number = self._count
        self._known[id(thing)] = number, thing
        self._count += 1
        return number

    def number(self, thing: object) -> int:
        known = self._known.get(id(thing))
        if known is not None:
            return known[0]
        self.fresh.append(thing)
        return self.add(thing)


class ChangeWriter:
    """Turns snapshots into records of what changed since the one before.

    Parameters
    ----------
    base : Document
        What the base file holds.
    """

    def __init__(self, base: Document) -> None:
        self._strokes, self._arrays = _Shelf(), _Shelf()
        self._document = base
        self._models = {model.id: model for model in base}
        self._pending: tuple[Stroke, ...] = ()
        for encoded in _in_file_order(map(store_model, base)):
            for stroke in encoded.strokes:
                self._strokes.add(stroke)
            for array in encoded.arrays:
                self._arrays.add(array)
        for one in base.waiting:
            self._strokes.add(one.stroke)
        for underlay in base.underlays:
            self._arrays.add(underlay.pixels)

    def record(self, document: Document, pending: Sequence[Stroke], time: float) -> bytes | None:
        """Return what to append to the journal, or None if nothing changed.

        Parameters
        ----------
        document : Document
            The present snapshot.
        pending : sequence of Stroke
            Ink that waits beside the document's own; see `Document.waiting`.
        time : float
            Seconds since 1970.
        """
        waiting = tuple(pending)
        if document is self._document and waiting == self._pending:
            return None
        writer = ContainerWriter()
        models = {model.id: model for model in document}
        changed = [model for model in models.values() if self._models.get(model.id) is not model]
        entries: list[_ModelChange] = []
        for path, stored in (pair for model in changed for pair in store_model(model).with_paths()):
            writer.add(_state_name(len(entries)), stored.encoded.json)
            strokes = runs([self._strokes.number(stroke) for stroke in stored.encoded.strokes])
            arrays = [self._arrays.number(array) for array in stored.encoded.arrays]
            entries.append(_ModelChange(stored.header, strokes, arrays, path[:-1]))
        change = _Change(
            time,
            entries,
            list(models) if list(models) != list(self._models) else None,
            self._surroundings(document),
            runs([self._strokes.number(stroke) for stroke in waiting]),
            self._waiting_ink(document),
        )
        writer.add_json(CHANGE, change)
        put_strokes(writer, self._strokes.fresh)
        for place, array in enumerate(self._arrays.fresh):
            writer.add_array(f"arrays/{place}", array)
        writer.add_json(PARTS, writer.parts)
        self._strokes.fresh, self._arrays.fresh = [], []
        self._document, self._models, self._pending = document, models, waiting
        file = io.BytesIO()
        writer.write(file)
        return file.getvalue()

    def _waiting_ink(self, document: Document) -> _WaitingInk | None:
        if document.waiting == self._document.waiting:
            return None
        numbers = [self._strokes.number(stroke) for stroke in strokes_of(document.waiting)]
        return _WaitingInk(store_waiting(document.waiting), runs(numbers))

    def _surroundings(self, document: Document) -> _Surroundings | None:
        last = self._document
        if (
            document.camera is last.camera
            and document.views is last.views
            and document.underlays is last.underlays
        ):
            return None
        underlays = [
            (store_underlay(underlay), self._arrays.number(underlay.pixels))
            for underlay in document.underlays
        ]
        return _Surroundings(document.camera, list(document.views), underlays)


class Replay:
    """A document put together from its base and the records of its journal.

    Parameters
    ----------
    base : StoredDocument

    Attributes
    ----------
    stored : StoredDocument
    pending : tuple of Stroke
        Ink that waited beside the document's own, as in journals of earlier versions.
    time : float, optional
        When the last record was made; None while there was none.
    """

    def __init__(self, base: StoredDocument) -> None:
        self.stored = base
        self.pending: tuple[Stroke, ...] = ()
        self.time: float | None = None
        states = list(_in_file_order(base.models))
        self._strokes = [s for encoded in states for s in encoded.strokes]
        self._strokes += strokes_of(base.waiting)
        self._arrays = [a for encoded in states for a in encoded.arrays]
        self._arrays += [underlay.pixels for underlay in base.underlays]

    def feed(self, record: bytes) -> None:
        """Apply the next record, whole or not at all.

        Raises
        ------
        DocumentError
            If it does not follow from those before.
        """
        reader = ContainerReader(record)
        reader.declare(decode_json(reader.json(PARTS), list[Part]))
        change = decode_json(reader.json(CHANGE), _Change)
        strokes = self._strokes + take_strokes(reader, reader.json(STROKES))
        fresh = [name for name in reader.arrays if name.startswith("arrays/")]
        arrays = self._arrays + [reader.array(name) for name in fresh]
        models = {model.header.id: model for model in self.stored.models}
        changed: dict[tuple[str, ...], StoredModel] = {}
        for place, entry in enumerate(change.models):
            encoded = EncodedState(
                reader.read(_state_name(place)),
                _named(strokes, entry.strokes),
                tuple(_one(arrays, number) for number in entry.arrays),
            )
            changed[(*entry.within, entry.header.id)] = StoredModel(entry.header, encoded)
        models |= {model.header.id: model for model in with_frozen_models(changed)}
        if change.order is not None:
            if len(set(change.order)) < len(change.order) or not set(change.order) <= set(models):
                raise DocumentError("The journal orders objects that it does not hold.")
            models = {model_id: models[model_id] for model_id in change.order}
        stored = replace(self.stored, models=tuple(models.values()))
        if change.surroundings is not None:
            around = change.surroundings
            underlays = tuple(h.with_pixels(_one(arrays, n)) for h, n in around.underlays)
            stored = replace(
                stored, camera=around.camera, views=tuple(around.views), underlays=underlays
            )
        if change.waiting is not None:
            stored = replace(stored, waiting=_waiting(strokes, change.waiting))
        self.pending = _named(strokes, change.pending)
        self.stored, self.time = stored, change.time
        self._strokes, self._arrays = strokes, arrays


def _in_file_order(models: Iterable[StoredModel]) -> Iterator[EncodedState]:
    """Yield the states of models, then of what is frozen in them: as their file numbers them."""
    found = [pair for model in models for pair in model.with_paths()]
    for is_frozen in (False, True):
        yield from (stored.encoded for path, stored in found if (len(path) > 1) is is_frozen)


def _waiting(strokes: Sequence[Stroke], ink: _WaitingInk) -> Waiting:
    named = _named(strokes, ink.strokes)
    if len(named) != len(ink.entries):
        raise DocumentError("The journal's list of waiting ink does not fit its strokes.")
    return tuple(
        entry.with_stroke(stroke) for entry, stroke in zip(ink.entries, named, strict=True)
    )


def record_time(record: bytes) -> float:
    """Return the time at which a record was made, seconds since 1970."""
    return decode_json(ContainerReader(record).json(CHANGE), _Change).time


def _state_name(place: int) -> str:
    return f"states/{place}.json"


def _one(arrays: Sequence[NDArray[Any]], number: int) -> NDArray[Any]:
    if not 0 <= number < len(arrays):
        raise DocumentError("The journal refers to an array that it does not hold.")
    return arrays[number]


def _named(strokes: Sequence[Stroke], pairs: Runs) -> tuple[Stroke, ...]:
    """Return the strokes that (first, count) pairs name."""
    total = sum(count for _, count in pairs)
    if total > MAX_NAMED * len(strokes) or any(
        first < 0 or count < 1 or first + count > len(strokes) for first, count in pairs
    ):
        raise DocumentError("The journal refers to strokes that it does not hold.")
    return tuple(s for first, count in pairs for s in strokes[first : first + count])
