"""USD scenes in several files, put together: sublayers, references, payloads, inherited prims.

Of the rules of OpenUSD ("LIVERPS") those that need no choice: what is said of a prim where it
stands is stronger than what it inherits, that is stronger than what it refers to, that is stronger
than payloads, and these than what it specializes. Variants are not chosen.
"""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Iterator
from typing import Any, Final

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.limits import MAX_DEPTH, at_most
from bozzetto.exchange.usd.crate import MAGIC, parsed_crate
from bozzetto.exchange.usd.usda_text import MAX_LETTERS, Asset, ReadPrim, Target, parsed

ARCS: Final = ("inherits", "references", "payload", "specializes")
"""Metadata by which a prim takes something from elsewhere, the strongest first."""

MOST_TAKEN: Final = 200_000
"""Prims that are taken from elsewhere: those of a thousand chairs. A few lines
can ask for millions."""

LAYERS: Final = "subLayers"

REMOTE: Final = ("://", "[")
"""What names of files have that are no names of files: addresses, and files in packages."""


class Composition:
    """The files of a scene.

    Parameters
    ----------
    read : callable
        Gives the bytes of a file by its name, from the folder of the scene, and its kind, for
        messages.

    Attributes
    ----------
    missing : int
        How often something was named that could not be taken in.
    """

    def __init__(self, read: Callable[[str, str], bytes]) -> None:
        self._read = read
        self._layers: dict[str, ReadPrim | None] = {}
        self._tables: dict[int, dict[str, ReadPrim]] = {}
        self._open: list[tuple[int, str]] = []
        self._made = self._letters = 0
        self.missing = 0

    def picture(self, name: str) -> bytes:
        """Return the bytes of a picture by the name that the scene has for it."""
        return self._read(posixpath.normpath(name), "picture")

    def composed(self, data: bytes, name: str = "") -> ReadPrim:
        """Return the root of a scene with all that it takes from elsewhere.

        Parameters
        ----------
        data : bytes
            Text or binary.
        name : str
            Of its file, seen from where files are read.

        Raises
        ------
        FormatError
            If it is damaged or too large; of what it names, only if it becomes too large.
        """
        root = self._layer(data, name)
        if not any(arc in prim.said for prim in root.walk() for arc in ARCS):
            return root
        # What is taken from this file itself is taken as it is, not as it becomes.
        self._layers[posixpath.normpath(name)] = root
        self._tables[id(root)] = {one.path: one for one in self._copied(root, "", "").walk()}
        root.children = [self._whole(root, one) for one in root.children]
        return root

    def _layer(self, data: bytes, name: str, depth: int = 0) -> ReadPrim:
        """Return a file with its sublayers; names of files in it are seen from the scene's."""
        at_most(depth, MAX_DEPTH, "layers in one another")
        root = parsed_crate(data) if data.startswith(MAGIC) else parsed(data)
        folder = posixpath.dirname(name)
        below = root.said.pop(LAYERS, None)
        if folder:
            for prim in root.walk():
                for table in (prim.values, prim.said):
                    for key, value in table.items():
                        table[key] = _anchored(value, folder)
        said = root.said
        for other in below if isinstance(below, list) else ():
            weaker = self._named(_anchored(Asset(str(other)), folder), depth + 1)
            if weaker is not None:
                _merge(root, self._copied(weaker, "", ""))
        root.said = said  # of the whole scene it is the first file alone that speaks
        return root

    def _named(self, name: Asset, depth: int = 0) -> ReadPrim | None:
        """Return the root of a file; None, counted, where it cannot be read."""
        path = posixpath.normpath(name)
        if path not in self._layers:
            self._layers[path] = None  # while it is read it does not take in itself
            if not any(sign in path for sign in REMOTE):
                try:
                    data = self._read(path, "scene")
                    self._layers[path] = self._layer(data, path, depth)
                except (FormatError, UserError):
                    pass
        found = self._layers[path]
        self.missing += found is None
        return found

    def _whole(self, layer: ReadPrim, prim: ReadPrim) -> ReadPrim:
        """Return a prim of a layer with what it and all below it take from elsewhere."""
        prim.children = [self._whole(layer, one) for one in prim.children]
        for arc in ARCS:
            if arc in prim.said:
                for source in self._sources(layer, prim, arc):
                    _merge(prim, source)
        return prim

    def _sources(self, layer: ReadPrim, prim: ReadPrim, arc: str) -> Iterator[ReadPrim]:
        """Yield copies of the prims that one names, whole, the strongest first."""
        value = prim.said.pop(arc)
        for one in _row(value):
            if isinstance(one, Asset) and one:
                other, path = self._named(one), one.prim
                if other is not None and not path:
                    path = f"/{other.said.get('defaultPrim', '')}"
            elif isinstance(one, Target):
                other, path = layer, str(one)
            else:
                continue
            if other is None:
                continue
            found, key = self._table(other).get(path), (id(other), path)
            if found is None or key in self._open:
                self.missing += 1
                continue
            at_most(len(self._open), MAX_DEPTH, "scenes in one another")
            self._open.append(key)
            yield self._whole(other, self._copied(found, path, prim.path))
            self._open.pop()

    def _table(self, layer: ReadPrim) -> dict[str, ReadPrim]:
        """Return the prims of a layer by their paths."""
        if id(layer) not in self._tables:
            self._tables[id(layer)] = {one.path: one for one in layer.walk()}
        return self._tables[id(layer)]

    def _copied(self, prim: ReadPrim, before: str, after: str) -> ReadPrim:
        """Return a copy of a prim and all below it, with paths that begin otherwise."""
        self._made += 1
        path = _moved(prim.path, before, after)
        self._letters += len(path)
        at_most(self._made, MOST_TAKEN, "prims that it takes from elsewhere")
        at_most(self._letters, MAX_LETTERS, "letters in the paths of its prims")
        return ReadPrim(
            prim.kind,
            prim.type,
            prim.name,
            path,
            {key: _retargeted(value, before, after) for key, value in prim.said.items()},
            {key: _retargeted(value, before, after) for key, value in prim.values.items()},
            dict(prim.remarks),
            [self._copied(one, before, after) for one in prim.children],
            prim.has_variants,
        )


def _merge(prim: ReadPrim, weaker: ReadPrim) -> None:
    """Give a prim what a weaker one says and it does not, in all that is below."""
    if prim.kind == "over":
        prim.kind = weaker.kind
    prim.type = prim.type or weaker.type
    both: dict[str, Any] = {arc: _row(prim.said[arc]) + _row(weaker.said[arc])
            for arc in ARCS if arc in prim.said and arc in weaker.said}  # fmt: skip
    prim.said = {**weaker.said, **prim.said, **both}
    prim.values = {**weaker.values, **prim.values}
    prim.remarks = {**weaker.remarks, **prim.remarks}
    prim.has_variants = prim.has_variants or weaker.has_variants
    own = {one.name: one for one in prim.children}
    children = []
    for other in weaker.children:
        mine = own.pop(other.name, None)
        if mine is None:
            children.append(other)
        else:
            _merge(mine, other)
            children.append(mine)
    prim.children = children + list(own.values())


def _row(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _moved(path: str, before: str, after: str) -> str:
    """Return a path that begins with one as one that begins with another."""
    rest = path[len(before) :]
    return after + rest if path.startswith(before) and rest[:1] in ("", "/", ".") else path


def _retargeted(value: Any, before: str, after: str) -> Any:
    """Return a value whose paths begin otherwise."""
    if isinstance(value, Target):
        return Target(_moved(str(value), before, after))
    if isinstance(value, list) and any(isinstance(one, Target) for one in value):
        return [_retargeted(one, before, after) for one in value]
    return value


def _anchored(value: Any, folder: str) -> Any:
    """Return names of files that are seen from a folder as the scene sees them."""
    if isinstance(value, Asset):
        known = not value or posixpath.isabs(value) or any(sign in value for sign in REMOTE)
        return value if known or not folder else Asset(posixpath.join(folder, value), value.prim)
    if isinstance(value, list) and any(isinstance(one, Asset) for one in value):
        return [_anchored(one, folder) for one in value]
    return value
