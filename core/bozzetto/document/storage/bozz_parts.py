"""The parts of a ``.bozz`` file: their names, and the records that the core keeps in them."""

from __future__ import annotations

from typing import Annotated, Final

import msgspec
from msgspec import Meta

from bozzetto.document.model import NamedView
from bozzetto.document.storage.migrations import FROZEN, WAITING
from bozzetto.document.storage.records import Id, ModelHeader, UnderlayHeader
from bozzetto.document.storage.zip_container import Part
from bozzetto.view.camera import Camera

MIMETYPE: Final = b"application/vnd.bozzetto.document"
FORMAT: Final = "bozzetto.document"
MIN_READER: Final = 1
"""The oldest version of this program that may show what is written here."""

MANIFEST, MODELS, VIEWS = "manifest.json", "core/models.json", "core/views.json"
STROKES, STROKE_COLUMNS = "core/strokes.meta.json", "core/strokes/"
WAITING_STROKES, WAITING_COLUMNS = "core/waiting/strokes.meta.json", "core/waiting/"
FROZEN_STROKES, FROZEN_COLUMNS = "core/frozen/strokes.meta.json", "core/frozen/"
CORE: Final = (MANIFEST, MODELS, VIEWS, STROKES, WAITING, FROZEN)
OWN: Final = {"mimetype", *CORE, "thumbnail.png"}


class Manifest(msgspec.Struct):
    """Description of the file, with the kind and shape of its arrays."""

    format: str
    version: Annotated[int, Meta(ge=1)]
    min_reader: Annotated[int, Meta(ge=1)]
    generator: str
    units: str
    up: str
    requires: list[str]
    parts: list[Part]


class Promise(msgspec.Struct):
    """The part of a manifest that every version has in common."""

    format: str
    version: Annotated[int, Meta(ge=1)]
    min_reader: Annotated[int, Meta(ge=1)] = 1
    generator: str = "another program"


class ModelEntry(msgspec.Struct):
    """An object: its header, its first stroke and their number, and its arrays by name."""

    header: ModelHeader
    strokes: tuple[int, int]
    arrays: list[str]

    @property
    def folder(self) -> str:
        """Where its state lies in the file."""
        return self.header.folder


class FrozenEntry(ModelEntry):
    """A source that a model keeps; `within` leads to what it is frozen in, from a model on."""

    within: Annotated[tuple[Id, ...], Meta(min_length=1)]

    @property
    def folder(self) -> str:
        """Where its state lies in the file."""
        return "/".join(("frozen", *self.within, self.header.id))


class Views(msgspec.Struct):
    """The last camera, the named views and the underlays."""

    camera: Camera | None
    views: list[NamedView]
    underlays: list[UnderlayHeader]


def png_name(underlay_id: str) -> str:
    """Return the name of the part that holds the picture of an underlay."""
    return f"core/underlays/{underlay_id}.png"
