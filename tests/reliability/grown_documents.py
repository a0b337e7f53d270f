"""Documents of the bundled modelers in which one list of a state has grown: how they open."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from typing import Any, NamedTuple

from bozzetto.document.storage.bozz_file import decode_document
from bozzetto.errors import DocumentError
from tests.reliability.mutated_documents import entries, packed, with_sound_parts
from tests.reliability.mutated_models import bench, corpus

__all__ = ["GrownList", "grown_lists", "opening_time"]


class GrownList(NamedTuple):
    """A list in the state of a document.

    Attributes
    ----------
    modeler : str
    entry : str
        Of the document.
    path : tuple of str and int
        Keys and numbers that lead to the list.
    document : bytes
    """

    modeler: str
    entry: str
    path: tuple[str | int, ...]
    document: bytes

    @property
    def name(self) -> str:
        """Such as ``bozzetto.product joints/*/meetings``."""
        words = ("*" if isinstance(step, int) else step for step in self.path)
        return f"{self.modeler} {'/'.join(words)}"

    def grown(self, values: int) -> bytes:
        """Return the document with the list's own values again and again.

        Parameters
        ----------
        values : int
            How many JSON values its state then has, about.
        """
        found = dict(entries(self.document))
        tree = json.loads(found[self.entry])
        holder = tree
        for step in self.path[:-1]:
            holder = holder[step]
        own = holder[self.path[-1]]
        times = max(1, (values - _count(tree)) // max(1, _count(own) - 1))
        holder[self.path[-1]] = own * times
        found[self.entry] = json.dumps(tree).encode()
        return packed(with_sound_parts(found))


@cache
def grown_lists() -> tuple[GrownList, ...]:
    """Return the lists in one document of each bundled modeler; of lists in rows the first."""
    found: dict[str, GrownList] = {}
    seen: set[str] = set()
    for document in corpus():
        inside = entries(document)
        states = [name for name in inside if name.startswith("plugins/") and "json" in name]
        modelers = {name.split("/")[1] for name in states}
        if modelers <= seen:
            continue
        seen |= modelers
        for entry in states:
            for path in _paths(json.loads(inside[entry])):
                one = GrownList(entry.split("/")[1], entry, path, document)
                found.setdefault(one.name, one)
    return tuple(found.values())


def opening_time(document: bytes) -> float:
    """Return the processor time, s, until a document is open or refused; else what is raised."""
    started = time.process_time()
    with suppress(DocumentError):
        decode_document(document, bench().registry)
    return time.process_time() - started


def _paths(tree: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Yield where lists with something in them are."""
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield from _paths(value, (*path, key))
    elif isinstance(tree, list) and tree:
        if path:
            yield path
        for number, value in enumerate(tree):
            yield from _paths(value, (*path, number))


def _count(tree: Any) -> int:
    if isinstance(tree, dict):
        return 1 + sum(_count(value) for value in tree.values())
    if isinstance(tree, list):
        return 1 + sum(_count(value) for value in tree)
    return 1
