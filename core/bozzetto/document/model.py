"""The document: an immutable snapshot of models, views and underlays."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.geometry.arrays import frozen
from bozzetto.geometry.placement import Placement
from bozzetto.view.camera import Camera

__all__ = ["Document", "Model", "NamedView", "Underlay", "new_id"]


def new_id() -> str:
    """A fresh identifier for a model or an underlay."""
    return uuid.uuid4().hex[:16]


@dataclass(frozen=True)
class Model:
    """One object in a document: the recipe, never the mesh.

    Parameters
    ----------
    id : str
    name : str
        As the person calls it.
    modeler : str
        Id of the modeler that understands `state`.
    state : object
        The modeler's frozen state, or `document.codec.OpaqueState` where the plugin is absent.
    color : (r, g, b), optional
        None is the theme's clay.
    """

    id: str
    name: str
    modeler: str
    state: Any
    placement: Placement = Placement()
    visible: bool = True
    locked: bool = False
    color: tuple[int, int, int] | None = None


@dataclass(frozen=True)
class NamedView:
    """A camera worth keeping."""

    name: str
    camera: Camera


@dataclass(frozen=True, eq=False)
class Underlay:
    """A picture under the sheet, for tracing.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA.
    corner, across, down : (x, y, z)
        Where it lies in the world, mm; see `bozzetto.scene.Image`.
    """

    id: str
    name: str
    pixels: NDArray[np.uint8]
    corner: tuple[float, float, float]
    across: tuple[float, float, float]
    down: tuple[float, float, float]
    opacity: float = 0.5
    visible: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "pixels", frozen(self.pixels, np.uint8))


@dataclass(frozen=True, eq=False)
class Document:
    """A snapshot. Every method returns a new one that shares what did not change.

    Parameters
    ----------
    models : tuple of Model
        In the order of the object list.
    views : tuple of NamedView
    underlays : tuple of Underlay
    camera : Camera, optional
        Where the person last looked from.
    foreign : dict of str to bytes
        Parts of the file that belong to nobody we know; written back byte for byte.
    """

    models: tuple[Model, ...] = ()
    views: tuple[NamedView, ...] = ()
    underlays: tuple[Underlay, ...] = ()
    camera: Camera | None = None
    foreign: tuple[tuple[str, bytes], ...] = ()

    def __iter__(self) -> Iterator[Model]:
        return iter(self.models)

    def __len__(self) -> int:
        return len(self.models)

    def model(self, model_id: str) -> Model:
        """The model of that id.

        Raises
        ------
        UserError
            If there is none.
        """
        for model in self.models:
            if model.id == model_id:
                return model
        raise UserError("That object is no longer in the document. Choose another one.")

    def with_model(self, model: Model, *, at: int | None = None) -> Document:
        """Add a model, or exchange the one of the same id (keeping its place)."""
        places = [i for i, old in enumerate(self.models) if old.id == model.id]
        if places and at is None:
            i = places[0]
            return replace(self, models=(*self.models[:i], model, *self.models[i + 1 :]))
        rest = tuple(old for old in self.models if old.id != model.id)
        place = len(rest) if at is None else max(0, min(at, len(rest)))
        return replace(self, models=(*rest[:place], model, *rest[place:]))

    def without_model(self, model_id: str) -> Document:
        """Leave a model out."""
        self.model(model_id)
        return replace(self, models=tuple(m for m in self.models if m.id != model_id))

    def unused_name(self, wish: str) -> str:
        """`wish`, with a number behind it where the name is taken."""
        taken = {model.name for model in self.models}
        if wish not in taken:
            return wish
        number = 2
        while f"{wish} {number}" in taken:
            number += 1
        return f"{wish} {number}"
