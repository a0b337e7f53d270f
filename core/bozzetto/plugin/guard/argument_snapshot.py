"""Snapshots of arguments that a plugin may not change: compared and restored after a call.

The values handed to a plugin are frozen, but Python lets anyone write past that with
``object.__setattr__``, and a drawing's `extra` is a plain dict. What was written is put
back, so the document stays as it was.
"""

from __future__ import annotations

import copy
import dataclasses
import operator
from collections.abc import Callable, Iterable
from typing import Any, Final

import numpy as np

from bozzetto.ink.stroke import Stroke
from bozzetto.scene.display_list import Scene

MOST_OBJECTS: Final = 4096
"""Objects looked at before one call: some milliseconds at most."""

LEAVES: Final = (str, bytes, int, float, bool, complex, type(None))


class ArgumentSnapshot:
    """The frozen objects within some arguments, with the values of their fields.

    Dataclasses are followed through their fields, tuples and lists through their entries,
    dicts through their values; of a stroke the slots are kept and the camera followed, for
    its columns are backed by immutable memory.

    Parameters
    ----------
    arguments : iterable of object
        Walked breadth first; beyond `MOST_OBJECTS` nothing is remembered.
    """

    __slots__ = ("_containers", "_objects", "_writable")

    def __init__(self, arguments: Iterable[object]) -> None:
        self._objects: list[tuple[object, tuple[str, ...], tuple[Any, ...]]] = []
        self._containers: list[tuple[Any, Any]] = []
        self._writable: list[tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]] = []
        waiting: list[Any] = list(arguments)
        seen: set[int] = set()
        for value in waiting:
            kind = type(value)
            way = _ways.get(kind) or _way_of(kind)
            if way == "leaf" or id(value) in seen:
                continue
            if way == "scene" and not value.is_made:
                continue  # nobody else has what the plugin may make of it
            if len(seen) == MOST_OBJECTS:
                return
            seen.add(id(value))
            if way == "tuple":
                waiting.extend(value)
            elif way == "list":
                self._containers.append((value, copy.copy(value)))
                waiting.extend(value)
            elif way == "dict":
                self._containers.append((value, copy.copy(value)))
                waiting.extend(value.values())
            elif way == "array":
                if value.flags.writeable:
                    self._writable.append((value, value.copy()))
            else:
                names, read = _fields(kind)
                if names:
                    values = read(value)
                    self._objects.append((value, names, values))
                    waiting.extend([value.camera] if way == "stroke" else values)

    def restore(self) -> list[str]:
        """Put everything back.

        Returns
        -------
        list of str
            What had been changed, such as "Band.width"; empty where nothing was.
        """
        changed = []
        for target, names, values in self._objects:
            _, read = _fields(type(target))
            try:
                if all(map(operator.is_, read(target), values)):
                    continue
            except AttributeError:
                pass  # a field was deleted
            for name, value in zip(names, values, strict=True):
                if getattr(target, name, _MISSING) is not value:
                    changed.append(f"{type(target).__name__}.{name}")
                    object.__setattr__(target, name, value)
        for container, before in self._containers:
            if len(container) != len(before) or not all(
                map(operator.is_, _entries(container), _entries(before))
            ):
                changed.append(f"a {type(container).__name__}")
                container.clear()
                (container.update if isinstance(before, dict) else container.extend)(before)
        for array, content in self._writable:
            if array.tobytes() != content.tobytes():
                changed.append("an array")
                array[...] = content
        return changed


_MISSING: Final = object()


def _entries(container: Any) -> list[Any]:
    if isinstance(container, dict):
        return [part for pair in container.items() for part in pair]
    return list(container)


_ways: dict[type[Any], str] = {}


def _way_of(kind: type[Any]) -> str:
    """Return how objects of a type are followed; a call looks at a thousand of few types."""
    ways = (
        (LEAVES, "leaf"), (Scene, "scene"), (tuple, "tuple"), (list, "list"), (dict, "dict"),
        (np.ndarray, "array"), (Stroke, "stroke"),
    )  # fmt: skip
    way = next((way for kinds, way in ways if issubclass(kind, kinds)), "fields")
    _ways[kind] = way
    return way


Reader = Callable[[Any], tuple[Any, ...]]
_known: dict[type[Any], tuple[tuple[str, ...], Reader]] = {}


def _fields(kind: type[Any]) -> tuple[tuple[str, ...], Reader]:
    """Return the names of the fields of a dataclass or of slots, and how to read them.

    A slot whose name begins with an underscore holds what is worked out from the others, at any
    time.
    """
    if kind not in _known:
        _known[kind] = _find_fields(kind)
    return _known[kind]


def _find_fields(kind: type[Any]) -> tuple[tuple[str, ...], Reader]:
    names: tuple[str, ...] = ()
    if dataclasses.is_dataclass(kind):
        names = tuple(entry.name for entry in dataclasses.fields(kind))
    elif kind.__module__.startswith("bozzetto."):
        slots = (name for part in kind.__mro__ for name in vars(part).get("__slots__", ()))
        names = tuple(name for name in slots if not name.startswith("_"))
    if not names:
        return (), lambda _: ()
    if len(names) == 1:
        one = operator.attrgetter(names[0])
        return names, lambda value: (one(value),)
    return names, operator.attrgetter(*names)
