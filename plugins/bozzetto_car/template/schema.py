"""The schema of a template's file: strict JSON, with limits.

A file is not trusted. Unknown and repeated keys are refused, numbers are finite and within limits,
texts are short, and there are no more entries than a large template needs. Every message names the
key.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Final

import msgspec
from msgspec import Meta

from bozzetto.errors import FormatError, words_of
from bozzetto.typed_data import convert
from bozzetto_car.template.model import InsetKind

FORMAT: Final = "bozzetto-car-template/1"

LARGEST_FILE: Final = 1 << 20
"""Largest file, bytes; a template is some pages of text."""

MOST_INSETS: Final = 40
"""Most lamps and grilles of one half."""

MOST_ITEMS: Final = 400
"""Most nodes, edges, patches, chains or rules of one half: ten times those of a sedan."""

FARTHEST: Final = 100_000.0
"""Largest coordinate or tangent, mm: a hundred metres hold any vehicle on a road."""

Length = Annotated[float, Meta(ge=-FARTHEST, le=FARTHEST)]
Vector = tuple[Length, Length, Length]
Text = Annotated[str, Meta(min_length=1, max_length=200)]

_NAME: Final = r"\A[A-Z][A-Z0-9]{0,7}\Z"
_LABEL: Final = r"\A[a-z][a-z0-9_]{0,39}\Z"
_IN_WORDS: Final = {
    _NAME: "a name such as S1 (a capital letter, then capital letters and digits, up to eight)",
    _LABEL: "a word such as roof_rail (lower-case letters, digits and “_”, up to forty)",
}
"""The meaning of the patterns in words, for messages."""

Name = Annotated[str, Meta(pattern=_NAME)]
Label = Annotated[str, Meta(pattern=_LABEL)]
Names = Annotated[list[Name], Meta(min_length=2, max_length=MOST_ITEMS)]


class PictureRecord(msgspec.Struct, forbid_unknown_fields=True):
    """The direction from which a node is seen best; a `ViewHint` of the right half."""

    azimuth: Annotated[float, Meta(ge=-180, le=180)]
    elevation: Annotated[float, Meta(ge=-90, le=90)]
    patches: Annotated[list[Label], Meta(max_length=8)] = []


class NodeRecord(msgspec.Struct, forbid_unknown_fields=True):
    """A node of the right half or the middle."""

    at: Vector
    title: Text
    prompt: Text
    picture: PictureRecord


class ChainRecord(msgspec.Struct, forbid_unknown_fields=True):
    """A chain of the right half, or along or across the middle."""

    nodes: Names
    smooth: Annotated[list[Name], Meta(min_length=1, max_length=MOST_ITEMS)]


Share = Annotated[float, Meta(ge=0.0, le=1.0)]


class InsetRecord(msgspec.Struct, forbid_unknown_fields=True):
    """A lamp or a grille in a patch of the right half, between places along its sides."""

    patch: Label
    kind: InsetKind
    u: tuple[Share, Share]
    v: tuple[Share, Share]


class Records(msgspec.Struct, forbid_unknown_fields=True):
    """All records of a file."""

    format: str
    id: Label
    title: Text
    about: Text
    centre: dict[Name, NodeRecord]
    pairs: dict[Name, NodeRecord]
    wheels: dict[Name, NodeRecord]
    edges: dict[Text, tuple[Vector, Vector]]
    patches: dict[Label, tuple[Name, Name, Name, Name]]
    chains: dict[Label, ChainRecord]
    soundness: dict[Text, Text]
    order: Annotated[list[Text], Meta(max_length=2 * MOST_ITEMS)]
    glass: Annotated[list[Label], Meta(max_length=MOST_ITEMS)] = []
    insets: Annotated[dict[Label, InsetRecord], Meta(max_length=MOST_INSETS)] = {}
    shut_lines: Annotated[list[Text], Meta(max_length=MOST_ITEMS)] = []
    creases: Annotated[list[Text], Meta(max_length=MOST_ITEMS)] | None = None


_SECTIONS: Final[Mapping[str, tuple[Any, Any]]] = {
    "centre": (Name, NodeRecord),
    "pairs": (Name, NodeRecord),
    "wheels": (Name, NodeRecord),
    "edges": (Text, tuple[Vector, Vector]),
    "patches": (Label, tuple[Name, Name, Name, Name]),
    "chains": (Label, ChainRecord),
    "soundness": (Text, Text),
    "insets": (Label, InsetRecord),
}
"""The objects of a file: types of their keys and values, to read them entry by entry."""


def read_records(data: bytes) -> Records:
    """Read the records of a file.

    Parameters
    ----------
    data : bytes
        JSON, UTF-8.

    Raises
    ------
    FormatError
        If a key is wrong; the message names it.
    """
    top = _parsed(data)
    if top.get("format") != FORMAT:
        raise FormatError(f"This is not a car template: “format” must be “{FORMAT}”.")
    optional = len(Records.__struct_defaults__)
    for key in Records.__struct_fields__[:-optional]:
        if key not in top:
            raise FormatError(f"“{key}” is missing from the template.")
    for key, (names, values) in _SECTIONS.items():
        if key in top:
            _check_section(top[key], key, names, values)
    records: Records = _as(top, Records, "the template")
    return records


def _parsed(data: bytes) -> dict[str, Any]:
    if len(data) > LARGEST_FILE:
        raise FormatError(f"The template is larger than {LARGEST_FILE:,} bytes. Shorten it.")
    try:
        top = json.loads(
            data.decode("utf-8-sig"), object_pairs_hook=_unique, parse_constant=_no_number
        )
    except UnicodeDecodeError:
        raise FormatError("The template is not UTF-8 text. Save it as such.") from None
    except RecursionError:
        raise FormatError("The template is nested too deeply.") from None
    except ValueError as problem:
        raise FormatError(f"The template is not valid JSON: {words_of(problem)}.") from None
    if not isinstance(top, dict):
        raise FormatError("The template is not a JSON object.")
    return top


def _unique(members: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    made = dict(members)
    if len(made) < len(members):
        keys = [key for key, _ in members]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise FormatError(f"“{twice[:40]}” stands twice in one object. Keep one of them.")
    return made


def _no_number(word: str) -> float:
    raise FormatError(f"{word} is not a number in JSON. Write a finite number.")


def _check_section(value: Any, key: str, names: Any, values: Any) -> None:
    """Refuse a section and name the entry, which msgspec by itself does not."""
    if not isinstance(value, dict):
        raise FormatError(f"{key}: an object belongs here.")
    if len(value) > MOST_ITEMS:
        raise FormatError(f"{key}: {len(value)} entries are more than the {MOST_ITEMS} allowed.")
    for name, entry in value.items():
        _as(name, names, f"{key}, the name “{name[:40]}”")
        _as(entry, values, f"{key}, {name[:40]}")


def _as(value: Any, kind: Any, place: str) -> Any:
    try:
        return convert(value, kind)
    except msgspec.ValidationError as problem:
        words = words_of(problem)
        for pattern, meaning in _IN_WORDS.items():
            words = words.replace(f"`str` matching regex {pattern!r}", meaning)
        raise FormatError(f"{place}: {words}.") from None
