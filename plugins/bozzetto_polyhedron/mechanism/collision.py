"""Where two convex polytopes touch: separating axes, and the faces that lie on one another.

The axis along which two polytopes are farthest apart is a normal of a face or square to an edge of
each (separating axes; Gottschalk, Lin & Manocha 1996). Where it is a normal, they touch in what the
face that looks against it has in common with that face (Sutherland & Hodgman 1974). When they will
meet is found by conservative advancement (Mirtich 1996) along these axes: what is fast does not
pass through what is thin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.mechanism.convex_parts import Polytope
from bozzetto_polyhedron.mechanism.rotations import rotations_by

PREFERRED: Final = 1e-5
"""Distance, m, by which an axis square to two edges must be better than a face's normal."""

ADVANCES: Final = 24
"""Rounds in which the time of a meeting is sought."""

MET: Final = 2e-5
"""Distance, m, at which two polytopes have met."""

MOST_POINTS: Final = 8
"""Places in which two polytopes touch: more of them carry nothing more."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A polytope at a pose, with the velocity of its body.

    Parameters
    ----------
    part : Polytope
        In the frame of its body, m.
    place : (3,) float64
    turn : (3, 3) float64
    velocity : (3,) float64
        m/s.
    spin : (3,) float64
        rad/s.
    """

    part: Polytope
    place: Array
    turn: Array
    velocity: Array
    spin: Array

    @property
    def corners(self) -> Array:
        """Where its corners are, (n, 3) m."""
        return np.asarray(self.part.corners @ self.turn.T + self.place)

    @property
    def radius(self) -> float:
        """The largest distance of a corner from the centre of mass of its body, m."""
        return float(np.sqrt((self.part.corners**2).sum(axis=1).max()))

    def later(self, seconds: float) -> Placed:
        """Return it as it will be if nothing acts on it."""
        turn = rotations_by(self.spin[None] * seconds)[0] @ self.turn
        return Placed(
            self.part, self.place + self.velocity * seconds, turn, self.velocity, self.spin
        )


@dataclass(frozen=True, eq=False)
class Touch:
    """Places in which a second polytope touches a first one.

    Parameters
    ----------
    normal : (3,) float64
        From the first to the second.
    on_first, on_second : (k, 3) float64
        m.
    """

    normal: Array
    on_first: Array
    on_second: Array


@dataclass(frozen=True, eq=False)
class _Axis:
    """The axis along which two polytopes are farthest apart.

    Parameters
    ----------
    gap : float
        m; below 0 where they overlap.
    normal : (3,) float64
        From the first to the second.
    kind : {"first", "second", "edges"}
    number, other : int
        Of the face; or of the directions of the edges of both.
    """

    gap: float
    normal: Array
    kind: str
    number: int
    other: int = -1


def touch_within(first: Placed, second: Placed, seconds: float, margin: float) -> Touch | None:
    """Return where two polytopes touch now or will touch within a time, unless they are stopped.

    Parameters
    ----------
    first : Placed
        With its velocity.
    second : Placed
        The same of the other one.
    seconds : float
        0 for now alone.
    margin : float
        Distance, m, within which they count as touching now.
    """
    turning = float(
        np.linalg.norm(first.spin) * first.radius + np.linalg.norm(second.spin) * second.radius
    )
    between = second.velocity - first.velocity
    time, one, two = 0.0, first, second
    for _ in range(ADVANCES):
        axis = _widest(one, two)
        if axis.gap <= (margin if time == 0.0 else MET):
            touch = _touch(one, two, axis, margin + turning * seconds)
            if touch is not None:
                return Touch(
                    touch.normal,
                    _carried(touch.on_first, one, first),
                    _carried(touch.on_second, two, second),
                )
        if axis.gap <= MET:
            return _deepest(first, two, axis) if time == 0.0 and axis.gap < -MET else None
        closing = turning - float(axis.normal @ between)
        if closing * (seconds - time) <= axis.gap:
            return None
        time += axis.gap / closing
        one, two = first.later(time), second.later(time)
    return None


def gap_between(first: Placed, second: Placed) -> float:
    """Return how far two polytopes are apart along their best axis, m; below 0 how deep they lie.

    Two corners are farther apart than that.
    """
    return _widest(first, second).gap


def _carried(places: Array, there: Placed, here: Placed) -> Array:
    """Return where places (k, 3) of a body that is there are while it is here."""
    return np.asarray((places - there.place) @ there.turn @ here.turn.T + here.place)


def _widest(one: Placed, two: Placed) -> _Axis:
    a, b = one.corners, two.corners
    normals_a, normals_b = one.part.normals @ one.turn.T, two.part.normals @ two.turn.T
    gaps_a = (normals_a @ b.T).min(axis=1) - one.part.offsets - normals_a @ one.place
    gaps_b = (normals_b @ a.T).min(axis=1) - two.part.offsets - normals_b @ two.place
    at_a, at_b = int(gaps_a.argmax()), int(gaps_b.argmax())
    if gaps_a[at_a] >= gaps_b[at_b] - PREFERRED:
        best = _Axis(float(gaps_a[at_a]), normals_a[at_a], "first", at_a)
    else:
        best = _Axis(float(gaps_b[at_b]), -normals_b[at_b], "second", at_b)
    ways_a = one.part.directions[0] @ one.turn.T
    ways_b = two.part.directions[0] @ two.turn.T
    axes = np.cross(ways_a[:, None], ways_b[None]).reshape(-1, 3)
    sizes = np.linalg.norm(axes, axis=1)
    kept = np.flatnonzero(sizes > 1e-3)
    if not len(kept):
        return best
    axes = axes[kept] / sizes[kept, None]
    along_a, along_b = axes @ a.T, axes @ b.T
    ahead = along_b.min(axis=1) - along_a.max(axis=1)
    behind = along_a.min(axis=1) - along_b.max(axis=1)
    gaps = np.maximum(ahead, behind)
    at = int(gaps.argmax())
    if gaps[at] <= best.gap + PREFERRED:
        return best
    number, other = divmod(int(kept[at]), len(ways_b))
    normal = axes[at] if ahead[at] >= behind[at] else -axes[at]
    return _Axis(float(gaps[at]), normal, "edges", number, other)


def _touch(one: Placed, two: Placed, axis: _Axis, reach: float) -> Touch | None:
    """Return the places within reach of one another along an axis."""
    if axis.kind == "edges":
        on_first = _edge(one, axis.number, axis.normal)
        on_second = _edge(two, axis.other, -axis.normal)
        near, far = _closest(on_first, on_second)
        return Touch(axis.normal, near[None], far[None])
    if axis.kind == "second":
        turned = _face_touch(two, one, axis.number, reach)
        if turned is None:
            return None
        return Touch(-turned.normal, turned.on_second, turned.on_first)
    return _face_touch(one, two, axis.number, reach)


def _deepest(one: Placed, two: Placed, axis: _Axis) -> Touch:
    """Return the corner of the second polytope that lies deepest in the first one."""
    corners = two.corners
    deepest = corners[int((corners @ axis.normal).argmin())]
    return Touch(axis.normal, (deepest - axis.gap * axis.normal)[None], deepest[None])


def _face_touch(one: Placed, two: Placed, number: int, reach: float) -> Touch | None:
    """Return where the second polytope lies on a face of the first one."""
    normal = one.turn @ one.part.normals[number]
    ring = one.corners[list(one.part.rings[number])]
    against = int((two.part.normals @ two.turn.T @ normal).argmin())
    points = two.corners[list(two.part.rings[against])]
    for begin, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        points = _cut(points, begin, np.cross(end - begin, normal))
        if not len(points):
            return None
    gaps = (points - ring[0]) @ normal
    near = gaps <= float(gaps.min()) + reach
    points, gaps = points[near], gaps[near]
    if len(points) > MOST_POINTS:
        outermost = _outermost(points, normal)
        points, gaps = points[outermost], gaps[outermost]
    return Touch(normal, points - gaps[:, None] * normal, points)


def _cut(points: Array, through: Array, outwards: Array) -> Array:
    """Return what of a convex polygon (n, 3) lies inside of a plane."""
    if not len(points):
        return points
    away = (points - through) @ outwards
    following = np.roll(away, -1)
    kept = []
    for k, point in enumerate(points):
        if away[k] <= 0.0:
            kept.append(point)
        if away[k] * following[k] < 0.0:
            share = away[k] / (away[k] - following[k])
            kept.append(point + share * (points[(k + 1) % len(points)] - point))
    return np.array(kept)


def _outermost(points: Array, normal: Array) -> Array:
    """Return which points are farthest to some sides across a normal."""
    start = np.eye(3)[int(np.abs(normal).argmin())]
    across = np.cross(normal, start)
    across /= np.linalg.norm(across)
    turns = 2.0 * np.pi / MOST_POINTS * np.arange(MOST_POINTS)
    ways = np.outer(np.cos(turns), across) + np.outer(np.sin(turns), np.cross(normal, across))
    return np.unique((points @ ways.T).argmax(axis=0))


def _edge(placed: Placed, direction: int, outwards: Array) -> Array:
    """Return both ends of the edge of a direction that lies farthest outwards, (2, 3)."""
    _, which = placed.part.directions
    edges = placed.part.edges[which == direction]
    ends = placed.corners[edges]
    return np.asarray(ends[int((ends.sum(axis=1) @ outwards).argmax())])


def _closest(one: Array, other: Array) -> tuple[Array, Array]:
    """Return the closest places of two segments (2, 3) that are not parallel."""
    along, across, apart = one[1] - one[0], other[1] - other[0], one[0] - other[0]
    a, b, c = float(along @ along), float(along @ across), float(across @ across)
    d, e = float(along @ apart), float(across @ apart)
    share = float(np.clip((b * e - c * d) / max(a * c - b * b, 1e-300), 0.0, 1.0))
    far = float(np.clip((b * share + e) / c, 0.0, 1.0))
    share = float(np.clip((b * far - d) / a, 0.0, 1.0))
    return one[0] + share * along, other[0] + far * across
