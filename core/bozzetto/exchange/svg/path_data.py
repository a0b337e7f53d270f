"""The path data of SVG as cubic Bézier pieces (SVG 1.1, chapter 8)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_COORDINATE, at_most
from bozzetto.ink.stroke import MAX_SAMPLES

Point = complex

ARC_PIECE: Final = math.pi / 4
"""Widest angle given to one cubic: its radius is then right to 5e-6 of itself."""

FLAT: Final = 1e-9
"""Share of its own size below which an ellipse counts as the line it nearly is."""

# All quantifiers give nothing back: a text that does not fit is given up in one pass.
TOKEN: Final = re.compile(r"[\s,]*+([A-Za-z]|[+-]?(?:\d++\.?+\d*+|\.\d++)(?:[eE][+-]?\d++)?+)")
FLAG: Final = re.compile(r"[\s,]*+([01])")
BLANK: Final = re.compile(r"[\s,]*+")

MAX_PIECES: Final = 1_000_000
"""Cubics of a drawing, and commands of a path: 64 MB as numbers, and more than any drawing has."""

ARGUMENTS: Final = {
    "M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0,
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Subpath:
    """One stretch of the pen.

    Attributes
    ----------
    cubics : (k, 4, 2) float
        Control points of cubic pieces that join; straight lines are cubics as well.
    closed : bool
    """

    cubics: Array
    closed: bool


def polyline(points: Array, *, closed: bool) -> Subpath:
    """Return straight lines through points, shape (n, 2), ``n >= 1``."""
    ring = np.vstack((points, points[:1])) if closed else points
    begin, end = ring[:-1], ring[1:]
    thirds = (begin, begin + (end - begin) / 3, end - (end - begin) / 3, end)
    return Subpath(np.stack(thirds, axis=1), closed)


def ellipse(center: Point, radii: Point) -> Subpath:
    """Return a whole ellipse, from its rightmost point clockwise on the canvas."""
    unit = _arc_pieces(0.0, 2 * math.pi)
    cubics = np.stack(
        (center.real + radii.real * unit.real, center.imag + radii.imag * unit.imag), axis=-1
    )
    cubics[-1, 3] = cubics[0, 0]
    return Subpath(cubics, True)


def chord_counts(subpath: Subpath, tolerance: float) -> NDArray[np.int64]:
    """Return how many chords `flatten` gives to each cubic of a subpath."""
    bend = np.linalg.norm(np.diff(subpath.cubics, n=2, axis=1), axis=2).max(axis=1)
    return np.asarray(np.maximum(np.ceil(np.sqrt(0.75 * bend / tolerance)), 1), np.int64)


def flatten(subpath: Subpath, tolerance: float) -> Array:
    """Return points on a subpath whose chords stay within the tolerance of the curve.

    A cubic strays from ``n`` equal chords by at most ``|B''| / 8n²``, and its second
    derivative is at most six times its largest second difference.

    Parameters
    ----------
    subpath : Subpath
        The curve.
    tolerance : float
        In the units of the control points.

    Returns
    -------
    (n, 2) float
        A closed subpath ends on its first point.
    """
    p = subpath.cubics
    pieces = chord_counts(subpath, tolerance)
    at_most(int(pieces.sum()), MAX_SAMPLES, "points in one line")
    if len(pieces) == pieces.sum():
        return np.vstack((p[0, :1], p[:, 3]))
    owner = np.repeat(np.arange(len(p)), pieces)
    first = np.repeat(np.cumsum(pieces) - pieces, pieces)
    u = ((np.arange(len(owner)) - first + 1) / pieces[owner])[:, None]
    a, b, c, d = (p[owner, k] for k in range(4))
    points = (1 - u) ** 3 * a + 3 * (1 - u) ** 2 * u * b + 3 * (1 - u) * u**2 * c + u**3 * d
    points[np.cumsum(pieces) - 1] = p[:, 3]  # ends exactly, so that closed means closed
    return np.vstack((p[0, :1], points))


# -- parsing -----------------------------------------------------------------------------------


def parse_path(data: str) -> list[Subpath]:
    """Parse the ``d`` attribute of a path.

    Returns
    -------
    list of Subpath
        Those that consist of a mere "move to" are left out.

    Raises
    ------
    FormatError
        Where the data breaks the grammar; the message quotes the place.
    """
    pen = _Pen()
    for count, (command, numbers) in enumerate(_commands(data), 1):
        at_most(count, MAX_PIECES, "commands in one path")
        pen.take(command, numbers)
    return pen.finished()


def _commands(data: str) -> Iterator[tuple[str, list[float]]]:
    """Yield commands with exactly their numbers; repeated arguments as repeated commands."""
    at = BLANK.match(data, 0).end()  # type: ignore[union-attr]
    command = ""
    while at < len(data):
        match = TOKEN.match(data, at)
        if match is None:
            raise _broken(data, at)
        if match[1].isalpha():
            command, at = match[1], match.end()
            if command.upper() not in ARGUMENTS:
                raise _broken(data, match.start(1))
        elif command in ("", "Z", "z"):
            raise _broken(data, at)
        elif command in "Mm":
            command = "L" if command == "M" else "l"  # what follows a move is lines
        numbers: list[float] = []
        for place in range(ARGUMENTS[command.upper()]):
            flag = command in "Aa" and place in (3, 4)
            match = (FLAG if flag else TOKEN).match(data, at)
            if match is None or match[1].isalpha():
                raise _broken(data, at)
            numbers.append(float(match[1]))
            at = match.end()
        if not all(abs(number) <= MAX_COORDINATE for number in numbers):
            raise _broken(data, at)
        yield command, numbers
        at = BLANK.match(data, at).end()  # type: ignore[union-attr]


def _broken(data: str, at: int) -> FormatError:
    return FormatError(f"A path cannot be understood at “{data[at : at + 20].strip()}”.")


class _Pen:
    """Current state while path data are read."""

    def __init__(self) -> None:
        self.at: Point = 0j
        self.start: Point = 0j
        self.handle: Point = 0j
        self.last = ""
        self.pieces: list[tuple[Point, Point, Point, Point]] = []
        self.done: list[Subpath] = []

    def finished(self) -> list[Subpath]:
        self._lift(closed=False)
        return self.done

    def _lift(self, *, closed: bool) -> None:
        if self.pieces:
            corners = np.array(self.pieces)
            self.done.append(Subpath(np.stack((corners.real, corners.imag), axis=-1), closed))
        self.pieces = []

    def take(self, command: str, numbers: list[float]) -> None:
        """Carry out one command."""
        kind = command.upper()
        origin = self.at if command.islower() else 0j
        if not self.last and kind != "M":
            raise FormatError("A path does not begin with a “move to”.")
        pairs = [complex(*numbers[k : k + 2]) + origin for k in range(0, len(numbers) - 1, 2)]
        match kind:
            case "M":
                self._lift(closed=False)
                self.at = self.start = pairs[0]
            case "Z":
                if self.at != self.start:
                    self._line(self.start)
                self._lift(closed=True)
                self.at = self.start
            case "L":
                self._line(pairs[0])
            case "H":
                self._line(complex(origin.real + numbers[0], self.at.imag))
            case "V":
                self._line(complex(self.at.real, origin.imag + numbers[0]))
            case "C":
                self._cubic(*pairs)
            case "S":
                reflected = 2 * self.at - self.handle if self.last in "CS" else self.at
                self._cubic(reflected, *pairs)
            case "Q":
                self._quadratic(*pairs)
            case "T":
                reflected = 2 * self.at - self.handle if self.last in "QT" else self.at
                self._quadratic(reflected, pairs[0])
            case "A":
                end = complex(numbers[5], numbers[6]) + origin
                self._arc(complex(*numbers[:2]), numbers[2], numbers[3] > 0, numbers[4] > 0, end)
        self.last = kind

    def _line(self, end: Point) -> None:
        step = (end - self.at) / 3
        self.pieces.append((self.at, self.at + step, end - step, end))
        self.at = end

    def _cubic(self, one: Point, two: Point, end: Point) -> None:
        self.pieces.append((self.at, one, two, end))
        self.handle, self.at = two, end

    def _quadratic(self, one: Point, end: Point) -> None:
        begin = self.at
        self.pieces.append((begin, begin + 2 / 3 * (one - begin), end + 2 / 3 * (one - end), end))
        self.handle, self.at = one, end

    def _arc(self, radii: Point, degrees: float, large: bool, sweep: bool, end: Point) -> None:
        """Add an elliptical arc from its end points (SVG 1.1, appendix F.6.5)."""
        begin = self.at
        rx, ry = abs(radii.real), abs(radii.imag)
        if begin == end:
            return
        if min(rx, ry) <= FLAT * max(rx, ry, abs(begin - end)):
            self._line(end)
            return
        turn = complex(math.cos(math.radians(degrees)), math.sin(math.radians(degrees)))
        half = (begin - end) / 2 * turn.conjugate()
        x, y = half.real / rx, half.imag / ry
        reach = x * x + y * y
        if reach > 1:  # radii too small: grown until they just reach
            rx, ry = rx * math.sqrt(reach), ry * math.sqrt(reach)
            x, y, reach = x / math.sqrt(reach), y / math.sqrt(reach), 1.0
        lift = math.sqrt(max(1 / reach - 1, 0.0)) if reach > 0 else 0.0
        if large == sweep:
            lift = -lift
        center = complex(lift * y, -lift * x)
        first = math.atan2(y - center.imag, x - center.real)
        last = math.atan2(-y - center.imag, -x - center.real)
        span = last - first
        if sweep and span < 0:
            span += 2 * math.pi
        if not sweep and span > 0:
            span -= 2 * math.pi
        unit = _arc_pieces(first, span) + center
        cubics = (unit.real * rx + 1j * unit.imag * ry) * turn + (begin + end) / 2
        cubics[0, 0], cubics[-1, 3] = begin, end
        self.pieces += [(a, b, c, d) for a, b, c, d in cubics.tolist()]
        self.at = end


def _arc_pieces(first: float, span: float) -> NDArray[np.complex128]:
    """Return cubics along the unit circle, shape (k, 4)."""
    count = max(1, math.ceil(abs(span) / ARC_PIECE - 1e-9))
    angle = first + span * np.arange(count + 1) / count
    on = np.exp(1j * angle)
    handle = 1j * on * (4 / 3 * math.tan(span / count / 4))
    return np.stack((on[:-1], on[:-1] + handle[:-1], on[1:] - handle[1:], on[1:]), axis=1)
