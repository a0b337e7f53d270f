"""JSON forms of all types that a state may be made of.

One `Form` per type does both ways, so what is accepted for writing is what can be read.
Strokes and arrays do not go into the JSON: they are put aside (`Aside`), and the JSON
refers to them by number. JSON objects whose key starts with ``$`` are such references, or
name the class of a dataclass that stands in a union with others.

No general JSON library is used for this step: they write NaN as null, do not check what
they write, and cannot tell the dataclasses of a union apart.
"""

from __future__ import annotations

import dataclasses
import math
import types
from collections.abc import Hashable
from dataclasses import dataclass
from functools import cache
from itertools import repeat
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from bozzetto.cached_properties import cached_property
from bozzetto.document.storage.side_tables import Aside, Refusal, runs
from bozzetto.document.storage.zip_container import DTYPES, MAX_AXES, all_finite, dtype_name
from bozzetto.errors import words_of
from bozzetto.ink.stroke import Stroke, Strokes
from bozzetto.typed_data import unaliased

MAX_DEPTH: Final = 64
"""Deepest nesting of dataclasses in a state: a tree of parts, not an attack on the stack."""

MAX_INTEGER: Final = 2**63 - 1
"""Largest whole number in a state."""


class Form:
    """Writer and reader of one type.

    Attributes
    ----------
    python, json : tuple of type
        What values look like on the surface, in the state and in JSON. A union chooses
        among its members by that.
    """

    python: tuple[type, ...] = ()
    json: tuple[type, ...] = ()

    def takes(self, value: Any) -> bool:
        """Whether a value of a state looks like this type."""
        return type(value) in self.python

    def reads(self, raw: Any) -> bool:
        """Whether a JSON value looks like this type."""
        return type(raw) in self.json

    def write(self, value: Any, aside: Aside) -> Any:
        """Return the JSON value; strokes and arrays go to side tables. Raises `Refusal`."""
        if not self.takes(value):
            raise Refusal(f"{type(value).__name__} where {self} belongs")
        return self._write(value, aside)

    def read(self, raw: Any, aside: Aside) -> Any:
        """Return the value from its JSON. Raises `Refusal`."""
        if not self.reads(raw):
            raise Refusal(f"JSON {type(raw).__name__} where {self} belongs")
        return self._read(raw, aside)

    def _write(self, value: Any, aside: Aside) -> Any:
        return value

    def _read(self, raw: Any, aside: Aside) -> Any:
        return raw

    def __str__(self) -> str:
        return type(self).__name__.strip("_").lower()


class _Number(Form):
    json = (float, int)

    def takes(self, value: Any) -> bool:
        return isinstance(value, float | int) and not isinstance(value, bool)

    def _write(self, value: Any, aside: Aside) -> Any:
        number = self._read(value, aside)
        if not math.isfinite(number):
            raise Refusal("not a finite number")
        return number

    def _read(self, raw: Any, aside: Aside) -> Any:
        try:
            return float(raw)
        except OverflowError:
            raise Refusal("a number that is too large") from None


class _Integer(Form):
    python = json = (int,)

    def _write(self, value: Any, aside: Aside) -> Any:
        if abs(value) > MAX_INTEGER:
            raise Refusal("a whole number of more than 63 bits")
        return value

    def _read(self, raw: Any, aside: Aside) -> Any:
        return self._write(raw, aside)


class _Switch(Form):
    python = json = (bool,)


class _Nothing(Form):
    python = json = (type(None),)


class _Text(Form):
    python = json = (str,)

    def _write(self, value: Any, aside: Aside) -> Any:
        try:
            value.encode()
        except UnicodeEncodeError:
            raise Refusal("a text with half a character in it") from None
        return value


@dataclass
class _Choice(Form):
    values: tuple[Any, ...]

    def takes(self, value: Any) -> bool:
        return any(type(value) is type(known) and value == known for known in self.values)

    def reads(self, raw: Any) -> bool:
        return self.takes(raw)

    def __str__(self) -> str:
        return f"one of {self.values}"


@dataclass
class _Tuple(Form):
    """``tuple[a, b, c]``, or ``tuple[a, ...]`` where `endless`."""

    forms: tuple[Form, ...]
    endless: bool

    def takes(self, value: Any) -> bool:
        return type(value) is tuple and (self.endless or len(value) == len(self.forms))

    def reads(self, raw: Any) -> bool:
        return type(raw) is list and (self.endless or len(raw) == len(self.forms))

    def _each(self, way: Literal["read", "write"], values: Any, aside: Aside) -> list[Any]:
        made: list[Any] = []
        forms = repeat(self.forms[0], len(values)) if self.endless else self.forms
        try:
            for form, value in zip(forms, values, strict=True):
                made.append(getattr(form, way)(value, aside))
        except Refusal as refusal:
            refusal.where.append(f"[{len(made)}]")
            raise
        return made

    def _write(self, value: Any, aside: Aside) -> Any:
        return self._each("write", value, aside)

    def _read(self, raw: Any, aside: Aside) -> Any:
        return tuple(self._each("read", raw, aside))

    def __str__(self) -> str:
        return "a tuple" if self.endless else f"a tuple of {len(self.forms)}"


@dataclass
class DataclassForm(Form):
    """A frozen dataclass; `tagged` with its name where a union holds several."""

    type: type[Any]
    tagged: bool = False

    json = (dict,)

    @cached_property
    def fields(self) -> dict[str, tuple[Form, bool]]:
        """Form of each field, and whether it may be missing in a file."""
        hints = get_type_hints(self.type, include_extras=True)
        found = {}
        for entry in dataclasses.fields(self.type):
            if entry.init:
                optional = (
                    entry.default is not dataclasses.MISSING
                    or entry.default_factory is not dataclasses.MISSING
                )
                try:
                    found[entry.name] = form_of(hints[entry.name]), optional
                except TypeError as problem:
                    where = f"{self.type.__name__}.{entry.name}"
                    raise TypeError(f"{where}: {words_of(problem)}") from None
        return found

    def takes(self, value: Any) -> bool:
        """Whether a value is of this very class."""
        return type(value) is self.type

    def reads(self, raw: Any) -> bool:
        """Whether a JSON value is an object of this class, by its tag where there is one."""
        return type(raw) is dict and (not self.tagged or raw.get("$type") == self.type.__name__)

    def _write(self, value: Any, aside: Aside) -> Any:
        made: dict[str, Any] = {"$type": self.type.__name__} if self.tagged else {}
        self._descend(aside)
        for name, (form, _) in self.fields.items():
            try:
                made[name] = form.write(getattr(value, name), aside)
            except Refusal as refusal:
                refusal.where.append(f".{name}")
                raise
        aside.depth -= 1
        return made

    def _read(self, raw: Any, aside: Aside) -> Any:
        extra = raw.keys() - self.fields.keys() - ({"$type"} if self.tagged else set())
        if extra:
            raise Refusal(f"unknown fields {', '.join(sorted(extra))}")
        self._descend(aside)
        made = {}
        for name, (form, optional) in self.fields.items():
            try:
                if name in raw:
                    made[name] = form.read(raw[name], aside)
                elif not optional:
                    raise Refusal("missing")
            except Refusal as refusal:
                refusal.where.append(f".{name}")
                raise
        aside.depth -= 1
        try:
            return self.type(**made)
        except Exception as problem:  # __post_init__ is the plugin's code: any fault is a refusal
            raise Refusal(f"{self.type.__name__}: {words_of(problem)}") from problem

    def _descend(self, aside: Aside) -> None:
        aside.depth += 1
        if aside.depth > MAX_DEPTH:
            raise Refusal(f"nested more than {MAX_DEPTH} deep")

    def __str__(self) -> str:
        return self.type.__name__


@dataclass
class _Union(Form):
    members: tuple[Form, ...]

    def takes(self, value: Any) -> bool:
        return any(member.takes(value) for member in self.members)

    def reads(self, raw: Any) -> bool:
        return any(member.reads(raw) for member in self.members)

    def _write(self, value: Any, aside: Aside) -> Any:
        return next(m for m in self.members if m.takes(value)).write(value, aside)

    def _read(self, raw: Any, aside: Aside) -> Any:
        return next(m for m in self.members if m.reads(raw)).read(raw, aside)

    def __str__(self) -> str:
        return " or ".join(map(str, self.members))


class _Reference(Form):
    """Reference into a side table: an object with one key that starts with ``$``."""

    key: str

    def reads(self, raw: Any) -> bool:
        return type(raw) is dict and raw.keys() == {self.key}


class _Stroke(_Reference):
    key = "$stroke"
    python = (Stroke,)

    def _write(self, value: Any, aside: Aside) -> Any:
        return {self.key: aside.put(aside.strokes, value)}

    def _read(self, raw: Any, aside: Aside) -> Any:
        return aside.get(aside.strokes, raw[self.key])


class _Strokes(_Reference):
    key = "$strokes"
    python = (Strokes,)

    def _write(self, value: Any, aside: Aside) -> Any:
        pairs = runs([aside.put(aside.strokes, stroke) for stroke in value])
        aside.name_strokes(len(value))
        return {self.key: pairs}

    def _read(self, raw: Any, aside: Aside) -> Any:
        found: list[Stroke] = []
        for first, count in form_of(tuple[tuple[int, int], ...]).read(raw[self.key], aside):
            if first < 0 or count < 1 or first + count > len(aside.strokes):
                raise Refusal(f"refers to {count} strokes from {first} on")
            aside.name_strokes(count)
            found += aside.strokes[first : first + count]
        return Strokes(found)


@dataclass
class _Array(_Reference):
    """A read-only array; `dtype` is None where the state does not say."""

    dtype: np.dtype[Any] | None

    key = "$array"
    python = (np.ndarray,)

    def _write(self, value: Any, aside: Aside) -> Any:
        self._check(value)
        if not _is_read_only(value):
            raise Refusal("an array that can be written to; use bozzetto.geometry.frozen")
        if not all_finite(value):
            raise Refusal("an array with values that are not finite")
        return {self.key: aside.put(aside.arrays, value)}

    def _read(self, raw: Any, aside: Aside) -> Any:
        array = aside.get(aside.arrays, raw[self.key])
        self._check(array)
        return array

    def _check(self, array: NDArray[Any]) -> None:
        # Not "in (None, …)": numpy holds float64 and None to be equal.
        fits = array.dtype == self.dtype if self.dtype is not None else True
        if array.ndim > MAX_AXES:
            raise Refusal(f"an array of more than {MAX_AXES} axes")
        if dtype_name(array) is None or not fits:
            raise Refusal(f"an array of {array.dtype} where {self.dtype or list(DTYPES)} belongs")


def _is_read_only(array: object) -> bool:
    while isinstance(array, np.ndarray):
        if array.flags.writeable:
            return False
        array = array.base
    return True


_PLAIN: Final[dict[Any, Form]] = {
    float: _Number(),
    int: _Integer(),
    bool: _Switch(),
    str: _Text(),
    type(None): _Nothing(),
    None: _Nothing(),
    Stroke: _Stroke(),
    Strokes: _Strokes(),
}


_KEPT: Final[dict[Any, str]] = {
    list: "tuple[…, ...]",
    set: "tuple[…, ...]",
    frozenset: "tuple[…, ...]",
    dict: "tuple[tuple[…, …], ...]",
}
"""What to write in place of types that can be changed, or have no order."""


def form_of(hint: Any) -> Form:
    """Return the form of a type.

    Raises
    ------
    TypeError
        If values of this type cannot be kept in a document.
    """
    return _made(hint)


@cache
def _made(hint: Hashable) -> Form:
    if hint in _PLAIN:
        return _PLAIN[hint]
    plain = unaliased(hint)
    if plain is not hint:
        return form_of(plain)
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return form_of(arguments[0])
    if origin is Literal:
        return _Choice(arguments)
    if origin is tuple:
        endless = len(arguments) == 2 and arguments[1] is Ellipsis
        kept = arguments[:1] if endless else arguments
        return _Tuple(tuple(form_of(part) for part in kept), endless)
    if origin is np.ndarray:
        return _Array(_dtype_of(arguments[1]))
    if origin in (Union, types.UnionType):
        return _union_of(arguments)
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        if not hint.__dataclass_params__.frozen:  # type: ignore[attr-defined]
            raise TypeError(f"{hint.__name__} is a dataclass that is not frozen")
        return DataclassForm(hint)
    advice = f"; write {_KEPT[origin or hint]}" if (origin or hint) in _KEPT else ""
    raise TypeError(f"{hint} cannot be kept in a document{advice}")


def _union_of(members: tuple[Any, ...]) -> Form:
    forms = tuple(form_of(member) for member in members)
    names = [str(form) for form in forms if isinstance(form, DataclassForm)]
    if len(set(names)) < len(names):
        raise TypeError(f"two classes in a union are called alike: {', '.join(names)}")
    several = len(names) > 1
    return _Union(
        tuple(
            dataclasses.replace(form, tagged=True)
            if several and isinstance(form, DataclassForm)
            else form
            for form in forms
        )
    )


def _dtype_of(hint: Any) -> np.dtype[Any] | None:
    scalar = (get_args(hint) or (Any,))[0]
    if not (isinstance(scalar, type) and issubclass(scalar, np.generic)):
        return None
    dtype = np.dtype(scalar)
    if dtype not in DTYPES.values():
        raise TypeError(f"an array of {dtype} cannot be kept; there are {', '.join(DTYPES)}")
    return dtype
