"""How far bodies turn at a hinge before they meet: between two angles, found once at rest.

Two bodies at a hinge meet or not by one number, the angle. So where they stop is sought before
anything moves, and costs hardly anything then: from the pose at rest to both sides the angle
advances by what the gap between the bodies lets it (conservative advancement; Mirtich 1996).
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import override, remembered
from bozzetto_polyhedron.mechanism.assembly import (
    DIRECTION,
    GROUND,
    Joints,
    Motion,
    Stops,
    square_to,
)
from bozzetto_polyhedron.mechanism.collision import Placed, gap_between
from bozzetto_polyhedron.mechanism.convex_parts import Polytope, polytope_of
from bozzetto_polyhedron.mechanism.distance import distance_between
from bozzetto_polyhedron.mechanism.rotations import rotations_by

CLEAR: Final = 0.02
"""Distance from a hinge, by the smaller body, within which bodies may lie in one another."""

DEEP: Final = 1e-5
"""Depth, by the smaller body, from which on bodies have met."""

COARSE: Final = float(np.radians(0.05))
"""Least advance of the angle, rad: what is thin is thicker than that where it begins."""

FINE: Final = 1e-5
"""How closely an angle is found, rad."""

MOST_AXES: Final = 2000
"""Pairs of directions of edges of all parts together up to which separating axes tell how far two
parts are apart: a second's work. Those of round limbs are asked by their corners."""

MOST_ROUND: Final = 8
"""Pairs of parts that are asked by their corners: bodies of more pass through one another."""

MOST_SMALLER: Final = 1e-3
"""Share by which a round part may be smaller: where both are thin plates nothing stops them."""

STRAIGHT: Final = 1e-6
"""Distance from an axis, by its length, within which places of a joint are on it."""


def stops_of(
    joints: Joints, rest: Motion, bodies: Sequence[int], parts: Sequence[Polytope]
) -> Stops | None:
    """Return the stops of all hinges at which one is; None without any.

    Parameters
    ----------
    joints : Joints
        Hinges among others.
    rest : Motion
        At which nothing is turned.
    bodies : sequence of int
        Which body each part belongs to.
    parts : sequence of Polytope
        In the frames of their bodies, m.
    """
    rows = []
    for (first, second), (begin, end) in hinge_axes(joints, rest).items():
        own, other = (
            tuple(
                part.scaled(1.0, rest.places[body])
                for owner, part in zip(bodies, parts, strict=True)
                if owner == body
            )
            for body in (first, second)
        )
        axis = (end - begin) / np.linalg.norm(end - begin)
        free = free_turn(own, other, begin, axis) if own and other else None
        if free is None:
            continue
        places = np.concatenate([part.corners for part in own]) - begin
        radius = float(np.linalg.norm(places - np.outer(places @ axis, axis), axis=1).max())
        aside, half = square_to(axis)[0], 0.5 * (free[1] - free[0])
        middle = _turned(aside, axis, 0.5 * (free[0] + free[1]))
        place = begin - rest.places[second]
        rows.append((first, second, place, axis, radius * aside, middle, half))
    if not rows:
        return None
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    return Stops(*columns)


def hinge_axes(joints: Joints, rest: Motion) -> dict[tuple[int, int], tuple[Array, Array]]:
    """Return two places on the axis of each pair of bodies that turn about one another, m."""
    held = np.flatnonzero((joints.kind == DIRECTION) & (joints.second != GROUND))
    places = joints.first_point[held] + rest.places[joints.first[held]]
    found: dict[tuple[int, int], list[Array]] = {}
    for row, place in zip(held, places, strict=True):
        found.setdefault((int(joints.first[row]), int(joints.second[row])), []).append(place)
    axes = {}
    for pair, own in found.items():
        points = np.array(own)
        far = points[int(np.linalg.norm(points - points[0], axis=1).argmax())]
        along = far - points[0]
        length = float(np.linalg.norm(along))
        aside = np.linalg.norm(np.cross(points - points[0], along), axis=1)
        if length > 0.0 and float(aside.max()) <= STRAIGHT * length**2 and len(own) == 5:
            axes[pair] = points[0], far
    return axes


def _what_turns(
    own: tuple[Polytope, ...], other: tuple[Polytope, ...], place: Array, axis: Array
) -> Hashable:
    corners = (part.corners.round(9).tobytes() for part in (*own, *other))
    return len(own), *corners, place.round(9).tobytes(), axis.round(9).tobytes()


@remembered(limit=64, key=_what_turns)
def free_turn(
    own: tuple[Polytope, ...], other: tuple[Polytope, ...], place: Array, axis: Array
) -> tuple[float, float] | None:
    """Return between which angles, rad, some parts turn before they meet others.

    Parameters
    ----------
    own, other : tuple of Polytope
        At rest, m.
    place, axis : (3,) float64
        About which the first ones turn; a unit vector.

    Returns
    -------
    (float, float) or None
        From -2 π … 0 to 0 … 2 π. None where nothing meets, where they lie in one another at rest,
        where the axis runs through them, and where round ones have too many parts or are thin.
    """
    sizes = (
        float(np.linalg.norm(np.ptp(np.concatenate([part.corners for part in each]), axis=0)))
        for each in (own, other)
    )
    size = min(sizes)
    is_round = _axes(own) * _axes(other) > MOST_AXES
    if is_round and len(own) * len(other) > MOST_ROUND:
        return None
    cleared = [_cleared(part, place, axis, CLEAR * size) for part in (*own, *other)]
    kept = [part for part in cleared if part is not None]
    if len(kept) < len(cleared):
        return None
    turning, still = kept[: len(own)], kept[len(own) :]
    kind = _RoundPair if is_round else _Pair
    pairs = [kind(one, another, place, axis, DEEP * size) for one in turning for another in still]
    if any(isinstance(pair, _RoundPair) and pair.share > MOST_SMALLER for pair in pairs):
        return None
    if min(pair.gap(0.0) for pair in pairs) < -DEEP * size:
        return None
    ends = [_end(pairs, way, -DEEP * size) for way in (-1.0, 1.0)]
    return None if ends[0] is None or ends[1] is None else (-ends[0], ends[1])


def _axes(parts: Sequence[Polytope]) -> int:
    return sum(len(part.directions[0]) for part in parts)


class _Pair:
    """A part that turns about an axis, and one that does not."""

    def __init__(
        self, turning: Polytope, still: Polytope, place: Array, axis: Array, deep: float
    ) -> None:
        self._turning, self._place, self._axis = turning, place, axis
        self._nothing = np.zeros(3)
        self._still = Placed(still, self._nothing, np.eye(3), self._nothing, self._nothing)
        away = turning.corners - place
        self.radius = float(np.linalg.norm(away - np.outer(away @ axis, axis), axis=1).max())

    def gap(self, angle: float) -> float:
        """Return the gap where one is turned by an angle, m."""
        turn = rotations_by(angle * self._axis[None])[0]
        there = self._place - turn @ self._place
        return gap_between(
            Placed(self._turning, there, turn, self._nothing, self._nothing), self._still
        )


class _RoundPair(_Pair):
    """The same of parts with many edges: the thicker one is smaller by the depth of a meeting.

    So the distance of their corners is 0 where the parts lie in one another by that, and not where
    they touch.
    """

    def __init__(
        self, turning: Polytope, still: Polytope, place: Array, axis: Array, deep: float
    ) -> None:
        super().__init__(turning, still, place, axis, deep)
        inner = [_inner_radius(part) for part in (turning, still)]
        number = int(np.argmax(inner))
        corners = [part.corners - place for part in (turning, still)]
        middle = corners[number].mean(axis=0)
        spokes = corners[number] - middle
        self.share = deep / max(inner[number], deep)
        corners[number] = middle + (1.0 - self.share) * spokes
        self._slack = self.share * float(np.linalg.norm(spokes, axis=1).max())
        self._corners = corners

    @override
    def gap(self, angle: float) -> float:
        """Return no more than the gap where one is turned by an angle, m; 0 where they touch."""
        turn = rotations_by(angle * self._axis[None])[0]
        apart = distance_between(self._corners[0] @ turn.T, self._corners[1])
        return max(0.0, apart - self._slack) if apart > 0.0 else -np.inf


def _inner_radius(part: Polytope) -> float:
    """Return the distance of the mean of its corners from the nearest face, m."""
    return float((part.offsets - part.normals @ part.corners.mean(axis=0)).min())


def _end(pairs: Sequence[_Pair], way: float, deepest: float) -> float | None:
    """Return the angle at which the first of some pairs meets; None where none does in a round."""
    free, now = np.zeros(len(pairs)), np.zeros(len(pairs))
    while True:
        number = int(now.argmin())
        pair, angle = pairs[number], float(now[number])
        if angle >= 2.0 * np.pi:
            return None
        gap = pair.gap(way * angle)
        if gap < deepest:
            break
        free[number], now[number] = angle, angle + max(COARSE, gap / pair.radius)
    low = float(free[number])
    while angle - low > FINE:
        half = 0.5 * (low + angle)
        low, angle = (half, angle) if pair.gap(way * half) >= deepest else (low, half)
    return low


def _cleared(part: Polytope, place: Array, axis: Array, width: float) -> Polytope | None:
    """Return what of a part is farther from an axis; None where that runs through its inside."""
    middle = part.corners.mean(axis=0) - place
    aside = middle - (middle @ axis) * axis
    away = float(np.linalg.norm(aside))
    if away <= width:
        return None
    outwards = aside / away
    heights = (part.corners - place) @ outwards - width
    if heights.min() >= 0.0:
        return part
    if heights.min() < -3.0 * width:
        return None
    begin, end = part.edges.T
    crossing = heights[begin] * heights[end] < 0.0
    share = heights[begin] / np.where(crossing, heights[begin] - heights[end], 1.0)
    cuts = part.corners[begin] + share[:, None] * (part.corners[end] - part.corners[begin])
    return polytope_of(np.concatenate((part.corners[heights >= 0.0], cuts[crossing])))


def _turned(vector: Array, axis: Array, angle: float) -> Array:
    return np.asarray(rotations_by(angle * axis[None])[0] @ vector)
