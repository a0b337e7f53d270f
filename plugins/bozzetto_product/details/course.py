"""The way of an outline over the faces of a shell: where it passes from one to the next."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Trim
from bozzetto_product.details.chart import Chart, parameters_at
from bozzetto_product.details.ring import Ring
from bozzetto_product.details.shell import CREASE, Shell

APART: Final = 1e-7
"""Least difference of parameters t between crossings."""

NEAR_END: Final = 1e-5
"""Share of an edge at its ends in which nothing crosses it: there is a corner."""

NEAR_START: Final = 1e-6
"""Share of the length of a ring from its start within which an edge is crossed at the start."""

NEAR: Final = 1e-4
"""Distance in space, as share of the size, within which a crossing is on the face walked."""

SAMPLES: Final = 8
"""Segments of each span of a curved edge for its polyline."""

ROUNDS: Final = 25
"""Most steps of Newton's method."""

MOST_PASSAGES: Final = 4000
"""Most faces that an outline walks through."""


REACH: Final = 0.1
"""Share of the length of an open curve by which it may miss the border at either end."""


class MeetsCorner(Exception):
    """An outline goes through a corner of faces, or along an edge."""


@dataclass(frozen=True)
class Crossing:
    """A place where an outline crosses an edge.

    Parameters
    ----------
    t : float
        Parameter of the outline.
    edge : int
    at : float
        Parameter of the edge.
    """

    t: float
    edge: int
    at: float


@dataclass(frozen=True)
class Passage:
    """A part of an outline on one face.

    Parameters
    ----------
    face : int
    start, end : float
        Parameters of the outline.
    entry, leave : Crossing, optional
        None where it begins or ends inside the face.
    """

    face: int
    start: float
    end: float
    entry: Crossing | None
    leave: Crossing | None


LEAVES: Final = (
    "The outline leaves the surface. Draw it inside, or from border to border for a split."
)
CROSSES: Final = (
    "The outline crosses another detail: only cuts and splits may. Draw it inside the other one or "
    "beside it."
)
TURNED: Final = (
    "The surface turns away under the outline. Draw it smaller, or on the side that faces you."
)
SHORT: Final = (
    "The line does not part the surface. Draw it from border to border, or as a closed round."
)
CORNER: Final = "The outline goes through a corner of surfaces. Move it a little."


def course_of(
    shell: Shell,
    chart: Chart,
    ring: Ring,
    first: int,
    outward: float,
    start: float = 0.0,
    *,
    walls: bool = False,
) -> tuple[Passage, ...]:
    """Return the faces that a ring walks over, in order.

    Parameters
    ----------
    shell : Shell
        What it walks over.
    chart : Chart
        The plane that it lies in.
    ring : Ring
        The outline.
    first : int
        Face under its start.
    outward : float
        1 where faces look to the chart, −1 on a far side.
    start : float
        Where it begins: 0 where it is closed. An open one ends at a rim or a crease.
    walls : bool
        Whether a closed one may cross walls of details; creases it may.

    Raises
    ------
    UserError
        If it leaves the surface, or crosses what cannot be crossed.
    MeetsCorner
        If it goes through the end of an edge, or begins on one.
    """
    row: list[Passage] = []
    face, t, entry = first, start, None
    while len(row) < MOST_PASSAGES:
        leave = _next_crossing(shell, chart, ring, face, t, outward)
        row.append(Passage(face, t, ring.end if leave is None else leave.t, entry, leave))
        if leave is None:
            break
        face, t, entry = _beyond(shell, face, leave, ring.closed, walls), leave.t, leave
        if face < 0:
            break
    if ring.closed and row[-1].face != row[0].face:
        if _begins_on_edge(shell, chart, ring, row[0].face):
            raise MeetsCorner
        raise UserError(TURNED)
    return tuple(row)


def _begins_on_edge(shell: Shell, chart: Chart, ring: Ring, face: int) -> bool:
    """Whether the start of a closed ring lies on an edge of the face under it."""
    found = (
        c for trim in shell.faces[face].trims for c in crossings_with(shell, chart, ring, trim)
    )
    return any(min(one.t, ring.end - one.t) <= NEAR_START * ring.end for one in found)


def _beyond(shell: Shell, face: int, crossing: Crossing, closed: bool, walls: bool) -> int:
    """Return the face behind an edge; −1 where a curve from border to border may end there."""
    users = shell.users[crossing.edge]
    others = [(number, trim) for number, trim in users if number != face]
    if not others:
        if closed:
            raise UserError(LEAVES if len(users) == 1 else TURNED)
        return -1
    own = next(trim for number, trim in users if number == face)
    number, trim = others[0]
    if not walls and (shell.owners[number].is_wall or shell.owners[face].is_wall):
        if closed:
            raise UserError(CROSSES)
        return -1
    if closed:
        return number
    at = np.array([crossing.at])
    one = shell.faces[face].surface.normals(*own.curve.value(at).T)[0]
    two = shell.faces[number].surface.normals(*trim.curve.value(at).T)[0]
    return number if float(one @ two) >= CREASE else -1


def _next_crossing(
    shell: Shell, chart: Chart, ring: Ring, face: int, after: float, outward: float
) -> Crossing | None:
    """Return the first crossing of a ring with the border of a face behind a parameter."""
    found = [
        crossing
        for trim in shell.faces[face].trims
        for crossing in crossings_with(shell, chart, ring, trim)
        if crossing.t > after + APART * ring.end
    ]
    surface = shell.faces[face].surface
    for crossing in sorted(found, key=lambda one: one.t):
        trim = next(t for t in shell.faces[face].trims if t.edge == crossing.edge)
        there = trim.curve.value(np.array([crossing.at]))
        if float((surface.normals(*there.T) @ chart.normal)[0]) * outward <= 0.0:
            continue
        own = parameters_at(surface, chart, ring.value(np.array([crossing.t])), outward)
        if not np.isfinite(own).all():
            continue
        gap = np.linalg.norm(surface.value(*own.T) - surface.value(*there.T))
        if gap <= NEAR * shell.size:
            low, high = shell.edges[crossing.edge].range
            at_end = min(crossing.at - low, high - crossing.at) <= NEAR_END * (high - low)
            at_start = ring.closed and crossing.t >= ring.end - APART * ring.end
            if at_end or at_start:
                raise MeetsCorner
            return crossing
    return None


def crossings_with(shell: Shell, chart: Chart, ring: Ring, trim: Trim) -> list[Crossing]:
    """Return where a ring crosses an edge, seen in the chart."""
    if trim.edge is None:
        return []
    at, places = shell.edges[trim.edge].polyline(SAMPLES)
    pairs = _segments_that_cross(ring.polyline, chart.flat(places))
    found: list[Crossing] = []
    for i, share, j, other in pairs:
        t = ring.polyline_at[i] + share * (ring.polyline_at[i + 1] - ring.polyline_at[i])
        s = at[j] + other * (at[j + 1] - at[j])
        met = _met(shell, chart, ring, trim.edge, float(t), float(s))
        if met is None or any(abs(one.t - met[0]) <= APART * ring.end for one in found):
            continue
        found.append(Crossing(met[0], trim.edge, met[1]))
    return found


def _met(
    shell: Shell, chart: Chart, ring: Ring, edge: int, t: float, s: float
) -> tuple[float, float] | None:
    """Return parameters of ring and edge where both are at one place; None where they touch."""
    curve = shell.edges[edge]
    low, high = curve.range
    stretch = min(int(t), len(ring.stretches) - 1)
    for _ in range(ROUNDS):
        way = ring.value(np.array([t]))[0] - chart.flat(curve.value([s]))[0]
        along = ring.tangents(np.array([min(t, stretch + 1.0 - 1e-12)]))[0]
        across = (curve.derivative([s], 1) @ chart.axes[:2].T)[0]
        matrix = np.column_stack((along, -across))
        if abs(np.linalg.det(matrix)) < 1e-9 * np.linalg.norm(along) * np.linalg.norm(across):
            return None
        step = np.linalg.solve(matrix, -way)
        after = min(max(t + step[0], float(stretch)), stretch + 1.0)
        beyond = min(max(s + step[1], low), high)
        moved = abs(after - t) + abs(beyond - s) / (high - low)
        t, s = float(after), float(beyond)
        if moved < 1e-14:
            break
    return t, s


def _segments_that_cross(one: Array, two: Array) -> list[tuple[int, float, int, float]]:
    """Return pairs of segments of two polylines that cross, with the shares along them."""
    low = np.maximum(one.min(axis=0), two.min(axis=0))
    if (low > np.minimum(one.max(axis=0), two.max(axis=0))).any():
        return []
    a, b = one[:-1], one[1:] - one[:-1]
    c, d = two[:-1], two[1:] - two[:-1]
    whole = b[:, None, 0] * d[None, :, 1] - b[:, None, 1] * d[None, :, 0]
    way = c[None] - a[:, None]
    safe = np.where(whole == 0.0, np.inf, whole)
    s = (way[..., 0] * d[None, :, 1] - way[..., 1] * d[None, :, 0]) / safe
    t = (way[..., 0] * b[:, None, 1] - way[..., 1] * b[:, None, 0]) / safe
    slack = 1e-9
    hit = (s >= -slack) & (s <= 1.0 + slack) & (t >= -slack) & (t <= 1.0 + slack) & (whole != 0.0)
    return [(i, float(s[i, j]), j, float(t[i, j])) for i, j in np.argwhere(hit).tolist()]


def course_across(
    shell: Shell, chart: Chart, ring: Ring, first: int, ends: Array
) -> tuple[Passage, ...]:
    """Return the faces that an open curve walks over, from border to border of patches.

    Parameters
    ----------
    shell : Shell
        What it walks over.
    chart : Chart
        The plane that it lies in.
    ring : Ring
        The curve, drawn out beyond its ends.
    first : int
        Face under its middle.
    ends : (2,) float
        Parameters between which it was drawn.

    Raises
    ------
    UserError
        If it does not reach a border at both ends.
    """
    middle = float(ends.mean())
    onward = course_of(shell, chart, ring, first, 1.0, middle)
    back = course_of(shell, chart, ring.reversed(), first, 1.0, ring.end - middle)
    before = [_turned(passage, ring.end) for passage in reversed(back)]
    joined = Passage(first, before[-1].start, onward[0].end, before[-1].entry, onward[0].leave)
    row = [*before[:-1], joined, *onward[1:]]
    places = [k for k, p in enumerate(row) if _is_border(shell, p.entry)]
    start = _nearest(ring, places, [row[k].start for k in places], float(ends[0]))
    places = [k for k, p in enumerate(row) if _is_border(shell, p.leave)]
    end = _nearest(ring, places, [row[k].end for k in places], float(ends[1]))
    if end < start:
        raise UserError(SHORT)
    return tuple(row[start : end + 1])


def _turned(passage: Passage, end: float) -> Passage:
    """Return a passage as the reversed curve has it."""

    def turned(crossing: Crossing | None) -> Crossing | None:
        return None if crossing is None else replace(crossing, t=end - crossing.t)

    return Passage(
        passage.face,
        end - passage.end,
        end - passage.start,
        turned(passage.leave),
        turned(passage.entry),
    )


def _is_border(shell: Shell, crossing: Crossing | None) -> bool:
    """Whether an edge that is crossed is on the border of a patch, or of a floor."""
    if crossing is None:
        return False
    owners = [shell.owners[face] for face, _ in shell.users[crossing.edge]]
    return len(owners) == 1 or not owners[0].is_of_one_area(owners[1])


def _nearest(ring: Ring, places: list[int], at: list[float], end: float) -> int:
    """Return which of some places lies nearest to an end of the ink, along the curve."""
    whole = np.linalg.norm(np.diff(ring.polyline, axis=0), axis=1)
    along = np.concatenate(([0.0], np.cumsum(whole)))
    gaps = np.abs(np.interp(at, ring.polyline_at, along) - np.interp(end, ring.polyline_at, along))
    if not len(gaps) or float(gaps.min()) > REACH * along[-1]:
        raise UserError(SHORT)
    return places[int(np.argmin(gaps))]
