"""Faces cut by curves: into pieces, each within loops of its own."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Face, ParameterCurve, Trim
from bozzetto.ink import signed_area
from bozzetto_product.details.course import CROSSES, Crossing
from bozzetto_product.details.shell import EdgePieces

if TYPE_CHECKING:
    import shapely

SAMPLES: Final = 20
"""Places on each span of a side for the polygon of its loop."""


@dataclass(frozen=True, eq=False)
class Chord:
    """Edges that follow one another over a face: round, or from its border to its border.

    Parameters
    ----------
    sides : tuple of (int, ParameterCurve)
        Numbers of edges, each with its image in the face, run forward.
    entry, leave : Crossing, optional
        Where it comes from the border and goes to it; None for what is closed within the face.
    """

    sides: tuple[tuple[int, ParameterCurve], ...]
    entry: Crossing | None
    leave: Crossing | None


def cut_face(face: Face, chords: Sequence[Chord], pieces: EdgePieces) -> tuple[Face, ...]:
    """Return the pieces of a face between its border and chords.

    Parameters
    ----------
    face : Face
        Its sides are cut already where chords meet them.
    chords : sequence of Chord
        None crosses another one.
    pieces : EdgePieces
        Where edges were cut.

    Raises
    ------
    UserError
        If chords cross one another.
    """
    follows: dict[tuple[int, bool], Trim] = {}
    trims: dict[tuple[int, bool], Trim] = {}
    for loop in face.loops:
        for trim, after in zip(loop, (*loop[1:], loop[0]), strict=True):
            trims[_key(trim)] = trim
            follows[_key(trim)] = after
    for chord in chords:
        forth = [Trim(edge, True, path) for edge, path in chord.sides]
        back = [Trim(edge, False, path) for edge, path in reversed(chord.sides)]
        for trim in (*forth, *back):
            trims[_key(trim)] = trim
        for row in (forth, back):
            for trim, after in itertools.pairwise(row):
                follows[_key(trim)] = after
        if chord.entry is None or chord.leave is None:
            follows[_key(forth[-1])] = forth[0]
            follows[_key(back[-1])] = back[0]
            continue
        into, out_of = (_around(face, one, pieces) for one in (chord.entry, chord.leave))
        follows[_key(into[0])], follows[_key(back[-1])] = forth[0], into[1]
        follows[_key(out_of[0])], follows[_key(forth[-1])] = back[0], out_of[1]
    return tuple(_faces(face, list(_cycles(trims, follows))))


def _key(trim: Trim) -> tuple[int, bool]:
    assert trim.edge is not None
    return trim.edge, trim.forward


def _around(face: Face, crossing: Crossing, pieces: EdgePieces) -> tuple[Trim, Trim]:
    """Return the sides of a face before and behind a place at which an edge was cut."""
    at, numbers = pieces[crossing.edge]
    place = at.index(crossing.at)
    own = {numbers[place], numbers[place + 1]}
    for loop in face.loops:
        for trim, after in zip(loop, (*loop[1:], loop[0]), strict=True):
            if {trim.edge, after.edge} == own:
                return trim, after
    raise UserError(CROSSES)


def _cycles(
    trims: dict[tuple[int, bool], Trim], follows: dict[tuple[int, bool], Trim]
) -> Iterator[tuple[Trim, ...]]:
    left = dict(trims)
    while left:
        key, trim = next(iter(left.items()))
        row = []
        while key in left:
            row.append(left.pop(key))
            trim = follows[key]
            key = _key(trim)
        yield tuple(row)


def ring_of(loop: Sequence[Trim]) -> Array:
    """Return a polygon near a loop, in u and v, (n, 2)."""
    rows = []
    for trim in loop:
        places = trim.curve.polyline(SAMPLES)
        rows.append((places if trim.forward else places[::-1])[:-1])
    return np.concatenate(rows)


def _faces(face: Face, cycles: Sequence[tuple[Trim, ...]]) -> Iterator[Face]:
    """Yield faces: each cycle that runs counter-clockwise, with those holes that are in it."""
    import shapely

    rings = [ring_of(cycle) for cycle in cycles]
    areas = [signed_area(ring) for ring in rings]
    outer = [k for k, area in enumerate(areas) if area > 0.0]
    polygons = {k: shapely.Polygon(rings[k]) for k in outer}
    if any(not polygon.is_valid for polygon in polygons.values()):
        raise UserError(CROSSES)
    holes: dict[int, list[int]] = {k: [] for k in outer}
    for k, area in enumerate(areas):
        if area <= 0.0:
            holes[_home(k, cycles, rings, areas, polygons)].append(k)
    for k in outer:
        if not shapely.Polygon(rings[k], [rings[h] for h in holes[k]]).is_valid:
            raise UserError(CROSSES)
        loops = (cycles[k], *(cycles[h] for h in holes[k]))
        yield replace(face, loops=loops)


def _home(
    hole: int,
    cycles: Sequence[tuple[Trim, ...]],
    rings: Sequence[Array],
    areas: Sequence[float],
    polygons: dict[int, shapely.Polygon],
) -> int:
    """Return the smallest of the outer loops that a hole lies in."""
    import shapely

    own = {trim.edge for trim in cycles[hole]}
    place = shapely.Polygon(rings[hole]).representative_point()
    around = [
        k
        for k, polygon in polygons.items()
        if areas[k] > -areas[hole]
        and own.isdisjoint({trim.edge for trim in cycles[k]})
        and polygon.contains(place)
    ]
    if not around:
        raise UserError(CROSSES)
    return min(around, key=lambda k: areas[k])
