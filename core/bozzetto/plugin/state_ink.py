"""Ink of a state: the strokes that a modeler's recipe holds, whatever its types are called."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.plugin.parts import Part, PartsState


def ink_of_state(state: Any) -> Strokes:
    """Return all strokes that a state holds, in the order of its fields and parts.

    Hidden parts are left out, and so are paths of erasers; a stroke that is held twice comes
    once. Cameras stay.
    """
    found: dict[int, Stroke] = {}
    ahead = [state]  # no recursion: recipes may be nested deeply
    while ahead:
        thing = ahead.pop()
        if isinstance(thing, Stroke):
            if thing.tool != "eraser":
                found.setdefault(id(thing), thing)
        else:
            ahead.extend(reversed(list(_content(thing))))
    return Strokes(found.values())


def _content(thing: Any) -> Iterator[Any]:
    """Yield what a value of a state is made of, in order."""
    if isinstance(thing, Mapping):
        yield from thing.values()
    elif isinstance(thing, Strokes | tuple | list):
        yield from thing
    elif is_dataclass(thing) and not isinstance(thing, type):
        shown = thing.shown(Part) if isinstance(thing, PartsState) else None
        for field in fields(thing):
            is_row = shown is not None and field.name == "nodes"
            yield shown if is_row else getattr(thing, field.name)
