"""Links between models: what follows what, and sources frozen inside their followers.

A model names its sources by their ids. Each is either *followed*, a model of the same document,
or *frozen*: a recipe of its own inside the follower, placed in the follower's frame, with all
that it is made from frozen in it in turn. A frozen source is a recipe as any other model is, so
that a document still holds no mesh, and no solve is needed to freeze one.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

from bozzetto.document.model import LONGEST_CHAIN, Document, Model
from bozzetto.errors import UserError


def followers(document: Document, model_id: str) -> tuple[Model, ...]:
    """Return the models that follow one, in the order of the document."""
    return tuple(model for model in document if model_id in model.followed)


def in_order(models: Iterable[Model]) -> Iterator[Model]:
    """Yield models, each behind those that it follows; all others are left out.

    Left out are models that follow themselves through others, and those at the end of a chain
    longer than `LONGEST_CHAIN`. A source that is not among the models delays nobody.
    """
    waiting = list(models)
    there = {model.id for model in waiting}
    done: set[str] = set()
    for _ in range(LONGEST_CHAIN + 1):
        ready = [m for m in waiting if all(s in done or s not in there for s in m.followed)]
        if not ready:
            return
        yield from ready
        done.update(model.id for model in ready)
        waiting = [model for model in waiting if model.id not in done]


class LinkedModels:
    """Models of a document with what they follow in them, ready to be solved.

    As long as neither a model nor anything that it is made from has changed, it stays the very
    same object. One thread at a time.
    """

    def __init__(self) -> None:
        self._known: dict[str, tuple[Model, tuple[Model, ...], Model]] = {}

    def forget(self) -> None:
        """Forget all models."""
        self._known.clear()

    def resolved(self, document: Document) -> dict[str, Model]:
        """Return all models by their ids, with `Model.linked`.

        A source that is not there, or that cannot be put in an order, is missing in `linked`.
        """
        models = {model.id: model for model in document}
        if not any(model.followed for model in models.values()):
            self._known.clear()
            return models
        made: dict[str, Model] = {}
        known, self._known = self._known, {}
        for model in in_order(document):
            found = made[model.id] = self._linked(model, made, known.get(model.id))
            if found is not model:
                sources = tuple(made[source] for source in model.followed if source in made)
                self._known[model.id] = (model, sources, found)
        return models | made

    @staticmethod
    def _linked(
        model: Model,
        made: Mapping[str, Model],
        known: tuple[Model, tuple[Model, ...], Model] | None,
    ) -> Model:
        sources = tuple(made[source] for source in model.followed if source in made)
        if not sources:
            return model
        if known is not None and known[0] is model and _are(known[1], sources):
            return known[2]
        linked = []
        for source in sources:
            with suppress(UserError):  # they lie further apart than numbers reach
                linked.append(_seen_from(model, source))
        return replace(model, linked=tuple(linked))


def resolved(document: Document) -> dict[str, Model]:
    """Return all models of a document by their ids, with what they follow in `Model.linked`."""
    return LinkedModels().resolved(document)


def with_sources_added(document: Document, model: Model) -> Document:
    """Return a document with what a new model follows and brings along; see `Model.linked`.

    A source that is there stays as it is.
    """
    there = {other.id for other in document}
    for source in model.linked:
        if source.id not in there:
            named = replace(source, name=document.unused_name(source.name))
            document = with_sources_added(document, source).with_model(named)
    return document


def with_frozen(document: Document, model: Model, sources: Collection[str]) -> Model:
    """Return a model that follows some of its sources no longer and keeps them, as they are now.

    One that cannot be had, because it is not in the document, stays as it is.
    """
    found = resolved(document).get(model.id, model)
    kept = tuple(_frozen(source) for source in found.linked if source.id in sources)
    return replace(model, frozen=model.frozen + kept)


def without_sources(document: Document, model_ids: Collection[str]) -> Document:
    """Return a document in which nothing follows some models any more, but what they follow."""
    going = set(model_ids)
    for model in tuple(document):
        if model.id not in going and going.intersection(model.followed):
            document = document.with_model(with_frozen(document, model, going))
    return document


def is_same_recipe(one: Model, other: Model) -> bool:
    """Whether two models have the very same states, also in all that they are made from.

    Then they have the same result; names, colours and their own placements do not matter.
    """
    if one is other:
        return True
    if one.state is not other.state or one.sources != other.sources:
        return False
    return _same_row(one.frozen, other.frozen) and _same_row(one.linked, other.linked)


def _same_row(one: tuple[Model, ...], other: tuple[Model, ...]) -> bool:
    return len(one) == len(other) and all(
        a.id == b.id and a.placement == b.placement and is_same_recipe(a, b)
        for a, b in zip(one, other, strict=True)
    )


def _are(one: tuple[Model, ...], other: tuple[Model, ...]) -> bool:
    return len(one) == len(other) and all(a is b for a, b in zip(one, other, strict=True))


def _seen_from(follower: Model, source: Model) -> Model:
    """Return a source, placed in the frame of its follower."""
    if follower.placement.is_identity:
        return source
    return replace(source, placement=follower.placement.inverse().after(source.placement))


def _frozen(source: Model) -> Model:
    """Return a source with all that it follows frozen in it."""
    if not source.linked:
        return source
    return replace(source, frozen=source.frozen + tuple(map(_frozen, source.linked)), linked=())
