"""Read templates from files, complete both halves, and provide the bundled ones.

A file (``bozzetto-car-template/1``, see `docs/car.md`) holds the right half of a car and its
middle. The left half is made here by changing the sign of y, so a template from a file is symmetric
to the last bit. No template is used before `validation.check` has found it sound.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Final, Literal, get_args

import numpy as np

from bozzetto.errors import FormatError
from bozzetto_car.template.model import (
    MIRROR,
    Chain,
    Inset,
    Patch,
    Rule,
    Template,
    ViewHint,
    twin,
)
from bozzetto_car.template.rules import parse_rule
from bozzetto_car.template.schema import (
    LARGEST_FILE,
    PictureRecord,
    Records,
    Vector,
    read_records,
)
from bozzetto_car.template.smooth_edges import smooth_by_chains
from bozzetto_car.template.validation import check, undeclared_creases

Bundled = Literal[
    "sedan", "hatchback", "minivan", "estate", "coupe", "limousine", "city_car", "suv", "van",
    "pickup",
]  # fmt: skip

TEMPLATES: Final[tuple[Bundled, ...]] = get_args(Bundled)
"""The templates that come with the modeler."""

PAPER_TEMPLATES: Final = TEMPLATES[:3]
"""Those of Kara & Shimada (2008), laid out by hand; the others are shaped from them."""

FORMAT_WORD: Final = b'"bozzetto-car-template/'
"""A text that stands in every template file."""

BESIDE_EDGE: Final = 0.02
"""Least distance of a lamp or a grille from the sides of its patch and from others, in u and v."""

NARROWEST_INSET: Final = 0.02
"""Least width of one, in u and v."""

MOST_FAULTS: Final = 3
"""Number of faults of the network that a message names; the others mostly follow from them."""


@lru_cache
def bundled(name: str) -> Template:
    """Return one of the bundled templates.

    Raises
    ------
    FormatError
        If there is no template of that name.
    """
    return read_template(bundled_file(name))


def bundled_file(name: str) -> bytes:
    """Return the file of one of the bundled templates.

    Raises
    ------
    FormatError
        If there is no template of that name.
    """
    if name not in TEMPLATES:
        there = ", ".join(TEMPLATES)
        raise FormatError(f"There is no template “{name[:40]}”. Choose one of: {there}.")
    return files("bozzetto_car").joinpath(f"templates/{name}.json").read_bytes()


@lru_cache
def bundled_title(name: str) -> str:
    """Return the title of one of the bundled templates, without reading and checking the rest.

    Raises
    ------
    FormatError
        If there is no template of that name.
    """
    return str(json.loads(bundled_file(name))["title"])


def read_template(data: bytes) -> Template:
    """Read a template and check it.

    Parameters
    ----------
    data : bytes
        JSON, UTF-8.

    Raises
    ------
    FormatError
        If a key is wrong, or the network is not that of a car; the message says which or why.
    """
    records = read_records(data)
    template = _Whole(records).template()
    faults = _faults(records, template)
    if faults:
        first = " ".join(faults[:MOST_FAULTS])
        more = len(faults) - MOST_FAULTS
        raise FormatError(
            f"The template “{template.title}” cannot be used. {first}"
            + (f" There are {more} more faults." if more > 0 else "")
        )
    return template


def is_template(path: Path) -> bool:
    """Whether a file declares itself a template, of this version or a later one."""
    return FORMAT_WORD in _content(path)


def faults_in(path: Path) -> list[str]:
    """Return everything that is wrong with a template's file, for its author.

    Returns
    -------
    list of str
        One sentence where the file cannot be read at all, otherwise one for each fault;
        empty for a template that can be used.
    """
    try:
        records = read_records(_content(path))
        return _faults(records, _Whole(records).template())
    except FormatError as problem:
        return [problem.message]


def _faults(records: Records, template: Template) -> list[str]:
    """Return what is wrong with a template, and with its creases if it has declared any."""
    faults = check(template)
    return faults or ([] if records.creases is None else undeclared_creases(template))


def _content(path: Path) -> bytes:
    """Return the content of a file; of one that is too large only so much that this shows."""
    try:
        with path.open("rb") as file:
            return file.read(LARGEST_FILE + 1)
    except OSError as problem:
        raise FormatError(f"{path.name} cannot be read: {problem.strerror}.") from None


class _Whole:
    """Both halves of the car of which a file holds one."""

    def __init__(self, records: Records) -> None:
        self.records = records
        self.halves: dict[str, str] = {name: name for name in records.centre}
        for name in (*records.pairs, *records.wheels):
            if name in self.halves:
                raise FormatError(f"{name} stands in two of centre, pairs and wheels.")
            self.halves[name] = f"{name}.R"
        if len(records.wheels) != 2:
            raise FormatError("wheels: a template has two entries here, front and rear.")
        self.names = [
            full for half in self.halves.values() for full in dict.fromkeys((half, twin(half)))
        ]
        self.node = {name: number for number, name in enumerate(self.names)}
        self.edges: list[tuple[int, int]] = []
        self.tangents: list[tuple[Vector, Vector]] = []
        self.between: dict[tuple[int, int], int] = {}

    def template(self) -> Template:
        """Assemble the template.

        Raises
        ------
        FormatError
            If the file refers to something that it does not define.
        """
        given = self.records
        nodes = {**given.centre, **given.pairs, **given.wheels}
        records = {self.halves[name]: record for name, record in nodes.items()}
        positions = np.array(
            [
                np.asarray(records[name].at)
                if name in records
                else np.asarray(records[twin(name)].at) * MIRROR
                for name in self.names
            ]
        )
        self._read_edges()
        records_by_name = {name: records.get(name) or records[twin(name)] for name in self.names}
        right = [self.node[name] for name in self.names if name.endswith(".R")]
        left = [self.node[twin(self.names[number])] for number in right]
        patches = self._patches()
        template = Template(
            id=given.id,
            title=given.title,
            about=given.about,
            names=tuple(self.names),
            positions=positions,
            pairs=np.stack((right, left), axis=1),
            centre=np.array([self.node[name] for name in self.records.centre], np.intp),
            wheels=np.array(
                [(self.node[f"{name}.R"], self.node[f"{name}.L"]) for name in self.records.wheels]
            ),
            edges=np.array(self.edges),
            tangents=np.array(self.tangents),
            patches=patches,
            chains=self._chains(),
            rules=self._rules(),
            order=tuple(self._order()),
            titles={name: record.title for name, record in records_by_name.items()},
            prompts={name: record.prompt for name, record in records_by_name.items()},
            pictures={name: _view_hint(records_by_name[name].picture, name) for name in self.names},
            insets=self._insets(patches),
            shut_lines=tuple(self._shut_lines()),
        )
        return replace(template, creases=self._creases(template))

    def _number(self, name: str, place: str) -> int:
        """Return the index of a node of the right half or the centre."""
        if name not in self.halves:
            raise FormatError(f"{place}: there is no node {name}.")
        return self.node[self.halves[name]]

    def _image(self, number: int) -> int:
        return self.node[twin(self.names[number])]

    def _read_edges(self) -> None:
        given: list[tuple[int, int, tuple[Vector, Vector]]] = []
        for key, tangents in self.records.edges.items():
            place = f"edges, {key[:40]}"
            ends = key.split("-")
            if len(ends) != 2 or ends[0] == ends[1]:
                raise FormatError(f"{place}: an edge is called by its two ends, as in C0-C1.")
            first, last = (self._number(end, place) for end in ends)
            given.append((first, last, tangents))
        for start, end, (out, into) in given:
            self._add_edge(start, end, (out, into))
        for start, end, (out, into) in given:
            image = self._image(start), self._image(end)
            if image != (start, end):
                self._add_edge(*image, (_reflected(out), _reflected(into)))

    def _add_edge(self, start: int, end: int, tangents: tuple[Vector, Vector]) -> None:
        if (start, end) in self.between:
            a, b = self.names[start], self.names[end]
            raise FormatError(f"edges: there are two edges between {a} and {b}. Keep one.")
        self.between[start, end] = len(self.edges)
        self.between[end, start] = ~len(self.edges)
        self.edges.append((start, end))
        self.tangents.append(tangents)

    def _edge(self, start: int, end: int, place: str) -> int:
        if (start, end) not in self.between:
            a, b = self.names[start], self.names[end]
            raise FormatError(f"{place}: there is no edge between {a} and {b}. Add it to edges.")
        return self.between[start, end]

    def _patches(self) -> tuple[Patch, ...]:
        made: list[Patch] = []
        mirrored: list[Patch] = []
        for key in self.records.glass:
            if key not in self.records.patches:
                raise FormatError(f"glass: there is no patch {key}.")
        for key, corners in self.records.patches.items():
            place = f"patches, {key}"
            loop = [self._number(name, place) for name in corners]
            made.append(self._patch(f"{key}.R", loop, place))
            # Reversed, so that the image, too, runs anticlockwise seen from outside.
            image = [self._image(number) for number in (loop[0], *loop[:0:-1])]
            mirrored.append(self._patch(f"{key}.L", image, place))
        return (*made, *mirrored)

    def _patch(self, name: str, loop: Sequence[int], place: str) -> Patch:
        sides = zip(loop, (*loop[1:], loop[0]), strict=True)
        a, b, c, d = (self._edge(start, end, place) for start, end in sides)
        n0, n1, n2, n3 = loop
        glass = name[:-2] in self.records.glass
        return Patch(name, (a, b, c, d), (n0, n1, n2, n3), glass)

    def _insets(self, patches: Sequence[Patch]) -> tuple[Inset, ...]:
        """Return lamps and grilles, each within one patch and beside all others.

        Raises
        ------
        FormatError
            If one lies in no patch, in a window, over an edge or over another one.
        """
        known = {patch.name: patch for patch in patches}
        middle = {self.node[name] for name in self.records.centre}
        made: list[Inset] = []
        for key, record in self.records.insets.items():
            place = f"insets, {key}"
            patch = known.get(f"{record.patch}.R")
            if patch is None or patch.glass:
                raise FormatError(f"{place}: there is no patch {record.patch} without a window.")
            inner = {side for side in range(4) if self._is_inner(patch, side, middle)}
            box = record.u, record.v
            for (low, high), sides in zip(box, ((3, 1), (0, 2)), strict=True):
                if not high - low >= NARROWEST_INSET:
                    raise FormatError(f"{place}: it has no size. Give the smaller number first.")
                for at, side in ((low, sides[0]), (1.0 - high, sides[1])):
                    if at < BESIDE_EDGE and not (at == 0.0 and side in inner):
                        raise FormatError(
                            f"{place}: it reaches over an edge of the patch. Stay {BESIDE_EDGE} "
                            "away, but for a side in the middle of the car, which it may reach."
                        )
            whole = Inset(key, patch.name, record.kind, box)
            if [at for ends in box for at in ends if at in (0.0, 1.0)][1:]:
                raise FormatError(f"{place}: it reaches two sides of the patch.")
            for other in made:
                if other.patch == whole.patch and _overlap(other, whole):
                    raise FormatError(f"{place}: it lies over {other.name}. Move one of them.")
            made.append(whole)
        return tuple(made)

    def _shut_lines(self) -> Iterator[int]:
        for key in self.records.shut_lines:
            place = f"shut_lines, {key[:40]}"
            start, _, end = key.partition("-")
            edge = self._edge(self._number(start, place), self._number(end, place), place)
            yield max(edge, ~edge)

    def _creases(self, template: Template) -> frozenset[int]:
        """Return the creases of both halves; if none are declared, where lines do not run on.

        Raises
        ------
        FormatError
            If one is no edge between two patches.
        """
        inner = frozenset(range(len(template.edges))) - template.rim
        if self.records.creases is None:
            return inner - smooth_by_chains(template)
        found = set()
        for key in self.records.creases:
            place = f"creases, {key[:40]}"
            start, _, end = key.partition("-")
            nodes = self._number(start, place), self._number(end, place)
            for ends in (nodes, (self._image(nodes[0]), self._image(nodes[1]))):
                edge = self._edge(*ends, place)
                found.add(max(edge, ~edge))
        if not found <= inner:
            raise FormatError("creases: an edge at the lower rim has no crease. Leave it out.")
        return frozenset(found)

    def _is_inner(self, patch: Patch, side: int, middle: set[int]) -> bool:
        return {patch.nodes[side], patch.nodes[(side + 1) % 4]} <= middle

    def _chains(self) -> tuple[Chain, ...]:
        made = []
        for key, record in self.records.chains.items():
            place = f"chains, {key}"
            nodes = [self._number(name, place) for name in record.nodes]
            smooth = [self._number(name, place) for name in record.smooth]
            image = [self._image(number) for number in nodes]
            if nodes[0] in smooth and nodes[0] == image[0]:
                # Smooth in the middle of the car: the line crosses to the other side.
                made.append(self._chain(key, [*image[:0:-1], *nodes], smooth, place))
            elif image == nodes:
                made.append(self._chain(key, nodes, smooth, place))
            else:
                made.append(self._chain(f"{key}.R", nodes, smooth, place))
                other = [self._image(number) for number in smooth]
                made.append(self._chain(f"{key}.L", image, other, place))
        return tuple(made)

    def _chain(self, name: str, nodes: list[int], smooth: list[int], place: str) -> Chain:
        edges = tuple(self._edge(start, end, place) for start, end in pairwise(nodes))
        return Chain(name, tuple(nodes), edges, tuple(smooth))

    def _rules(self) -> tuple[Rule, ...]:
        nodes = {half: self.node[name] for half, name in self.halves.items()}
        texts = self.records.soundness.items()
        return tuple(parse_rule(name, text, nodes) for name, text in texts)

    def _order(self) -> list[str]:
        for word in self.records.order:
            name = word.partition(".")[0]
            if name not in self.halves:
                raise FormatError(f"order: there is no node {name[:40]}.")
            paired = self.halves[name] != name
            if word not in ((f"{name}.near", f"{name}.far") if paired else (name,)):
                raise FormatError(
                    f"order: “{word[:40]}” should be {name} for a node in the middle, and "
                    f"{name}.near or {name}.far for one of a pair."
                )
        return self.records.order


def _reflected(vector: Vector) -> Vector:
    """Return the mirror image of a vector; -0.0 becomes 0.0, so that equal halves compare equal."""
    return vector[0], 0.0 - vector[1], vector[2]


def _overlap(one: Inset, other: Inset) -> bool:
    """Whether two insets of one patch lie over or too close to each other."""
    pairs = zip(one.box, other.box, strict=True)
    return all(a[0] < b[1] + BESIDE_EDGE and b[0] < a[1] + BESIDE_EDGE for a, b in pairs)


def _view_hint(record: PictureRecord, name: str) -> ViewHint:
    """Return the view hint of a node: for its own side of the car, or for both halves."""
    sides = (name[-2:],) if name.endswith((".R", ".L")) else (".R", ".L")
    turn = -record.azimuth if sides == (".L",) else record.azimuth
    tinted = tuple(f"{patch}{side}" for patch in record.patches for side in sides)
    return ViewHint(turn, record.elevation, tinted)
