"""Rows of the object list: pure functions over the document."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple

from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Model
    from bozzetto.plugin.part_tree import PartTree

__all__ = ["Entry", "entries_of", "link_words", "place_of_drop"]


class Entry(NamedTuple):
    """One row.

    Attributes
    ----------
    kind : {"model", "part", "heading", "underlay"}
    id : str
        Of what it stands for; "" of a heading.
    model : str
        Id of the model that a part is in; else "".
    """

    kind: Literal["model", "part", "heading", "underlay"]
    id: str = ""
    model: str = ""


def entries_of(
    document: Document,
    parts_of: Callable[[Model], PartTree | None],
    is_open: Callable[[str], bool],
    folded_groups: Collection[tuple[str, str]],
) -> Iterator[Entry]:
    """All rows, in order.

    Parameters
    ----------
    document : Document
        The objects and underlays to list.
    parts_of : callable
        Gives the parts of a model.
    is_open : callable
        Whether the parts of a model are listed, by its id.
    folded_groups : collection of (model id, part id)
        Groups whose parts are not listed.
    """
    for model in document:
        yield Entry("model", model.id)
        tree = parts_of(model) if is_open(model.id) else None
        deepest = None
        for part, depth in () if tree is None else tree.rows():
            if deepest is not None and depth > deepest:
                continue
            yield Entry("part", part.id, model.id)
            deepest = depth if (model.id, part.id) in folded_groups else None
    if document.underlays:
        yield Entry("heading")
        for underlay in document.underlays:
            yield Entry("underlay", underlay.id)


def link_words(model: Model, document: Document) -> str:
    """Return what a model is made from, in words; "" if it is made from no other."""
    if not (model.followed or model.frozen):
        return ""
    names = {other.id: other.name for other in document}
    lost = tr("Objects", "what is not here")
    followed = [f"“{names[s]}”" if s in names else lost for s in model.followed]
    frozen = [f"“{source.name}”" for source in model.frozen]
    words = []
    if followed:
        words.append(tr("Objects", "follows {names}", names=", ".join(followed)))
    if frozen:
        words.append(tr("Objects", "keeps {names} as it was", names=", ".join(frozen)))
    return "; ".join(words)


def place_of_drop(
    entries: Sequence[Entry], tree: PartTree, source: int, target: int, on: bool
) -> tuple[str, int] | None:
    """Where a part goes that is let go in the list.

    Parameters
    ----------
    entries : sequence of Entry
        What is listed.
    tree : PartTree
        Of the model that the part is in.
    source : int
        The row of the part.
    target : int
        The row above whose upper edge, or on which, it was let go.
    on : bool
        Which of the two.

    Returns
    -------
    (group, place) or None
        For `PartTree.moved`; None where nothing is to be moved.
    """
    part = entries[source]
    after = entries[target] if target < len(entries) else Entry("heading")
    before = entries[target - 1] if target > 0 else Entry("heading")
    if on:
        if after == Entry("model", part.model):
            return "", len(tree.parts)
        inside = after.model == part.model and after.id in tree.groups and after.id != part.id
        return (after.id, len(tree.parts)) if inside else None
    if after.kind == "part" and after.model == part.model:
        group, neighbour, behind = tree.part(after.id).within, after.id, 0
    elif before.kind == "part" and before.model == part.model:
        group, neighbour, behind = tree.part(before.id).within, before.id, 1
    else:
        return None
    row = [other.id for other in tree.within(group)]
    place = row.index(neighbour) + behind
    if part.id in row:
        place -= row.index(part.id) < place
        if place == row.index(part.id):
            return None
    return group, place
