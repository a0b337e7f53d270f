"""The document: an immutable snapshot of models, views and underlays."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, replace
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.chunked import Chunked
from bozzetto.document.waiting_ink import Waiting
from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement
from bozzetto.images.png import MAX_PIXELS
from bozzetto.ink.stroke import Stroke
from bozzetto.view.camera import Camera

ID_PATTERN: Final = r"^[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}\Z"
"""Ids of models, modelers and underlays: they become folders in the file."""

NAME_PATTERN: Final = r"^[^\x00-\x1f\x7f\ud800-\udfff]{1,200}\Z"
"""Names of models, views and underlays: no control characters, no halves of characters."""

LONGEST_STEM: Final = 180
"""Characters of a name to which a number is added: names have up to 200."""

LONGEST_CHAIN: Final = 64
"""Models of which each follows the next: more are refused, and not solved."""

STANDING: Final = Placement()
"""Placement of a model that nobody has moved."""


def new_id() -> str:
    """Return a fresh identifier for a model or an underlay."""
    return os.urandom(8).hex()


def _check_id(text: str) -> None:
    if re.match(ID_PATTERN, text) is None:
        raise ValueError(f"{text!r} cannot be an id in a document")


def check_name(text: str) -> None:
    """Raise `UserError` if an object, a part, a view or an underlay cannot be called that."""
    if re.match(NAME_PATTERN, text) is None:
        raise UserError("A name has between 1 and 200 characters, without line breaks.")


def numbered_name(wish: str, taken: Set[str]) -> str:
    """Return a name with the least number from 2 on that is not taken.

    The number that a copy of a copy ends in gives way; a longer one, of a year or a type, stays.
    """
    stem = re.sub(r" \d{1,2}$", "", wish)[:LONGEST_STEM]
    return next(name for k in range(2, len(taken) + 3) if (name := f"{stem} {k}") not in taken)


@dataclass(frozen=True, eq=False)
class OpaqueState:
    """The state of a model whose modeler is absent: kept as it was stored.

    Parameters
    ----------
    version : int
        The modeler's ``state_version`` when it was stored.
    json, strokes, arrays
        As in `state_codec.EncodedState`; never looked into.
    """

    version: int
    json: bytes
    strokes: Sequence[Stroke] = ()
    arrays: tuple[NDArray[Any], ...] = ()


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
    state_version : int
        The modeler's ``state_version`` at the time; written beside the state, so that a
        later version knows what to upgrade.
    color : (r, g, b), optional
        None is the theme's clay.
    sources : tuple of str
        Ids of the models that this one is made from, as its modeler says of the state; kept
        beside it for the time when the modeler is absent.
    frozen : tuple of Model
        Those of the sources that are followed no longer, as they were last, placed in this
        model's own frame.
    linked : tuple of Model
        Those that are followed, in the same way: given for a solve (`links.resolved`), empty
        in a document.
    """

    id: str
    name: str
    modeler: str
    state: Any
    placement: Placement = STANDING
    visible: bool = True
    locked: bool = False
    color: tuple[int, int, int] | None = None
    state_version: int = 1
    sources: tuple[str, ...] = ()
    frozen: tuple[Model, ...] = ()
    linked: tuple[Model, ...] = ()

    def __post_init__(self) -> None:
        for name in (self.id, self.modeler, *self.sources):
            _check_id(name)
        check_name(self.name)
        if self.color is not None and not all(0 <= part <= 255 for part in self.color):
            raise ValueError(f"{self.color} is no colour")
        ids = [model.id for model in self.frozen]
        if ids and (len(set(ids)) < len(ids) or not set(ids) <= set(self.sources)):
            raise ValueError("what a model keeps frozen are sources of it, each once")

    @property
    def followed(self) -> tuple[str, ...]:
        """Ids of the sources that are not frozen."""
        if not self.frozen:
            return self.sources
        frozen = {model.id for model in self.frozen}
        return tuple(source for source in self.sources if source not in frozen)

    def with_state(self, state: Any, sources: tuple[str, ...]) -> Model:
        """Return the model with another state, and what its modeler says that it is made from."""
        if sources == self.sources:
            return replace(self, state=state)
        frozen = tuple(model for model in self.frozen if model.id in sources)
        return replace(self, state=state, sources=sources, frozen=frozen, linked=())


@dataclass(frozen=True)
class NamedView:
    """A camera worth keeping."""

    name: str
    camera: Camera

    def __post_init__(self) -> None:
        check_name(self.name)


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
        _check_id(self.id)
        check_name(self.name)
        object.__setattr__(self, "pixels", frozen(self.pixels, np.uint8))
        if self.pixels.ndim != 3 or self.pixels.shape[2] != 4 or not self.pixels.size:
            raise ValueError(
                f"an underlay's pixels are of shape (h, w, 4), not {self.pixels.shape}"
            )
        if self.pixels.shape[0] * self.pixels.shape[1] > MAX_PIXELS:
            raise UserError(f"“{self.name}” is too large an underlay. Make the picture smaller.")
        place = (*self.corner, *self.across, *self.down)
        if not np.isfinite(place).all() or not 0.0 <= self.opacity <= 1.0:
            raise ValueError("an underlay needs finite corners and an opacity from 0 to 1")


@dataclass(frozen=True, eq=False)
class Document:
    """A snapshot. Every method returns a new one that shares what did not change.

    Parameters
    ----------
    models : sequence of Model
        In the order of the object list; kept as `Chunked`, so that a change to one of a
        thousand models does not copy a thousand pointers.
    views : tuple of NamedView
    underlays : tuple of Underlay
    camera : Camera, optional
        Where the person last looked from.
    foreign : tuple of (str, bytes)
        Parts of the file that belong to nobody we know; written back byte for byte.
    waiting : tuple of WaitingStroke
        Ink that no modeler has taken yet, in the order drawn; no part of any shape.
    """

    models: Sequence[Model] = ()
    views: tuple[NamedView, ...] = ()
    underlays: tuple[Underlay, ...] = ()
    camera: Camera | None = None
    foreign: tuple[tuple[str, bytes], ...] = ()
    waiting: Waiting = ()

    def __post_init__(self) -> None:
        if not isinstance(self.models, Chunked):
            object.__setattr__(self, "models", Chunked(self.models))

    @property
    def _models(self) -> Chunked[Model]:
        return cast("Chunked[Model]", self.models)

    def __iter__(self) -> Iterator[Model]:
        return iter(self.models)

    def __len__(self) -> int:
        return len(self.models)

    def place_of(self, model_id: str) -> int:
        """Return the place of a model in the object list.

        Raises
        ------
        UserError
            If there is none of that id.
        """
        for place, model in enumerate(self.models):
            if model.id == model_id:
                return place
        raise UserError("That object is no longer in the document. Choose another one.")

    def model(self, model_id: str) -> Model:
        """Return the model of that id.

        Raises
        ------
        UserError
            If there is none.
        """
        return self.models[self.place_of(model_id)]

    def with_model(self, model: Model, *, at: int | None = None) -> Document:
        """Add a model, or exchange the one of the same id (keeping its place).

        What was given to it for a solve (`Model.linked`) stays behind.

        Raises
        ------
        UserError
            If it would follow itself.
        """
        self.refuse_circle(model)
        if model.linked:
            model = replace(model, linked=())
        models = self._models
        known = next((i for i, old in enumerate(models) if old.id == model.id), None)
        if known is not None and at is None:
            return replace(self, models=models.replaced(known, model))
        if known is not None:
            models = models.without(known)
        place = len(models) if at is None else max(0, min(at, len(models)))
        return replace(self, models=models.inserted(place, model))

    def refuse_circle(self, model: Model) -> None:
        """Raise `UserError` if a model of this document would follow itself, or too many others."""
        if not model.followed:
            return
        before = next((other for other in self.models if other.id == model.id), None)
        if before is not None and before.followed == model.followed:
            return
        known = {other.id: other for other in self.models if other.followed}
        known[model.id] = model
        level, seen = [model], {model.id}
        for _ in range(LONGEST_CHAIN):
            ids = {source for follower in level for source in follower.followed}
            if model.id in model.followed:
                raise UserError(f"“{model.name}” cannot follow itself. Choose another object.")
            if model.id in ids:
                raise UserError(
                    f"“{model.name}” cannot follow what itself follows “{model.name}”. Choose "
                    "another object, or unlink that one first."
                )
            level = [known[source] for source in ids - seen if source in known]
            seen |= ids
            if not level:
                return
        raise UserError(
            f"More than {LONGEST_CHAIN} objects would follow one another. Unlink one of them."
        )

    def without_model(self, model_id: str) -> Document:
        """Return the document without a model."""
        return replace(self, models=self._models.without(self.place_of(model_id)))

    def with_waiting(self, waiting: Waiting) -> Document:
        """Exchange the ink that waits; the same document where it is the same ink."""
        return self if waiting is self.waiting else replace(self, waiting=waiting)

    def unused_name(self, wish: str) -> str:
        """Return `wish`, or with a number behind it where the name is taken."""
        taken = {model.name for model in self.models}
        return wish if wish not in taken else numbered_name(wish, taken)
