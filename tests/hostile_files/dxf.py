"""Hostile files: DXF."""

from __future__ import annotations

import math

from tests.hostile_files.families import family, filled
from tests.hostile_files.obj import zigzag


def dxf(*entities: bytes, blocks: bytes = b"") -> bytes:
    body = b"".join(entities)
    head = tags((0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1015"), (0, "ENDSEC"))
    sections = b"  0\nSECTION\n  2\nBLOCKS\n" + blocks + b"  0\nENDSEC\n" if blocks else b""
    return head + sections + b"  0\nSECTION\n  2\nENTITIES\n" + body + b"  0\nENDSEC\n  0\nEOF\n"


def tags(*pairs: tuple[int, object]) -> bytes:
    return b"".join(f"{code:3d}\n{value}\n".encode() for code, value in pairs)


def dxf_line(*ends: float) -> bytes:
    return tags((0, "LINE"), (8, "0"), *zip((10, 20, 11, 21), ends, strict=True))


def dxf_block(name: str, content: bytes) -> bytes:
    begin = tags((0, "BLOCK"), (8, "0"), (2, name), (70, 0), (10, 0), (20, 0), (30, 0))
    return begin + content + tags((0, "ENDBLK"), (8, "0"))


def dxf_insert(name: str, *more: tuple[int, object]) -> bytes:
    return tags((0, "INSERT"), (8, "0"), (2, name), (10, 1), (20, 1), (30, 0), *more)


@family("dxf lines without end")
def _(size):
    return dxf(filled(dxf_line(0, 0, 1, 1), size))


@family("dxf an open chain of lines")
def _(size):
    rows = (dxf_line(k, k % 2, k + 1, (k + 1) % 2) for k in range(max(1, size // 46)))
    return dxf(b"".join(rows))


@family("dxf blocks in blocks")
def _(size):
    count = 12
    rows = [dxf_block("b0", filled(dxf_line(0, 0, 1, 1), size // 2))]
    rows += [dxf_block(f"b{k}", dxf_insert(f"b{k - 1}") * 9) for k in range(1, count)]
    return dxf(dxf_insert(f"b{count - 1}"), blocks=b"".join(rows))


@family("dxf a block in itself")
def _(size):
    row = dxf_block("a", dxf_insert("a") + filled(dxf_line(0, 0, 1, 1), size))
    return dxf(dxf_insert("a"), blocks=row)


@family("dxf a block in rows beyond all bounds")
def _(size):
    many = dxf_insert("a", (70, 32767), (71, 32767), (44, 1.0), (45, 1.0))
    return dxf(filled(many, size), blocks=dxf_block("a", dxf_line(0, 0, 1, 1)))


@family("dxf a line of many corners")
def _(size):
    count = max(2, size // 22)
    places = [pair for x, y in zigzag(count) for pair in ((10, x), (20, y))]
    return dxf(
        tags(
            (0, "LWPOLYLINE"),
            (100, "AcDbEntity"),
            (8, "0"),
            (100, "AcDbPolyline"),
            (90, count),
            (70, 0),
            *places,
        )
    )


@family("dxf arcs of a line that turn and turn")
def _(size):
    count = max(2, size // 36)
    places = [pair for x, y in zigzag(count) for pair in ((10, x), (20, y), (42, 1e6))]
    return dxf(
        tags(
            (0, "LWPOLYLINE"),
            (100, "AcDbEntity"),
            (8, "0"),
            (100, "AcDbPolyline"),
            (90, count),
            (70, 1),
            *places,
        )
    )


@family("dxf a spline of high degree")
def _(size):
    count = max(8, size // 40)
    knots = [(40, float(k)) for k in range(2 * count)]
    places = [pair for x, y in zigzag(count) for pair in ((10, x), (20, y), (30, 0.0))]
    head = (
        (0, "SPLINE"),
        (100, "AcDbEntity"),
        (8, "0"),
        (100, "AcDbSpline"),
        (70, 8),
        (71, count - 1),
        (72, 2 * count),
        (73, count),
    )
    return dxf(tags(*head, *knots, *places))


@family("dxf splines with knots in one place")
def _(size):
    places = [pair for x, y in zigzag(4) for pair in ((10, x), (20, y), (30, 0.0))]
    head = (
        (0, "SPLINE"),
        (100, "AcDbEntity"),
        (8, "0"),
        (100, "AcDbSpline"),
        (70, 8),
        (71, 3),
        (72, 8),
        (73, 4),
    )
    return dxf(filled(tags(*head, *[(40, 0.0)] * 8, *places), size))


@family("dxf places beyond all bounds")
def _(size):
    return dxf(filled(dxf_line(1e308, -1e308, math.inf, math.nan), size))


@family("dxf a helix of many turns")
def _(size):
    axis = ((10, 0), (20, 0), (30, 0), (11, 1), (21, 0), (31, 0), (12, 0), (22, 0), (32, 1))
    one = tags(
        (0, "HELIX"), (100, "AcDbEntity"), (8, "0"), (100, "AcDbSpline"), (70, 0), (71, 3), (72, 0),
        (73, 0), (100, "AcDbHelix"), *axis, (40, 1.0), (41, 1e9), (42, 1e-9),
    )  # fmt: skip
    return dxf(filled(one, size))


@family("dxf tags that are none")
def _(size):
    return dxf(filled(b"zz\nno number\n", size))


@family("dxf one long value")
def _(size):
    return dxf(tags((0, "TEXT"), (1, "a" * size)))


@family("dxf entities that nobody knows")
def _(size):
    return dxf(b"".join(tags((0, f"E{k}"), (8, k)) for k in range(max(1, size // 20))))


@family("dxf layers without end")
def _(size):
    rows = b"".join(
        tags((0, "LAYER"), (2, f"l{k}"), (70, 0), (62, -k)) for k in range(max(1, size // 40))
    )
    table = tags((0, "SECTION"), (2, "TABLES"), (0, "TABLE"), (2, "LAYER"), (70, 1)) + rows
    return table + tags((0, "ENDTAB"), (0, "ENDSEC")) + dxf(dxf_line(0, 0, 1, 1))


def dxf_face(*corners: float) -> bytes:
    return tags((0, "3DFACE"), (8, "0"), *zip((10, 20, 30, 11, 21, 31, 12, 22, 32), corners,
                                              strict=True))  # fmt: skip


def dxf_vertex(*more: tuple[int, object]) -> bytes:
    return tags((0, "VERTEX"), (8, "0"), *more)


@family("dxf faces without end")
def _(size):
    return dxf(filled(dxf_face(0, 0, 0, 1, 0, 0, 0, 1, 0), size))


@family("dxf faces of colours without end")
def _(size):
    rows = (
        tags(
            (0, "3DFACE"),
            (8, f"l{k}"),
            (420, k),
            (10, 0),
            (20, 0),
            (11, 1),
            (21, 0),
            (12, 0),
            (22, k),
        )
        for k in range(max(1, size // 80))
    )
    return dxf(b"".join(rows))


@family("dxf a grid of more places than it has")
def _(size):
    head = tags((0, "POLYLINE"), (8, "0"), (66, 1), (70, 16), (71, 32767), (72, 32767))
    rows = filled(dxf_vertex((10, 0), (20, 1), (30, 2), (70, 64)), size)
    return dxf(head + rows + tags((0, "SEQEND"), (8, "0")))


@family("dxf a set of faces that name what is not there")
def _(size):
    head = tags((0, "POLYLINE"), (8, "0"), (66, 1), (70, 64))
    rows = filled(
        dxf_vertex((10, 0), (20, 0), (30, 0), (70, 128), (71, 9), (72, -7), (73, 5)), size
    )
    return dxf(head + rows + tags((0, "SEQEND"), (8, "0")))


@family("dxf a mesh in rows beyond all bounds")
def _(size):
    head = tags((0, "POLYLINE"), (8, "0"), (66, 1), (70, 64))
    rows = filled(dxf_vertex((10, 0), (20, 0), (30, 0), (70, 192)), size // 2)
    block = dxf_block("a", head + rows + tags((0, "SEQEND"), (8, "0")))
    return dxf(filled(dxf_insert("a"), size // 2), blocks=block)


@family("dxf a mesh of one face with many corners")
def _(size):
    count = max(4, size // 30)
    places = [pair for x, y in zigzag(count) for pair in ((10, x), (20, y), (30, 0.0))]
    return dxf(tags((0, "MESH"), (100, "AcDbEntity"), (8, "0"), (100, "AcDbSubDMesh"), (71, 2),
                    (72, 0), (91, 0), (92, count), *places, (93, count + 1), (90, count),
                    *[(90, k) for k in range(count)], (94, 0), (95, 0), (90, 0)))  # fmt: skip
