"""Hostile files: PLY."""

from __future__ import annotations

import struct

from tests.hostile_files.families import family, filled
from tests.hostile_files.obj import zigzag


def ply(elements: bytes, body: bytes, form: bytes = b"binary_little_endian") -> bytes:
    return b"ply\nformat " + form + b" 1.0\n" + elements + b"end_header\n" + body


PLACES = b"property float x\nproperty float y\nproperty float z\n"
LISTS = b"property list uchar int vertex_indices\n"


@family("ply of 2^63 vertices")
def _(size):
    return ply(b"element vertex 9223372036854775808\n" + PLACES, bytes(size))


@family("ply lists of every length")
def _(size):
    rows = b"".join(bytes([k % 7]) + bytes(4 * (k % 7)) for k in range(size // 13))
    head = b"element vertex 1\n" + PLACES + b"element face %d\n" % (size // 13) + LISTS
    return ply(head, bytes(12) + rows)


@family("ply one list of all")
def _(size):
    head = b"element vertex 1\n" + PLACES
    head += b"element face 1\nproperty list uint int vertex_indices\n"
    return ply(head, bytes(12) + struct.pack("<I", size // 4) + bytes(size // 4 * 4))


@family("ply empty lists")
def _(size):
    head = b"element vertex 1\n" + PLACES + b"element face %d\n" % size + LISTS
    return ply(head, bytes(12) + bytes(size))


@family("ply rows of nothing")
def _(size):
    return ply(b"element nothing 19999999\n" * 9 + b"element vertex 1\n" + PLACES, bytes(size))


@family("ply elements without end")
def _(size):
    return ply(filled(b"element a 0\n", min(size, 60_000)), bytes(size))


@family("ply of short words")
def _(size):
    head = b"element vertex %d\n" % (size // 6) + PLACES + b"element face 1\n" + LISTS
    return ply(head, filled(b"1 ", size) + b"3 0 1 2", b"ascii")


@family("ply of words that are no numbers")
def _(size):
    head = b"element vertex %d\n" % (size // 12) + PLACES
    return ply(head, filled(b"nan inf ", size), b"ascii")


@family("ply lists of double length")
def _(size):
    head = b"element vertex 1\n" + PLACES
    head += b"element face 2\nproperty list double double vertex_indices\n"
    return ply(head, bytes(12) + struct.pack("<d", 1e300) + bytes(size))


@family("ply a face of many corners")
def _(size):
    count = max(4, size // 16)
    head = b"element vertex %d\n" % count + PLACES
    head += b"element face 1\nproperty list uint int vertex_indices\n"
    body = b"".join(struct.pack("<3f", x, y, 0) for x, y in zigzag(count))
    return ply(head, body + struct.pack("<I", count) + struct.pack(f"<{count}i", *range(count)))
