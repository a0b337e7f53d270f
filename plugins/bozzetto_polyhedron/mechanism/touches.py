"""Contacts of bodies in a step, with the ground or one another, and their impulses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto_polyhedron.mechanism.assembly import (
    DIRECTION,
    GROUND,
    Assembly,
    Colliding,
    Ground,
    Joints,
    Motion,
    Stops,
    square_to,
)
from bozzetto_polyhedron.mechanism.collision import Placed, gap_between, touch_within
from bozzetto_polyhedron.mechanism.constraints import Factored
from bozzetto_polyhedron.mechanism.contact import contact_impulses
from bozzetto_polyhedron.mechanism.gaps import Slopes

PUSH: Final = 0.2
"""Fastest way out of one another, m/s, for what a turn has taken into something."""

TOUCHING: Final = 1e-5
"""Distance, m, from which on a corner stands on what is below it."""

MARGIN: Final = 2e-4
"""Distance, m, within which bodies are looked at closely: one that is pushed pushes on."""

HELD: Final = 1e-9
"""How much of what it would give alone a place gives through joints, at most, where these let it
give nothing, such as where a motor turns: then nothing stops it."""

OVERLAPPING: Final = 0.01
"""Depth, in sizes of the smaller part, from which on bodies at rest lie in one another."""


@dataclass(frozen=True, eq=False)
class Touches:
    """Places in which bodies touch.

    Parameters
    ----------
    first, second : (k,) intp
        Bodies; the second may be the ground.
    first_arm, second_arm : (k, 3) float64
        From the centres of the bodies to the places, in the world, m.
    axes : (k, 3, 3) float64
        Rows: two directions across, and the normal, from the second to the first.
    gaps : (k,) float64
        m.
    """

    first: Index
    second: Index
    first_arm: Array
    second_arm: Array
    axes: Array
    gaps: Array

    def __len__(self) -> int:
        return len(self.first)


class Touching:
    """Contacts between the ground and the bodies of one assembly.

    Parameters
    ----------
    assembly : Assembly
    """

    def __init__(self, assembly: Assembly) -> None:
        self._assembly = assembly
        self._joints = assembly.joints
        self._freedoms = assembly.freedoms

    def impulses(
        self,
        motion: Motion,
        velocities: Array,
        inverse: Array,
        joints: tuple[Slopes, Factored],
        h: float,
    ) -> tuple[Array, Array]:
        """Return what touching gives to the velocities of all bodies in a step, (n, 6).

        The second value is the impulse itself, with its moment about the centres, (n, 6).

        Parameters
        ----------
        motion : Motion
            The pose.
        velocities : (n, 6) float64
            Without touching, and without those that open joints.
        inverse : (n, 6, 6) float64
            Inverse masses in the world.
        joints : (Slopes, Factored)
            At this pose.
        h : float
            Length of the step, s; 0 for what touches to stay there.
        """
        kinds = []
        if self._assembly.ground is not None:
            kinds.append(ground_touches(self._assembly.ground, motion, velocities, h))
        if self._assembly.colliding is not None:
            kinds.append(body_touches(self._assembly.colliding, motion, velocities, h))
        if self._assembly.stops is not None:
            kinds.append(stop_touches(self._assembly.stops, motion, velocities, h))
        touches = _together(kinds)
        if not len(touches):
            return np.zeros_like(velocities), np.zeros_like(velocities)
        sides = self._sides(touches)
        by_place = np.zeros((len(velocities), 6, len(touches), 3))
        for bodies, slopes in sides:
            held = np.flatnonzero(bodies != GROUND)
            moved = inverse[bodies[held]] @ slopes[held].transpose(0, 2, 1)
            by_place[bodies[held], :, held] += moved
        given = by_place.reshape(len(velocities), 6, -1)
        alone = np.diagonal(_response(sides, given))
        given = given + self._through_joints(given, joints)
        response = _response(sides, given)
        speeds = sum(
            np.einsum("kca,ka->kc", slopes, velocities[bodies]) for bodies, slopes in sides
        )
        speeds = np.asarray(speeds)
        if h > 0.0:
            speeds[:, 2] += np.maximum(touches.gaps / h, -PUSH)
        found = np.zeros_like(speeds)
        yields = np.diagonal(response)[2::3] > HELD * alone[2::3]
        rows = np.repeat(yields, 3)
        found[yields] = contact_impulses(
            response[np.ix_(rows, rows)], speeds[yields], self._assembly.friction
        )
        pushed = np.zeros_like(velocities)
        for bodies, slopes in sides:
            held = bodies != GROUND
            np.add.at(pushed, bodies[held], np.einsum("kca,kc->ka", slopes, found)[held])
        return np.asarray(given @ found.ravel()), pushed

    def _through_joints(self, given: Array, joints: tuple[Slopes, Factored]) -> Array:
        """Return what joints answer to velocities (n, 6, j) so that none of them opens."""
        slopes, factored = joints
        if not len(self._joints):
            return np.zeros_like(given)
        opened = np.einsum("ma,maj->mj", slopes.first, given[self._joints.first])
        opened += np.einsum("ma,maj->mj", slopes.second, given[self._joints.second])
        return factored.velocities(factored.impulses(-opened))

    def _sides(self, touches: Touches) -> tuple[tuple[Index, Array], tuple[Index, Array]]:
        """Return both bodies of touches and how these open with their velocities, (k, 3, 6)."""
        first = self._slopes(touches.axes, touches.first_arm)
        second = -self._slopes(touches.axes, touches.second_arm)
        second[touches.second == GROUND] = 0.0
        return (touches.first, first), (touches.second, second)

    def _slopes(self, axes: Array, arms: Array) -> Array:
        slopes = np.empty((len(arms), 3, 6))
        slopes[:, :, :3] = axes
        for row in range(3):
            slopes[:, row, 3:] = cross_product(arms, axes[:, row])
        return slopes * self._freedoms


def _response(sides: tuple[tuple[Index, Array], ...], given: Array) -> Array:
    """Return the velocities (3 k, 3 k) in places that touch for those of bodies, (n, 6, 3 k)."""
    size = given.shape[2]
    found = sum((slopes @ given[bodies]).reshape(size, size) for bodies, slopes in sides)
    return np.asarray(0.5 * (found + np.transpose(found)))


def ground_touches(ground: Ground, motion: Motion, velocities: Array, h: float) -> Touches:
    """Return the corners that stand on the ground, or would be below it after a step."""
    bodies = ground.bodies
    arms = np.einsum("kij,kj->ki", motion.turns[bodies], ground.points)
    heights = arms[:, 2] + motion.places[bodies, 2] - ground.height
    falls = (velocities[bodies, :3] + cross_product(velocities[bodies, 3:], arms))[:, 2]
    near = np.flatnonzero(heights <= np.maximum(-falls, 0.0) * h + TOUCHING)
    return Touches(
        bodies[near],
        np.full(len(near), GROUND),
        arms[near],
        np.zeros((len(near), 3)),
        np.tile(np.eye(3), (len(near), 1, 1)),
        heights[near],
    )


def body_touches(colliding: Colliding, motion: Motion, velocities: Array, h: float) -> Touches:
    """Return the places in which bodies touch, or would lie in one another after a step."""
    found = []
    placed = [
        Placed(part, motion.places[body], motion.turns[body], *np.split(velocities[body], 2))
        for body, part in zip(colliding.bodies, colliding.parts, strict=True)
    ]
    for one, other in _near_pairs(colliding, placed, h):
        touch = touch_within(placed[one], placed[other], h, MARGIN if h > 0.0 else TOUCHING)
        if touch is not None:
            count = len(touch.on_first)
            axes = np.stack((*square_to(touch.normal), touch.normal))
            found.append(
                Touches(
                    np.full(count, colliding.bodies[other]),
                    np.full(count, colliding.bodies[one]),
                    touch.on_second - placed[other].place,
                    touch.on_first - placed[one].place,
                    np.tile(axes, (count, 1, 1)),
                    (touch.on_second - touch.on_first) @ touch.normal,
                )
            )
    return _together(found)


def stop_touches(stops: Stops, motion: Motion, velocities: Array, h: float) -> Touches:
    """Return the hinges that are at an end of their way, or would be beyond it after a step."""
    first, second = stops.first, stops.second
    axis = np.einsum("kij,kj->ki", motion.turns[second], stops.axis)
    mark = np.einsum("kij,kj->ki", motion.turns[first], stops.mark)
    arm = np.einsum("kij,kj->ki", motion.turns[second], stops.place)
    radius = np.linalg.norm(mark, axis=1)
    turning = np.einsum("ki,ki->k", axis, velocities[first, 3:] - velocities[second, 3:])
    angles = stops.angles(motion)
    found = []
    for way in (1.0, -1.0):
        gaps = radius * (stops.reach + way * angles)
        near = np.flatnonzero(gaps <= np.maximum(-way * turning * radius, 0.0) * h + TOUCHING)
        normal = way * cross_product(axis[near], mark[near]) / radius[near, None]
        there = arm[near] + mark[near]
        place = there + motion.places[second[near]]
        found.append(
            Touches(
                first[near],
                second[near],
                place - motion.places[first[near]],
                there,
                np.stack((axis[near], mark[near] / radius[near, None], normal), axis=1),
                gaps[near],
            )
        )
    return _together(found)


def lying_in_one_another(colliding: Colliding, motion: Motion) -> frozenset[tuple[int, int]]:
    """Return the pairs of bodies that overlap in a pose, the smaller number first."""
    still = np.zeros(3)
    placed = [
        Placed(part, motion.places[body], motion.turns[body], still, still)
        for body, part in zip(colliding.bodies, colliding.parts, strict=True)
    ]
    found = set()
    for one, other in _near_pairs(colliding, placed, 0.0):
        size = min(float(np.ptp(placed[k].corners, axis=0).max()) for k in (one, other))
        if gap_between(placed[one], placed[other]) < -OVERLAPPING * size:
            first, second = sorted((int(colliding.bodies[one]), int(colliding.bodies[other])))
            found.add((first, second))
    return frozenset(found)


def jointed(joints: Joints) -> frozenset[tuple[int, int]]:
    """Return the pairs of bodies that touch in a joint, the smaller number first.

    A bar keeps bodies apart; they may meet all the same.
    """
    held = joints.kind == DIRECTION
    pairs = zip(joints.first[held].tolist(), joints.second[held].tolist(), strict=True)
    return frozenset((min(pair), max(pair)) for pair in pairs if GROUND not in pair)


def _near_pairs(colliding: Colliding, placed: list[Placed], h: float) -> list[tuple[int, int]]:
    """Return the parts of different bodies whose boxes come near one another in a step."""
    if not placed:
        return []
    reach = [
        float(np.linalg.norm(each.velocity) + np.linalg.norm(each.spin) * each.radius) * h + MARGIN
        for each in placed
    ]
    low = np.array([each.corners.min(axis=0) - r for each, r in zip(placed, reach, strict=True)])
    high = np.array([each.corners.max(axis=0) + r for each, r in zip(placed, reach, strict=True)])
    meet = ((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(axis=2)
    bodies = colliding.bodies
    meet &= bodies[:, None] != bodies[None]
    pairs = np.argwhere(np.triu(meet, 1))
    return [
        (int(one), int(other))
        for one, other in pairs
        if tuple(sorted((int(bodies[one]), int(bodies[other])))) not in colliding.passing
    ]


def _together(found: list[Touches]) -> Touches:
    if not found:
        none = np.zeros(0, np.intp)
        return Touches(
            none, none, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0)
        )
    return Touches(
        *(
            np.concatenate([getattr(each, name) for each in found])
            for name in Touches.__dataclass_fields__
        )
    )
