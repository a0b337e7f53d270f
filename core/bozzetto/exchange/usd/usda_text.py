"""The text of USD, read: the tree of prims with their properties.

What is read is the text file format of OpenUSD (``#usda 1.0``), leniently: commas, semicolons and
ends of lines part what stands beside each other.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple, Self

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_DEPTH, MAX_ELEMENTS, MAX_WORDS, at_most

BEGIN: Final = "#usda"

SPACE: Final = re.compile(r"(?:[\s,;]++|#[^\n]*+)*+")

TOKEN: Final = re.compile(
    r'(?P<text>"""(?:[^"\\]++|\\.|"(?!""))*+"""|"(?:[^"\\\n]++|\\.)*+"'
    r"|'''(?:[^'\\]++|\\.|'(?!''))*+'''|'(?:[^'\\\n]++|\\.)*+')"
    r"|(?P<asset>@@@(?:[^@]++|@(?!@@))*+@@@|@[^@\n]*+@)"
    r"|(?P<path><[^>\n]*+>)"
    r"|(?P<number>[+-]?+(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?+\d++)?+|[+-]?+(?:inf|nan)\b)"
    r"|(?P<word>[^\W\d][\w:.]*+)"
    r"|(?P<sign>[=()\[\]{}:])",
    re.DOTALL,
)

MAX_LETTERS: Final = 1 << 27
"""Of all paths together: a long name is part of the path of all that is below."""

ESCAPED: Final = re.compile(r"\\(.)", re.DOTALL)
ESCAPES: Final = {"n": "\n", "t": "\t", "r": "\r"}

NUMERIC: Final = re.compile(
    r"(?:u?int(?:64)?|uchar|half|float|double|timecode)[234]?"
    r"|(?:point|normal|vector|color|texCoord)[234][fhd]|quat[fhd]|(?:matrix|frame)[234]d"
)
"""Types whose arrays are nothing but numbers."""

PLAIN: Final = str.maketrans("()[],\n\r\t", "        ")

LIST_WORDS: Final = frozenset(("prepend", "append", "add", "delete", "reorder"))
LEADING: Final = LIST_WORDS | {"custom", "uniform", "varying", "config"}
SPECIFIERS: Final = frozenset(("def", "over", "class"))


CHOSEN: Final = "variants"
"""Metadata that says which choice is made of each set."""

SETS: Final = "variantSets"
"""Metadata that names the sets of choices, the strongest first."""


class Target(str):
    """A path of a prim or a property, without its angle brackets."""

    __slots__ = ()


class Asset(str):
    """The name of another file.

    Attributes
    ----------
    prim : str
        Path of a prim in it; empty where none is named.
    """

    __slots__ = ("prim",)
    prim: str

    def __new__(cls, name: str, prim: str = "") -> Self:
        """Return the name of a file, with the path of a prim in it."""
        made = super().__new__(cls, name)
        made.prim = prim
        return made


@dataclass(eq=False)
class ReadPrim:
    """A prim of a file.

    Attributes
    ----------
    kind : {"def", "over", "class"}
    type : str
        Such as "Mesh"; empty where none is said.
    name : str
    path : str
        From the root, such as "/Model/box".
    said : dict of str to value
        Its metadata.
    values : dict of str to value
        Of its properties, by their names; numbers of arrays are a flat array. Values at times
        are under ``name.timeSamples`` as pairs, targets of connections under ``name.connect``.
    remarks : dict of str to dict
        Metadata of properties that have any.
    children : list of ReadPrim
    variants : dict of str to dict
        What it has besides by choices: sets by their names, the strongest first, and in each what
        belongs to a choice, by the name of this.
    """

    kind: str
    type: str
    name: str
    path: str
    said: dict[str, Any] = field(default_factory=dict)
    values: dict[str, Any] = field(default_factory=dict)
    remarks: dict[str, dict[str, Any]] = field(default_factory=dict)
    children: list[ReadPrim] = field(default_factory=list)
    variants: dict[str, dict[str, ReadPrim]] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """The name for people."""
        said = self.said.get("displayName")
        return said if isinstance(said, str) and said else self.name

    def numbers(self, name: str, width: int) -> Array | None:
        """Return the value of a property as rows (n, width); the first one where it changes.

        Raises
        ------
        FormatError
            If it is no whole rows of numbers.
        """
        value = self.values.get(name)
        samples = self.values.get(f"{name}.timeSamples")
        if value is None and samples:
            value = samples[0][1]
        return None if value is None else rows_of(value, width, name)

    def number(self, name: str) -> float | None:
        """Return the value of a property that is one number."""
        value = self.numbers(name, 1)
        return float(value[0, 0]) if value is not None and value.size == 1 else None

    def word(self, name: str) -> str:
        """Return the value of a property that is a word; else nothing."""
        value = self.values.get(name)
        return value if isinstance(value, str) else ""

    def targets(self, name: str) -> list[str]:
        """Return the prims or properties that a relationship or connection names."""
        value = self.values.get(name)
        found = value if isinstance(value, list) else [value]
        return [str(one) for one in found if isinstance(one, Target)]

    def all_choices(self) -> Iterator[ReadPrim]:
        """Yield what belongs to each of its choices."""
        for choices in self.variants.values():
            yield from choices.values()

    def walk(self) -> Iterator[ReadPrim]:
        """Yield it and all below it, in the order of the file, without what is to be chosen."""
        waiting = [self]
        while waiting:
            one = waiting.pop()
            yield one
            waiting.extend(reversed(one.children))


def rows_of(value: Any, width: int, name: str) -> Array:
    """Return a value as rows of numbers (n, width).

    Raises
    ------
    FormatError
        If it is none.
    """
    try:
        flat = np.asarray(value, np.float64).ravel()
    except (TypeError, ValueError):
        flat = np.zeros(1)
        width = 2
    if len(flat) % width:
        raise FormatError(f"The numbers of “{name[:40]}” do not come in {width}s.")
    return np.asarray(flat.reshape(-1, width))


def parsed(data: bytes) -> ReadPrim:
    """Return the root of a scene, with what stands at the top of the file.

    Raises
    ------
    FormatError
        If it is no such text, or holds too much.
    """
    text = data.decode("utf-8", "replace").removeprefix("\ufeff")
    if not text.startswith(BEGIN):
        raise FormatError("This is not a USD file.")
    return _Parser(text).root


class _VariantSet(NamedTuple):
    """A set of choices that is being read."""

    prim: ReadPrim
    choices: dict[str, ReadPrim]


class _Parser:
    """One pass over the text."""

    def __init__(self, text: str) -> None:
        self._text, self._at = text, 0
        self._words = 0
        self._kind = self._token = ""
        self._next()
        self.root = ReadPrim("def", "", "", "")
        self._metadata(self.root.said)
        self._prims()

    def _next(self) -> None:
        """Go on to the next token; at the end it is nothing."""
        begin = SPACE.match(self._text, self._at)
        self._at = begin.end() if begin else self._at
        found = TOKEN.match(self._text, self._at)
        if found is None:
            if self._at < len(self._text):
                raise self._unclear()
            self._kind = self._token = ""
            return
        self._kind, self._token = str(found.lastgroup), found[0]
        self._at = found.end()

    def _unclear(self) -> FormatError:
        begin = max(self._at - len(self._token), 0)
        shown = "".join(letter for letter in self._text[begin : begin + 30] if letter.isprintable())
        return FormatError(f"It cannot be understood at “{shown}”.")

    def _take(self, kind: str, token: str = "") -> str:
        if self._kind != kind or (token and self._token != token):
            raise self._unclear()
        taken = self._token
        self._next()
        return taken

    def _is(self, sign: str) -> bool:
        return self._kind == "sign" and self._token == sign

    def _prims(self) -> None:
        """Read all prims; those that are open stand on a list, not on the machine's stack."""
        open_prims: list[ReadPrim | _VariantSet] = [self.root]
        count = letters = 0
        while self._kind:
            here = open_prims[-1]
            if self._is("}"):
                if here is self.root:
                    raise self._unclear()
                open_prims.pop()
                self._next()
                continue
            at_most(len(open_prims), MAX_DEPTH, "levels of prims")
            if isinstance(here, _VariantSet):
                count += 1
                at_most(count, MAX_ELEMENTS, "prims")
                open_prims.append(self._choice(here))
            elif self._kind == "word" and self._token in SPECIFIERS:
                count += 1
                at_most(count, MAX_ELEMENTS, "prims")
                kind = self._take("word")
                type_of = self._take("word") if self._kind == "word" else ""
                name = _plain(self._take("text"))
                made = ReadPrim(kind, type_of, name, f"{here.path}/{name}")
                letters += len(made.path)
                at_most(letters, MAX_LETTERS, "letters in the paths of its prims")
                self._metadata(made.said)
                self._take("sign", "{")
                here.children.append(made)
                open_prims.append(made)
            elif here is self.root:
                raise self._unclear()
            elif self._kind == "word" and self._token == "variantSet":
                self._next()
                name = _plain(self._take("text"))
                self._take("sign", "=")
                self._take("sign", "{")
                open_prims.append(_VariantSet(here, here.variants.setdefault(name, {})))
            else:
                self._property(here)
        if len(open_prims) > 1:
            raise FormatError("It is cut short. Save it again.")

    def _choice(self, to: _VariantSet) -> ReadPrim:
        """Read the beginning of what belongs to a choice."""
        name = _plain(self._take("text"))
        made = ReadPrim("over", "", to.prim.name, to.prim.path)
        self._metadata(made.said)
        self._take("sign", "{")
        to.choices[name] = made
        return made

    def _property(self, prim: ReadPrim) -> None:
        listed = False
        while self._kind == "word" and self._token in LEADING:
            listed = listed or self._token in LIST_WORDS
            self._next()
        type_of = self._take("word")
        if self._is("["):
            self._next()
            self._take("sign", "]")
            type_of += "[]"
        name = self._take("word") if self._kind == "word" else type_of  # reorder properties = …
        if self._is("="):
            value = self._property_value(type_of, name)
            if listed and isinstance(prim.values.get(name), list) and isinstance(value, list):
                value = prim.values[name] + value
            prim.values[name] = value
        elif self._is("["):
            raise self._unclear()
        said: dict[str, Any] = {}
        self._metadata(said)
        if said:
            prim.remarks[name] = said

    def _property_value(self, type_of: str, name: str) -> Any:
        """Read what follows the sign of equality, whose type is known."""
        if type_of.endswith("[]") and NUMERIC.fullmatch(type_of[:-2]):
            if name.endswith(".timeSamples"):
                self._next()
                return self._samples(numeric=True)
            if not name.endswith(".connect"):
                return self._numbers()
        self._next()
        if name.endswith(".timeSamples"):
            return self._samples(numeric=False)
        return self._value(0)

    def _numbers(self) -> Array | None:
        """Read an array of numbers; its sign before is the current token."""
        begin = SPACE.match(self._text, self._at)
        at = begin.end() if begin else self._at
        if not self._text.startswith("[", at):
            self._next()
            value = self._value(0)
            return None if value is None else rows_of(value, 1, "array")[:, 0]
        end = self._text.find("]", at)
        if end < 0:
            raise FormatError("It is cut short. Save it again.")
        body = self._text[at:end]
        # What a word takes is asked for before the words are made.
        self._words += body.count(",") + 1
        at_most(self._words, MAX_WORDS, "numbers")
        try:
            found = np.array([float(word) for word in body.translate(PLAIN).split()], np.float64)
        except ValueError:
            raise self._unclear() from None
        self._at = end + 1
        self._next()
        return found

    def _samples(self, *, numeric: bool) -> list[tuple[float, Any]]:
        """Read values at times, in the order of these."""
        if not self._is("{"):
            raise self._unclear()
        found: list[tuple[float, Any]] = []
        self._next()
        while not self._is("}"):
            time = float(self._take("number"))
            if not self._is(":"):
                raise self._unclear()
            if numeric:
                value = self._numbers()
            else:
                self._next()
                value = self._value(0)
            if value is not None:
                found.append((time, value))
            at_most(len(found), MAX_ELEMENTS, "values at times")
        self._next()
        return sorted(found, key=lambda pair: pair[0])

    def _value(self, depth: int) -> Any:
        """Read any value: a number, a text, a list of values."""
        at_most(depth, MAX_DEPTH, "levels of values")
        self._words += 1
        at_most(self._words, MAX_WORDS, "values")
        kind, token = self._kind, self._token
        if kind == "number":
            self._next()
            return float(token)
        if kind == "text":
            self._next()
            return _plain(token)
        if kind == "path":
            self._next()
            return Target(token[1:-1])
        if kind == "asset":
            self._next()
            prim = self._take("path")[1:-1] if self._kind == "path" else ""
            self._skip_remark()
            return Asset(token.strip("@"), prim)
        if kind == "word":
            self._next()
            return {"None": None, "true": 1.0, "false": 0.0}.get(token, token)
        if self._is("{"):
            self._skip_braces()
            return {}
        if self._is("[") or self._is("("):
            close = "]" if token == "[" else ")"
            self._next()
            values = []
            while not self._is(close):
                if not self._kind:
                    raise FormatError("It is cut short. Save it again.")
                values.append(self._value(depth + 1))
                if isinstance(values[-1], Target):
                    self._skip_remark()
            self._next()
            return values
        raise self._unclear()

    def _skip_remark(self) -> None:
        """Pass over what stands in parentheses after a reference, such as an offset in time."""
        if self._is("("):
            self._metadata({})

    def _skip_braces(self) -> None:
        """Pass over what stands in braces."""
        self._take("sign", "{")
        depth = 1
        while depth:
            if not self._kind:
                raise FormatError("It is cut short. Save it again.")
            depth += self._is("{") - self._is("}")
            self._next()

    def _metadata(self, said: dict[str, Any]) -> None:
        """Read what stands in parentheses, if anything does."""
        if not self._is("("):
            return
        self._next()
        while not self._is(")"):
            if self._kind == "text":
                self._next()
                continue
            words = [self._take("word")]
            while self._kind == "word":
                words.append(self._take("word"))
            if self._is("="):
                self._next()
                said[words[-1]] = self._chosen() if words[-1] == CHOSEN else self._value(0)
        self._next()

    def _chosen(self) -> dict[str, str]:
        """Read which choice is made of each set."""
        self._take("sign", "{")
        found = {}
        while not self._is("}"):
            self._take("word")
            name = _plain(self._token) if self._kind == "text" else self._token
            self._next()
            self._take("sign", "=")
            found[name] = _plain(self._take("text"))
        self._next()
        return found


def _plain(token: str) -> str:
    """Return what a text in quotation marks says."""
    size = 3 if token[:3] in ('"""', "'''") and len(token) >= 6 else 1
    inner = token[size:-size]
    if "\\" not in inner:
        return inner
    return ESCAPED.sub(lambda found: ESCAPES.get(found[1], found[1]), inner)
