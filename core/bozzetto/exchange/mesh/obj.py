"""Wavefront OBJ: text, polygons, names; colours as ``v x y z r g b``, which most read."""

from __future__ import annotations

import re
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.color import vertex_colors
from bozzetto.exchange.limits import MAX_FACES, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.polygons import (
    check_places,
    checked_mesh,
    triangulate,
    without_degenerate,
)
from bozzetto.exchange.mesh.text_words import check_words
from bozzetto.geometry.shapes import FaceGroup, Shapes, Surface

MAX_LINES: Final = 6_000_000
"""Limit of lines: as objects a quarter of a gigabyte; 64 MB of usual lines are two million."""

HEADER: Final = "# Bozzetto: millimetres, Z up\n"


def write_shapes(shapes: Shapes) -> bytes:
    """Write OBJ with one object per part, and its groups; faces share the part's vertices."""
    pieces = [HEADER]
    first = 1
    for part in shapes.meshes():
        mesh = part.mesh
        pieces.append(f"o {_word(part.name)}\n")
        rows = mesh.vertices.astype(np.float64)
        colors = vertex_colors(part)
        line = "v %.9g %.9g %.9g"
        if colors is not None:
            rows = np.hstack((rows, colors[:, :3] / 255.0))
            line += " %.4f %.4f %.4f"
        pieces.append((f"{line}\n" * len(rows)) % tuple(rows.ravel().tolist()))
        corners = mesh.faces.astype(np.int64) + first
        begin = 0
        for group in part.groups or (FaceGroup("", len(corners)),):
            if group.name:
                pieces.append(f"g {_word(group.name)}\n")
            own = corners[begin : begin + group.count]
            pieces.append(("f %d %d %d\n" * len(own)) % tuple(own.ravel().tolist()))
            begin += group.count
        first += len(mesh.vertices)
    return "".join(pieces).encode()


def _word(name: str) -> str:
    """Return a name without blanks, which end names in OBJ."""
    return re.sub(r"\s+", "_", name.strip()) or "part"


def read_shapes(data: bytes) -> Shapes:
    """Read the polygons of an OBJ file as one mesh.

    Groups, materials, texture coordinates, normals, lines and free-form curves are passed
    over; negative indices count back from the last vertex before them.
    """
    check_words(data)
    at_most(data.count(b"\n"), MAX_LINES, "lines")
    vertices: list[list[bytes]] = []
    corners: list[int] = []
    sizes: list[int] = []
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
    faces = without_degenerate(triangulate(places, rings, np.array(sizes, np.int64)))
    return Shapes(surfaces=(Surface(checked_mesh(places, faces, colors=colors), name=""),))


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
