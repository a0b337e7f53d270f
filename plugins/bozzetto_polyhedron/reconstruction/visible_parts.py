"""Parts of a drawing of visible lines that no line joins: pockets, holes and bosses in faces.

Each part is completed by itself. A rim in a face that surrounds it is one end of a pocket, whose
other end is told by a corner of it that is seen; where none is, the pocket goes through as far as
the edges of the body that leave that face. What stands in a face is a prism over its own visible
face, or symmetric. Lengths are shares of the diagonal.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, product
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.planar_embedding import Ring, components, neighbors_of
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.explained_ink import compared
from bozzetto_polyhedron.reconstruction.missing_lines import Whole
from bozzetto_polyhedron.reconstruction.planar_faces import inside
from bozzetto_polyhedron.reconstruction.visible_halves import mirrored_wholes
from bozzetto_polyhedron.reconstruction.visible_prisms import (
    distinct_steps,
    extruded,
    prism,
    steps_of,
)
from bozzetto_polyhedron.reconstruction.visible_regions import (
    Junctions,
    junctions_of,
    outer_rings,
    regions_of,
)

MOST_WAYS: Final = 3
"""Ways to complete one part that are kept."""

MOST_TOGETHER: Final = 6
"""Ways to complete all parts in one body that are kept."""

ALONG: Final = np.radians(6.0)
"""Angle up to which an edge of the body runs as lines that leave a rim."""


@dataclass(frozen=True, eq=False)
class VisiblePart:
    """Lines that hang together on the sheet.

    Parameters
    ----------
    drawing : Drawing
        All corners, and the lines of the part.
    junctions : Junctions
        Of these lines.
    """

    drawing: Drawing
    junctions: Junctions


def parts_of(drawing: Drawing, junctions: Junctions, reach: float) -> list[VisiblePart]:
    """Return the parts of a drawing, the largest on the sheet first.

    Parameters
    ----------
    drawing : Drawing
        Corners and visible lines.
    junctions : Junctions
        Ends of lines that go behind others, which hang together with these.
    reach : float
        Distance within which an end lies on a line.
    """
    behind = np.flatnonzero(junctions.on_line >= 0)
    ties = np.column_stack((behind, drawing.lines[junctions.on_line[behind], 0]))
    found = components(neighbors_of(np.concatenate((drawing.lines, ties))))
    found.sort(key=lambda part: -float(np.linalg.norm(np.ptp(drawing.points[list(part)], axis=0))))
    made = []
    for part in found:
        own = np.isin(drawing.lines[:, 0], part)
        alone = replace(drawing, lines=drawing.lines[own], light=drawing.light[own])
        made.append(VisiblePart(alone, junctions_of(alone, reach)))
    return made


def completed_parts(
    whole: Whole, parts: Sequence[VisiblePart], reach: float, most_unexplained: float
) -> Iterator[Whole]:
    """Yield a whole body with all other parts completed in it, by the fewest corners first.

    Parameters
    ----------
    whole : Whole
        Of the first part.
    parts : sequence of VisiblePart
        All of them.
    reach : float
        Distance within which places are one.
    most_unexplained : float
        Share of its ink that a completed part may leave unexplained.
    """
    ways = []
    for number, part in enumerate(parts[1:], 1):
        fit: list[Whole] = []
        for made in (_pockets(whole, parts, number, reach), _bosses(part, reach)):
            fit += [
                each
                for each in made
                if compared(part.drawing, part.junctions, each, reach)[1] <= most_unexplained
            ]
            if fit and _is_sunk(part):
                break
        ways.append(sorted(fit, key=lambda each: len(each.points))[:MOST_WAYS])
    if all(ways):
        for chosen in islice(product(*ways), MOST_TOGETHER):
            yield _together((whole, *chosen))


def _together(wholes: Sequence[Whole]) -> Whole:
    counts = np.cumsum([0, *(len(each.points) for each in wholes)])
    lines = [each.lines + start for each, start in zip(wholes, counts[:-1], strict=True)]
    return Whole(np.concatenate([each.points for each in wholes]), np.concatenate(lines))


def _pockets(
    whole: Whole, parts: Sequence[VisiblePart], number: int, reach: float
) -> Iterator[Whole]:
    """Yield prisms over the rim of one part in a body, as deep as corners of its own tell first."""
    part = parts[number]
    drawing = part.drawing
    for rim in outer_rings(drawing, part.junctions):
        _, own = steps_of(drawing, part.junctions, rim, np.arange(len(drawing.lines)))
        steps = distinct_steps(own, reach) or distinct_steps(
            _steps_through(whole, parts, number, rim), reach
        )
        for step in steps:
            yield prism(drawing, rim, drawing.points[list(rim)] + step, reach)


def _bosses(part: VisiblePart, reach: float) -> Iterator[Whole]:
    """Yield what stands in a face: prisms over a visible face, and symmetric solids."""
    yield from extruded(part.drawing, part.junctions, reach)
    yield from mirrored_wholes(part.drawing, part.junctions, reach)


def _is_sunk(part: VisiblePart) -> bool:
    """Return whether lines of a part go behind its own rim: then it is no boss, but a pocket."""
    rims = [corner for rim in outer_rings(part.drawing, part.junctions) for corner in rim]
    on_line = part.junctions.on_line[part.junctions.on_line >= 0]
    return bool(np.isin(part.drawing.lines[on_line], rims).all(axis=1).any())


def _steps_through(whole: Whole, parts: Sequence[VisiblePart], number: int, rim: Ring) -> Array:
    """Return the ways along edges of the body that leave the face around a rim, (k, 2).

    Where lines leave the rim, behind which they go, only edges along these.
    """
    part = parts[number]
    face = _face_around(parts, number, rim)
    if face is None:
        return np.zeros((0, 2))
    away = np.linalg.norm(whole.points[:, None] - face, axis=2)
    on_face = away.min(axis=1) < 1e-9
    ends = on_face[whole.lines]
    leaving = ends[:, 0] != ends[:, 1]
    spans = whole.points[whole.lines[leaving, 1]] - whole.points[whole.lines[leaving, 0]]
    spans *= np.where(ends[leaving, 0], 1.0, -1.0)[:, None]
    stems = part.junctions.is_stem[part.drawing.lines]
    on_rim = np.isin(part.drawing.lines, rim)
    sides = (stems & on_rim[:, ::-1]).any(axis=1)
    if not sides.any():
        return np.asarray(spans)
    sines = _sines(spans, part.drawing.spans[sides]).min(axis=1)
    return np.asarray(spans[sines < np.sin(ALONG)])


def _sines(ones: Array, others: Array) -> Array:
    """Return the sine of the angle of each of some spans with each of others, (k, m)."""
    first, second = (
        each / np.maximum(np.linalg.norm(each, axis=1, keepdims=True), 1e-12)
        for each in (ones, others)
    )
    crossed = first[:, None, 0] * second[:, 1] - first[:, None, 1] * second[:, 0]
    return np.asarray(np.abs(crossed))


def _face_around(parts: Sequence[VisiblePart], number: int, rim: Ring) -> Array | None:
    """Return the corners of the smallest face of another part that surrounds a rim, (k, 2)."""
    drawing = parts[number].drawing
    around = [
        drawing.points[list(ring)]
        for other, part in enumerate(parts)
        if other != number
        for ring in regions_of(part.drawing, part.junctions)
        if inside(drawing.points[list(rim)], drawing.points[list(ring)]).all()
    ]
    return min(around, key=lambda ring: float(np.prod(np.ptp(ring, axis=0))), default=None)
