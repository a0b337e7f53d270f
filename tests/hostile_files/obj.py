"""Hostile files: OBJ."""

from __future__ import annotations

import math

from tests.hostile_files.families import family, filled
from tests.hostile_files.svg import random_places


def zigzag(count: int) -> list[tuple[float, float]]:
    """A polygon that is not convex and does not cross itself: a saw on top of a line."""
    top = [(float(k), 1.0 + (k % 2)) for k in range(count - 2)]
    return [*top, (float(count), -1.0), (-1.0, -1.0)]


@family("obj a face of many corners")
def _(size):
    count = max(4, size // 22)
    rows = b"".join(b"v %g %g 0\n" % place for place in zigzag(count))
    return rows + b"f " + b" ".join(b"%d" % k for k in range(1, count + 1)) + b"\n"


@family("obj faces of five, not convex")
def _(size):
    rows = b"v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\n"
    return rows + filled(b"f 1 2 3 4 5\n", size)


@family("obj faces of four, not convex")
def _(size):
    return b"v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\n" + filled(b"f 1 2 3 4\n", size)


@family("obj faces of every size")
def _(size):
    rows = b"v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\n"
    most = int(math.sqrt(size))
    return rows + b"".join(b"f " + b"1 2 3 4 " * (k // 4) + b"\n" for k in range(4, most))


@family("obj vertices of three letters")
def _(size):
    return filled(b"v 1 1 1\n", size) + b"f 1 2 3\n"


@family("obj empty lines")
def _(size):
    return b"\n" * size + b"v 0 0 0\nf 1 1 1\n"


@family("obj one long line")
def _(size):
    return b"v 0 0 0\nf " + filled(b"1 ", size)


@family("obj lines joined")
def _(size):
    return b"v 0 0 0 " + filled(b"\\\n", size) + b"\nf 1 1 1\n"


@family("obj a number of many digits")
def _(size):
    return b"v 0 0 0\nf " + b"9" * size + b" 1 1\n"


@family("obj places that are no numbers")
def _(size):
    return filled(b"v nan inf -inf\n", size) + b"f 1 2 3\n"


@family("obj a spiral of one face")
def _(size):
    count = max(6, size // 40)
    arm = [(k * math.cos(k / 5), k * math.sin(k / 5)) for k in range(count // 2)]
    back = [(0.99 * x, 0.99 * y) for x, y in reversed(arm)]
    rows = b"".join(b"v %g %g 0\n" % place for place in (*arm, *back))
    return rows + b"f " + b" ".join(b"%d" % (k + 1) for k in range(len(arm) + len(back))) + b"\n"


@family("obj a face that crosses itself")
def _(size):
    count = max(4, size // 25)
    rows = b"".join(b"v %g %g 0\n" % place for place in random_places(count, 3))
    return rows + b"f " + b" ".join(b"%d" % k for k in range(1, count + 1)) + b"\n"
