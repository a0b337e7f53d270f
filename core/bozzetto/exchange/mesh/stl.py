"""STL: triangles without names, colours or shared vertices; files do not tell their unit."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.handover import MILLIMETRES, FileFrame
from bozzetto.exchange.limits import MAX_FACES, at_most
from bozzetto.exchange.mesh.polygons import checked_mesh, weld, without_degenerate
from bozzetto.exchange.mesh.text_words import check_words
from bozzetto.geometry.shapes import Shapes, Surface

HEADER: Final = "Binary STL, "
"""Must not begin with "solid": many readers take that for the text form."""

HEADER_SIZE: Final = 80

RECORD: Final = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])


def write_shapes(shapes: Shapes, frame: FileFrame = MILLIMETRES) -> bytes:
    """Write binary STL of all meshes, one after the other; the header says the frame."""
    corners = np.concatenate([part.mesh.vertices[part.mesh.faces] for part in shapes.meshes()])
    records = np.zeros(len(corners), RECORD)
    records["corners"] = corners
    wide = corners.astype(np.float64)
    across = np.cross(wide[:, 1] - wide[:, 0], wide[:, 2] - wide[:, 0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    records["normal"] = np.divide(across, length, out=np.zeros_like(across), where=length > 0)
    header = f"{HEADER}{frame}".encode().ljust(HEADER_SIZE)
    return header + np.uint32(len(records)).tobytes() + records.tobytes()


def read_shapes(data: bytes) -> Shapes:
    """Read binary or text STL; equal corners become one vertex."""
    corners = _binary(data)
    if corners is None:
        corners = _text(data)
    loose = checked_mesh(corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3))
    kept, faces = weld(loose.vertices, loose.faces)
    mesh = checked_mesh(loose.vertices[kept], without_degenerate(faces))
    return Shapes(surfaces=(Surface(mesh, name=""),))


def _binary(data: bytes) -> NDArray[np.floating] | None:
    """Return the corners of a binary file; None if its length does not fit its count."""
    if len(data) < 84:
        return None
    count = int(np.frombuffer(data, "<u4", 1, 80)[0])
    # Some writers append bytes of their own, so longer is right too, unless it is text.
    size = 84 + count * RECORD.itemsize
    if len(data) < size or (len(data) > size and data.lstrip()[:5].lower() == b"solid"):
        return None
    at_most(count, MAX_FACES, "triangles")
    return np.asarray(np.frombuffer(data, RECORD, count, 84)["corners"])


def _text(data: bytes) -> NDArray[np.floating]:
    if data.lstrip()[:5].lower() != b"solid":
        raise FormatError("This is not an STL file, or it is cut short.")
    check_words(data)
    words = data.lower().split()
    at_most(len(words) // 21, MAX_FACES, "triangles")
    places = [i for i, word in enumerate(words) if word == b"vertex"]
    if len(places) % 3:
        raise FormatError("A triangle of this STL file lacks a corner: it may be cut short.")
    try:
        rows = [[float(word) for word in words[i + 1 : i + 4]] for i in places]
        return np.array(rows, float).reshape(-1, 3, 3)
    except ValueError:
        raise FormatError("A corner in this STL file is not three numbers.") from None
