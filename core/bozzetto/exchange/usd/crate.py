"""USD's binary form ("crate"), read: the same tree of prims as of its text.

The form has no specification but the code of OpenUSD (``crateFile.h``); versions 0.4 to 0.13 are
read. A table of contents names six sections: tokens, strings, paths, fields, sets of fields, and
specs, each a path with a set of fields. A field's value is eight bytes, which say its type and
hold it or the place where it stands.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_DEPTH, MAX_ELEMENTS, MAX_WORDS, at_most
from bozzetto.exchange.usd.crate_bytes import Cursor, damaged
from bozzetto.exchange.usd.usda_text import CHOSEN, MAX_LETTERS, SETS, Asset, ReadPrim, Target

MAGIC: Final = b"PXR-USDC"

OLDEST, NEWEST = (0, 4), (0, 13)

FEWEST_PACKED: Final = 16
"""Numbers of an array below which it is not compressed."""

END: Final = 0xFFFFFFFF
"""After the last field of a set."""

ATTRIBUTE, PRIM, ROOT, RELATIONSHIP, CHOICE = 1, 6, 7, 8, 10
"""Kinds of specs that are read."""

SPECIFIERS: Final = ("def", "over", "class")

SCALARS: Final = {
    1: "u1", 2: "u1", 3: "<i4", 4: "<u4", 5: "<i8", 6: "<u8", 7: "<f2", 8: "<f4", 9: "<f8",
    56: "<f8",
}  # fmt: skip
"""Numbers by the type of their value: bool, uchar, int, uint, int64, uint64, half, float, double,
time code."""

TUPLES: Final = {
    13: ("<f8", 4), 14: ("<f8", 9), 15: ("<f8", 16), 16: ("<f8", 4), 17: ("<f4", 4),
    18: ("<f2", 4), 19: ("<f8", 2), 20: ("<f4", 2), 21: ("<f2", 2), 22: ("<i4", 2),
    23: ("<f8", 3), 24: ("<f4", 3), 25: ("<f2", 3), 26: ("<i4", 3), 27: ("<f8", 4),
    28: ("<f4", 4), 29: ("<f2", 4), 30: ("<i4", 4),
}  # fmt: skip
"""Several numbers by the type of their value: matrices, quaternions (their real part is the last
one here), vectors."""

MATRICES: Final = {13: 2, 14: 3, 15: 4}
QUATERNIONS: Final = (16, 17, 18)

STRING, TOKEN, ASSET, DICTIONARY, SPECIFIER = 10, 11, 12, 31, 42
TOKEN_LIST, STRING_LIST, PATH_LIST, REFERENCE_LIST, PAYLOAD_LIST = 32, 33, 34, 35, 55
PATHS, TOKENS, VARIANTS, SAMPLES, PAYLOAD = 40, 41, 45, 46, 47
DOUBLES, STRINGS, NOTHING = 48, 50, 51

CALLED: Final = {
    "inheritPaths": "inherits", "variantSelection": CHOSEN, "variantSetNames": SETS
}  # fmt: skip
"""Fields that the text calls otherwise."""

LISTS: Final = (0x02, 0x04, 0x20, 0x40, 0x08, 0x10)
"""Bits of a list's head by what follows it: explicit, added, prepended, appended, deleted,
ordered items."""

TAKEN: Final = 4
"""How many of these kinds of items are what the list holds."""

LISTED: Final = frozenset((TOKEN_LIST, STRING_LIST, PATH_LIST, REFERENCE_LIST, PAYLOAD_LIST))


CHOICES: Final = re.compile(r"\{[^}]*+\}")
"""Choices in a path."""


class _Path(NamedTuple):
    """A path of the file: of a prim, and of a property of it if that is not empty.

    What belongs to a choice, ``{set=choice}``, is in that of the prim.
    """

    prim: str
    property: str = ""

    def __str__(self) -> str:
        prim = CHOICES.sub("", self.prim)
        return f"{prim}.{self.property}" if self.property else prim


def parsed_crate(data: bytes) -> ReadPrim:
    """Return the root of a scene, with what stands at the top of the file.

    Raises
    ------
    FormatError
        If it is damaged, of another version, or holds too much.
    """
    return _Crate(data).root()


class _Crate:
    """The sections of a file, understood."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        head = Cursor(data)
        if head.take(8) != MAGIC:
            raise damaged()
        version = tuple(head.take(8)[:2])
        if not OLDEST <= version <= NEWEST:
            raise FormatError(
                f"It is of version {version[0]}.{version[1]} of USD’s binary form, which is not "
                "read. Save it as .usda."
            )
        self._version = version
        head.at = head.numbers("q")[0]
        places = {}
        for _ in range(head.count("sections", 64)):
            name, start, _ = head.numbers("16sqq")
            places[name.rstrip(b"\0").decode("ascii", "replace")] = start
        self._places = places
        self._words = 0
        self._tokens = self._read_tokens()
        strings = self._at("STRINGS")
        count = strings.count("strings", MAX_WORDS)
        self._strings = strings.array("<u4", count).tolist()
        self._fields = self._read_fields()
        sets = self._at("FIELDSETS")
        self._sets = (sets.integers(sets.count("fields", MAX_WORDS)) & END).tolist()
        self._paths = self._read_paths()

    def _at(self, section: str) -> Cursor:
        """Return the beginning of a section."""
        if section not in self._places:
            raise damaged()
        return Cursor(self._data, self._places[section])

    def _read_tokens(self) -> list[str]:
        cursor = self._at("TOKENS")
        count = cursor.count("tokens", MAX_WORDS)
        size = cursor.count("bytes", MAX_LETTERS)
        words = cursor.packed(size).split(b"\0")
        if len(words) <= count:
            raise damaged()
        return [word.decode("utf-8", "replace") for word in words[:count]]

    def _read_fields(self) -> list[tuple[str, int]]:
        cursor = self._at("FIELDS")
        count = cursor.count("fields", MAX_WORDS)
        names = cursor.integers(count).tolist()
        values = Cursor(cursor.packed(8 * count)).array("<u8", count)
        return [
            (self._token(name), value) for name, value in zip(names, values.tolist(), strict=True)
        ]

    def _read_paths(self) -> list[_Path | None]:
        """Return all paths; those of what is not read, such as mappers, are None."""
        cursor = self._at("PATHS")
        total = cursor.count("paths", MAX_WORDS)
        count = cursor.count("paths", MAX_WORDS)
        places, words, jumps = (cursor.integers(count).tolist() for _ in range(3))
        paths: list[_Path | None] = [None] * total
        letters = 0
        waiting: list[tuple[int, _Path | None, bool]] = [(0, None, True)] if count else []
        seen = 0
        while waiting:
            at, above, is_root = waiting.pop()
            while True:
                seen += 1
                if not 0 <= at < count or seen > count or not 0 <= places[at] < total:
                    raise damaged()
                path = _Path("/") if is_root else self._below(above, words[at])
                is_root = False
                letters += 0 if path is None else len(path.prim) + len(path.property)
                at_most(letters, MAX_LETTERS, "letters in the paths of its prims")
                paths[places[at]] = path
                jump = jumps[at]
                if jump > 0 or jump == -1:
                    if jump > 0:
                        waiting.append((at + jump, above, False))
                    above = path
                elif jump != 0:
                    break
                at += 1
        return paths

    def _below(self, above: _Path | None, word: int) -> _Path | None:
        """Return the path of a prim, or of a property if the number is negative."""
        name = self._token(abs(word))
        if above is None or above.property or not name or name[0] in "[.":
            return None
        if word < 0:
            return _Path(above.prim, name)
        if name[0] == "{":
            return _Path(f"{above.prim}{name}")
        return _Path(f"{above.prim.rstrip('/')}/{name}")

    def _token(self, number: int) -> str:
        if not 0 <= number < len(self._tokens):
            raise damaged()
        return self._tokens[number]

    def _string(self, number: int) -> str:
        if not 0 <= number < len(self._strings):
            raise damaged()
        return self._token(self._strings[number])

    def _path(self, number: int) -> str:
        if not 0 <= number < len(self._paths):
            raise damaged()
        path = self._paths[number]
        return "" if path is None else str(path)

    def root(self) -> ReadPrim:
        """Return the tree of prims with their properties."""
        cursor = self._at("SPECS")
        count = cursor.count("specs", MAX_WORDS)
        rows = np.column_stack([cursor.integers(count) for _ in range(3)]).tolist()
        root = ReadPrim("def", "", "", "")
        prims, order, properties = {"/": root}, {}, []
        for where, which, kind in rows:
            path = self._paths[where] if 0 <= where < len(self._paths) else None
            if path is None:
                continue
            if kind in (ATTRIBUTE, RELATIONSHIP) and path.property:
                properties.append((path, which))
            elif kind in (PRIM, CHOICE) and not path.property and path.prim != "/":
                at_most(len(prims), MAX_ELEMENTS, "prims")
                said = self._said(which)
                specifier = said.pop("specifier", 0 if kind == PRIM else 1)
                plain = str(path)
                prims[path.prim] = ReadPrim(
                    SPECIFIERS[specifier] if specifier in (0, 1, 2) else "over",
                    str(said.pop("typeName", "")),
                    plain.rpartition("/")[2],
                    plain,
                    said,
                )
                order[path.prim] = said.pop("primChildren", None)
            elif kind == ROOT:
                root.said = self._said(which)
                order["/"] = root.said.pop("primChildren", None)
        for path, which in properties:
            holder = prims.get(path.prim)
            if holder is not None:
                self._put(holder, path.property, self._said(which))
        self._hang(prims, order)
        return root

    @staticmethod
    def _hang(prims: dict[str, ReadPrim], order: dict[str, Any]) -> None:
        """Put all prims into those that hold them, in the order that these say."""
        for path, prim in prims.items():
            at_most(path.count("/") + path.count("{"), MAX_DEPTH, "levels of prims")
            if path.endswith("}"):
                holder, _, choice = path[:-1].rpartition("{")
                name, _, choice = choice.partition("=")
                if holder in prims and choice:
                    prims[holder].variants.setdefault(name, {})[choice] = prim
            elif path != "/":
                above = prims.get(path.rpartition("/")[0] or "/")
                if above is not None:
                    above.children.append(prim)
        for path, prim in prims.items():
            names = order.get(path)
            if isinstance(names, list):
                number = {name: place for place, name in enumerate(names)}
                prim.children.sort(key=lambda one: number.get(one.name, len(number)))

    def _put(self, prim: ReadPrim, name: str, said: dict[str, Any]) -> None:
        """Give a property to a prim as its text would have it."""
        for key in ("default", "targetPaths"):
            if said.get(key) is not None:
                prim.values[name] = said[key]
        for key, ending, kind in (
            ("timeSamples", "timeSamples", tuple), ("connectionPaths", "connect", Target)
        ):  # fmt: skip
            found = said.get(key)
            if isinstance(found, list) and found and all(isinstance(one, kind) for one in found):
                prim.values[f"{name}.{ending}"] = found
        remarks = {
            key: value for key, value in said.items()
            if key not in ("default", "targetPaths", "timeSamples", "connectionPaths")
        }  # fmt: skip
        if remarks:
            prim.remarks[name] = remarks

    def _said(self, first: int) -> dict[str, Any]:
        """Return the fields of a set by their names."""
        said: dict[str, Any] = {}
        while True:
            if not 0 <= first < len(self._sets):
                raise damaged()
            number = self._sets[first]
            if number == END:
                return said
            if number >= len(self._fields):
                raise damaged()
            self._word()
            name, value = self._fields[number]
            said[CALLED.get(name, name)] = self._value(value, 0)
            first += 1

    def _word(self, count: int = 1) -> None:
        """Count objects that are made."""
        self._words += count
        at_most(self._words, MAX_WORDS, "values")

    def _value(self, rep: int, depth: int) -> Any:
        """Return a value as the reader of the text does; None for what is not read."""
        at_most(depth, MAX_DEPTH, "levels of values")
        kind, payload = rep >> 48 & 0xFF, rep & (1 << 48) - 1
        is_array, is_inline, is_packed = (bool(rep >> bit & 1) for bit in (63, 62, 61))
        if is_array:
            return self._array(kind, payload, packed=is_packed)
        if is_inline:
            return self._inline(kind, payload)
        cursor = Cursor(self._data, payload)
        if kind in SCALARS:
            return float(cursor.array(SCALARS[kind], 1)[0])
        if kind in TUPLES:
            dtype, width = TUPLES[kind]
            return _turned(kind, cursor.array(dtype, width)).tolist()
        if kind in LISTED:
            return self._list(cursor, kind)
        if kind == SAMPLES:
            return self._samples(cursor, depth)
        if kind == PAYLOAD:
            return self._reference(cursor, is_payload=True)
        if kind == VARIANTS:
            pairs = range(cursor.count("variants", MAX_ELEMENTS))
            return {self._string(k): self._string(v)
                    for k, v in (cursor.numbers("II") for _ in pairs)}  # fmt: skip
        row: Callable[[int], str] | None = {
            PATHS: self._path, TOKENS: self._token, STRINGS: self._string
        }.get(kind)  # fmt: skip
        if row is not None:
            count = cursor.count("words", MAX_WORDS)
            self._word(count)
            return [row(number) for number in cursor.array("<u4", count).tolist()]
        if kind == DOUBLES:
            return cursor.array("<f8", cursor.count("numbers"))
        return {} if kind == DICTIONARY else None

    def _inline(self, kind: int, payload: int) -> Any:
        """Return a value that stands where others have their place."""
        data = Cursor(payload.to_bytes(6, "little"))
        if kind in SCALARS:
            size = np.dtype(SCALARS[kind]).itemsize
            dtype = SCALARS[kind] if size <= 4 else {"f": "<f4", "i": "<i4", "u": "<u4"}[
                np.dtype(SCALARS[kind]).kind
            ]  # fmt: skip
            return float(data.array(dtype, 1)[0])
        if kind in MATRICES:
            size = MATRICES[kind]
            return np.diag(data.array("i1", size).astype(float)).ravel().tolist()
        if kind in TUPLES:
            return data.array("i1", TUPLES[kind][1]).astype(float).tolist()
        number = payload & END
        if kind == STRING:
            return self._string(number)
        if kind == TOKEN:
            return self._token(number)
        if kind == ASSET:
            return Asset(self._token(number))
        return number if kind == SPECIFIER else None

    def _array(self, kind: int, payload: int, *, packed: bool) -> Any:
        """Return an array: of numbers flat, of words as a list."""
        is_words = kind in (STRING, TOKEN, ASSET)
        if not is_words and kind not in SCALARS and kind not in TUPLES:
            return None
        if payload == 0:
            return [] if is_words else np.zeros(0)
        cursor = Cursor(self._data, payload)
        if self._version < (0, 5):
            cursor.numbers("I")  # how many dimensions: one
        count = int(cursor.numbers("I" if self._version < (0, 7) else "Q")[0])
        if is_words:
            self._word(count)
            read = {STRING: self._string, TOKEN: self._token}.get(kind, self._asset)
            return [read(number) for number in cursor.array("<u4", count).tolist()]
        if kind in TUPLES:
            dtype, width = TUPLES[kind]
            return _turned(kind, cursor.array(dtype, count * width).reshape(-1, width)).ravel()
        dtype = SCALARS[kind]
        kind_of, size = np.dtype(dtype).kind, np.dtype(dtype).itemsize
        if not packed or count < FEWEST_PACKED or size == 1:
            return cursor.array(dtype, count)
        if kind_of != "f":
            found = cursor.integers(count, size)
            return found & END if dtype == "<u4" else found
        way = cursor.take(1)
        if way == b"i":  # whole numbers
            return cursor.integers(count).astype(float)
        if way != b"t":
            raise damaged()
        few = cursor.array(dtype, cursor.numbers("I")[0])
        which = cursor.integers(count)
        if not len(few) or not 0 <= which.min() <= which.max() < len(few):
            raise damaged()
        return few[which]

    def _asset(self, number: int) -> Asset:
        return Asset(self._token(number))

    def _list(self, cursor: Cursor, kind: int) -> list[Any]:
        """Return what a list of changes leaves in it, if it was empty."""
        (head,) = cursor.numbers("B")
        found: list[Any] = []
        for number, bit in enumerate(LISTS):
            if not head & bit:
                continue
            count = cursor.count("items", MAX_WORDS)
            self._word(count)
            items: list[Any]
            if kind in (REFERENCE_LIST, PAYLOAD_LIST):
                payload = kind == PAYLOAD_LIST
                items = [self._reference(cursor, is_payload=payload) for _ in range(count)]
            else:
                rows = cursor.array("<u4", count).tolist()
                read = {TOKEN_LIST: self._token, STRING_LIST: self._string}.get(kind, self._target)
                items = [read(row) for row in rows]
            if number < TAKEN:
                found += items
        return found

    def _target(self, number: int) -> Target:
        return Target(self._path(number))

    def _reference(self, cursor: Cursor, *, is_payload: bool) -> Asset | Target:
        """Return a file and the path of a prim in it; in this file the path alone."""
        name, path = cursor.numbers("II")
        if not is_payload or self._version >= (0, 8):
            cursor.numbers("dd")  # how times are shifted and scaled
        if not is_payload:
            self._pass_dictionary(cursor)
        file, prim = self._string(name), self._path(path)
        return Asset(file, "" if prim == "/" else prim) if file else Target(prim)

    def _pass_dictionary(self, cursor: Cursor) -> None:
        """Go behind a dictionary: names, each with the distance to where its value is told."""
        for _ in range(cursor.count("notes", MAX_ELEMENTS)):
            cursor.numbers("I")
            self._go(cursor)
            cursor.numbers("Q")

    @staticmethod
    def _go(cursor: Cursor) -> None:
        """Go as far as is said here, from here."""
        here = cursor.at
        cursor.at = here + cursor.numbers("q")[0]

    def _samples(self, cursor: Cursor, depth: int) -> list[tuple[float, Any]]:
        """Return values at times, in the order of these."""
        self._go(cursor)
        times: NDArray[Any] = np.asarray(self._value(cursor.numbers("Q")[0], depth + 1), float)
        self._go(cursor)
        count = cursor.count("values at times", MAX_ELEMENTS)
        self._word(count)
        values = cursor.array("<u8", count).tolist()
        if times.ndim != 1 or len(times) != count:
            raise damaged()
        found = [
            (time, self._value(value, depth + 1))
            for time, value in zip(times.tolist(), values, strict=True)
        ]
        return sorted((pair for pair in found if pair[1] is not None), key=lambda pair: pair[0])


def _turned(kind: int, rows: NDArray[Any]) -> NDArray[Any]:
    """Return rows as the text has them: of quaternions, whose real part is the last, it first."""
    return np.roll(rows, 1, axis=-1) if kind in QUATERNIONS else rows
