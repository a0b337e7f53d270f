"""Lines that go on from the ends of an arc, and the corner that it rounds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.rounds.ink_samples import directions

GOES_ON: Final = np.cos(np.radians(35.0))
"""Cosine of the angle within which it does."""

TURNED_BACK: Final = np.cos(np.radians(30.0))
"""Cosine of the angle between two lines within which the arc between them is a half turn."""


@dataclass(frozen=True, eq=False)
class LineEnd:
    """An end of a straight stroke, or of a row of dashes: the number is −1 then."""

    number: int
    line: Array
    place: Array
    way: Array
    members: tuple[int, ...]


def both_ends(number: int, line: Array, members: tuple[int, ...]) -> list[LineEnd]:
    """Return both ends of a line, (2, 2); each way leads from the end along the line."""
    span = line[1] - line[0]
    length = float(np.linalg.norm(span))
    if not length > 0.0:
        return []
    way = span / length
    return [
        LineEnd(number, line, line[0], way, members),
        LineEnd(number, line, line[1], -way, members),
    ]


def ends_of(arc: Array) -> list[tuple[Array, Array]]:
    """Return both ends of an arc, each with the direction in which a line would go on."""
    ways = directions(arc)
    before, after = -ways[:4].mean(axis=0), ways[-4:].mean(axis=0)
    return [
        (arc[0], before / np.linalg.norm(before)),
        (arc[-1], after / np.linalg.norm(after)),
    ]


def line_at(lines: Sequence[LineEnd], place: Array, way: Array, reach: float) -> LineEnd | None:
    """Return the nearest of some ends from which a line goes on where something else ends.

    Along a row of dashes half of the distance counts: a dash of the arc may be taken for one of it.
    """
    best: tuple[float, LineEnd] | None = None
    for each in lines:
        away = each.place - place
        apart = float(np.linalg.norm(away))
        if each.number < 0:
            along = float(away @ each.way)
            apart = float(np.hypot(0.5 * along, np.linalg.norm(away - along * each.way)))
        if apart < (reach if best is None else best[0]) and float(each.way @ way) > GOES_ON:
            best = apart, each
    return None if best is None else best[1]


def corners_between(arc: Array, begin: LineEnd, end: LineEnd) -> Array | None:
    """Return where the lines at both ends of an arc would meet, or the corners of a square end."""
    first, one, second, other = begin.place, begin.way, end.place, end.way
    if float(one @ other) > TURNED_BACK:
        forward = -(one + other)
        forward = forward / np.linalg.norm(forward)
        across = second - first
        system = np.column_stack((forward, across))
        if abs(float(np.linalg.det(system))) < 0.2 * np.linalg.norm(across):
            return None
        reached = float(np.linalg.solve(system, (arc - first).T)[0].max())
        return np.stack((first + reached * forward, second + reached * forward))
    system = np.column_stack((one, -other))
    if abs(float(np.linalg.det(system))) < np.sin(np.radians(15.0)):
        return None
    back, _ = np.linalg.solve(system, second - first)
    corner = first + back * one
    ahead = float((corner - second) @ other)
    return corner[None] if back < 0.0 and ahead < 0.0 else None
