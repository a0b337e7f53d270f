"""Hostile files: STL."""

from __future__ import annotations

import math
import random
import struct

from tests.hostile_files.families import family, filled


def stl_records(count: int, record: bytes) -> bytes:
    return b"x" * 80 + struct.pack("<I", count) + record * count


@family("stl triangles without end")
def _(size):
    rng = random.Random(0)
    some = b"".join(struct.pack("<12fH", *(rng.random() for _ in range(12)), 0)
                    for _ in range(min(1000, max(1, size // 50))))  # fmt: skip
    count = max(1, size // len(some)) * (len(some) // 50)
    return b"x" * 80 + struct.pack("<I", count) + some * (count * 50 // len(some))


@family("stl of NaN and infinity")
def _(size):
    row = struct.pack("<12fH", *[math.nan] * 6, *[math.inf] * 6, 0)
    return stl_records(max(1, size // 50), row)


@family("stl that promises much")
def _(size):
    return b"x" * 80 + b"\xff\xff\xff\xff" + bytes(size)


@family("stl of words")
def _(size):
    return b"solid " + filled(b"a ", size)


@family("stl of vertices")
def _(size):
    return b"solid " + filled(b"vertex 1 1 1 ", size)


@family("stl of numbers that are none")
def _(size):
    return b"solid " + filled(b"vertex nan inf 1e999 ", size)


@family("stl of one point")
def _(size):
    return stl_records(max(1, size // 50), bytes(50))
