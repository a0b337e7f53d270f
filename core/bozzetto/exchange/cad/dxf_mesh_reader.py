"""DXF, read: its faces as meshes, one for each layer and colour, and one for each mesh entity.

3DFACE, POLYLINE that is a grid or a set of faces, and MESH without its subdivision. Bodies of a
modelling kernel (3DSOLID, BODY, SURFACE, REGION) are told: their data are not documented.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from bozzetto.errors import FormatError
from bozzetto.exchange.cad.dxf_document import MM_PER, color_of, entities_of, opened
from bozzetto.exchange.limits import MAX_FACES, MAX_PARTS, at_most
from bozzetto.exchange.mesh.polygons import (
    check_places,
    checked_mesh,
    triangulate,
    weld,
    without_degenerate,
)
from bozzetto.exchange.page_layout import Color
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.shapes import Shapes, Surface

DAMAGED: Final = "A mesh of this DXF file is damaged. Save it again."

KERNEL: Final = frozenset(("3DSOLID", "BODY", "REGION", "SURFACE", "EXTRUDEDSURFACE",
                           "LOFTEDSURFACE", "REVOLVEDSURFACE", "SWEPTSURFACE"))  # fmt: skip
"""Entities whose shape only the kernel of the program that wrote them knows."""

Place = tuple[float, float, float]


class _Piece(NamedTuple):
    """Polygons of one part: places, corners of all polygons in a row, and how many each has."""

    places: list[Place]
    corners: list[int]
    sizes: list[int]

    def add(self, places: list[Place], polygons: list[list[int]]) -> None:
        """Add polygons over places of their own."""
        first = len(self.places)
        self.places.extend(places)
        for polygon in polygons:
            self.corners.extend(first + corner for corner in polygon)
            self.sizes.append(len(polygon))
        at_most(len(self.corners), 4 * MAX_FACES, "corners")


def read_shapes(data: bytes, reading: Reading | None = None) -> Shapes:
    """Read the faces of a DXF file; lengths are millimetres where it says its unit.

    Parameters
    ----------
    data : bytes
        Content of the file.
    reading : Reading, optional
        Takes what is told.

    Raises
    ------
    UserError
        If ezdxf is not installed.
    FormatError
        If it is no DXF, is damaged or too large, or holds no faces.
    """
    reading = reading or Reading()
    document, damaged = opened(data)
    unit = MM_PER.get(int(document.units or 0))
    if unit is None:
        reading.tell("Read as millimetres: the file does not say its unit.")
    entities, others = entities_of(document, _is_face)
    others.update(damaged)
    bodies = sum(count for kind, count in others.items() if kind in KERNEL)
    if bodies:
        reading.tell(
            f"Left out of the DXF file: {bodies} {'body' if bodies == 1 else 'bodies'} of a "
            "modelling kernel. Save them as STEP, or as meshes."
        )
    rest = {kind: count for kind, count in others.items() if kind not in KERNEL}
    if rest:
        named = ", ".join(f"{count} {kind}" for kind, count in sorted(rest.items()))
        reading.tell(f"Left out of the DXF file: {named}; only its faces are read.")
    surfaces = [
        surface
        for (name, color, _), piece in _pieces(document, entities).items()
        if (surface := _surface(piece, unit or 1.0, name, color)) is not None
    ]
    if not surfaces:
        raise FormatError(" ".join(("There are no faces in this file.", *reading.left_out)))
    return Shapes(surfaces=tuple(surfaces))


def _is_face(entity: Any) -> bool:
    """Whether an entity is made of faces; a POLYLINE may be a line."""
    if entity.dxftype() == "POLYLINE":
        return bool(entity.is_poly_face_mesh or entity.is_polygon_mesh)
    return entity.dxftype() in ("3DFACE", "MESH")


def _pieces(document: Any, entities: list[Any]) -> dict[tuple[str, Color | None, int], _Piece]:
    """Return the polygons by layer, colour, and the number of the mesh; 0 for single faces."""
    found: dict[tuple[str, Color | None, int], _Piece] = {}
    for number, entity in enumerate(entities, 1):
        single = entity.dxftype() == "3DFACE"
        layer = str(entity.dxf.get("layer", "0"))
        key = ("" if layer == "0" else layer, color_of(document, entity), 0 if single else number)
        piece = found.setdefault(key, _Piece([], [], []))
        at_most(len(found), MAX_PARTS, "parts")
        try:
            piece.add(*_polygons(entity))
        except (MemoryError, RecursionError, FormatError):
            raise
        except Exception as problem:  # whatever the library makes of a damaged mesh
            raise FormatError(DAMAGED) from problem
    return found


def _polygons(entity: Any) -> tuple[list[Place], list[list[int]]]:
    """Return the places of an entity, and the corners of each of its polygons."""
    kind = entity.dxftype()
    if kind == "3DFACE":
        places = [_place(v) for v in entity.wcs_vertices()]
        return places, [list(range(len(places)))]
    if kind == "MESH":
        rows = [_place(v) for v in entity.vertices]
        faces = [[int(corner) for corner in face] for face in entity.faces]
        if any(not 0 <= corner < len(rows) for face in faces for corner in face):
            raise FormatError("A face names a vertex that the file does not hold.")
        return rows, faces
    if entity.is_poly_face_mesh:
        vertices, found = entity.indexed_faces()
        rows = [_place(v.dxf.location) for v in vertices]
        faces = [[int(corner) for corner in face.indices] for face in found]
        if any(not 0 <= corner < len(rows) for face in faces for corner in face):
            raise FormatError("A face names a vertex that the file does not hold.")
        return rows, faces
    return _grid(entity)


def _grid(entity: Any) -> tuple[list[Place], list[list[int]]]:
    """Return the places and quadrangles of a POLYLINE that is a grid of m by n places."""
    m, n = int(entity.dxf.m_count), int(entity.dxf.n_count)
    rows = [_place(v.dxf.location) for v in entity.vertices]
    if m < 2 or n < 2 or m * n > len(rows):
        raise FormatError(DAMAGED)
    rows = rows[: m * n]
    i, j = np.meshgrid(
        np.arange(m if entity.is_m_closed else m - 1),
        np.arange(n if entity.is_n_closed else n - 1),
        indexing="ij",
    )
    below, beside = (i + 1) % m, (j + 1) % n
    quads = np.stack([i * n + j, below * n + j, below * n + beside, i * n + beside], axis=2)
    faces: list[list[int]] = quads.reshape(-1, 4).tolist()
    return rows, faces


def _place(vector: Any) -> Place:
    return float(vector[0]), float(vector[1]), float(vector[2])


def _surface(piece: _Piece, unit: float, name: str, color: Color | None) -> Surface | None:
    """Return a part with equal places made one; None where all of its faces have no area."""
    places = unit * np.array(piece.places, float).reshape(-1, 3)
    check_places(places)
    cut = triangulate(places, np.array(piece.corners, np.int64), np.array(piece.sizes, np.int64))
    if not len(cut):
        return None
    rows = places.astype(np.float32)
    kept, faces = weld(rows, cut)
    faces = without_degenerate(faces)
    return Surface(checked_mesh(rows[kept], faces), name, color) if len(faces) else None
