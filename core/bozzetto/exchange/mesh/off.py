"""OFF, read: polygons with colours of faces or vertices, as text (Geomview, OpenSCAD, CGAL).

The first word says what each vertex has: ``[ST][C][N]OFF`` for places in a picture, colours and
normals beside the place. Colours are numbers up to 1, or up to 255 where none has a point.
"""

from __future__ import annotations

import re
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_FACES, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.colored_faces import colored_part
from bozzetto.exchange.mesh.polygons import check_places
from bozzetto.exchange.mesh.text_words import checked_text
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.shapes import Color, Shapes

HEADER: Final = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF(?![a-z])[ \t]*", re.IGNORECASE)

MAX_LINES: Final = 6_000_000
"""Limit of lines: as objects a quarter of a gigabyte."""

UNKNOWN: Final = "A line of this OFF file cannot be understood: “{}”."

Colors = NDArray[np.uint8]


class _Faces(NamedTuple):
    """Corners of all faces, one after the other; how many each has; and its colour, or none."""

    corners: NDArray[np.int64]
    sizes: NDArray[np.int64]
    colors: list[Color | None]


def read_shapes(data: bytes, reading: Reading | None = None) -> Shapes:
    """Read the polygons of an OFF file; faces of one colour are a group.

    Parameters
    ----------
    data : bytes
        The file.
    reading : Reading, optional
        Takes what is told.

    Raises
    ------
    FormatError
        If it is no OFF file, is binary or of another space, damaged, or too large.
    """
    reading = reading or Reading()
    data = checked_text(data)
    at_most(data.count(b"\n") + data.count(b"\r"), MAX_LINES, "lines")
    lines = [line for line in (one.partition(b"#")[0].strip() for one in data.splitlines()) if line]
    found = HEADER.match(lines[0]) if lines else None
    if found is None:
        raise FormatError("This is not an OFF file.")
    if found[4] or found[5]:
        raise FormatError("Its vertices are not places in space (4OFF or nOFF).")
    rest = lines[0][found.end() :]
    if rest.upper().startswith(b"BINARY"):
        raise FormatError("This OFF file is binary. Save it as text.")
    rows = ([rest] if rest else []) + lines[1:]
    count, faces = _counts(rows[0] if rows else b"")
    if len(rows) < 1 + count + faces:
        raise FormatError("This OFF file is cut short: it has fewer lines than it says.")
    places, colors = _vertices(rows[1 : 1 + count], bool(found[2]), bool(found[3]))
    drawn = _faces(rows[1 + count : 1 + count + faces], count)
    check_places(places)
    part = colored_part(places, drawn.corners, drawn.sizes, drawn.colors, colors, "OFF", reading)
    return Shapes(surfaces=(part,))


def _counts(line: bytes) -> tuple[int, int]:
    """Return how many vertices and faces there are."""
    words = line.split()[:2]
    if len(words) < 2 or not all(word.isdigit() for word in words):
        raise FormatError(UNKNOWN.format(line[:40].decode("ascii", "replace")))
    vertices, faces = (int(word[:20]) for word in words)
    at_most(vertices, MAX_VERTICES, "vertices")
    at_most(faces, MAX_FACES, "faces")
    return vertices, faces


def _vertices(
    rows: list[bytes], colored: bool, with_normals: bool
) -> tuple[NDArray[np.float64], Colors | None]:
    """Return the places, (v, 3), and the colours, (v, 4), where every vertex has one."""
    words = [row.split() for row in rows]
    first = 6 if with_normals else 3
    width = min(map(len, words), default=3)
    if width < 3:
        raise FormatError("A vertex of this file has fewer than three coordinates.")
    channels = min(width - first, 4) if colored else 0
    try:
        places = np.array([[float(word) for word in row[:3]] for row in words], float)
        shades = [[float(word) for word in row[first : first + channels]] for row in words]
    except ValueError:
        raise FormatError("A vertex of this file is not made of numbers.") from None
    if channels < 3:
        return places.reshape(-1, 3), None
    whole = not any(b"." in word for row in words for word in row[first : first + channels])
    return places.reshape(-1, 3), _bytes(np.array(shades, float), whole)


def _bytes(shades: NDArray[np.float64], whole: bool) -> Colors:
    """Return colours as bytes, (n, 4), from numbers up to 255 if they are whole, else up to 1."""
    found = np.full((len(shades), 4), 255, np.uint8)
    scale = 1.0 if whole else 255.0
    within = np.clip(np.nan_to_num(shades), 0.0, 255.0 / scale)
    found[:, : shades.shape[1]] = np.rint(within * scale)
    return found


def _faces(rows: list[bytes], count: int) -> _Faces:
    """Read faces: how many corners, the corners, and perhaps a colour."""
    corners: list[int] = []
    sizes: list[int] = []
    colors: list[Color | None] = []
    row = b""
    try:
        for row in rows:
            words = row.split()
            size = int(words[0])
            if size < 0 or len(words) < 1 + size:
                raise ValueError
            corners += map(int, words[1 : 1 + size])
            sizes.append(size)
            colors.append(_color(words[1 + size : 4 + size]))
    except ValueError:
        shown = row[:40].decode("ascii", "replace")
        raise FormatError(UNKNOWN.format(shown)) from None
    at_most(len(corners), 4 * MAX_FACES, "corners")
    try:
        rings = np.array(corners, np.int64)
    except OverflowError:
        rings = np.array([-1])
    if len(rings) and not 0 <= rings.min() <= rings.max() < count:
        raise FormatError("A face names a vertex that the file does not hold.")
    return _Faces(rings, np.array(sizes, np.int64), colors)


def _color(words: list[bytes]) -> Color | None:
    """Return the colour of a face; none for the number of one in a list that is not there."""
    if len(words) < 3:
        return None
    whole = not any(b"." in word for word in words)
    shade = _bytes(np.array([[float(word) for word in words]]), whole)[0].tolist()
    return shade[0], shade[1], shade[2]
