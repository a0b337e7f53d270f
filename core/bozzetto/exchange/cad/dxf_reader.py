"""DXF, read: the lines of a drawing as seen from above, one stroke for every line or closed ring.

CAD programs leave outlines in pieces: lines and
arcs that meet end to end and close become one stroke; open ones stay as they are, an edge each.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import FormatError
from bozzetto.exchange.cad.dxf_document import MM_PER, color_of, entities_of, opened
from bozzetto.exchange.limits import MAX_COORDINATE, at_most
from bozzetto.exchange.optional_libraries import library
from bozzetto.exchange.page_layout import Color, sheet_drawing
from bozzetto.ink.drawing import Drawing

DRAWN: Final = frozenset(
    ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "HELIX")
)
"""Entities that are lines."""

FLATTENING: Final = 2e-4
"""How far a chord may be off its curve, as a share of the drawing's size."""

TOGETHER: Final = 1e-5
"""Ends that are nearer than this share of the size are one place."""

FLAT: Final = 1e-6
"""A drawing that is higher than this share of its size is one in space."""

MAX_POINTS: Final = 4_000_000

Line = tuple[Array, Color | None]


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
    if _height([line for line, _ in found]) > FLAT * _size([line for line, _ in found]):
        told.append("This drawing lies in space: it is read as seen from above.")
    flat = [(line[:, :2] * (1.0, -1.0), color) for line, color in found]
    rings = _with_rings(flat, TOGETHER * _size([line for line, _ in flat]))
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


def _size(lines: Sequence[Array]) -> float:
    low = np.min([line[:, :2].min(axis=0) for line in lines], axis=0)
    high = np.max([line[:, :2].max(axis=0) for line in lines], axis=0)
    return float(math.hypot(*(high - low)))


def _height(lines: Sequence[Array]) -> float:
    return float(max(line[:, 2].max() for line in lines) - min(line[:, 2].min() for line in lines))


def _with_rings(lines: Sequence[Line], near: float) -> list[Line]:
    """Join the lines that close when they follow one another; a place where three meet parts them.

    Parameters
    ----------
    lines : sequence of ((n, 2) array, colour)
        Of the same colour they may be joined.
    near : float
        Ends that are nearer are one place.

    Returns
    -------
    list of ((n, 2) array, colour)
        In the order of the first line of each.
    """
    place = _places(np.array([[line[0], line[-1]] for line, _ in lines]).reshape(-1, 2), near)
    at: dict[int, list[int]] = defaultdict(list)
    for end, where in enumerate(place.tolist()):
        at[where].append(end)
    used, opened = [False] * len(lines), [False] * len(lines)
    found: list[Line] = []
    for first, (line, color) in enumerate(lines):
        if opened[first]:  # nor does the row close from its middle
            found.append((line, color))
        if used[first]:
            continue
        used[first] = True
        row, pieces, end = [first], [line], 2 * first + 1
        while place[end] != place[2 * first]:
            meeting = at[int(place[end])]
            if len(meeting) != 2:
                break
            other = meeting[0] if meeting[1] == end else meeting[1]
            after = other // 2
            if used[after] or lines[after][1] != color:
                break
            row.append(after)
            pieces.append(lines[after][0] if other % 2 == 0 else lines[after][0][::-1])
            end = other ^ 1
        closes = place[end] == place[2 * first] and len(at[int(place[end])]) == 2
        if len(row) > 1 and closes:
            for one in row:
                used[one] = True
            whole = np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])
            whole[-1] = whole[0]
            found.append((whole, color))
        else:
            found.append((line, color))
            for one in row[1:]:
                used[one] = opened[one] = True
    return found


def _places(ends: Array, near: float) -> Index:
    """Return the number of the place of each end, (n,): those in reach of one another have one.

    Ends are first put together by cells of a grid, so that the cost does not grow with the square
    of the ends that meet in one place.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    side = max(near, 1e-300) / math.sqrt(2.0)  # all places of a cell are in reach of one another
    cells = np.floor((ends - ends.min(axis=0)) / side)
    _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    pairs = cKDTree(ends[first]).query_pairs(max(near, 1e-300), output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(first), len(first)))
    return np.asarray(connected_components(links, directed=False)[1][cell.reshape(-1)])
