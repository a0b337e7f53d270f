"""DXF, read: the lines of a drawing as seen from above, one stroke for every line or closed ring.

CAD programs leave outlines in pieces: lines and
arcs that meet end to end and close become one stroke; open ones stay as they are, an edge each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import FormatError
from bozzetto.exchange.cad.dxf_document import MM_PER, color_of, entities_of, opened
from bozzetto.exchange.cad.rings import TOGETHER, Line, size_of, with_rings
from bozzetto.exchange.limits import MAX_COORDINATE, at_most
from bozzetto.exchange.optional_libraries import library
from bozzetto.exchange.page_layout import sheet_drawing
from bozzetto.ink.drawing import Drawing

DRAWN: Final = frozenset(
    ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "HELIX")
)
"""Entities that are lines."""

FLATTENING: Final = 2e-4
"""How far a chord may be off its curve, as a share of the drawing's size."""

FLAT: Final = 1e-6
"""A drawing that is higher than this share of its size is one in space."""

MAX_POINTS: Final = 4_000_000


def read_drawing(data: bytes, name: str) -> Drawing:
    """Read the lines of a DXF file.

    Parameters
    ----------
    data : bytes
        Content of the file.
    name : str
        Name of the drawing.

    Raises
    ------
    UserError
        If ezdxf is not installed.
    FormatError
        If it is no DXF, is damaged or too large, or holds no line.
    """
    document, damaged = opened(data)
    unit = MM_PER.get(int(document.units or 0))
    told: list[str] = []
    if unit is None:
        told.append("Read as millimetres: the file does not say its unit.")
    entities, others = entities_of(document, _is_line)
    others.update(damaged)
    if others:
        named = ", ".join(f"{count} {kind}" for kind, count in sorted(others.items()))
        told.append(f"Left out of the DXF file: {named}; only lines and curves are read.")
    found = list(_lines(document, entities, unit or 1.0))
    if not found:
        raise FormatError(" ".join(("There are no lines in this drawing.", *told)))
    if _height([line for line, _ in found]) > FLAT * size_of([line for line, _ in found]):
        told.append("This drawing lies in space: it is read as seen from above.")
    flat = [(line[:, :2] * (1.0, -1.0), color) for line, color in found]
    rings = with_rings(flat, TOGETHER * size_of([line for line, _ in flat]))
    colors = [color for _, color in rings]
    drawing = sheet_drawing([line for line, _ in rings], None, name, colors=colors)
    return replace(drawing, left_out=tuple(told))


def _is_line(entity: Any) -> bool:
    """Whether an entity is a line; a POLYLINE may be a mesh."""
    if entity.dxftype() == "POLYLINE":
        return bool(entity.is_2d_polyline or entity.is_3d_polyline)
    return entity.dxftype() in DRAWN


def _lines(document: Any, entities: Sequence[Any], unit: float) -> Iterator[Line]:
    """Yield the places of each line, (n, 3), mm, and its colour."""
    path = library("ezdxf.path", "dxf")
    made = []
    for entity in entities:
        try:
            made.append((path.make_path(entity), color_of(document, entity)))
        except (MemoryError, RecursionError):
            raise
        except Exception:  # a line without length, or without the values that it needs
            continue
    ends = [np.array([*one.start, *one.end]) for one, _ in made if len(one)]
    if not ends:
        return
    corners = np.concatenate([_corners(one) for one, _ in made if len(one)])
    if not (np.abs(corners) * unit <= MAX_COORDINATE).all():  # False of what is not finite, too
        raise FormatError("A point lies further away than a drawing can reach.")
    tolerance = max(FLATTENING * float(np.linalg.norm(np.ptp(corners, axis=0))), 1e-300)
    points = 0
    for one, color in made:
        for piece in one.sub_paths():
            if not len(piece):
                continue
            places = []
            for place in piece.flattening(tolerance, segments=4):
                places.append((place.x, place.y, place.z))
                points += 1
                at_most(points, MAX_POINTS, "points")
            line = unit * np.array(places, float)
            if len(line) > 1 and np.ptp(line[:, :2], axis=0).max() > 0.0:  # not seen from its end
                yield line, color


def _corners(path: Any) -> Array:
    """Return the control vertices of a path, (n, 3)."""
    return np.array([[v.x, v.y, v.z] for v in path.control_vertices()], float).reshape(-1, 3)


def _height(lines: Sequence[Array]) -> float:
    return float(max(line[:, 2].max() for line in lines) - min(line[:, 2].min() for line in lines))
