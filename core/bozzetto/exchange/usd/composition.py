"""USD scenes in several files, put together: sublayers, references, payloads, inherited prims.

By the rules of OpenUSD ("LIVERPS"): what is said of a prim where it stands is stronger than what
it inherits, that is stronger than what is chosen of its variants, that is stronger than what it
refers to, that is stronger than payloads, and these than what it specializes. The strongest says
what is chosen.
"""

from __future__ import annotations

import posixpath
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final, NamedTuple

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.limits import MAX_DEPTH, at_most
from bozzetto.exchange.usd.crate import MAGIC, parsed_crate
from bozzetto.exchange.usd.usda_text import (
    CHOSEN,
    MAX_LETTERS,
    SETS,
    Asset,
    ReadPrim,
    Target,
    parsed,
)

STRONG: Final = ("inherits",)
WEAK: Final = ("references", "payload", "specializes")
ARCS: Final = (*STRONG, *WEAK)
"""Metadata by which a prim takes something from elsewhere, the strongest first: what is chosen of
its variants stands between the strong and the weak ones."""

MOST_TAKEN: Final = 200_000
"""Prims that are taken from elsewhere: those of a thousand chairs. A few lines
can ask for millions."""

LAYERS: Final = "subLayers"

REMOTE: Final = ("://", "[")
"""What names of files have that are no names of files: addresses, and files in packages."""


_Key = tuple[int, str]
"""A file, and the path of a prim in it."""


class _Arc(NamedTuple):
    """Source of a prim: a path in a file of the scene, or in another file."""

    layer: ReadPrim
    named: Target | Asset


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
    unread : int
        Sets of choices of which something was not chosen.
    """

    def __init__(self, read: Callable[[str, str], bytes]) -> None:
        self._read = read
        self._layers: dict[str, ReadPrim | None] = {}
        self._tables: dict[int, dict[str, ReadPrim]] = {}
        self._made = self._letters = 0
        self.missing = self.unread = 0

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
        if not any(one.variants or any(arc in one.said for arc in ARCS) for one in root.walk()):
            return root
        # What is taken from this file itself is taken as it is, not as it becomes.
        self._layers[posixpath.normpath(name)] = root
        self._tables[id(root)] = {one.path: one for one in self._copied(root, "", "").walk()}
        root.children = [self._whole(one, frozenset()) for one in root.children]
        return root

    def _layer(self, data: bytes, name: str, depth: int = 0) -> ReadPrim:
        """Return a file with its sublayers; names of files in it are seen from the scene's."""
        at_most(depth, MAX_DEPTH, "layers in one another")
        root = parsed_crate(data) if data.startswith(MAGIC) else parsed(data)
        folder = posixpath.dirname(name)
        below = root.said.pop(LAYERS, None)
        for prim in everything(root):
            if folder:
                for table in (prim.values, prim.said):
                    for key, value in table.items():
                        table[key] = _anchored(value, folder)
            for arc in ARCS:
                if arc in prim.said:
                    prim.said[arc] = [_Arc(root, one) for one in _row(prim.said[arc])
                                      if isinstance(one, Asset | Target)]  # fmt: skip
        said = root.said
        for other in below if isinstance(below, list) else ():
            weaker = self._named(_anchored(Asset(str(other)), folder), depth + 1)
            if weaker is not None:
                copied = self._copied(weaker, "", "")
                for prim in everything(copied):
                    for arc in ARCS:
                        if arc in prim.said:
                            prim.said[arc] = [_Arc(root, one.named) for one in prim.said[arc]]
                _merge(root, copied)
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

    def _whole(self, prim: ReadPrim, within: frozenset[_Key]) -> ReadPrim:
        """Return a prim with what it and all below it take from elsewhere.

        Parameters
        ----------
        prim : ReadPrim
            Changed in place.
        within : frozenset
            What all that it is in was taken from: nothing is in itself.
        """
        within |= self._expand(prim, {}, within)
        at_most(len(within), MAX_DEPTH, "scenes in one another")
        prim.children = [self._whole(one, within) for one in prim.children]
        return prim

    def _expand(
        self, prim: ReadPrim, stronger: Mapping[str, str], within: frozenset[_Key]
    ) -> frozenset[_Key]:
        """Give a prim what it takes from elsewhere, and what is chosen of its variants.

        What is below it is left as it comes.

        Parameters
        ----------
        prim : ReadPrim
            Changed in place.
        stronger : mapping of str to str
            Choices by their sets, of who takes it.
        within : frozenset
            What it cannot take.

        Returns
        -------
        frozenset
            What was taken.
        """
        taken = self._take(prim, STRONG, stronger, within)
        self._choose(prim, stronger)
        # A choice may inherit something as well.
        taken |= self._take(prim, STRONG, stronger, within)
        return taken | self._take(prim, WEAK, stronger, within)

    def _take(
        self,
        prim: ReadPrim,
        arcs: tuple[str, ...],
        stronger: Mapping[str, str],
        within: frozenset[_Key],
    ) -> frozenset[_Key]:
        """Give a prim what some of its arcs lead to; see `_expand`."""
        taken: frozenset[_Key] = frozenset()
        for arc in arcs:
            for one in prim.said.pop(arc, ()):
                source = self._source(one)
                if source is None:
                    continue
                layer, found = source
                key = id(layer), found.path
                if key in within:
                    self.missing += 1
                    continue
                at_most(len(within), MAX_DEPTH, "scenes in one another")
                copied = self._copied(found, found.path, prim.path)
                chosen = {**_choices(prim), **stronger}
                taken |= {key} | self._expand(copied, chosen, within | {key})
                _merge(prim, copied)
        return taken

    def _choose(self, prim: ReadPrim, stronger: Mapping[str, str]) -> None:
        """Give a prim what is chosen of its variants, the strongest set first."""
        while True:
            names = [str(name) for name in _row(prim.said.get(SETS, []))]
            name = next((one for one in names if one in prim.variants), "")
            if not name:
                break
            choices = prim.variants.pop(name)
            choice = {**_choices(prim), **stronger}.get(name, "")
            chosen = choices.get(choice)
            self.unread += len(choices) > (chosen is not None)
            if chosen is not None:
                _merge(prim, chosen)
        self.unread += len(prim.variants)  # nobody has named them as sets
        prim.variants = {}

    def _source(self, arc: _Arc) -> tuple[ReadPrim, ReadPrim] | None:
        """Return the file and the prim that an arc leads to; None, counted, where there is none."""
        layer: ReadPrim | None = arc.layer
        path = str(arc.named)
        if isinstance(arc.named, Asset):
            path = arc.named.prim
            if arc.named:
                layer = self._named(arc.named)
            if layer is None or not (arc.named or path):
                return None
            path = path or f"/{layer.said.get('defaultPrim', '')}"
        assert layer is not None
        found = self._table(layer).get(path)
        self.missing += found is None
        return None if found is None else (layer, found)

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
            {name: {choice: self._copied(one, before, after) for choice, one in choices.items()}
             for name, choices in prim.variants.items()},
        )  # fmt: skip


def _merge(prim: ReadPrim, weaker: ReadPrim) -> None:
    """Give a prim what a weaker one says and it does not, in all that is below."""
    if prim.kind == "over":
        prim.kind = weaker.kind
    prim.type = prim.type or weaker.type
    both: dict[str, Any] = {key: _row(prim.said[key]) + _row(weaker.said[key])
            for key in (*ARCS, SETS) if key in prim.said and key in weaker.said}  # fmt: skip
    both[CHOSEN] = {**_choices(weaker), **_choices(prim)}
    prim.said = {**weaker.said, **prim.said, **both}
    prim.values = {**weaker.values, **prim.values}
    prim.remarks = {**weaker.remarks, **prim.remarks}
    for name, choices in weaker.variants.items():
        mine = prim.variants.setdefault(name, {})
        for choice, one in choices.items():
            if choice in mine:
                _merge(mine[choice], one)
            else:
                mine[choice] = one
    own = {one.name: one for one in prim.children}
    children = []
    for other in weaker.children:
        same = own.pop(other.name, None)
        if same is None:
            children.append(other)
        else:
            _merge(same, other)
            children.append(same)
    prim.children = children + list(own.values())


def _choices(prim: ReadPrim) -> dict[str, str]:
    """Return which choice a prim makes of each set."""
    said = prim.said.get(CHOSEN)
    return said if isinstance(said, dict) else {}


def everything(prim: ReadPrim) -> Iterator[ReadPrim]:
    """Yield a prim and all below it, and what is to be chosen there."""
    waiting = [prim]
    while waiting:
        one = waiting.pop()
        yield one
        waiting += [*one.children, *one.all_choices()]


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
