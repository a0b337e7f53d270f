"""Corners of loops, and the planes that their edges tell there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.plugin import cached_property, remembered
from bozzetto_product.fill.edge_pieces import opened
from bozzetto_product.fill.normal_field import (
    NormalField,
    across,
    angle_about,
    frame_of,
    rotated,
    unit_tangents,
)
from bozzetto_product.network.net import Loop, Net

FLAT_SINE: Final = 0.17
"""Sine of the angle between two edges below which they tell a tangent plane weakly: ten degrees."""

WEAK_SINE: Final = 0.1
"""Sine at which a flat corner's own plane counts as much as what is carried from the others."""

CONCAVE_COSINE: Final = -0.6
"""Cosine between a corner's normal and the loop's below which the corner is a concave one."""


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
    """

    normal: Array
    sine: float
    enter: Array
    leave: Array

    @cached_property
    def turn(self) -> float:
        """How far the loop turns, radians; negative at a concave corner."""
        angle = float(
            np.arctan2(np.linalg.norm(np.cross(self.enter, self.leave)), self.enter @ self.leave)
        )
        return angle if np.cross(self.enter, self.leave) @ self.normal >= 0 else -angle


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
    area = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
    length = float(np.linalg.norm(area))
    if length == 0.0:
        area, length = across(np.array([[0.0, 0.0, 1.0]]), np.asarray(leave[:1]))[0], 1.0
    area = area / length
    made = [_corner(enter[k - 1], leave[k], area) for k in range(len(loop))]
    return tuple(_with_flat_corners(net, loop, made))


def _corner(enter: Array, leave: Array, area: Array) -> Corner:
    normal = np.cross(enter, leave)
    sine = float(np.linalg.norm(normal))
    if sine > FLAT_SINE:
        normal = normal / sine
    else:
        normal = across(area[None], leave[None])[0]
    if normal @ area < CONCAVE_COSINE:
        normal = -normal
    return Corner(normal, sine, enter, leave)


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
    own = np.cross(corner.enter, corner.leave)
    own = own if own @ normal >= 0 else -own
    share = corner.sine**2 / (corner.sine**2 + WEAK_SINE**2)
    turn = share * angle_about(corner.leave, normal, own) if corner.sine > 0.0 else 0.0
    return replace(corner, normal=rotated(normal[None], axis, np.array([turn]))[0])
