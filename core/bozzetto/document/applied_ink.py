"""Models that come of waiting ink, and their place in the history."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from bozzetto.document.waiting_ink import without

if TYPE_CHECKING:
    from bozzetto.document.history import History
    from bozzetto.document.model import Document, Model
    from bozzetto.ink.stroke import Stroke


def take(history: History, label: str, model: Model, used: Sequence[Stroke] = ()) -> None:
    """Put a model into the present document, in the place of the ink that it came of.

    Ink that is taken at the first try and what came of it are one step: that with which the
    last of the strokes was lifted, however many were lifted since.

    Parameters
    ----------
    history : History
        The history of the document; it gets the new snapshot.
    label : str
        For the menus: "Undo <label>".
    model : Model
        A new one, or another state of one that is there.
    used : sequence of Stroke
        Ink that waits, and is the model's from now on.
    """
    before = history.document
    document = before.with_model(model).with_waiting(without(before.waiting, used))
    lifted = _place_lifted(history, used)
    if lifted is None:
        history.apply(label, document, drawn=bool(used))
        return
    taken = len(set(map(id, used)))

    def completed(then: Document) -> Document:
        waiting = without(then.waiting, used)
        if then.models is not before.models or len(then.waiting) - len(waiting) < taken:
            return then
        return replace(then, models=document.models, waiting=waiting)

    history.complete(lifted, label, completed)


def _place_lifted(history: History, used: Sequence[Stroke]) -> int | None:
    """Return the step that lifted the last of some strokes, if this is its first answer.

    None as well where the shapes have changed since: the outcome is a step of its own then.
    """
    if not used:
        return None
    now, last = history.document, used[-1]

    def waits(document: Document) -> bool:
        return any(one.stroke is last for one in document.waiting)

    is_new = any(one.stroke is last and one.status == "new" for one in now.waiting)
    lifted = history.place_where(waits)
    same = history.place_where(lambda one: waits(one) and one.models is now.models)
    return lifted if is_new and lifted == same else None
