"""PLY: polygons with colours, text or binary (Turk 1994)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.color import vertex_colors
from bozzetto.exchange.handover import MILLIMETRES, FileFrame
from bozzetto.exchange.limits import MAX_FACES, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.ply_faces import Columns, ply_shapes
from bozzetto.exchange.mesh.polygon_corners import corner_runs
from bozzetto.exchange.mesh.text_words import check_words
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.shapes import Shapes

TYPES: Final = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}

ORDERS: Final = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

MAX_HEADER: Final = 1 << 16
"""Longest header, bytes."""

MAX_PROPERTIES: Final = 256
"""Most properties of one element."""

STRIPS: Final = "tristrips"
"""Element in which scanners' programs, such as those of the Stanford models, keep triangles."""

PICTURE: Final = "TextureFile"


# -- writing -------------------------------------------------------------------------------


def write_shapes(shapes: Shapes, frame: FileFrame = MILLIMETRES) -> bytes:
    """Write binary little-endian PLY of all meshes together; with colours if any part has one.

    Parts without a colour are white among coloured ones.
    """
    parts = list(shapes.meshes())
    palettes = [vertex_colors(part) for part in parts]
    colored = any(colors is not None for colors in palettes)
    fields: list[Any] = [("place", "<f4", 3)] + ([("color", "u1", 4)] if colored else [])
    rows = np.zeros(sum(len(part.mesh.vertices) for part in parts), fields)
    faces: list[bytes] = []
    at = face_count = 0
    for part, colors in zip(parts, palettes, strict=True):
        count = len(part.mesh.vertices)
        rows["place"][at : at + count] = part.mesh.vertices
        if colored:
            rows["color"][at : at + count] = 255 if colors is None else colors
        for corners in corner_runs(part, 0, len(part.mesh.faces)):
            size = corners.shape[1]
            run = np.zeros(len(corners), [("size", "u1"), ("corners", "<i4", size)])
            run["size"] = size
            run["corners"] = part.mesh.faces.ravel()[corners] + at
            faces.append(run.tobytes())
            face_count += len(run)
        at += count
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"comment Bozzetto: {frame}",
        f"element vertex {len(rows)}",
        *(f"property float {axis}" for axis in "xyz"),
        *(f"property uchar {name}" for name in ("red", "green", "blue", "alpha") if colored),
        f"element face {face_count}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    return "\n".join(header).encode() + rows.tobytes() + b"".join(faces)


# -- reading -------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str
    counts: str = ""
    """Type of the length in front; empty where the property is no list."""


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property]

    @property
    def has_lists(self) -> bool:
        return any(p.counts for p in self.properties)


def read_shapes(data: bytes, reading: Reading | None = None) -> Shapes:
    """Read text or binary PLY of either byte order, with colours of vertices, or else of faces.

    Parameters
    ----------
    data : bytes
        The file.
    reading : Reading, optional
        Where it is told what is left out.
    """
    reading = reading or Reading()
    order, elements, pictures, body = _header(data)
    if order:
        found = _found(elements, lambda element, at: _binary(element, body, at, order))[0]
    else:
        check_words(body)
        found = _of_text(elements, body, reading)
    vertex, face, strips = (found.get(name, {}) for name in ("vertex", "face", STRIPS))
    return ply_shapes(vertex, face, strips, pictures, reading)


def _found(
    elements: Sequence[_Element], read: Callable[[_Element, int], tuple[Columns, int]]
) -> tuple[dict[str, Columns], int]:
    """Read elements until vertices and faces are there; return where the reading ended, too."""
    found: dict[str, Columns] = {}
    at = 0
    for element in elements:
        found[element.name], at = read(element, at)
        if {"vertex", "face"} <= found.keys() or {"vertex", STRIPS} <= found.keys():
            break
    return found, at


def _of_text(elements: Sequence[_Element], body: bytes, reading: Reading) -> dict[str, Columns]:
    """Read the rows of a text file.

    A row goes over as many lines as it likes. Some programs write more into a row than their
    header says (old MeshLab: three colours for each face); then every line is a row.
    """
    words = body.split()
    problem: FormatError | None = None
    try:
        found, at = _found(elements, lambda element, at: _text(element, words, at))
        if at == len(words) or len(found) < len(elements):
            return found
    except FormatError as error:
        problem = error
    rows = [row for line in body.splitlines() if (row := line.split())]
    if len(rows) != sum(element.count for element in elements if element.properties):
        if problem is not None:
            raise problem
        return found
    try:
        fitted = _fitted(elements, rows)
    except (FormatError, IndexError, ValueError):
        raise problem or FormatError("Its rows are not as its header says.") from None
    reading.tell(
        "Left out of the PLY file: what stands at the ends of its rows and not in its header. "
        "Save it again in the program that made it if something is missing."
    )
    return _found(elements, lambda element, at: _text(element, fitted, at))[0]


def _fitted(elements: Sequence[_Element], rows: list[list[bytes]]) -> list[bytes]:
    """Return the words that the header knows of lines that are one row each."""
    words: list[bytes] = []
    lines = iter(rows)
    for element in elements:
        for _ in range(element.count if element.properties else 0):
            row, end = next(lines), 0
            for p in element.properties:
                end += 1 + (_length(float(row[end])) if p.counts else 0)
            if end > len(row):
                raise _short()
            words += row[:end]
    return words


def _header(data: bytes) -> tuple[str, list[_Element], list[str], bytes]:
    """Return byte order, elements, pictures that it names, and what follows the header."""
    end = data.find(b"end_header", 0, MAX_HEADER)
    # Rhino ends its lines with a carriage return alone, and the numbers may begin with a 10.
    line_end = data.find(b"\n" if b"\n" in data[: max(end, 0)] else b"\r", end)
    if data[:3] != b"ply" or end < 0 or line_end < 0:
        raise FormatError("This is not a PLY file, or it is cut short.")
    order: str | None = None
    elements: list[_Element] = []
    pictures: list[str] = []
    for line in data[:end].decode("utf-8", "replace").splitlines():
        match line.split(None, 2):
            case ["comment", kind, name] if kind == PICTURE:
                pictures.append(name.strip().replace("\\", "/"))
        match line.split():
            case ["format", name, *_]:
                order = ORDERS.get(name)
            case ["element", name, count]:
                if not count.isascii() or not count.isdigit():
                    raise FormatError(f"“{line[:40]}” in the header is no element.")
                at_most(int(count[:20]), max(MAX_VERTICES, MAX_FACES), "rows")
                elements.append(_Element(name, int(count[:20]), []))
            case ["property", "list", counts, kind, name] if elements:
                elements[-1].properties.append(_Property(name, _type(kind), _type(counts)))
            case ["property", kind, name] if elements:
                elements[-1].properties.append(_Property(name, _type(kind)))
            case ["format" | "element" | "property", *_]:
                raise FormatError(f"“{line[:40]}” in the header cannot be understood.")
    if order is None:
        raise FormatError("The header does not say how the numbers are stored.")
    if any(len(element.properties) > MAX_PROPERTIES for element in elements):
        raise FormatError("The header names more properties than can be read.")
    return order, elements, pictures, data[line_end + 1 :]


def _type(name: str) -> str:
    if name not in TYPES:
        raise FormatError(f"“{name[:40]}” is not a type of number that PLY knows.")
    return TYPES[name]


def _short() -> FormatError:
    return FormatError("The file ends before its last row: it may be cut short.")


def _binary(element: _Element, body: bytes, at: int, order: str) -> tuple[Columns, int]:
    """Read the columns of one element from byte `at` on; return where the next one begins, too."""
    if not element.has_lists:
        return _table(element, body, at, order, ())
    # Nearly always all lists are of one length: then the rows are a table, too.
    lengths = _first_lengths(element, body, at, order)
    if element.count and lengths is not None:
        columns, end = _table(element, body, at, order, lengths)
        if all(
            (columns[f"{p.name} length"] == length).all()
            for p, length in zip(_lists(element), lengths, strict=True)
        ):
            return columns, end
    return _row_by_row(element, body, at, order)


def _lists(element: _Element) -> list[_Property]:
    return [p for p in element.properties if p.counts]


def _first_lengths(element: _Element, body: bytes, at: int, order: str) -> tuple[int, ...] | None:
    """Return the lengths of the lists in the first row; None if the table exceeds the file."""
    lengths: list[int] = []
    start = at
    for p in element.properties:
        size = np.dtype(p.kind).itemsize
        if p.counts:
            counts = np.dtype(order + p.counts)
            if at + counts.itemsize > len(body):
                return None
            length = float(np.frombuffer(body, counts, 1, at)[0])
            if not 0 <= length <= len(body):
                return None
            lengths.append(int(length))
            at += counts.itemsize + int(length) * size
        else:
            at += size
    return tuple(lengths) if start + (at - start) * element.count <= len(body) else None


def _table(
    element: _Element, body: bytes, at: int, order: str, lengths: tuple[int, ...]
) -> tuple[Columns, int]:
    """Read rows of one size; a list becomes its values in a row and a column of lengths."""
    fields: list[Any] = []
    names: list[str] = []
    sizes = iter(lengths)
    for index, p in enumerate(element.properties):
        if p.counts:
            fields.append((f"{index} length", order + p.counts))
            fields.append((str(index), order + p.kind, (next(sizes),)))
            names += [f"{p.name} length", p.name]
        else:
            fields.append((str(index), order + p.kind))
            names.append(p.name)
    record = np.dtype(fields)
    end = at + record.itemsize * element.count
    if end > len(body):
        raise _short()
    if not fields or not element.count:
        return {name: np.zeros(0) for name in names}, end
    rows = np.frombuffer(body, record, element.count, at)
    columns = {name: rows[field[0]].ravel() for name, field in zip(names, fields, strict=True)}
    return columns, end


def _row_by_row(element: _Element, body: bytes, at: int, order: str) -> tuple[Columns, int]:
    """Read rows whose lists differ in length."""
    kinds = [
        (p.name, np.dtype(order + p.kind), np.dtype(order + p.counts) if p.counts else None)
        for p in element.properties
    ]
    parts: dict[str, list[NDArray[Any]]] = {p.name: [] for p in element.properties}
    sizes: dict[str, list[int]] = {p.name: [] for p in _lists(element)}
    for _ in range(element.count):
        for name, kind, counts in kinds:
            length = 1
            if counts is not None:
                if at + counts.itemsize > len(body):
                    raise _short()
                length = _length(float(np.frombuffer(body, counts, 1, at)[0]))
                at += counts.itemsize
                sizes[name].append(length)
            if at + length * kind.itemsize > len(body):
                raise _short()
            parts[name].append(np.frombuffer(body, kind, length, at))
            at += length * kind.itemsize
    columns = {name: np.concatenate(rows or [np.zeros(0)]) for name, rows in parts.items()}
    columns |= {f"{name} length": np.array(values) for name, values in sizes.items()}
    return columns, at


def _length(value: float) -> int:
    if not 0 <= value <= MAX_VERTICES:
        raise FormatError("A list in this file has a length that cannot be.")
    return int(value)


def _text(element: _Element, words: list[bytes], at: int) -> tuple[Columns, int]:
    """Read the columns of one element of a text file; return where the next one begins, too."""
    if element.count > len(words) - at and element.properties:
        raise _short()
    try:
        if not element.has_lists:
            width = len(element.properties)
            end = at + element.count * width
            if end > len(words):
                raise _short()
            return {
                p.name: _typed(words[at + k : end : width], p.kind)
                for k, p in enumerate(element.properties)
            }, end
        values: dict[str, list[bytes]] = {p.name: [] for p in element.properties}
        sizes: dict[str, list[int]] = {p.name: [] for p in _lists(element)}
        for _ in range(element.count):
            for p in element.properties:
                length = 1
                if p.counts:
                    length = _length(float(words[at]))
                    at += 1
                    sizes[p.name].append(length)
                if at + length > len(words):
                    raise _short()
                values[p.name] += words[at : at + length]
                at += length
        columns: Columns = {p.name: _typed(values[p.name], p.kind) for p in element.properties}
    except IndexError:
        raise _short() from None
    except ValueError:
        raise FormatError("A value in this file is not a number.") from None
    columns |= {f"{name} length": np.array(column) for name, column in sizes.items()}
    return columns, at


def _typed(words: list[bytes], kind: str) -> NDArray[Any]:
    """Convert a column of text to numbers; to integers where the header says so."""
    values = np.array([float(word) for word in words])
    if kind[0] == "f":
        return values
    if not np.isfinite(values).all():
        raise ValueError
    return np.asarray(np.clip(values, -(2.0**40), 2.0**40), np.int64)
