"""Regions of a shell: cut out along their outlines, and what stands in their place."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import BSplineSurface, Face, ParameterCurve
from bozzetto.plugin import remembered
from bozzetto_product.details.chart import Chart, parameters_at
from bozzetto_product.details.course import CROSSES, SHORT, TURNED, Passage
from bozzetto_product.details.face_cuts import Chord, cut_face, ring_of
from bozzetto_product.details.joint_edges import FittedEdge, Track, fitted_edges
from bozzetto_product.details.levels import Ends, Level, track_on_floor
from bozzetto_product.details.ring import Ring
from bozzetto_product.details.shell import Owner, Shell, is_smooth

SAME_BREAK: Final = 1e-6
"""Least difference of parameters between ends of edges of an outline."""

BESIDE: Final = 1e-11
"""Share of the range of u or v by which an edge may end beside the edge that it crosses."""


@dataclass(frozen=True, eq=False)
class OutlineEdge:
    """A part of an outline, and of what its walls end in."""

    ring: int
    start: float
    end: float
    top: FittedEdge
    bottom: FittedEdge | None


@dataclass(frozen=True, eq=False)
class Seat:
    """What the wall of one edge of an outline ends in.

    Parameters
    ----------
    level : Level, optional
    ends : (start, end)
        Where on the floor it begins and ends, as u and v; None where the level says so.
    """

    level: Level | None
    ends: Ends = (None, None)


def first_face(shell: Shell, chart: Chart, place: Array, near: Array, outward: float) -> int:
    """Return the face over a place of the chart that is nearest to a point.

    Raises
    ------
    UserError
        If there is none.
    """
    best, found = np.inf, -1
    for number, where in faces_over(shell, chart, place, outward):
        gap = float(np.linalg.norm(where - near))
        if gap < best:
            best, found = gap, number
    if found < 0:
        raise UserError(TURNED)
    return found


def faces_over(shell: Shell, chart: Chart, place: Array, outward: float) -> list[tuple[int, Array]]:
    """Return faces over a place of the chart that are no walls, with the point in space."""
    import shapely

    rows = []
    for number, (face, owner) in enumerate(zip(shell.faces, shell.owners, strict=True)):
        if owner.is_wall:
            continue
        net = chart.flat(face.surface.control_points.reshape(-1, 3))
        if (place < net.min(axis=0)).any() or (place > net.max(axis=0)).any():
            continue
        at = parameters_at(face.surface, chart, place[None], outward)
        if not np.isfinite(at).all():
            continue
        polygon = shapely.Polygon(
            ring_of(face.loops[0]), [ring_of(loop) for loop in face.loops[1:]]
        )
        if polygon.buffer(1e-9).contains(shapely.Point(at[0])):
            rows.append((number, face.surface.value(*at.T)[0]))
    return rows


def region_faces(
    shell: Shell, chart: Chart, ring: Ring, first: Sequence[int], *, creased: bool = False
) -> tuple[int, ...]:
    """Return faces that may lie under a region: those of its outline, and what joins them.

    Over creases only where that is said.
    """
    low, high = ring.polyline.min(axis=0), ring.polyline.max(axis=0)
    found, waiting = set(first), list(first)
    while waiting:
        number = waiting.pop()
        for trim in shell.faces[number].trims:
            for other, side in shell.users[trim.edge or 0] if trim.edge is not None else ():
                if other in found or (shell.owners[other].is_wall and not creased):
                    continue
                net = chart.flat(shell.faces[other].surface.control_points.reshape(-1, 3))
                apart = (net.max(axis=0) < low).any() or (net.min(axis=0) > high).any()
                if apart or not (creased or is_smooth(shell, number, trim, other, side)):
                    continue
                found.add(other)
                waiting.append(other)
    return tuple(sorted(found))


# -- outlines as edges -------------------------------------------------------------------------


def outline_edges(
    shell: Shell,
    chart: Chart,
    rings: Sequence[Ring],
    courses: Sequence[Sequence[Passage]],
    level: Level | None,
    far: Sequence[Sequence[Passage]],
    seats: Sequence[Seat] = (),
) -> tuple[OutlineEdge, ...]:
    """Return the edges of outlines, cut wherever they pass from face to face.

    Walls end in a level, or where each edge has one of its own, in that.
    """
    made: list[OutlineEdge] = []
    for number, (ring, course) in enumerate(zip(rings, courses, strict=True)):
        places = [float(k) for k in range(len(ring.stretches) + 1)]
        first, last = course[0].start, course[-1].end
        places = [place for place in places if first < place < last] + [first, last]
        places += [p.start for p in course[1:]]
        if far:
            places += [p.start for p in far[number][1:]]
        breaks = _merged(places)
        for start, end in itertools.pairwise(breaks):
            middle = 0.5 * (start + end)
            over = shell.faces[_at(course, middle)].surface
            under = shell.faces[_at(far[number], middle)].surface if far else None
            own = seats[len(made)] if seats else Seat(level)
            run = (start, end)
            edge = _edge(chart, ring, number, run, over, own.level, own.ends, under, shell.size)
            top = _met(shell, course, start, end, edge.top)
            bottom = edge.bottom
            if far and bottom is not None:
                bottom = _met(shell, far[number], start, end, bottom)
            if top is not edge.top or bottom is not edge.bottom:
                edge = replace(edge, top=top, bottom=bottom)
            made.append(edge)
    return tuple(made)


def _met(
    shell: Shell, course: Sequence[Passage], start: float, end: float, fitted: FittedEdge
) -> FittedEdge:
    """Return an edge that begins and ends in the very places of the edges that it crosses.

    Edges of details are fitted: their images in faces are beside them by up to `EXACT`, and faces
    ask for less between sides that follow one another.
    """
    for passage in course:
        for crossing, at, row in ((passage.entry, start, 0), (passage.leave, end, -1)):
            if crossing is None or abs(crossing.t - at) > SAME_BREAK:
                continue
            trim = next(t for n, t in shell.users[crossing.edge] if n == passage.face)
            place = np.array([crossing.at])
            path, point = trim.curve.value(place)[0], shell.edges[crossing.edge].value(place)[0]
            off = np.abs(fitted.path.control_points[row] - path)
            if (off > BESIDE * np.ptp(shell.faces[passage.face].surface.ranges, axis=1)).any():
                paths, points = (
                    fitted.path.control_points.copy(),
                    fitted.curve.control_points.copy(),
                )
                paths[row], points[row] = path, point
                fitted = FittedEdge(
                    replace(fitted.curve, control_points=points),
                    replace(fitted.path, control_points=paths),
                )
    return fitted


def _merged(places: Sequence[float]) -> list[float]:
    row: list[float] = []
    for place in sorted(set(places)):
        if not row or place - row[-1] > SAME_BREAK:
            row.append(place)
    return row


def _at(course: Sequence[Passage], t: float) -> int:
    return next((p.face for p in course if p.start <= t <= p.end), course[-1].face)


@remembered(limit=1024)
def _edge(
    chart: Chart,
    ring: Ring,
    number: int,
    run: tuple[float, float],
    over: BSplineSurface,
    level: Level | None,
    ends: Ends,
    under: BSplineSurface | None,
    size: float,
) -> OutlineEdge:
    """Return a part of an outline on one surface, with what its wall ends in, if anywhere.

    It does not depend on how the face is trimmed: other details leave it as it is.
    """
    tracks = [_track_over(over, chart, ring, 1.0)]
    if under is not None and level is not None:
        tracks.append(_track_over(under, chart, level.rings[number], -1.0))
    elif level is not None and level.floor is not None:
        tracks.append(track_on_floor(level, number, len(ring.stretches), run, over, ends))
    fitted = fitted_edges(tracks, *run, size)
    return OutlineEdge(number, *run, fitted[0], fitted[1] if len(fitted) > 1 else None)


def _track_over(surface: BSplineSurface, chart: Chart, ring: Ring, outward: float) -> Track:
    def parameters(t: Array) -> Array:
        found = parameters_at(surface, chart, ring.value(t), outward)
        if not np.isfinite(found).all():
            raise UserError(TURNED)
        return found

    return Track(surface, parameters)


# -- cutting -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class CutShell:
    """A shell cut along outlines.

    Parameters
    ----------
    shell : Shell
        Its last edges are those of the outlines: first all at the top, then all at the far side.
    tops, bottoms : tuple of int
        Numbers of these edges; no bottoms without a far side.
    inside : frozenset of int
        Faces within the outlines, on both sides.
    """

    shell: Shell
    tops: tuple[int, ...]
    bottoms: tuple[int, ...]
    inside: frozenset[int]


def cut_shell(
    shell: Shell,
    edges: Sequence[OutlineEdge],
    courses: Sequence[Sequence[Passage]],
    far: Sequence[Sequence[Passage]],
    *,
    closed: bool = True,
    walls: bool = False,
) -> CutShell:
    """Return the shell with its faces cut along outlines.

    Parameters
    ----------
    shell : Shell
        What is cut.
    edges : sequence of OutlineEdge
        Along which.
    courses, far : sequence of sequence of Passage
        The faces under the outlines, and on the far side of the body.
    closed : bool
        Whether the outlines are closed; else the smaller part of the patches is inside.
    walls : bool
        Whether walls of details may lie inside.
    """
    cuts: dict[int, list[float]] = {}
    for course in (*courses, *far):
        for passage in course:
            for crossing in (passage.entry, passage.leave):
                if crossing is not None:
                    cuts.setdefault(crossing.edge, []).append(crossing.at)
    split, pieces = shell.with_edges_split(cuts)
    tops = tuple(range(len(split.edges), len(split.edges) + len(edges)))
    bottoms = tuple(range(tops[-1] + 1, tops[-1] + 1 + len(edges))) if far else ()
    new = [edge.top.curve for edge in edges]
    new += [edge.bottom.curve for edge in edges if edge.bottom is not None] if far else []
    chords: dict[int, list[Chord]] = {}
    for number, course in enumerate(courses):
        own = [(e, k) for e, k in zip(edges, tops, strict=True) if e.ring == number]
        _add_chords(chords, course, [(e, k, e.top.path) for e, k in own])
    for number, course in enumerate(far):
        own = [(e, k) for e, k in zip(edges, bottoms, strict=True) if e.ring == number]
        _add_chords(chords, course, [(e, k, e.bottom.path) for e, k in own if e.bottom is not None])
    faces: list[Face] = []
    owners: list[Owner] = []
    for number, (face, owner) in enumerate(zip(split.faces, split.owners, strict=True)):
        row = cut_face(face, chords[number], pieces) if number in chords else (face,)
        faces += row
        owners += [owner] * len(row)
    whole = Shell((*split.edges, *new), tuple(faces), tuple(owners))
    if closed:
        inside = _inside(whole, set(tops), set(bottoms), walls=walls)
    else:
        inside = _lesser(whole, set(tops))
    return CutShell(whole, tops, bottoms, inside)


def _add_chords(
    chords: dict[int, list[Chord]],
    course: Sequence[Passage],
    edges: Sequence[tuple[OutlineEdge, int, ParameterCurve]],
) -> None:
    rows = [
        (p, [(k, path) for e, k, path in edges if p.start < 0.5 * (e.start + e.end) < p.end])
        for p in course
    ]
    joined = course[0].entry is None and course[-1].leave is None
    if joined and len(course) > 1:
        (first, sides), (last, before) = rows[0], rows[-1]
        merged = replace(last, leave=first.leave)
        rows = [(merged, before + sides), *rows[1:-1]]
    for passage, sides in rows:
        chord = Chord(tuple(sides), passage.entry, passage.leave)
        chords.setdefault(passage.face, []).append(chord)


def _inside(shell: Shell, tops: set[int], bottoms: set[int], *, walls: bool) -> frozenset[int]:
    """Return faces on the left of outlines, as the chart sees them, and all between.

    Raises
    ------
    UserError
        If inside and outside hang together, or a wall lies inside that may not.
    """
    found: set[int] = set()
    outside: set[int] = set()
    for number, face in enumerate(shell.faces):
        for trim in face.trims:
            if trim.edge in tops or trim.edge in bottoms:
                left = trim.forward == (trim.edge in tops)
                (found if left else outside).add(number)
    found = flooded(shell, tops | bottoms, found, walls=walls)
    if found & outside:
        raise UserError(TURNED)
    return frozenset(found)


def _lesser(shell: Shell, tops: set[int]) -> frozenset[int]:
    """Return the side of smaller area of patches that are parted by edges.

    Raises
    ------
    UserError
        If they are not parted.
    """
    sides: tuple[set[int], set[int]] = (set(), set())
    for edge in tops:
        for number, trim in shell.users[edge]:
            sides[trim.forward].add(number)
    for side in sides:
        waiting = list(side)
        while waiting:
            number = waiting.pop()
            for trim in shell.faces[number].trims:
                if trim.edge is None or trim.edge in tops:
                    continue
                for other, _ in shell.users[trim.edge]:
                    same = shell.owners[other].is_of_one_area(shell.owners[number])
                    if same and other not in side:
                        side.add(other)
                        waiting.append(other)
    if sides[0] & sides[1]:
        raise UserError(SHORT)
    return frozenset(min(sides, key=lambda side: sum(_area(shell.faces[k]) for k in side)))


def _area(face: Face) -> float:
    """Return about the area of a face: that of the polygons of its loops."""
    rings = [face.surface.value(*ring_of(loop).T) for loop in face.loops]
    crosses = [cross_product(ring, np.roll(ring, -1, axis=0)).sum(axis=0) for ring in rings]
    return 0.5 * float(np.linalg.norm(sum(crosses)))


def flooded(
    shell: Shell, border: set[int], first: Iterable[int] = (), *, walls: bool = False
) -> set[int]:
    """Return faces that hang together with given ones, up to certain edges.

    Parameters
    ----------
    shell : Shell
        What they belong to.
    border : set of int
        Edges that are not crossed.
    first : iterable of int
        Where to begin; by default beside these edges, but on no wall.
    walls : bool
        Whether walls of details are crossed.

    Raises
    ------
    UserError
        If a detail lies between them.
    """
    found = set(first) or {
        number
        for edge in border
        for number, _ in shell.users[edge]
        if not shell.owners[number].is_wall
    }
    waiting = list(found)
    while waiting:
        number = waiting.pop()
        for trim in shell.faces[number].trims:
            if trim.edge is None or trim.edge in border:
                continue
            for other, _ in shell.users[trim.edge]:
                if other in found:
                    continue
                if not walls and shell.owners[other].is_wall:
                    raise UserError(CROSSES)
                found.add(other)
                waiting.append(other)
    return found
