"""Wavefront OBJ, read: text, polygons, objects and groups; colours as ``v x y z r g b``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Flags
from bozzetto.errors import FormatError
from bozzetto.exchange.color import WHITE
from bozzetto.exchange.limits import MAX_FACES, MAX_PARTS, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.obj_materials import PLAIN, Look, materials_of
from bozzetto.exchange.mesh.obj_writer import files_beside as files_beside
from bozzetto.exchange.mesh.obj_writer import write_shapes as write_shapes
from bozzetto.exchange.mesh.polygons import (
    check_places,
    checked_mesh,
    is_degenerate,
    triangulate,
)
from bozzetto.exchange.mesh.stacked_pictures import Pictures
from bozzetto.exchange.mesh.text_words import checked_text
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.shapes import FaceGroup, Shapes, Surface

BELONGS: Final = {b"o": "part", b"g": "group", b"usemtl": "material"}
"""Words after which faces belong to something else, and to what."""

THIN: Final = frozenset((b"l", b"p", b"curv", b"curv2", b"surf"))
"""Words of what has no faces of its own."""

MAX_REPEATS: Final = 1e6
"""How often a picture may be repeated on its way to a triangle."""

MAX_NAME: Final = 200
"""Bytes of a name."""

MAX_LINES: Final = 6_000_000
"""Limit of lines: as objects a quarter of a gigabyte; 64 MB of usual lines are two million."""


class _Face(NamedTuple):
    """Where a face belongs."""

    part: str
    group: str
    material: str


@dataclass
class _Table:
    """The rows of a file, as they stand in it.

    Attributes
    ----------
    vertices, texels : list of list of bytes
        Words of the vertices, and of the places in pictures.
    corners : list of int
        Vertices of the corners of all faces.
    texel_of : list of int
        The place in a picture of each corner; -1 where there is none.
    sizes : list of int
        How many corners each face has.
    begins : list of (int, _Face)
        Faces from a number on belong there.
    libraries : list of str
        Names of the files of materials.
    thin : int
        Rows of what has no faces.
    """

    vertices: list[list[bytes]] = field(default_factory=list)
    texels: list[list[bytes]] = field(default_factory=list)
    corners: list[int] = field(default_factory=list)
    texel_of: list[int] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)
    begins: list[tuple[int, _Face]] = field(default_factory=list)
    libraries: list[str] = field(default_factory=list)
    thin: int = 0

    def add_face(self, words: list[bytes]) -> None:
        """Add a face of corners such as ``4/2/1``; raises ValueError where they make no sense."""
        before = len(self.vertices)
        for word in words:
            first, _, rest = word.partition(b"/")
            index = int(first)
            self.corners.append(index - 1 if index > 0 else before + index)
            if index == 0 or -index > before:
                raise ValueError
            texel = rest.partition(b"/")[0]
            place = int(texel) if texel else 0
            self.texel_of.append(place - 1 if place >= 0 else max(len(self.texels) + place, -1))
        self.sizes.append(len(words))


def read_shapes(data: bytes, reading: Reading | None = None) -> Shapes:
    """Read the polygons of an OBJ file: a part for each object, groups and materials within it.

    Normals are passed over; lines, points and free-form curves are told; negative indices count
    back from the last vertex before them. Pictures lie beside the file, as its materials do.

    Parameters
    ----------
    data : bytes
        The file.
    reading : Reading, optional
        Where its materials lie, and what is told.
    """
    reading = reading or Reading()
    table = _table_of(checked_text(data))
    places, colors = _columns(table.vertices)
    rings = _rings(table, len(places))
    check_places(places)
    if table.thin:
        reading.tell(
            f"Left out of the OBJ file: {table.thin} {'line' if table.thin == 1 else 'lines'}, "
            "points or free-form curves; save curves as SVG to draw with them."
        )
    looks = materials_of(table.libraries, reading)
    counts = np.array(table.sizes, np.int64)
    owners, kinds = _owners(table.begins, len(counts))
    at_most(len(kinds), MAX_PARTS, "parts and groups")
    shown = _shown(table, looks, reading)
    if shown is None:
        cut = triangulate(places, rings, counts)
        where = np.zeros((len(cut), 0), np.int64)
    else:  # by corners, whose places in pictures differ where their vertices do not
        corner = triangulate(places[rings], np.arange(len(rings)), counts)
        cut, where = rings[corner].astype(np.int32), np.array(table.texel_of, np.int64)[corner]
    owner = np.repeat(owners, np.maximum(counts - 2, 0))
    proper = ~is_degenerate(cut)
    cut, owner, where = cut[proper], owner[proper], where[proper]
    order = np.argsort(owner, kind="stable")
    bounds = np.searchsorted(owner[order], np.arange(len(kinds) + 1))
    numbers_of: dict[str, list[int]] = {}
    for number, kind in enumerate(kinds):
        numbers_of.setdefault(kind.part, []).append(number)
    surfaces = []
    for name, numbers in numbers_of.items():
        rows = [order[bounds[k] : bounds[k + 1]] for k in numbers]
        owned = [(kinds[k], len(row)) for k, row in zip(numbers, rows, strict=True)]
        chosen = np.concatenate(rows)
        if not len(chosen):
            continue
        groups = [_group(kind, count, looks) for kind, count in owned if count]
        part = _part(name, places, colors, cut[chosen], groups)
        if shown is not None:
            own = [(looks.get(kind.material, PLAIN), count) for kind, count in owned]
            part = shown.on(part, own, where[chosen])
        surfaces.append(part)
    if not surfaces:
        raise FormatError("There are no faces in this file.")
    return Shapes(surfaces=tuple(surfaces))


def _table_of(data: bytes) -> _Table:
    """Return the rows of a text, no more of them than are read."""
    at_most(data.count(b"\n"), MAX_LINES, "lines")
    table = _Table()
    here = _Face("", "", "")
    line = b""
    try:
        for line in _lines(data):
            words = line.split()
            if not words:
                continue
            if words[0] == b"v":
                table.vertices.append(words[1:])
            elif words[0] == b"f":
                table.add_face(words[1:])
            elif words[0] == b"vt":
                table.texels.append(words[1:3])
            elif words[0] in BELONGS:
                here = here._replace(**{BELONGS[words[0]]: _name(line)})
                if words[0] == b"o":
                    here = here._replace(group="")
                table.begins.append((len(table.sizes), here))
            elif words[0] == b"mtllib":
                table.libraries.append(_name(line))
            elif words[0] in THIN:
                table.thin += 1
    except ValueError:
        shown = line[:40].decode("ascii", "replace")
        raise FormatError(f"A line cannot be understood: “{shown}”.") from None
    at_most(len(table.vertices), MAX_VERTICES, "vertices")
    at_most(len(table.texels), 4 * MAX_FACES, "places in pictures")
    at_most(len(table.corners), 4 * MAX_FACES, "corners")
    return table


def _rings(table: _Table, count: int) -> NDArray[np.int64]:
    """Return the corners of all faces, which must be among so many vertices."""
    if not table.corners:
        if table.thin:
            raise FormatError(
                "There are no faces in this file, only lines, points or free-form curves. Save "
                "curves as SVG to draw with them, and surfaces as polygons."
            )
        raise FormatError("There are no faces in this file.")
    try:
        rings = np.array(table.corners, np.int64)
    except OverflowError:
        raise FormatError("A face names a vertex that the file does not hold.") from None
    if rings.max() >= count:
        raise FormatError("A face names a vertex that the file does not hold.")
    return rings


def _shown(table: _Table, looks: Mapping[str, Look], reading: Reading) -> _Shown | None:
    """Return the pictures of materials and their places, if both are there; tell of one alone."""
    pictured = any(look.picture for look in looks.values())
    if pictured and not table.texels:
        reading.tell(
            "Left out of the OBJ file: the picture of a material. Its places on the surface are "
            "not in the file."
        )
    if table.texels and not pictured:
        reading.tell_of_unused_places("OBJ")
    if not pictured or not table.texels:
        return None
    return _Shown(Pictures("OBJ", reading), _texels(table.texels))


class _Shown(NamedTuple):
    """The pictures of a file, and the places in them that it names, (n, 2)."""

    pictures: Pictures
    texels: NDArray[np.float64]

    def on(
        self, part: Surface, looks: list[tuple[Look, int]], corners: NDArray[np.int64]
    ) -> Surface:
        """Return a part with the pictures of its materials, if there are any.

        Parameters
        ----------
        part : Surface
            Without them.
        looks : list of (Look, int)
            Of its triangles, and how many in turn have each.
        corners : (f, 3) int array
            Which places in the pictures their corners have; -1 where none.
        """
        files = sorted({look.picture for look, count in looks if look.picture and count})
        if not files:
            return part
        for file in files:
            self.pictures.add(file, partial(self.pictures.reading.beside, file, "picture"))
        counts = [count for _, count in looks]
        numbers = [files.index(look.picture) if look.picture else -1 for look, _ in looks]
        held = (corners >= 0) & (corners < len(self.texels))
        known: Flags = np.asarray(held.all(axis=1), bool)
        shown = np.where(known, np.repeat(numbers, counts), -1)
        colors = np.array([(*(look.color or WHITE), 255) for look, _ in looks], np.uint8)
        places = self.texels[np.where(known[:, None], corners, 0)]
        texture = self.pictures.texture(shown, files, places, np.repeat(colors, counts, axis=0))
        if texture is None:
            return part
        groups = tuple(replace(group, color=None) for group in part.groups)
        mesh = replace(part.mesh, colors=None)
        return replace(part, mesh=mesh, color=None, groups=groups, texture=texture)


def _texels(rows: list[list[bytes]]) -> NDArray[np.float64]:
    """Return places in pictures, (n, 2)."""
    try:
        table = np.array([[float(word) for word in (*row, b"0")[:2]] for row in rows], float)
    except ValueError:
        raise FormatError("A place in a picture is not made of numbers.") from None
    if not (np.abs(table) <= MAX_REPEATS).all():
        raise FormatError("A place in a picture is not finite.")
    return table.reshape(-1, 2)


def _owners(begins: list[tuple[int, _Face]], count: int) -> tuple[NDArray[np.int64], list[_Face]]:
    """Return for each face the number of what it belongs to, and these in their order."""
    numbers: dict[_Face, int] = {}
    owners = np.zeros(count, np.int64)
    starts = [(0, _Face("", "", "")), *begins]
    for (begin, kind), end in zip(starts, [*(b for b, _ in begins), count], strict=True):
        if end > begin:
            owners[begin:end] = numbers.setdefault(kind, len(numbers))
    return owners, list(numbers)


def _group(kind: _Face, count: int, looks: Mapping[str, Look]) -> FaceGroup:
    look = looks.get(kind.material, PLAIN)
    return FaceGroup(kind.group or kind.material, count, look.color, look.finish)


def _part(
    name: str,
    places: NDArray[np.float64],
    colors: NDArray[np.uint8] | None,
    faces: NDArray[np.int32],
    groups: list[FaceGroup],
) -> Surface:
    """Return a part with the vertices that it uses; a single group without a name is the part."""
    used, corners = np.unique(faces, return_inverse=True)
    own = None if colors is None or not colors[used, 3].any() else colors[used]
    if own is not None:
        own[own[:, 3] == 0] = 255
    color = groups[0].color if all(one.color == groups[0].color for one in groups) else None
    painted = any(one.color is not None for one in groups)
    if painted and own is not None and (own == own[0]).all():  # that of the part, below materials
        red, green, blue = own[0, :3].tolist()
        color, own = (red, green, blue), None
    mesh = checked_mesh(places[used], corners.reshape(-1, 3).astype(np.int32), colors=own)
    plain = len(groups) == 1 and groups[0].finish == "matt"
    return Surface(mesh, name, color, () if plain else tuple(groups))


def _name(line: bytes) -> str:
    """Return what follows the first word of a line, as a name that can be shown."""
    words = line.split(None, 1)
    text = words[1].strip()[:MAX_NAME].decode("utf-8", "replace") if len(words) > 1 else ""
    return "".join(sign for sign in text if sign.isprintable())


def _lines(data: bytes) -> list[bytes]:
    """Return lines without comments; a backslash at the end joins the next one."""
    if b"\\\n" in data or b"\\\r\n" in data:
        data = re.sub(rb"\\\r?\n", b" ", data)
    return [line.partition(b"#")[0] for line in data.splitlines()]


def _columns(
    rows: list[list[bytes]],
) -> tuple[NDArray[np.float64], NDArray[np.uint8] | None]:
    """Return places, and colours where vertices have three values more; others are clear."""
    if min(map(len, rows), default=3) < 3:
        raise FormatError("A vertex of this file has fewer than three coordinates.")
    colored = np.array([len(row) >= 6 for row in rows], bool)
    try:
        places = np.array([[float(word) for word in row[:3]] for row in rows], float)
        shares = np.array([[float(word) for word in row[3:6]] for row in rows if len(row) >= 6])
    except ValueError:
        raise FormatError("A vertex of this file is not made of numbers.") from None
    places = places.reshape(-1, 3)
    if not colored.any():
        return places, None
    colors = np.zeros((len(places), 4), np.uint8)
    colors[colored, :3] = np.rint(255 * np.clip(np.nan_to_num(shares), 0.0, 1.0))
    colors[colored, 3] = 255
    return places, colors
