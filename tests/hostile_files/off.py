"""Hostile files: OFF."""

from __future__ import annotations

from tests.hostile_files.families import family, filled
from tests.hostile_files.obj import zigzag


def off(vertices: int, faces: int, body: bytes, word: bytes = b"OFF") -> bytes:
    return word + b"\n%d %d 0\n" % (vertices, faces) + body


@family("off of 2^63 vertices")
def _(size):
    return off(2**63, 1, bytes(size))


@family("off vertices of short words")
def _(size):
    return off(size // 6, 1, filled(b"1 2 3\n", size) + b"3 0 1 2\n")


@family("off faces without end")
def _(size):
    count = size // 8
    return off(3, count, b"0 0 0\n1 0 0\n0 1 0\n" + b"3 0 1 2\n" * count)


@family("off a colour for every face")
def _(size):
    rows = b"".join(
        b"3 0 1 2 %d %d %d\n" % (k % 256, k // 256 % 256, k >> 16) for k in range(size // 16)
    )
    return off(3, size // 16, b"0 0 0\n1 0 0\n0 1 0\n" + rows)


@family("off a face of many corners")
def _(size):
    count = max(4, size // 20)
    rows = b"".join(b"%g %g 0\n" % place for place in zigzag(count))
    return off(count, 1, rows + b"%d " % count + b" ".join(b"%d" % k for k in range(count)))


@family("off a face of more corners than there are")
def _(size):
    return off(3, 1, b"0 0 0\n1 0 0\n0 1 0\n999999999999 " + filled(b"0 ", size))


@family("off corners beyond all bounds")
def _(size):
    return off(3, 1, b"0 0 0\n1 0 0\n0 1 0\n3 0 1 " + b"9" * min(size, 4000))


@family("off empty faces")
def _(size):
    return off(1, size // 2, b"0 0 0\n" + b"0\n" * (size // 2))


@family("off words that are no numbers")
def _(size):
    return off(size // 12, 1, filled(b"nan inf -inf\n", size))


@family("off comments without end")
def _(size):
    return filled(b"# a\n", size) + off(1, 1, b"0 0 0\n3 0 0 0\n")
