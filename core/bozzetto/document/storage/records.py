"""Models and underlays between document and file: what is written of them as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import asdict
from numpy.typing import NDArray

from bozzetto.document.model import (
    ID_PATTERN,
    LONGEST_CHAIN,
    NAME_PATTERN,
    Model,
    OpaqueState,
    Underlay,
)
from bozzetto.document.storage.state_codec import (
    EncodedState,
    StateTypes,
    decode_state,
    encode_state,
)
from bozzetto.document.waiting_ink import Waiting, WaitingStatus, WaitingStroke
from bozzetto.errors import DocumentError
from bozzetto.geometry.placement import Placement

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke

Id = Annotated[str, Meta(pattern=ID_PATTERN)]

Name = Annotated[str, Meta(pattern=NAME_PATTERN)]
Byte = Annotated[int, Meta(ge=0, le=255)]
Point = tuple[float, float, float]


class ModelHeader(msgspec.Struct, frozen=True):
    """All of a model but its state."""

    id: Id
    name: Name
    modeler: Id
    state_version: Annotated[int, Meta(ge=0)]
    placement: Placement
    visible: bool
    locked: bool
    color: tuple[Byte, Byte, Byte] | None
    sources: tuple[Id, ...] = ()

    @property
    def folder(self) -> str:
        """Folder of the state in the file."""
        return f"plugins/{self.modeler}/{self.id}"


class UnderlayHeader(msgspec.Struct, frozen=True):
    """All of an underlay but its pixels."""

    id: Id
    name: Name
    corner: Point
    across: Point
    down: Point
    opacity: Annotated[float, Meta(ge=0.0, le=1.0)]
    visible: bool

    def with_pixels(self, pixels: NDArray[np.uint8]) -> Underlay:
        """Return the underlay; raises `DocumentError` where the array holds no pixels."""
        if pixels.dtype != np.uint8 or pixels.shape[2:] != (4,) or not pixels.size:
            raise DocumentError(f"The underlay “{self.name}” has no picture.")
        return Underlay(pixels=pixels, **asdict(self))


class WaitingHeader(msgspec.Struct, frozen=True):
    """All of a waiting stroke but the stroke."""

    modeler: str
    tool: str
    status: WaitingStatus
    reason: str
    places: list[tuple[float, float]]

    def with_stroke(self, stroke: Stroke) -> WaitingStroke:
        """Return the waiting stroke."""
        return WaitingStroke(
            stroke, self.modeler, self.tool, self.status, self.reason, tuple(self.places)
        )


@dataclass(frozen=True)
class StoredModel:
    """A model as files hold it."""

    header: ModelHeader
    encoded: EncodedState
    frozen: tuple[StoredModel, ...] = ()

    def with_paths(self, above: tuple[str, ...] = ()) -> Iterator[tuple[Path, StoredModel]]:
        """Yield it and all that is frozen in it, each behind what it is frozen in."""
        path = (*above, self.header.id)
        yield path, self
        for source in self.frozen:
            yield from source.with_paths(path)


Path = tuple[str, ...]
"""The id of a model, and of the frozen sources that lead from it to one."""


def with_frozen_models(models: dict[Path, StoredModel]) -> tuple[StoredModel, ...]:
    """Put models together that were listed as `StoredModel.with_paths` gives them.

    Raises
    ------
    DocumentError
        If one is frozen in a model that is not listed before it, or too deep.
    """
    within: dict[Path, list[StoredModel]] = {(): []}
    for path, stored in reversed(models.items()):
        if not path or len(path) > LONGEST_CHAIN + 1 or (path[:-1] and path[:-1] not in models):
            raise DocumentError("This document has frozen objects that belong to no object.")
        whole = replace(stored, frozen=tuple(reversed(within.pop(path, []))))
        within.setdefault(path[:-1], []).append(whole)
    made = within.pop(())
    if within:
        raise DocumentError("This document has frozen objects in no order.")
    return tuple(reversed(made))


def store_model(model: Model) -> StoredModel:
    """Take a model apart for writing."""
    state = model.state
    version = state.version if isinstance(state, OpaqueState) else model.state_version
    header = ModelHeader(**_fields_of(model, ModelHeader) | {"state_version": version})
    return StoredModel(header, encode_state(state), tuple(map(store_model, model.frozen)))


def store_underlay(underlay: Underlay) -> UnderlayHeader:
    """Return the record of an underlay beside its pixels."""
    return UnderlayHeader(**_fields_of(underlay, UnderlayHeader))


def store_waiting(waiting: Waiting) -> list[WaitingHeader]:
    """Return the records of waiting ink beside its strokes."""
    return [
        WaitingHeader(
            _writable(one.modeler),
            _writable(one.tool),
            one.status,
            _writable(one.reason),
            list(one.places),
        )
        for one in waiting
    ]


def _fields_of(source: object, record: type[msgspec.Struct]) -> dict[str, Any]:
    """Return the fields of a record from the attributes of the same names."""
    return {name: getattr(source, name) for name in record.__struct_fields__}


def _writable(text: str) -> str:
    """Remove halves of characters: plugins may say anything, and JSON cannot hold them."""
    return text.encode("utf-8", "replace").decode()


def open_model(stored: StoredModel, states: StateTypes) -> tuple[Model, str | None]:
    """Put a model together again, and say so where its state had to stay closed.

    A modeler that is absent, older than the file, or cannot make sense of an intact state
    does not keep the rest of the document from being opened: the state stays opaque and
    is written back as it was.
    """
    opened = [open_model(source, states) for source in stored.frozen]
    warnings = [warning for _, warning in opened if warning is not None]
    model, warning = _opened(stored, states)
    frozen = tuple(source for source, _ in opened if source.id in model.sources)
    model = replace(model, frozen=frozen)
    warnings = ([] if warning is None else [warning]) + warnings
    return model, " ".join(warnings) or None


def _opened(stored: StoredModel, states: StateTypes) -> tuple[Model, str | None]:
    header = stored.header
    closed = OpaqueState(
        header.state_version, stored.encoded.json, stored.encoded.strokes, stored.encoded.arrays
    )
    model = Model(state=closed, **asdict(header))
    known = states.state_type(header.modeler)
    if known is None:
        return model, (
            f"“{header.name}” was made with the modeler {header.modeler!r}, whose plugin is not "
            "installed or switched off. It is kept as it is and cannot be changed."
        )
    state_type, version = known
    if header.state_version > version:
        return model, (
            f"“{header.name}” was made with a newer version of {header.modeler!r}. It is kept "
            "as it is; update the plugin to change it."
        )

    def upgrade(state: dict[str, Any]) -> dict[str, Any]:
        if header.state_version == version:
            return state
        return states.upgrade(header.modeler, state, header.state_version)

    try:
        state = decode_state(state_type, stored.encoded, upgrade=upgrade)
        sources = states.sources(header.modeler, state)
    except DocumentError as problem:
        return model, (
            f"“{header.name}” cannot be read by {header.modeler!r} ({problem}). It is kept as "
            "it is and cannot be changed."
        )
    return replace(model, state=state, state_version=version, sources=sources), None
