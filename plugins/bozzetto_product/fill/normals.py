"""Which edges are smooth, and the normals of the surface along them."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.plugin import remembered
from bozzetto_product.fill.corners import FLAT_SINE, Corner, loop_corners
from bozzetto_product.fill.edge_pieces import opened
from bozzetto_product.fill.normal_field import (
    NormalField,
    across,
    carried,
    unit_tangents,
)
from bozzetto_product.fill.quadric_normals import is_exact_crease, quadric_turns
from bozzetto_product.fill.torsion import TwistCorner, agreeing
from bozzetto_product.network.flat_places import plane_through
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.outlines import outlines_of

SMOOTH_DEGREES: Final = 35.0
"""Angle between the tangent planes of two loops at the ends of an edge below which it is smooth."""

CORNER_REACH: Final = 0.5
"""Share of an edge over which a corner's own tangent plane fades to the common one."""


@dataclass(frozen=True, eq=False)
class LoopNormals:
    """Conditions that the surface of a loop fits along its half edges.

    Parameters
    ----------
    corners : tuple of Corner
        At the start of each half edge.
    fields : tuple of NormalField or None
        Of each half edge, to the outside; None where nothing is to be met: a crease, or an edge
        that no other loop has.
    starts : tuple of int
        First half edge of each outline: that of the surface, and those of its holes.
    """

    corners: tuple[Corner, ...]
    fields: tuple[NormalField | None, ...]
    starts: tuple[int, ...] = (0,)

    def outlines(self) -> tuple[LoopNormals, ...]:
        """Return the normals of each outline by itself."""
        ends = itertools.pairwise((*self.starts, len(self.corners)))
        return tuple(LoopNormals(self.corners[a:b], self.fields[a:b]) for a, b in ends)


@remembered(limit=8, key=lambda net, loops: (net, tuple(loops)))
def edge_normals(net: Net, loops: Sequence[Loop]) -> tuple[LoopNormals, ...]:
    """Return for each loop the normals along its edges.

    An edge of two loops is smooth if it says so, or else if the tangent planes of both loops
    agree at its ends, both do not lie on exact surfaces that meet at an angle, and it is not the
    rim of a hole in a surface that bends. Corners that
    smooth edges link make a fan with one normal, and each smooth edge has one field of normals,
    which both of its loops take. Where the tangents of a fan lie in no common plane, each corner
    keeps its own plane and fades to the common one.

    Parameters
    ----------
    net : Net
        The network.
    loops : sequence of Loop
        Counter-clockwise seen from outside.
    """
    every = [outlines_of(net, loop) for loop in loops]
    outlines, corners = outline_corners(net, loops)
    smooth = _smooth_edges(net, outlines, corners, _rims(net, loops))
    fields: list[list[NormalField | None]] = [[None] * len(outline) for outline in outlines]
    for edge, common in common_fields(net, outlines, corners, smooth).items():
        for number, place, forward in smooth[edge]:
            ends = corners[number][place], corners[number][(place + 1) % len(outlines[number])]
            fields[number][place] = _own_field(common, ends, forward, net.edges[edge].crease)
    rows = iter(zip(corners, fields, strict=True))
    return tuple(_joined_normals([next(rows) for _ in own]) for own in every)


def _joined_normals(
    rows: Sequence[tuple[Sequence[Corner], Sequence[NormalField | None]]],
) -> LoopNormals:
    """Return the normals of a loop by those of its outlines."""
    starts = itertools.accumulate((len(corners) for corners, _ in rows[:-1]), initial=0)
    return LoopNormals(
        tuple(corner for corners, _ in rows for corner in corners),
        tuple(field for _, fields in rows for field in fields),
        tuple(starts),
    )


def outline_corners(net: Net, loops: Sequence[Loop]) -> tuple[list[Loop], list[tuple[Corner, ...]]]:
    """Return the outlines of loops, and the corners of each, with normals to the outside."""
    outlines, corners = [], []
    for loop in loops:
        for number, outline in enumerate(outlines_of(net, loop)):
            own = loop_corners(net, outline)
            outlines.append(outline)
            corners.append(tuple(map(turned_over, own)) if number else own)
    return outlines, corners


def turned_over(corner: Corner) -> Corner:
    """Return the corner of a hole, which `loop_corners` takes for one of a surface within it."""
    return replace(corner, normal=-corner.normal, concave=not corner.concave)


@remembered(limit=8)
def smooth_half_edges(net: Net, loops: tuple[Loop, ...]) -> tuple[tuple[bool, ...], ...]:
    """Return for each half edge of loops whether the network asks for a smooth joint there."""
    return tuple(
        tuple(field is not None for field in own.fields) for own in edge_normals(net, loops)
    )


def _rims(net: Net, loops: Sequence[Loop]) -> frozenset[int]:
    """Return the edges of holes in surfaces that bend.

    Walls leave such a surface there. The corners of the hole do not tell how it leans: one that
    turns a little has the plane of the wall as soon as its curves do not lie on the surface.
    """
    found: set[int] = set()
    for loop in loops:
        holes = outlines_of(net, loop)[1:]
        if holes:
            points = [net.edges[edge].spline.control_points for edge, _ in loop]
            if plane_through(np.concatenate(points)) is None:
                found |= {edge for hole in holes for edge, _ in hole}
    return frozenset(found)


def _smooth_edges(
    net: Net,
    loops: Sequence[Loop],
    corners: Sequence[Sequence[Corner]],
    rims: frozenset[int],
) -> dict[int, list[tuple[int, int, bool]]]:
    """Return of each smooth edge the loops, the places in them, and if they run in its sense.

    Rims are smooth only where the network says so.
    """
    uses: dict[int, list[tuple[int, int, bool]]] = {}
    for number, loop in enumerate(loops):
        for place, (edge, forward) in enumerate(loop):
            uses.setdefault(edge, []).append((number, place, forward))
    return {
        edge: both
        for edge, both in uses.items()
        if (edge not in rims or np.isfinite(net.edges[edge].crease))
        and _is_smooth(net, edge, both, corners, loops)
    }


def planes_of_ends(net: Net, loops: Sequence[Loop]) -> dict[tuple[int, int], list[Array]]:
    """Return the tangent planes in which the ends of edges are to lie so that surfaces are smooth.

    Parameters
    ----------
    net, loops
        See `edge_normals`.

    Returns
    -------
    dict of (int, int) to list of (3,) array
        Number of an edge, and 0 for its start or 1 for its end: the normals of the fans there, of
        two corners or more.
    """
    rims = _rims(net, loops)
    loops, corners = outline_corners(net, loops)
    planes: dict[tuple[int, int], list[Array]] = {}
    for fan in _fans(_smooth_edges(net, loops, corners, rims), corners, loops):
        if len(fan) < 2:
            continue
        normal = _common_normal([_of(corners, one) for one in fan], list(fan.values()))
        ends = set()
        for number, place in fan:
            (after, onward), (before, there) = loops[number][place], loops[number][place - 1]
            ends |= {(after, 0 if onward else 1), (before, 1 if there else 0)}
        for end in sorted(ends):
            planes.setdefault(end, []).append(normal)
    return planes


def common_fields(
    net: Net,
    loops: Sequence[Loop],
    corners: Sequence[Sequence[Corner]],
    smooth: Mapping[int, Sequence[tuple[int, int, bool]]],
) -> dict[int, NormalField]:
    """Return one field of normals for each smooth edge.

    Parameters
    ----------
    net : Net
        The network.
    loops : sequence of Loop
        Counter-clockwise seen from outside.
    corners : sequence of sequence of Corner
        Of each loop; see `loop_corners`.
    smooth : mapping of int to sequence
        Of each smooth edge the loop, the place in it, and whether it runs in the edge's sense,
        once or twice.
    """
    told = {edge: known for edge in smooth if (known := net.edges[edge].normals) is not None}
    fields = _found_fields(net, loops, corners, smooth, frozenset(told))
    for edge, known in told.items():
        spline = opened(net.edges[edge].spline)
        fields[edge] = NormalField(spline, known.parameters, known.normals)
    return fields


def _found_fields(
    net: Net,
    loops: Sequence[Loop],
    corners: Sequence[Sequence[Corner]],
    smooth: Mapping[int, Sequence[tuple[int, int, bool]]],
    told: frozenset[int],
) -> dict[int, NormalField]:
    """Return the fields of smooth edges that are not told.

    Edges that are told tell nothing themselves: what lies on a surface may bend in it as it likes.
    """

    def counts(one: tuple[int, int]) -> bool:
        loop, place = loops[one[0]], one[1]
        return loop[place][0] not in told and loop[place - 1][0] not in told

    fans = _fans(smooth, corners, loops)
    planes = {}
    for fan in fans:
        chosen = [one for one in fan if counts(one)] or list(fan)
        normal = _common_normal([_of(corners, one) for one in chosen], [fan[one] for one in chosen])
        planes.update({one: sense * normal for one, sense in fan.items()})
    fields = {}
    for edge, uses in smooth.items():
        if edge in told:
            continue
        number, place, forward = uses[0]
        ends = planes[number, place], planes[number, (place + 1) % len(loops[number])]
        fields[edge] = carried(opened(net.edges[edge].spline), *(ends if forward else ends[::-1]))
    twists = [
        [
            _twist(loops[number], corners[number], place)
            for number, place in fan
            if counts((number, place)) and _has_twist(loops[number], corners[number], place, smooth)
        ]
        for fan in fans
    ]
    return agreeing(
        fields, [fan for fan in twists if fan], quadric_turns(net, loops, smooth, fields)
    )


def _has_twist(
    loop: Loop, corners: Sequence[Corner], place: int, smooth: Mapping[int, object]
) -> bool:
    """Whether both edges at a corner have normals, and tell a plane."""
    both = loop[place][0] in smooth and loop[place - 1][0] in smooth
    return both and corners[place].sine > FLAT_SINE


def _twist(loop: Loop, corners: Sequence[Corner], place: int) -> TwistCorner:
    corner = corners[place]
    (after, onward), (before, there) = loop[place], loop[place - 1]
    return TwistCorner(
        (after, 0 if onward else 1),
        (before, 1 if there else 0),
        corner.leave,
        -corner.enter,
        corner.normal,
    )


def _is_smooth(
    net: Net,
    edge: int,
    both: Sequence[tuple[int, int, bool]],
    corners: Sequence[Sequence[Corner]],
    loops: Sequence[Loop],
) -> bool:
    crease = net.edges[edge].crease
    if len(both) != 2 or crease >= 1.0:
        return False
    if np.isfinite(crease):
        return True
    sense = 1.0 if both[0][2] != both[1][2] else -1.0
    least = 1.0
    for one, other in _matching_ends(both, loops):
        least = min(least, sense * float(_of(corners, one).normal @ _of(corners, other).normal))
    if not least > np.cos(np.radians(SMOOTH_DEGREES)):
        return False
    return not is_exact_crease(net, edge, [loops[number] for number, _, _ in both])


def _of(corners: Sequence[Sequence[Corner]], which: tuple[int, int]) -> Corner:
    return corners[which[0]][which[1]]


def _matching_ends(
    both: Sequence[tuple[int, int, bool]], loops: Sequence[Loop]
) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return the corners of two loops at the start and at the end of an edge of both."""
    ends = []
    for number, place, forward in both:
        pair = (number, place), (number, (place + 1) % len(loops[number]))
        ends.append(pair if forward else pair[::-1])
    return [(ends[0][0], ends[1][0]), (ends[0][1], ends[1][1])]


def _fans(
    smooth: Mapping[int, Sequence[tuple[int, int, bool]]],
    corners: Sequence[Sequence[Corner]],
    loops: Sequence[Loop],
) -> list[dict[tuple[int, int], float]]:
    """Return the corners that smooth edges link, each with the sense of its normal."""
    links: dict[tuple[int, int], list[tuple[tuple[int, int], float]]] = {}
    for uses in smooth.values():
        if len(uses) < 2:
            continue
        sense = 1.0 if uses[0][2] != uses[1][2] else -1.0
        for one, other in _matching_ends(uses, loops):
            links.setdefault(one, []).append((other, sense))
            links.setdefault(other, []).append((one, sense))
    made: list[dict[tuple[int, int], float]] = []
    seen: set[tuple[int, int]] = set()
    for number, mine in enumerate(corners):
        for place in range(len(mine)):
            if (number, place) in seen:
                continue
            fan = {(number, place): 1.0}
            waiting = [(number, place)]
            while waiting:
                here = waiting.pop()
                for other, sense in links.get(here, []):
                    if other not in fan:
                        fan[other] = fan[here] * sense
                        waiting.append(other)
            seen.update(fan)
            made.append(fan)
    return made


def _common_normal(fan: list[Corner], senses: list[float]) -> Array:
    """Return the normal of the plane that best holds all tangents of a fan."""
    mean = np.sum(
        [s * max(c.sine, 0.05) * c.normal for c, s in zip(fan, senses, strict=True)], axis=0
    )
    length = float(np.linalg.norm(mean))
    if length < 1e-9:
        return fan[0].normal
    mean = mean / length
    if len(fan) == 1:
        return np.asarray(mean)
    tangents = np.array([way for corner in fan for way in (corner.enter, corner.leave)])
    normal = np.linalg.svd(tangents)[2][2]
    along = float(normal @ mean)
    return np.asarray(np.sign(along) * normal if abs(along) > 0.8 else mean)


@remembered(limit=4000)
def _own_field(
    common: NormalField, ends: tuple[Corner, Corner], forward: bool, crease: float
) -> NormalField:
    """Return the field of an edge as one of its loops takes it, from corner to corner."""
    spline = common.spline
    middle = common.normals[len(common.normals) // 2]
    field = (
        common
        if float(middle @ (ends[0].normal + ends[1].normal)) >= 0
        else (common.reversed_sign())
    )
    if 0.0 < crease < 1.0:
        first, last = ends if forward else ends[::-1]
        alone = carried(spline, first.normal, last.normal)
        mixed = (1.0 - crease) * field.normals + crease * alone.normals
        field = NormalField(
            spline, field.parameters, across(mixed, unit_tangents(spline, field.parameters))
        )
    return fitted_to_corners(field, ends, forward)


def fitted_to_corners(
    field: NormalField, ends: tuple[Corner, Corner], forward: bool
) -> NormalField:
    """Return a field that has the planes of the tangents at both corners of an edge.

    Parameters
    ----------
    field : NormalField
        Of the edge.
    ends : (Corner, Corner)
        Where the loop's half edge starts and ends.
    forward : bool
        Whether the loop runs it in the edge's sense.
    """
    if not forward:
        ends = ends[1], ends[0]
    tangents = unit_tangents(field.spline, field.parameters[[0, -1]])
    turns = [
        _turn_to_corner(field.normals[index], tangents[index], corner, forward)
        for index, corner in ((0, ends[0]), (-1, ends[1]))
    ]
    if max(map(abs, turns)) < 1e-9:
        return field
    return field.turned(
        lambda share: (
            turns[0] * _fade(share / CORNER_REACH) + turns[1] * _fade((1.0 - share) / CORNER_REACH)
        )
    )


def _turn_to_corner(normal: Array, tangent: Array, corner: Corner, forward: bool) -> float:
    """Return the angle about an edge to the plane of a corner's own tangents, radians."""
    if corner.sine < FLAT_SINE:
        return 0.0
    plane = cross_product(corner.enter, corner.leave) / corner.sine
    plane = plane if plane @ normal >= 0 else -plane
    return float(np.arctan2(cross_product(normal, plane) @ tangent, normal @ plane))


def _fade(x: Array) -> Array:
    """Return a smooth step from 1 at 0 to 0 at 1 and beyond."""
    inside = np.clip(x, 0.0, 1.0)
    return np.asarray((1.0 - inside) ** 4 * (1.0 + 4.0 * inside))
