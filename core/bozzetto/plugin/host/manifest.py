"""The manifest: what a plugin has to offer, read without importing it.

Beside a plugin's ``__init__.py`` lies ``plugin.toml``::

    id = "author.name"
    title = "Ribbon"
    summary = "A stroke becomes a ribbon."
    version = "1.0.0"
    api = ">=2,<3"

    [[modeler]]
    id = "author.ribbon"
    title = "Ribbon"
    icon = "icons/ribbon.svg"
    hint = "Draw a stroke."
    samples = ["samples/wave.json", { file = "samples/knot.json", title = "A knot" }]

Opening the window must not import scipy, and a broken plugin must not break the list.
"""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Final, Literal

import msgspec

from bozzetto.errors import UserError, words_of
from bozzetto.plugin.host.similar_names import meant_by
from bozzetto.typed_data import convert

MANIFEST = "plugin.toml"

LARGEST_MANIFEST = 64 * 1024
"""Bytes; a manifest is a page of text."""

MOST_KEYS = 16
"""Kinds of files that are told by a key."""

MOST_MODELERS = 64
"""Modelers that one plugin may announce."""

MOST_TEMPLATES = 64
"""Templates that one plugin may bring for one modeler."""

Ability = Literal["panel", "read_shapes", "follow", "add_picture", "add_drawing"]
"""What a menu must know of a modeler before its plugin is imported."""

Word = Annotated[str, msgspec.Meta(min_length=1, max_length=80)]
Sentence = Annotated[str, msgspec.Meta(max_length=400)]
Key = Annotated[str, msgspec.Meta(max_length=80)]

ID_PATTERN = r"^[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)+$"
Id = Annotated[str, msgspec.Meta(pattern=ID_PATTERN, max_length=80)]

Side = Literal["front", "back", "left", "right"]
"""A side of what stands upright."""

_REGEX_WORDS = re.compile(r"`str` matching regex '.*'(?= - at )")
ID_IN_WORDS = "an id such as author.name: lower-case letters, digits, “_”, and a dot at least"


class ManifestError(UserError):
    """A manifest that cannot be used; the message names the place and what to write there."""


class Sample(msgspec.Struct, frozen=True):
    """A drawing that comes with a modeler: an ink file, and its name for people."""

    file: Word
    title: Word


class ModelerEntry(msgspec.Struct, frozen=True):
    """One ``[[modeler]]`` of a manifest.

    Attributes
    ----------
    id : str
        "author.name", unique in the program; as on the modeler's class.
    title : str
        Its name for people, said here and nowhere else.
    icon : str
        SVG file in the package: 20 × 20, strokes of 1.5 in ``currentColor``.
    hint : str
        The sheet's first line, for example "Draw a closed outline."
    samples : tuple of Sample
        Ink files in the package, each a file name or ``{ file, title }``.
    abilities : frozenset of str
        What must be known of it before the plugin is imported: "panel" (the plugin has a Qt
        panel of its own for it, `bozzetto_panel`), "read_shapes", "follow", "add_picture" and
        "add_drawing" (methods of `Modeler` that it overrides).
    listed : bool
        Whether a person can choose it; false where models are only made from files.
    order : int
        Place in the row of modelers, small first.
    facts : tuple of str
        The keys by which its files are told from others, a string where there is one: a JSON file
        without strokes that has one of them at the top is read by this modeler, whichever is in
        the hand.
    sides : mapping of str to str
        Where what it makes has its own front, back, left and right: each name stands for the side
        of the world that is called so. Empty where they are the world's.
    replaces : bool
        Whether what it makes of other objects that it follows stands in their place: they are
        hidden then, in the same step.
    """

    id: Id
    title: Word
    icon: Word
    hint: Sentence
    samples: tuple[Sample, ...] = ()
    abilities: frozenset[Ability] = frozenset()
    listed: bool = True
    order: int = 50
    facts: Annotated[tuple[Key, ...], msgspec.Meta(max_length=MOST_KEYS)] = ()
    sides: dict[Side, Side] = {}
    replaces: bool = False


class Manifest(msgspec.Struct, frozen=True):
    """Content of a ``plugin.toml``.

    Attributes
    ----------
    id : str
        "author.name", unique in the program.
    title, version : str
        For the list of plugins.
    api : str
        Versions of the contract that the plugin was written for, such as ">=2,<3".
    modelers : tuple of ModelerEntry
        Each a table ``[[modeler]]``; a plugin that brings templates alone has none.
    templates : mapping of str to tuple of str
        The table ``[templates]``: files in the package with which models of a modeler, its own or
        another plugin's, can begin, by the id of the modeler.
    summary : str
        One sentence for the list of plugins.
    checks_files : bool
        Whether it says what is wrong with files of a kind of its own (`bozzetto_faults`).
    warnings : tuple of str
        What was ignored; not a key of the file.
    """

    id: Id
    title: Word
    version: Word
    api: Word
    modelers: Annotated[tuple[ModelerEntry, ...], msgspec.Meta(max_length=MOST_MODELERS)] = (
        msgspec.field(name="modeler", default=())
    )
    templates: dict[
        Id, Annotated[tuple[Word, ...], msgspec.Meta(min_length=1, max_length=MOST_TEMPLATES)]
    ] = {}
    summary: Sentence = ""
    checks_files: bool = False
    warnings: tuple[str, ...] = ()


KEYS: Final = tuple(key for key in Manifest.__struct_encode_fields__ if key != "warnings")
MODELER: Final = "modeler"
"""The key of the tables of modelers."""


def find_folder(package: str) -> Path:
    """Find the folder of a top-level package without importing it.

    Raises
    ------
    ManifestError
        If there is no such package, or no manifest in it.
    """
    if not package.isidentifier():
        raise ManifestError(
            f"{package!r} is not the name of a top-level package. Write the import name of the "
            "package that holds plugin.toml, such as bozzetto_ribbon; this is also the value of "
            "the entry point."
        )
    spec = importlib.util.find_spec(package)
    if spec is None:
        raise ManifestError(f"There is no package {package!r}. Install it, or correct its name.")
    for place in spec.submodule_search_locations or ():
        if (Path(place) / MANIFEST).is_file():
            return Path(place)
    raise ManifestError(
        f"The package {package!r} has no {MANIFEST}. Put one beside its __init__.py, and see "
        "that it is packed into the wheel."
    )


def read_manifest(folder: Path) -> Manifest:
    """Read and check the manifest in a package's folder.

    Raises
    ------
    ManifestError
        If it cannot be read, or something in it is missing or wrong.
    """
    path = folder / MANIFEST
    try:
        if path.stat().st_size > LARGEST_MANIFEST:
            raise ManifestError(f"{MANIFEST} is larger than {LARGEST_MANIFEST} bytes. Shorten it.")
        said = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise ManifestError(f"{MANIFEST} cannot be read: {problem.strerror}.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as problem:
        raise ManifestError(f"{MANIFEST} is not valid TOML: {words_of(problem)}.") from None
    warnings = tuple(_unknown_keys(said))
    known = {key: said[key] for key in KEYS if key in said}
    if isinstance(tables := known.get(MODELER), list):
        known[MODELER] = [_in_full(each) if isinstance(each, dict) else each for each in tables]
    try:
        manifest: Manifest = convert(known | {"warnings": warnings}, Manifest)
    except msgspec.ValidationError as problem:
        words = _REGEX_WORDS.sub(ID_IN_WORDS, words_of(problem))
        ignored = "".join(f" {told}" for told in warnings)
        raise ManifestError(f"In {MANIFEST}: {words}.{ignored}") from None
    api_accepts(manifest.api, (0, 0))  # a range that cannot be read is refused here
    if not manifest.modelers and not manifest.templates:
        raise ManifestError(
            f"In {MANIFEST}: there is neither a [[modeler]] nor [templates]. Announce one of them."
        )
    for file in (file for files in manifest.templates.values() for file in files):
        _check_inside(file, "template", (".json",))
    ids = [modeler.id for modeler in manifest.modelers]
    for modeler in manifest.modelers:
        if ids.count(modeler.id) > 1:
            raise ManifestError(f"In {MANIFEST}: two modelers have the id {modeler.id!r}.")
        _check_modeler(modeler)
    return manifest


def _in_full(table: dict[str, Any]) -> dict[str, Any]:
    """Return a table of a modeler with what is written shortly in full."""
    full = dict(table)
    if isinstance(samples := full.get("samples"), list):
        full["samples"] = [
            {"file": each, "title": PurePosixPath(each).stem} if isinstance(each, str) else each
            for each in samples
        ]
    if isinstance(keys := full.get("facts"), str | list):
        full["facts"] = [key for key in ([keys] if isinstance(keys, str) else keys) if key != ""]
    return full


def _check_modeler(entry: ModelerEntry) -> None:
    """Refuse what only several values together show to be wrong."""
    for sample in entry.samples:
        _check_inside(sample.file, "sample", (".json", ".svg", ".inkml"))
    _check_inside(entry.icon, "icon", (".svg",))
    if entry.sides and set(entry.sides) != set(entry.sides.values()):
        raise ManifestError(
            f"In {MANIFEST}: the sides of {entry.id} exchange {', '.join(entry.sides)} for others. "
            "Name each side once on the left and once on the right."
        )


def _check_inside(name: str, what: str, endings: tuple[str, ...]) -> None:
    """Refuse file names that lead out of the package."""
    path = PurePosixPath(name)
    outside = path.is_absolute() or ".." in path.parts or "\\" in name or ":" in name
    if outside or path.suffix not in endings:
        raise ManifestError(
            f"In {MANIFEST}: the {what} {name!r} must be a file inside the package that ends "
            f"with {' or '.join(endings)}."
        )


def _unknown_keys(said: dict[str, Any]) -> list[str]:
    """Return warnings about keys that mean nothing to this version."""
    tables = [(said, KEYS, "")]
    modelers = said.get(MODELER)
    for modeler in modelers if isinstance(modelers, list) else ():
        if isinstance(modeler, dict):
            of = f" of modeler {modeler.get('id', '')}".rstrip()
            tables.append((modeler, ModelerEntry.__struct_fields__, of))
    warnings = []
    for table, fields, of in tables:
        for key in (key for key in table if key not in fields):
            meant = meant_by(key, fields)
            hint = f" It looks like “{meant}”." if meant and meant not in table else ""
            warnings.append(f"{MANIFEST}: “{key}”{of} is not known and was ignored.{hint}")
    return warnings


_COMPARISON = re.compile(r"\s*(>=|<=|==|>|<)\s*(\d{1,6})(?:\.(\d{1,6}))?\s*")


def api_accepts(wanted: str, version: tuple[int, int]) -> bool:
    """Whether a version lies in a range such as ">=2,<3" or ">=2.1,<3".

    Raises
    ------
    ManifestError
        If the range cannot be read.
    """
    accepted = True
    for part in wanted.split(","):
        match = _COMPARISON.fullmatch(part)
        if match is None:
            raise ManifestError(
                f'In {MANIFEST}: api = "{wanted}" is not a range of versions. '
                'Write for example api = ">=2,<3".'
            )
        sign, major, minor = match.groups()
        bound = (int(major), int(minor or 0))
        accepted &= {
            ">=": version >= bound,
            "<=": version <= bound,
            ">": version > bound,
            "<": version < bound,
            "==": version == bound,
        }[sign]
    return accepted
