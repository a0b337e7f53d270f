"""Regions of a drawing of visible lines, and lines that end on others because they go behind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.planar_faces import inside

MIDDLE: Final = 0.04
"""Distance from the ends of a line beyond which another one ends on its middle, diagonals."""


STRAIGHT: Final = np.radians(20.0)
"""Angle up to which two lines may go straight on through a corner."""

BESIDE: Final = (0.003, 2.0)
"""Distance of the corner from the line that they make, up to which they do: diagonals, and more for
each diagonal of noise."""


@dataclass(frozen=True, eq=False)
class Junctions:
    """Where lines end on the middle of others.

    Parameters
    ----------
    is_stem : (n,) bool
        Whether a corner is the end of a single line.
    on_line : (n,) intp
        The line on whose middle such a corner lies; -1 for none.
    """

    is_stem: Flags
    on_line: Index


def with_passing_lines(drawing: Drawing) -> Drawing:
    """Return a drawing in which two of three lines that go straight on through a corner are one.

    The third one goes behind it there: no corner of a solid lies on an edge that goes on, and few
    look so by chance.

    Parameters
    ----------
    drawing : Drawing
        Corners and visible lines.
    """
    lines = [tuple(pair) for pair in drawing.lines.tolist()]
    light = drawing.light.tolist()
    for corner in range(len(drawing.points)):
        here = [k for k, pair in enumerate(lines) if corner in pair]
        if len(here) != 3:
            continue
        ends = [sum(lines[k]) - corner for k in here]
        spans = drawing.points[ends] - drawing.points[corner]
        spans /= np.linalg.norm(spans, axis=1, keepdims=True)
        cosines = spans @ spans.T
        one, other = divmod(int(cosines.argmin()), 3)
        joined = (min(ends[one], ends[other]), max(ends[one], ends[other]))
        way = drawing.points[joined[1]] - drawing.points[joined[0]]
        off = drawing.points[corner] - drawing.points[joined[0]]
        away = abs(way[0] * off[1] - way[1] * off[0]) / max(1e-9, float(np.hypot(*way)))
        bent = cosines[one, other] > -np.cos(STRAIGHT)
        if bent or away > BESIDE[0] + BESIDE[1] * drawing.noise or joined in lines:
            continue
        first, second = sorted((here[one], here[other]))
        lines[first] = joined
        light[first] = 0.5 * (light[first] + light[second])
        del lines[second], light[second]
    return replace(drawing, lines=np.array(lines, np.intp).reshape(-1, 2), light=np.array(light))


def junctions_of(drawing: Drawing, reach: float) -> Junctions:
    """Find the ends of single lines, and the lines that they lie on.

    Parameters
    ----------
    drawing : Drawing
        Corners and visible lines.
    reach : float
        Distance within which an end lies on a line, diagonals.
    """
    degrees = np.bincount(drawing.lines.ravel(), minlength=len(drawing.points))
    stems: Flags = degrees == 1
    on_line = np.full(len(drawing.points), -1, np.intp)
    starts = drawing.points[drawing.lines[:, 0]]
    spans = drawing.spans
    square = np.maximum((spans**2).sum(1), 1e-12)
    margin = MIDDLE / np.sqrt(square)
    for corner in np.flatnonzero(stems).tolist():
        at = ((drawing.points[corner] - starts) * spans).sum(1) / square
        away = np.linalg.norm(drawing.points[corner] - starts - at[:, None] * spans, axis=1)
        hit = (at > margin) & (at < 1.0 - margin) & ~(drawing.lines == corner).any(1)
        away = np.where(hit, away, np.inf)
        if len(away) and away.min() < reach:
            on_line[corner] = int(away.argmin())
    return Junctions(stems, on_line)


def regions_of(drawing: Drawing, junctions: Junctions) -> list[tuple[int, ...]]:
    """Return the rings of corners around the bounded regions of a planar drawing.

    Ends of lines on the middle of others bound regions, and are left out of rings where the
    boundary goes straight through.

    Parameters
    ----------
    drawing : Drawing
        Corners and visible lines, which meet in corners or end on one another.
    junctions : Junctions
        Those ends.
    """
    return [
        ring for ring in _boundaries(drawing, junctions) if _area(drawing.points[list(ring)]) > 0
    ]


def holes_in(drawing: Drawing, junctions: Junctions, ring: Sequence[int]) -> list[Ring]:
    """Return rings around lines that appear inside a ring and that no line joins to it.

    Parameters
    ----------
    drawing : Drawing
        Corners and visible lines.
    junctions : Junctions
        Ends of lines that go behind others.
    ring : sequence of int
        Corners of the outer ring.
    """
    outer = drawing.points[list(ring)]
    return [
        each
        for each in outer_rings(drawing, junctions)
        if not set(each) & set(ring) and bool(inside(drawing.points[list(each)], outer).all())
    ]


def outer_rings(drawing: Drawing, junctions: Junctions) -> list[Ring]:
    """Return rings around all that hangs together, counter-clockwise.

    Parameters
    ----------
    drawing : Drawing
        Corners and visible lines.
    junctions : Junctions
        Ends of lines that go behind others.
    """
    return [
        each[::-1]
        for each in _boundaries(drawing, junctions)
        if len(each) > 2 and _area(drawing.points[list(each)]) < 0.0
    ]


def _boundaries(drawing: Drawing, junctions: Junctions) -> list[Ring]:
    """Return rings around regions, bounded ones counter-clockwise, the others the other way round.

    Those that pass a corner twice are left out.
    """
    turns = _turns(drawing, _pieces(drawing, junctions))
    left = set(turns)
    found = []
    while left:
        start = min(left)
        ring = [start]
        left.discard(start)
        while turns[ring[-1]] != start:
            ring.append(turns[ring[-1]])
            left.discard(ring[-1])
        corners = [side[0] for side in ring]
        if len(set(corners)) < len(corners):
            continue
        passed = [_passes(junctions, drawing, ring[k - 1], side) for k, side in enumerate(ring)]
        found.append(tuple(c for c, through in zip(corners, passed, strict=True) if not through))
    return found


def _pieces(drawing: Drawing, junctions: Junctions) -> list[tuple[int, int]]:
    """Cut lines where others end on them, and leave out what hangs loose."""
    made: list[tuple[int, int]] = []
    for number, (first, second) in enumerate(drawing.lines.tolist()):
        on = np.flatnonzero(junctions.on_line == number)
        along = (drawing.points[on] - drawing.points[first]) @ drawing.spans[number]
        chain = [first, *on[np.argsort(along, kind="stable")].tolist(), second]
        made += pairwise(chain)
    while True:
        degrees = np.bincount(np.array(made, np.intp).ravel(), minlength=len(drawing.points))
        kept = [pair for pair in made if degrees[pair[0]] > 1 and degrees[pair[1]] > 1]
        if len(kept) == len(made):
            return made
        made = kept


def _turns(
    drawing: Drawing, pieces: list[tuple[int, int]]
) -> dict[tuple[int, int], tuple[int, int]]:
    """Return for each directed piece the one that follows it around the region to its left."""
    around: dict[int, list[int]] = {}
    for first, second in pieces:
        around.setdefault(first, []).append(second)
        around.setdefault(second, []).append(first)
    made = {}
    for corner, others in around.items():
        spans = drawing.points[others] - drawing.points[corner]
        order = [others[k] for k in np.argsort(np.arctan2(spans[:, 1], spans[:, 0]))]
        for place, other in enumerate(order):
            made[(other, corner)] = (corner, order[place - 1])
    return made


def _passes(
    junctions: Junctions, drawing: Drawing, before: tuple[int, int], after: tuple[int, int]
) -> bool:
    """Whether the boundary goes straight through a corner along the line that it lies on."""
    number = int(junctions.on_line[after[0]])
    if number < 0:
        return False
    line = drawing.lines[number].tolist()

    def lies_on(corner: int) -> bool:
        return corner in line or int(junctions.on_line[corner]) == number

    return lies_on(before[0]) and lies_on(after[1])


def _area(ring: Array) -> float:
    following = np.roll(ring, -1, axis=0)
    return float((ring[:, 0] * following[:, 1] - ring[:, 1] * following[:, 0]).sum() / 2.0)
