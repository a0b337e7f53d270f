"""Corners of loops, and the planes that their edges tell there."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Spline
from bozzetto.plugin import cached_property, remembered
from bozzetto_product.fill.edge_pieces import opened
from bozzetto_product.fill.normal_field import (
    NormalField,
    across,
    angle_about,
    frame_of,
    length_shares,
    rotated,
    unit_tangents,
)
from bozzetto_product.network.net import Loop, Net

FLAT_SINE: Final = 0.17
"""Sine of the angle between two edges below which they tell a tangent plane weakly: ten degrees."""

WEAK_SINE: Final = 0.1
"""Sine at which a flat corner's own plane counts as much as what is carried from the others."""

CONCAVE_COSINE: Final = -0.6
"""Cosine between a corner's normal and the loop's below which the corner is a concave one, where
its neighbours tell neither."""

CHORDS: Final = 12
"""Chords of an edge, an even length apart, that tell on which side of corners the surface is."""


@dataclass(frozen=True, eq=False)
class Corner:
    """A corner of a loop, at the start of one of its half edges.

    Parameters
    ----------
    normal : (3,) float
        Unit, to the outside.
    sine : float
        Of the angle between both edges.
    enter, leave : (3,) float
        Unit tangents, as the loop runs.
    concave : bool
        The loop turns to its other side there.
    """

    normal: Array
    sine: float
    enter: Array
    leave: Array
    concave: bool = False

    @cached_property
    def turn(self) -> float:
        """How far the loop turns, radians; negative at a concave corner."""
        angle = float(
            np.arctan2(
                np.linalg.norm(cross_product(self.enter, self.leave)), self.enter @ self.leave
            )
        )
        return -angle if self.concave else angle


def _loop_key(net: Net, loop: Loop) -> tuple[object, ...]:
    return tuple((net.edges[edge].spline, forward) for edge, forward in loop)


@remembered(limit=2000, key=_loop_key)
def loop_corners(net: Net, loop: Loop) -> tuple[Corner, ...]:
    """Return the corners at the starts of a loop's half edges."""
    rows, enter, leave = [], [], []
    for edge, forward in loop:
        spline = opened(net.edges[edge].spline)
        begin, end = spline.range
        at = np.linspace(begin, end, 17)
        places = spline.value(at)
        tangents = unit_tangents(spline, at[[0, -1]])
        if not forward:
            places, tangents = places[::-1], -tangents[::-1]
        rows.append(places[:-1])
        leave.append(tangents[0])
        enter.append(tangents[1])
    ring = np.concatenate(rows)
    ring = ring - ring.mean(axis=0)
    area = cross_product(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    length = float(np.linalg.norm(area))
    if length == 0.0:
        area, length = across(np.array([[0.0, 0.0, 1.0]]), np.asarray(leave[:1]))[0], 1.0
    area = area / length
    made = [_corner(enter[k - 1], leave[k], area) for k in range(len(loop))]
    made = _with_senses(net, loop, made, area)
    return tuple(_with_flat_corners(net, loop, made))


def _corner(enter: Array, leave: Array, area: Array) -> Corner:
    """Return a corner as a convex one; without a plane of its own it has the loop's."""
    own = cross_product(enter, leave)
    sine = float(np.linalg.norm(own))
    normal = own / sine if sine > FLAT_SINE else across(area[None], leave[None])[0]
    return Corner(normal, sine, enter, leave, concave=bool(own @ normal < 0.0))


def _with_senses(net: Net, loop: Loop, corners: list[Corner], area: Array) -> list[Corner]:
    """Return corners of which the concave ones are turned over.

    With σ = 1 for a convex corner and -1 for a concave one, c the cosine between a corner's normal
    and the one carried to it from the corner before, and d that between its normal and the loop's,
    ``Σ c σ σ' + Σ (d - CONCAVE_COSINE) σ`` is largest. On a surface that bends far the loop's
    normal alone takes concave corners for convex ones. Normals are those of chords here: a hook at
    the end of a curve turns its tangent, and not the surface.
    """
    told = [place for place, corner in enumerate(corners) if corner.sine > FLAT_SINE]
    if not told:
        return corners
    courses = [_course_of(net.edges[edge].spline, forward) for edge, forward in loop]
    normals = {place: _chord_normal(courses, place, corners[place].normal) for place in told}
    along = []
    for start, end in zip(told, [*told[1:], told[0] + len(corners)], strict=True):
        normal = normals[start]
        for place in range(start, end):
            normal = courses[place % len(corners)].turn @ normal
        along.append(float(normal @ normals[end % len(corners)]))
    own = [float(normals[place] @ area) - CONCAVE_COSINE for place in told]
    made = list(corners)
    for place, sense in zip(told, _best_senses(own, along), strict=True):
        normal = corners[place].normal
        side = sense * float(normals[place] @ normal)
        normal = -normal if side < 0.0 else normal
        made[place] = replace(corners[place], normal=normal, concave=sense < 0)
    return made


@dataclass(frozen=True, eq=False)
class _Course:
    """The chords of a half edge.

    Parameters
    ----------
    first, last : (3,) float
        Unit vectors along the first and the last one.
    turn : (3, 3) float
        The rotation that takes one to the other along all of them, without turning about them.
    """

    first: Array
    last: Array
    turn: Array


@remembered(limit=4000)
def _course_of(spline: Spline, forward: bool) -> _Course:
    curve = opened(spline)
    fine = np.linspace(*curve.range, 8 * CHORDS + 1)
    shares = np.linspace(0.0, 1.0, CHORDS + 1)
    at = np.interp(shares, length_shares(curve, fine), fine)
    chords = np.diff(curve.value(at), axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    chords = chords[lengths > 0.0] / lengths[lengths > 0.0, None]
    if not len(chords):
        chords = unit_tangents(curve, np.array(curve.range[:1]))
    if not forward:
        chords = -chords[::-1]
    turn = np.eye(3)
    for one, other in itertools.pairwise(chords):
        both = one + other
        square = float(both @ both)
        if square > 1e-12:  # else the curve turns back on itself, and about nothing
            mirrored = turn - 2.0 * np.outer(both, both @ turn) / square
            turn = mirrored - 2.0 * np.outer(other, other @ mirrored)
    return _Course(chords[0], chords[-1], turn)


def _chord_normal(courses: list[_Course], place: int, own: Array) -> Array:
    """Return the normal of a corner's chords, (3,); its own where they are one line."""
    normal = cross_product(courses[place - 1].last, courses[place].first)
    sine = float(np.linalg.norm(normal))
    return normal / sine if sine > FLAT_SINE else own


def _best_senses(own: list[float], along: list[float]) -> tuple[int, ...]:
    """Return σ of a ring that make ``Σ own σ + Σ along σ σ'`` largest.

    Parameters
    ----------
    own, along : (n,) list of float
        Of each place, and of each one with the next.
    """
    best: tuple[float, tuple[int, ...]] = (-np.inf, ())
    for first in (1, -1):
        ways: dict[int, tuple[float, tuple[int, ...]]] = {first: (first * own[0], (first,))}
        for value, link in zip(own[1:], along[:-1], strict=True):
            ways = {
                sense: max(
                    (total + sense * (value + link * before[-1]), (*before, sense))
                    for total, before in ways.values()
                )
                for sense in (1, -1)
            }
        closed = [(t + along[-1] * first * senses[-1], senses) for t, senses in ways.values()]
        best = max(best, *closed)
    return best[1]


def _with_flat_corners(net: Net, loop: Loop, corners: list[Corner]) -> list[Corner]:
    """Return corners of which the flat ones have normals carried from the others.

    Between two corners that tell a plane the edges are like one curve: the frame that turns least
    along it tells more than the area of the loop, which may be bent.
    """
    count = len(corners)
    told = [place for place in range(count) if corners[place].sine > FLAT_SINE]
    if not told or len(told) == count:
        return corners
    made = list(corners)
    for start, end in zip(told, [*told[1:], told[0] + count], strict=True):
        if end - start < 2:
            continue
        run = range(start, end)
        frames, normal = [], corners[start].normal
        for place in run:
            frames.append(frame_of(_run_along(net, loop[place % count]), normal))
            normal = frames[-1].normals[-1]
        goal = corners[end % count]
        rest = angle_about(goal.enter, normal, goal.normal)
        shares = np.cumsum([frame.length for frame in frames])
        shares = rest * shares / max(float(shares[-1]), 1e-300)
        for place, frame, angle in zip(run[1:], frames, shares, strict=False):
            made[place % count] = _carried_to(corners[place % count], frame, float(angle))
    return made


def _run_along(net: Net, half_edge: tuple[int, bool]) -> Spline:
    edge, forward = half_edge
    spline = opened(net.edges[edge].spline)
    return spline if forward else spline.reversed()


def _carried_to(corner: Corner, frame: NormalField, angle: float) -> Corner:
    """Return a flat corner with the normal of a frame that is turned by an angle.

    The plane of its own tangents counts the more, the less flat it is.
    """
    axis = corner.leave[None]
    normal = rotated(across(frame.normals[-1:], axis), axis, np.array([angle]))[0]
    own = cross_product(corner.enter, corner.leave)
    concave = bool(own @ normal < 0.0)
    own = -own if concave else own
    share = corner.sine**2 / (corner.sine**2 + WEAK_SINE**2)
    turn = share * angle_about(corner.leave, normal, own) if corner.sine > 0.0 else 0.0
    normal = rotated(normal[None], axis, np.array([turn]))[0]
    return replace(corner, normal=normal, concave=concave)
