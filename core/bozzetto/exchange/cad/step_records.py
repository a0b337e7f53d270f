"""Instances of STEP files (ISO 10303-21): the clear text taken apart, each when it is asked for.

An instance is one record, ``#7=LINE('',#5,#6)``, or several that together are one thing,
``#7=(CURVE()B_SPLINE_CURVE(…)…)``. Nothing here calls itself, and the text is gone through once.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Final, NamedTuple

from bozzetto.damaged_files import DAMAGED
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_DEPTH, at_most

MAX_INSTANCES: Final = 3_000_000
"""Instances of one file; 64 MB hold about a million."""

MAX_VALUES: Final = 4_000_000
"""Values of one instance: a surface of a million control points has not as many."""

KEPT: Final = 16
"""Instances that stay taken apart: one is asked for several times in a row."""

STATEMENT: Final = re.compile(rb"(?:[^';/]++|'[^']*+(?:'|\Z)|/\*.*?(?:\*/|\Z)|/)*+(?:;|\Z)", re.S)
"""Text up to a semicolon that is in no string and no comment; it always matches."""

COMMENT: Final = re.compile(rb"('[^']*+(?:'|\Z))|/\*.*?(?:\*/|\Z)", re.S)

HEAD: Final = re.compile(rb"\s*+#(\d{1,18})\s*+=\s*+")

KINDS: Final = re.compile(rb"\(?\s*([A-Z_0-9]{1,80})\s*\(", re.IGNORECASE)

WORD: Final = re.compile(
    r"\s*+(?:(?P<text>'(?:[^']|'')*+')|\#(?P<link>\d{1,18})"
    r"|(?P<number>[-+]?\d[\d.]*(?:[eEdD][-+]?\d+)?)|\.(?P<flag>\w{1,80})\."
    r'|(?P<kind>[A-Za-z_!]\w{0,80})|(?P<sign>[(),$*])|(?P<bits>"[0-9A-Fa-f]*+"))'
)
"""One word of a record."""

POINT: Final = re.compile(
    rb"CARTESIAN_POINT\s*+\(\s*+'[^'\\]*+'\s*+,\s*+\(([-+.,\dE \r\n]++)\)\s*+\)\s*+;", re.IGNORECASE
)
"""A point as most programs write it: most of a file are points."""

ESCAPE: Final = re.compile(
    r"\\X2\\((?:[0-9A-Fa-f]{4})*+)\\X0\\|\\X4\\((?:[0-9A-Fa-f]{8})*+)\\X0\\"
    r"|\\X\\([0-9A-Fa-f]{2})|\\S\\(.)|\\(\\)|\\P[A-I]\\"
)
"""Characters beyond ASCII in strings (6.4.3)."""


class Link(int):
    """Number of another instance."""


class Flag(str):
    """A word between dots, such as ``.T.``."""


class Record(NamedTuple):
    """One record: its kind in capitals, and its values.

    Values are strings, floats, `Link`, `Flag`, None where nothing is said, lists of these, and
    records for what names its type, such as ``LENGTH_MEASURE(25.4)``.
    """

    kind: str
    values: list[Any]


class Instances:
    """The instances of one file.

    Parameters
    ----------
    data : bytes
        Content of the file.

    Raises
    ------
    FormatError
        If there are too many.
    """

    def __init__(self, data: bytes) -> None:
        self._texts: dict[int, bytes] = {}
        self._kinds: dict[str, list[int]] = {}
        self._newest: dict[int, list[Record]] = {}
        for found in STATEMENT.finditer(data):
            head = HEAD.match(data, found.start(), found.end())
            if head is None:
                statement = found[0]
                if b"#" not in statement or b"/*" not in statement:
                    continue
                statement = COMMENT.sub(rb"\1", statement)
                head = HEAD.match(statement)
                if head is None:
                    continue
                text = statement[head.end() :]
            else:
                text = data[head.end() : found.end()]
            self._texts[int(head[1])] = text
            at_most(len(self._texts), MAX_INSTANCES, "instances")
            kind = KINDS.match(text)
            if kind is not None:
                name = kind[1].decode("ascii").upper()
                if text.startswith(b"("):
                    name = ""
                self._kinds.setdefault(name, []).append(int(head[1]))

    def of_kind(self, *kinds: str) -> Iterator[int]:
        """Yield the instances of one record of these kinds, and those of several that hold one."""
        for kind in kinds:
            yield from self._kinds.get(kind, ())
        words = [kind.encode("ascii") for kind in kinds]
        for number in self._kinds.get("", ()):
            text = self._texts[number].upper()
            if any(word in text for word in words) and self.record(number, *kinds) is not None:
                yield number

    def records(self, number: object) -> list[Record]:
        """Return the records of an instance; none where there is no such instance."""
        if not isinstance(number, int):
            return []
        found = self._newest.get(number)
        if found is None:
            text = self._texts.get(number)
            found = [] if text is None else _records(text)
            if len(self._newest) >= KEPT:
                self._newest.clear()
            self._newest[number] = found
        return found

    def point(self, number: object) -> list[float] | None:
        """Return the coordinates of a point; None where the instance is none."""
        text = self._texts.get(number) if isinstance(number, int) else None
        plain = None if text is None else POINT.fullmatch(text)
        if plain is not None:
            return [float(value) for value in plain[1].split(b",")]
        record = self.record(number, "CARTESIAN_POINT")
        return None if record is None else record.values[1]

    def record(self, number: object, *kinds: str) -> Record | None:
        """Return the first record of an instance that is of one of these kinds."""
        return next((one for one in self.records(number) if one.kind in kinds), None)


def _records(text: bytes) -> list[Record]:
    """Return the records that a text holds."""
    if b"/*" in text:
        text = COMMENT.sub(rb"\1", text)
    try:
        plain = text.decode("utf-8")
    except UnicodeDecodeError:
        plain = text.decode("latin-1")
    top: list[Any] = []
    stack: list[list[Any]] = [top]
    kinds: list[str | None] = []
    kind: str | None = None
    count = at = 0
    while found := WORD.match(plain, at):
        at = found.end()
        count += 1
        if count > MAX_VALUES:
            at_most(count, MAX_VALUES, "values")
        sign = found["sign"]
        if found["kind"]:
            kind = found["kind"].upper()
        elif sign == "(":
            at_most(len(stack), MAX_DEPTH, "levels of brackets")
            kinds.append(kind)
            stack.append([])
            kind = None
        elif sign == ")":
            if len(stack) == 1:
                raise FormatError(DAMAGED)
            values, name = stack.pop(), kinds.pop()
            stack[-1].append(values if name is None else Record(name, values))
        elif sign in ("$", "*"):
            stack[-1].append(None)
        elif sign is None:
            stack[-1].append(_value(found))
    if len(stack) > 1:
        raise FormatError(DAMAGED)
    if len(top) == 1 and isinstance(top[0], list) and not isinstance(top[0], Record):
        top = top[0]
    return [one for one in top if isinstance(one, Record)]


def _value(found: re.Match[str]) -> Any:
    if found["text"] is not None:
        return decoded(found["text"][1:-1].replace("''", "'"))
    if found["link"] is not None:
        return Link(found["link"])
    if found["number"] is not None:
        try:
            return float(found["number"].upper().replace("D", "E"))
        except ValueError:
            raise FormatError(DAMAGED) from None
    return None if found["flag"] is None else Flag(found["flag"].upper())


def decoded(text: str) -> str:
    """Return a string with the characters that its escapes stand for."""
    return ESCAPE.sub(_character, text)


def _character(found: re.Match[str]) -> str:
    try:
        if found[1] is not None:
            return bytes.fromhex(found[1]).decode("utf-16-be", "replace")
        if found[2] is not None:
            return bytes.fromhex(found[2]).decode("utf-32-be", "replace")
        if found[3] is not None:
            return chr(int(found[3], 16))
    except UnicodeError:
        return "\ufffd"
    if found[4] is not None:
        return chr((ord(found[4]) + 128) % 0x110000) if ord(found[4]) < 128 else found[4]
    return found[5] or ""
