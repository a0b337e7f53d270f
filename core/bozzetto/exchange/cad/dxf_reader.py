"""DXF, read: the lines of a drawing as seen from above, one stroke for every line or closed ring.

Read with ezdxf, the extra ``bozzetto[dxf]``. Blocks are taken apart; what
lies on layers that are off or frozen is not seen. CAD programs leave outlines in pieces: lines and
arcs that meet end to end and close become one stroke; open ones stay as they are, an edge each.
"""

from __future__ import annotations

import io
import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import (
    MAX_COORDINATE,
    MAX_DEPTH,
    MAX_STROKES,
    USUAL_BYTES,
    at_most,
)
from bozzetto.exchange.optional_libraries import library
from bozzetto.exchange.page_layout import Color, sheet_drawing
from bozzetto.ink.drawing import Drawing

MM_PER: Final = {
    1: 25.4, 2: 304.8, 3: 1_609_344.0, 4: 1.0, 5: 10.0, 6: 1000.0, 7: 1e6, 8: 2.54e-5, 9: 0.0254,
    10: 914.4, 11: 1e-7, 12: 1e-6, 13: 1e-3, 14: 100.0, 15: 10_000.0, 16: 100_000.0,
}  # fmt: skip
"""Millimetres in a unit by the value of $INSUNITS."""

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

BY_LAYER, BY_BLOCK, BLACK_OR_WHITE = 256, 0, 7
"""Numbers of colours that stand for another one, or for that of ink."""

ENTITY: Final = re.compile(rb"\n[ \t]*0[ \t]*\r?\n[ \t]*[A-Z]")
"""Where an entity begins: a code of zero, and its kind."""

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
    document = _opened(data)
    unit = MM_PER.get(int(document.units or 0))
    told: list[str] = []
    if unit is None:
        told.append("Read as millimetres: the file does not say its unit.")
    entities, others = _entities(document)
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


def _opened(data: bytes) -> Any:
    """Return the document that ezdxf makes of a file."""
    if data.startswith(b"AutoCAD Binary DXF"):
        raise FormatError("This DXF file is binary. Save it as text (ASCII DXF).")
    if data[:4096].lstrip(b"\xef\xbb\xbf").split(None, 1)[:1] not in ([b"0"], [b"999"]):
        raise FormatError("This is not a DXF file.")
    _check_count(data)
    recover = library("ezdxf.recover", "dxf")
    try:
        document, _ = recover.read(io.BytesIO(data))
    except (MemoryError, RecursionError):
        raise
    except Exception as problem:  # whatever the library makes of a damaged file
        raise FormatError(
            "It is damaged, or not what its name says. Save it again where it was made."
        ) from problem
    return document


def _check_count(data: bytes) -> None:
    """Refuse more entities than the library reads within the budget, before it begins.

    It takes 50 µs for each, so that as many as the most strokes are ten seconds.
    """
    most = int(MAX_STROKES * max(1.0, len(data) / USUAL_BYTES))
    for count, _ in enumerate(ENTITY.finditer(data)):
        at_most(count, most, "lines")


def _entities(document: Any) -> tuple[list[Any], Counter[str]]:
    """Return the entities that are lines and can be seen, blocks taken apart, and other kinds."""
    hidden = {layer.dxf.name.lower() for layer in document.layers
              if layer.is_off() or layer.is_frozen()}  # fmt: skip
    found: list[Any] = []
    others: Counter[str] = Counter()
    waiting = [(entity, 0) for entity in reversed(list(document.modelspace()))]
    seen = 0
    while waiting:
        at_most(seen + len(waiting), MAX_STROKES, "lines")
        entity, depth = waiting.pop()
        seen += 1
        at_most(depth, MAX_DEPTH, "levels of blocks")
        kind = entity.dxftype()
        if not entity.is_supported_dxf_attrib("layer"):  # of a program that the library ignores
            others[kind] += 1
            continue
        if str(entity.dxf.get("layer", "0")).lower() in hidden or entity.dxf.get("invisible", 0):
            continue
        if kind == "INSERT":
            inside = _taken_apart(entity, seen + len(waiting))
            waiting += [(one, depth + 1) for one in reversed(inside)]
        elif kind in DRAWN and not (kind == "POLYLINE" and not _is_line(entity)):
            found.append(entity)
        elif kind not in ("VERTEX", "SEQEND", "VIEWPORT", "ATTDEF"):
            others[kind] += 1
    return found, others


def _is_line(polyline: Any) -> bool:
    """Whether a POLYLINE is one, and not a mesh."""
    return bool(polyline.is_2d_polyline or polyline.is_3d_polyline)


def _taken_apart(insert: Any, seen: int) -> list[Any]:
    """Return the entities of a block where it is inserted, once or in rows."""
    found: list[Any] = []
    try:
        for one in insert.multi_insert() if insert.mcount > 1 else (insert,):
            for entity in one.virtual_entities():
                found.append(entity)
                at_most(seen + len(found), MAX_STROKES, "lines")
    except (MemoryError, RecursionError, FormatError):
        raise
    except Exception as problem:  # whatever the library makes of a damaged block
        raise FormatError("A block of this drawing is damaged. Save it again.") from problem
    return found


def _lines(document: Any, entities: Sequence[Any], unit: float) -> Iterator[Line]:
    """Yield the places of each line, (n, 3), mm, and its colour."""
    path = library("ezdxf.path", "dxf")
    made = []
    for entity in entities:
        try:
            made.append((path.make_path(entity), _color(document, entity)))
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


def _color(document: Any, entity: Any) -> Color | None:
    """Return the colour of a line; None where it is that of ink."""
    colors = library("ezdxf.colors", "dxf")
    owner = entity
    number = int(entity.dxf.get("color", BY_LAYER))
    if entity.dxf.get("true_color") is None and number == BY_LAYER:
        layer = str(entity.dxf.get("layer", "0"))
        if layer not in document.layers:
            return None
        owner = document.layers.get(layer)
        number = int(owner.dxf.get("color", BLACK_OR_WHITE))
    exact = owner.dxf.get("true_color")
    if exact is not None:
        red, green, blue = colors.int2rgb(int(exact))
    elif number in (BY_BLOCK, BLACK_OR_WHITE) or not 0 < number < BY_LAYER:
        return None
    else:
        red, green, blue = colors.aci2rgb(number)
    return int(red), int(green), int(blue)


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
