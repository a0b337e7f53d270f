"""Wavefront OBJ, read: text, polygons, objects and groups; colours as ``v x y z r g b``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
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
from bozzetto.exchange.mesh.text_words import check_words
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.shapes import FaceGroup, Shapes, Surface

BELONGS: Final = {b"o": "part", b"g": "group", b"usemtl": "material"}
"""Words after which faces belong to something else, and to what."""

THIN: Final = frozenset((b"l", b"p", b"curv", b"curv2", b"surf"))
"""Words of what has no faces of its own."""

MAX_NAME: Final = 200
"""Bytes of a name."""

MAX_LINES: Final = 6_000_000
"""Limit of lines: as objects a quarter of a gigabyte; 64 MB of usual lines are two million."""


class _Face(NamedTuple):
    """Where a face belongs."""

    part: str
    group: str
    material: str


def read_shapes(data: bytes, reading: Reading | None = None) -> Shapes:
    """Read the polygons of an OBJ file: a part for each object, groups and materials within it.

    Texture coordinates and normals are passed over; lines, points and free-form curves are told;
    negative indices count back from the last vertex before them.

    Parameters
    ----------
    data : bytes
        The file.
    reading : Reading, optional
        Where its materials lie, and what is told.
    """
    reading = reading or Reading()
    check_words(data)
    at_most(data.count(b"\n"), MAX_LINES, "lines")
    vertices: list[list[bytes]] = []
    corners: list[int] = []
    sizes: list[int] = []
    begins: list[tuple[int, _Face]] = []  # faces from here on belong there
    libraries: list[str] = []
    here, thin = _Face("", "", ""), 0
    line = b""
    try:
        for line in _lines(data):
            words = line.split()
            if not words:
                continue
            if words[0] == b"v":
                vertices.append(words[1:])
            elif words[0] == b"f":
                before = len(vertices)
                for word in words[1:]:
                    index = int(word.partition(b"/")[0])
                    corners.append(index - 1 if index > 0 else before + index)
                    if index == 0 or -index > before:
                        raise ValueError
                sizes.append(len(words) - 1)
            elif words[0] in BELONGS:
                name = _name(line)
                here = here._replace(**{BELONGS[words[0]]: name})
                if words[0] == b"o":
                    here = here._replace(group="")
                begins.append((len(sizes), here))
            elif words[0] == b"mtllib":
                libraries.append(_name(line))
            elif words[0] in THIN:
                thin += 1
    except ValueError:
        shown = line[:40].decode("ascii", "replace")
        raise FormatError(f"A line cannot be understood: “{shown}”.") from None
    at_most(len(vertices), MAX_VERTICES, "vertices")
    at_most(len(corners), 4 * MAX_FACES, "corners")
    places, colors = _columns(vertices)
    if not corners:
        raise FormatError("There are no faces in this file.")
    try:
        rings = np.array(corners, np.int64)
    except OverflowError:
        raise FormatError("A face names a vertex that the file does not hold.") from None
    if rings.max() >= len(places):
        raise FormatError("A face names a vertex that the file does not hold.")
    check_places(places)
    if thin:
        reading.tell(
            f"Left out of the OBJ file: {thin} {'line' if thin == 1 else 'lines'}, points or "
            "free-form curves; save curves as SVG to draw with them."
        )
    looks = materials_of(libraries, reading)
    counts = np.array(sizes, np.int64)
    owners, kinds = _owners(begins, len(counts))
    parts: dict[str, list[int]] = {}
    for number, kind in enumerate(kinds):
        parts.setdefault(kind.part, []).append(number)
    at_most(len(kinds), MAX_PARTS, "parts and groups")
    cut = triangulate(places, rings, counts)
    owner = np.repeat(owners, np.maximum(counts - 2, 0))
    proper = ~is_degenerate(cut)
    cut, owner = cut[proper], owner[proper]
    order = np.argsort(owner, kind="stable")
    bounds = np.searchsorted(owner[order], np.arange(len(kinds) + 1))
    surfaces = []
    for name, numbers in parts.items():
        rows = [order[bounds[k] : bounds[k + 1]] for k in numbers]
        groups = [_group(kinds[k], len(row), looks) for k, row in zip(numbers, rows, strict=True)]
        faces = cut[np.concatenate(rows)]
        if len(faces):
            surfaces.append(_part(name, places, colors, faces, [g for g in groups if g.count]))
    if not surfaces:
        raise FormatError("There are no faces in this file.")
    return Shapes(surfaces=tuple(surfaces))


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
    own = None if colors is None else colors[used]
    mesh = checked_mesh(places[used], corners.reshape(-1, 3).astype(np.int32), colors=own)
    color = groups[0].color if all(one.color == groups[0].color for one in groups) else None
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
    """Return places and, where every vertex has three values more, colours."""
    width = min(map(len, rows), default=0)
    if rows and width < 3:
        raise FormatError("A vertex of this file has fewer than three coordinates.")
    width = 6 if width >= 6 else 3
    try:
        table = np.array([[float(word) for word in row[:width]] for row in rows], float)
    except ValueError:
        raise FormatError("A vertex of this file is not made of numbers.") from None
    table = table.reshape(-1, width)
    if width == 3:
        return table, None
    share = np.clip(np.nan_to_num(table[:, 3:]), 0.0, 1.0)
    opaque = np.full((len(table), 1), 255)
    return table[:, :3], np.hstack((np.rint(255 * share), opaque)).astype(np.uint8)
