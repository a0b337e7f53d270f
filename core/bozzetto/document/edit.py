"""Edits of the objects, views and underlays of a document.

Every function takes a document and gives an `Edit`: the new document, and the label under
which the history keeps it. None of them changes anything; a locked object refuses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from bozzetto.document.links import with_frozen, with_sources_added, without_sources
from bozzetto.document.model import Document, Model, NamedView, Underlay, new_id
from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera

Color = tuple[int, int, int]

Vector = tuple[float, float, float]

IN_PLACE: Final[Vector] = (0.0, 0.0, 0.0)


class Edit(NamedTuple):
    """A new document, and what was done."""

    document: Document
    label: str


# -- objects --------------------------------------------------------------------------------------


def add_model(document: Document, model: Model, *, at: int | None = None) -> Edit:
    """Add an object, under a name that no other has, and what it follows and brings along."""
    document = with_sources_added(document, model)
    named = replace(model, name=document.unused_name(model.name))
    return Edit(document.with_model(named, at=at), f"Add “{named.name}”")


def change_state(
    document: Document, model_id: str, state: Any, label: str, sources: tuple[str, ...] = ()
) -> Edit:
    """Give an object a new state, and the sources that its modeler says this has.

    Raises
    ------
    UserError
        If it is locked or gone; so do all functions below that change an object.
    """
    model = _unlocked(document, model_id)
    return Edit(document.with_model(model.with_state(state, sources)), label)


def rename_model(document: Document, model_id: str, name: str) -> Edit:
    """Call an object something else."""
    model = _unlocked(document, model_id)
    renamed = replace(model, name=name.strip())
    return Edit(document.with_model(renamed), f"Rename to “{renamed.name}”")


def show_model(document: Document, model_id: str, visible: bool) -> Edit:
    """Show or hide an object; locked ones too."""
    model = document.model(model_id)
    word = "Show" if visible else "Hide"
    return Edit(document.with_model(replace(model, visible=visible)), f"{word} “{model.name}”")


def lock_model(document: Document, model_id: str, locked: bool) -> Edit:
    """Lock an object against changes, or unlock it."""
    model = document.model(model_id)
    word = "Lock" if locked else "Unlock"
    return Edit(document.with_model(replace(model, locked=locked)), f"{word} “{model.name}”")


def color_model(document: Document, model_id: str, color: Color | None) -> Edit:
    """Give an object a colour, or the theme's clay."""
    model = _unlocked(document, model_id)
    return Edit(document.with_model(replace(model, color=color)), f"Colour “{model.name}”")


def place_model(document: Document, model_id: str, placement: Placement) -> Edit:
    """Put an object somewhere else."""
    model = _unlocked(document, model_id)
    return Edit(document.with_model(replace(model, placement=placement)), f"Move “{model.name}”")


def delete_models(document: Document, model_ids: Iterable[str]) -> Edit:
    """Take objects out; those that follow them keep them frozen, as they are now."""
    models = [_unlocked(document, model_id) for model_id in model_ids]
    if not models:
        raise UserError("Choose an object to delete.")
    document = without_sources(document, [model.id for model in models])
    for model in models:
        document = document.without_model(model.id)
    return Edit(document, f"Delete {_named(models)}")


def duplicate_model(document: Document, model_id: str) -> Edit:
    """Put a copy behind an object; it follows what the object follows. See `duplicate_models`."""
    return duplicate_models(document, [model_id], lambda model, _: model)


def duplicate_models(
    document: Document,
    model_ids: Iterable[str],
    with_sources: Callable[[Model, tuple[str, ...]], Model],
    step: Vector = IN_PLACE,
) -> Edit:
    """Put copies behind objects in the list; they are visible and unlocked, and lie beside them.

    A copy follows the copies of what its original follows, and what was not copied with it.

    Parameters
    ----------
    document : Document
        The document.
    model_ids : iterable of str
        The objects to copy, at least one.
    with_sources : callable
        Gives a model the sources of these ids instead, in their order; only called where they
        differ.
    step : (x, y, z)
        How far copies lie from what they would lie on, mm.
    """
    models = [document.model(model_id) for model_id in model_ids]
    if not models:
        raise UserError("Choose an object to duplicate.")
    copies = _copies(_beside(document, models, step), with_sources)
    for model, copy in zip(models, copies, strict=True):
        named = replace(copy, name=document.unused_name(copy.name))
        document = document.with_model(named, at=document.place_of(model.id) + 1)
    return Edit(document, f"Duplicate {_named(models)}")


def _copies(
    models: Sequence[Model], with_sources: Callable[[Model, tuple[str, ...]], Model]
) -> Iterator[Model]:
    """Yield models with ids of their own, visible and unlocked; copies follow copies."""
    copies = {model.id: new_id() for model in models}
    for model in models:
        frozen = {source.id for source in model.frozen}
        sources = tuple(
            source if source in frozen else copies.get(source, source) for source in model.sources
        )
        changed = model if sources == model.sources else with_sources(model, sources)
        yield replace(changed, id=copies[model.id], visible=True, locked=False)


def _beside(document: Document, models: Sequence[Model], step: Vector) -> Sequence[Model]:
    """Return models moved by the fewest steps that keep all from lying on their like."""
    if not any(step):
        return models
    there = {(id(model.state), model.placement) for model in document}
    moved = models
    for _ in there:
        if not any((id(model.state), model.placement) in there for model in moved):
            break
        moved = [
            replace(model, placement=Placement(offset=step).after(model.placement))
            for model in moved
        ]
    return moved


def copied_models(document: Document, model_ids: Iterable[str]) -> Document:
    """Return a document of some objects alone, as a clipboard holds them.

    What they follow and is not copied with them they keep frozen, as it is now.
    """
    wanted = {document.model(model_id).id for model_id in model_ids}
    if not wanted:
        raise UserError("Choose an object to copy.")
    alone = without_sources(document, [model.id for model in document if model.id not in wanted])
    return Document([model for model in alone if model.id in wanted])


def paste_models(
    document: Document,
    copied: Document,
    with_sources: Callable[[Model, tuple[str, ...]], Model],
    step: Vector = IN_PLACE,
) -> Edit:
    """Put copies of all objects of another document behind those that there are.

    They come where they stood, or beside what they would lie on.

    Parameters
    ----------
    document, copied : Document
        Where they go, and what `copied_models` gave, of this document or of another one.
    with_sources, step
        See `duplicate_models`.
    """
    models = tuple(copied)
    for copy in _copies(_beside(document, models, step), with_sources):
        document = document.with_model(replace(copy, name=document.unused_name(copy.name)))
    return Edit(document, f"Paste {_named(models)}")


# -- links ----------------------------------------------------------------------------------------


def unlink_model(document: Document, model_id: str) -> Edit:
    """Let an object follow nothing any more: its sources stay frozen in it, as they are now."""
    model = _unlocked(document, model_id)
    if not model.followed:
        raise UserError(f"“{model.name}” follows no other object.")
    kept = with_frozen(document, model, model.followed)
    if kept.followed:
        raise UserError(
            f"What “{model.name}” follows is not in this document, so it cannot be kept."
        )
    return Edit(document.with_model(kept), f"Unlink “{model.name}”")


def link_model(document: Document, model_id: str) -> Edit:
    """Let an object follow again what it was unlinked from, as far as that is still there."""
    model = _unlocked(document, model_id)
    there = {other.id for other in document}
    frozen = tuple(source for source in model.frozen if source.id not in there)
    if len(frozen) == len(model.frozen):
        raise UserError(f"What “{model.name}” followed is no longer in the document.")
    return Edit(document.with_model(replace(model, frozen=frozen)), f"Link “{model.name}” again")


# -- order ----------------------------------------------------------------------------------------


def move_model(document: Document, model_id: str, at: int) -> Edit:
    """Give an object another place in the list, counted from 0 without it; locked ones too."""
    model = document.model(model_id)
    return Edit(document.with_model(model, at=at), f"Reorder “{model.name}”")


def _named(models: Sequence[Model]) -> str:
    return f"“{models[0].name}”" if len(models) == 1 else f"{len(models)} objects"


def _unlocked(document: Document, model_id: str) -> Model:
    model = document.model(model_id)
    if model.locked:
        raise UserError(f"“{model.name}” is locked. Unlock it in the object list to change it.")
    return model


# -- views ----------------------------------------------------------------------------------------


def add_view(document: Document, name: str, camera: Camera) -> Edit:
    """Keep a camera under a name; one of that name is replaced."""
    views = tuple(view for view in document.views if view.name != name.strip())
    view = NamedView(name.strip(), camera)
    return Edit(replace(document, views=(*views, view)), f"Keep view “{view.name}”")


def delete_view(document: Document, name: str) -> Edit:
    """Forget a view."""
    place = _view_place(document, name)
    views = document.views[:place] + document.views[place + 1 :]
    return Edit(replace(document, views=views), f"Delete view “{name}”")


def _view_place(document: Document, name: str) -> int:
    for place, view in enumerate(document.views):
        if view.name == name:
            return place
    raise UserError(f"There is no view “{name}” any more.")


# -- underlays ------------------------------------------------------------------------------------


def add_underlay(document: Document, underlay: Underlay) -> Edit:
    """Put a picture under the sheet."""
    underlays = (*document.underlays, underlay)
    return Edit(replace(document, underlays=underlays), f"Add underlay “{underlay.name}”")


def change_underlay(document: Document, underlay: Underlay) -> Edit:
    """Exchange an underlay for one of the same id: moved, renamed, fainter, hidden."""
    place = _underlay_place(document, underlay.id)
    underlays = (*document.underlays[:place], underlay, *document.underlays[place + 1 :])
    return Edit(replace(document, underlays=underlays), f"Change underlay “{underlay.name}”")


def delete_underlay(document: Document, underlay_id: str) -> Edit:
    """Take a picture away."""
    place = _underlay_place(document, underlay_id)
    underlays = document.underlays[:place] + document.underlays[place + 1 :]
    name = document.underlays[place].name
    return Edit(replace(document, underlays=underlays), f"Delete underlay “{name}”")


def _underlay_place(document: Document, underlay_id: str) -> int:
    for place, underlay in enumerate(document.underlays):
        if underlay.id == underlay_id:
            return place
    raise UserError("That underlay is no longer in the document.")
