"""DXF files as ezdxf opens them (the extra ``bozzetto[dxf]``): what can be seen, and how it looks.

Blocks are taken apart; what lies on layers that are off or frozen is not seen.
"""

from __future__ import annotations

import io
import logging
import re
from collections import Counter
from collections.abc import Callable
from typing import Any, Final

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_DEPTH, MAX_STROKES, USUAL_BYTES, at_most
from bozzetto.exchange.optional_libraries import library
from bozzetto.exchange.page_layout import Color

MM_PER: Final = {
    1: 25.4, 2: 304.8, 3: 1_609_344.0, 4: 1.0, 5: 10.0, 6: 1000.0, 7: 1e6, 8: 2.54e-5, 9: 0.0254,
    10: 914.4, 11: 1e-7, 12: 1e-6, 13: 1e-3, 14: 100.0, 15: 10_000.0, 16: 100_000.0,
}  # fmt: skip
"""Millimetres in a unit by the value of $INSUNITS."""

BY_LAYER, BY_BLOCK, BLACK_OR_WHITE = 256, 0, 7
"""Numbers of colours that stand for another one, or for that of ink."""

ENTITY: Final = re.compile(rb"\n[ \t]*0[ \t]*\r?\n[ \t]*[A-Z]")
"""Where an entity begins: a code of zero, and its kind."""

FACES: Final = frozenset((b"3DFACE", b"MESH"))
"""Entities that are faces; a POLYLINE may be some, too."""

KIND: Final = re.compile(
    rb"\n[ \t]*0[ \t]*\r?\n[ \t]*(3DFACE|MESH|POLYLINE|LINE|LWPOLYLINE|ARC|CIRCLE|ELLIPSE|SPLINE"
    rb"|HELIX)[ \t]*\r?\n"
)

FLAGS: Final = re.compile(rb"\n[ \t]*70[ \t]*\r?\n[ \t]*(\d{1,5})")

POLYLINE_HEAD: Final = 600
"""Bytes of a POLYLINE within which its flags stand."""

PIECE: Final = 1 << 20
"""Bytes that are searched at a time: meanwhile no other thread runs, 30 ms at worst."""

CLASSES: Final = {
    b"LWPOLYLINE": b"AcDbPolyline", b"SPLINE": b"AcDbSpline", b"ELLIPSE": b"AcDbEllipse",
}  # fmt: skip
"""Classes of lines that came with release 13."""

REMOVED: Final = re.compile(
    r"Removed (3DFACE|MESH|POLYLINE|LINE|LWPOLYLINE|ARC|CIRCLE|ELLIPSE|SPLINE|HELIX)\("
)
"""What the library says of an entity that it takes out of a file."""

VERSION: Final = re.compile(rb"(\$ACADVER\s+1\s+)AC10(?:0\d|1[0-4])")
"""A release before 2000, the first of which the library reads such entities."""

COMMON: Final = frozenset((b"5", b"102", b"330", b"360", b"67", b"410", b"8", b"6", b"62", b"370",
                           b"48", b"60", b"420", b"430", b"440", b"347", b"390"))  # fmt: skip
"""Groups that every entity has, before those of its class."""

MESH_FLAGS: Final = 16 | 64
"""Flags of a POLYLINE that is a grid or a set of faces."""


def mostly_faces(data: bytes) -> bool:
    """Whether a DXF file holds more entities that are faces than such that are lines."""
    faces = lines = 0
    pieces = range(0, len(data), PIECE)
    for found in (
        one
        for begin in pieces
        for one in KIND.finditer(data, begin, begin + PIECE + POLYLINE_HEAD)
        if one.start() < begin + PIECE
    ):
        kind = found[1]
        if kind == b"POLYLINE":
            part = data[found.end() - 1 : found.end() + POLYLINE_HEAD]
            end = ENTITY.search(part)
            flags = FLAGS.search(part, 0, end.start() + 1 if end else len(part))
            is_mesh = flags is not None and bool(int(flags[1]) & MESH_FLAGS)
        else:
            is_mesh = kind in FACES
        faces, lines = faces + is_mesh, lines + (not is_mesh)
    return faces > lines


def opened(data: bytes) -> tuple[Any, Counter[str]]:
    """Return the document that ezdxf makes of a file, and what is damaged and not in it.

    Raises
    ------
    UserError
        If ezdxf is not installed.
    FormatError
        If it is no DXF, binary, damaged or too large.
    """
    if data.startswith(b"AutoCAD Binary DXF"):
        raise FormatError("This DXF file is binary. Save it as text (ASCII DXF).")
    if data[:4096].lstrip(b"\xef\xbb\xbf").split(None, 1)[:1] not in ([b"0"], [b"999"]):
        raise FormatError("This is not a DXF file.")
    _check_count(data)
    recover = library("ezdxf.recover", "dxf")
    # It logs what it mends with the file's own bytes: no sentence for anybody, and no text for all.
    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)
    try:
        try:
            document, audit = recover.read(io.BytesIO(data))
        except library("ezdxf", "dxf").DXFStructureError:
            document, audit = recover.read(io.BytesIO(_with_classes(data)))
    except (MemoryError, RecursionError):
        raise
    except Exception as problem:  # whatever the library makes of a damaged file
        raise FormatError(
            "It is damaged, or not what its name says. Save it again where it was made."
        ) from problem
    removed = (REMOVED.match(fix.message) for fix in audit.fixes)
    return document, Counter(f"damaged {found[1]}" for found in removed if found)


def _with_classes(data: bytes) -> bytes:
    """Return a file whose newer entities name their classes.

    OpenSCAD and others write polylines and splines of release 13 into files that say to be older,
    without the marks (group 100) by which a reader finds what belongs to which class.
    """
    lines = VERSION.sub(rb"\1AC1015", data, count=1).splitlines()
    count = len(lines) // 2 * 2
    marked: list[bytes] = []
    name, begun, plain = b"", 0, False
    for at in range(0, count, 2):
        code, value = lines[at].strip(), lines[at + 1].strip()
        if code == b"0":
            name, begun, plain = CLASSES.get(value, b""), at, True
        elif code == b"100":
            plain = False
        if name and plain and at > begun and code not in COMMON:
            marked += (b"100", name)
            name = b""
        marked += (lines[at], lines[at + 1])
        if name and at == begun and not _names_class(lines, at + 2, count):
            marked += (b"100", b"AcDbEntity")
        elif at == begun:
            name = b""
    return b"\n".join(marked) + b"\n"


def _names_class(lines: list[bytes], at: int, count: int) -> bool:
    """Whether an entity whose tags begin at a line has a mark of a class at its beginning."""
    for begin in range(at, min(at + 2 * len(COMMON), count), 2):
        code = lines[begin].strip()
        if code == b"100":
            return True
        if code == b"0" or code not in COMMON:
            return False
    return False


def _check_count(data: bytes) -> None:
    """Refuse more entities than the library reads within the budget, before it begins.

    It takes 50 µs for each, so that as many as the most strokes are ten seconds.
    """
    most = int(MAX_STROKES * max(1.0, len(data) / USUAL_BYTES))
    for count, _ in enumerate(ENTITY.finditer(data)):
        at_most(count, most, "lines")


def entities_of(document: Any, wanted: Callable[[Any], bool]) -> tuple[list[Any], Counter[str]]:
    """Return the entities that are wanted and can be seen, blocks taken apart; and other kinds.

    Where the model space has none, they are those of the first sheet that has some: drawings of
    SolidWorks and others lie there, in the units of the paper.
    """
    hidden = {layer.dxf.name.lower() for layer in document.layers
              if layer.is_off() or layer.is_frozen()}  # fmt: skip
    model = document.modelspace()  # the layouts come in any order
    answers = []
    for space in (model, *(sheet for sheet in document.layouts if sheet is not model)):
        found, others = _seen_in(space, hidden, wanted)
        if found:
            return found, others
        answers.append(others)
    return [], next(filter(None, answers), Counter())


def _seen_in(
    space: Any, hidden: set[str], wanted: Callable[[Any], bool]
) -> tuple[list[Any], Counter[str]]:
    """Return the same of one space, without what lies on hidden layers."""
    found: list[Any] = []
    others: Counter[str] = Counter()
    waiting = [(entity, 0) for entity in reversed(list(space))]
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
            inside, corners = _taken_apart(entity, seen + len(waiting))
            seen += corners
            waiting += [(one, depth + 1) for one in reversed(inside)]
        elif wanted(entity):
            found.append(entity)
        elif kind not in ("VERTEX", "SEQEND", "VIEWPORT", "ATTDEF"):
            others[kind] += 1
    return found, others


def _taken_apart(insert: Any, seen: int) -> tuple[list[Any], int]:
    """Return the entities of a block where it is inserted, once or in rows, and their corners."""
    found: list[Any] = []
    corners = 0
    try:
        for one in insert.multi_insert() if insert.mcount > 1 else (insert,):
            for entity in one.virtual_entities():
                found.append(entity)
                corners += len(entity.vertices) if entity.dxftype() == "POLYLINE" else 0
                at_most(seen + len(found) + corners, MAX_STROKES, "lines")
    except (MemoryError, RecursionError, FormatError):
        raise
    except Exception as problem:  # whatever the library makes of a damaged block
        raise FormatError("A block of this drawing is damaged. Save it again.") from problem
    return found, corners


def color_of(document: Any, entity: Any) -> Color | None:
    """Return the colour of an entity; None where it is that of ink."""
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
