"""Gaps of joints and their slopes, for many poses of one assembly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto_polyhedron.mechanism.assembly import ANGLE, DIRECTION, DISTANCE, GROUND, Joints


@dataclass(frozen=True, eq=False)
class Slopes:
    """Slopes of gaps by the six velocities of both bodies, (m, 6) each; zeros for the ground."""

    first: Array
    second: Array


@dataclass(frozen=True, eq=False)
class _Ends:
    """Pairs of points at a pose: arms from both centres, and the way from the second point."""

    first_arm: Array
    second_arm: Array
    apart: Array


class Gaps:
    """The gaps of all rows of some joints.

    Rows that share both points, such as the three of a spherical joint, share what is computed of
    them. The ground is a body behind all others that is never moved.

    Parameters
    ----------
    joints : Joints
    """

    def __init__(self, joints: Joints) -> None:
        self.joints = joints
        keys = np.column_stack(
            (joints.first, joints.second, joints.first_point, joints.second_point)
        )
        _, chosen, self._pair = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        pairs = joints.taken(chosen)
        self._first, self._second = pairs.first, pairs.second
        self._first_point, self._second_point = pairs.first_point, pairs.second_point
        self._along = np.flatnonzero(joints.kind == DIRECTION)
        self._bars = np.flatnonzero(joints.kind == DISTANCE)
        self._angles = np.flatnonzero(joints.kind == ANGLE)
        self._drives = joints.drives
        self._grounded = np.flatnonzero(joints.second == GROUND)

    def __len__(self) -> int:
        return len(self.joints)

    def at(self, places: Array, turns: Array, time: float) -> Array:
        """Return the gaps of all rows, (m,), m or rad, for bodies (n, 3) and (n, 3, 3)."""
        joints = self.joints
        places, turns = _with_ground(places, turns)
        ends = self._ends(places, turns)
        own = np.einsum("nji,nj->ni", turns[self._second], ends.apart)
        gaps = np.einsum("ij,ij->i", joints.direction, own[self._pair])
        if len(self._bars):
            gaps[self._bars] = np.linalg.norm(ends.apart[self._pair[self._bars]], axis=1)
        if len(self._angles):
            gaps[self._angles] = self._turned(turns)
        gaps -= joints.target
        for row, drive in self._drives:
            gaps[row] -= drive.at(time)
        if len(self._angles):
            gaps[self._angles] = (gaps[self._angles] + np.pi) % (2.0 * np.pi) - np.pi
        return np.asarray(gaps)

    def slopes(self, places: Array, turns: Array, freedoms: Array) -> Slopes:
        """Return how fast gaps open with the velocities of the bodies.

        A gap along d between p₁ = x₁ + r₁ and p₂ = x₂ + r₂ opens by d · (v₁ + ω₁ × r₁) of the
        first, and closes by d · (v₂ + ω₂ × (r₂ + p₁ − p₂)) of the second, with which d turns as
        well.
        """
        joints = self.joints
        places, turns = _with_ground(places, turns)
        ends = self._ends(places, turns)
        direction = np.einsum("nij,nj->ni", turns[joints.second], joints.direction)
        apart = ends.apart[self._pair]
        arm = ends.second_arm[self._pair]
        arm[self._along] += apart[self._along]
        if len(self._bars):
            lengths = np.linalg.norm(apart[self._bars], axis=1, keepdims=True)
            direction[self._bars] = apart[self._bars] / np.maximum(lengths, 1e-300)
        first, second = np.empty((len(joints), 6)), np.empty((len(joints), 6))
        first[:, :3], second[:, :3] = direction, -direction
        first[:, 3:] = cross_product(ends.first_arm[self._pair], direction)
        second[:, 3:] = cross_product(direction, arm)
        if len(self._angles):
            first[self._angles, :3] = second[self._angles, :3] = 0.0
            first[self._angles, 3:] = direction[self._angles]
            second[self._angles, 3:] = -direction[self._angles]
        second[self._grounded] = 0.0
        return Slopes(first * freedoms, second * freedoms)

    def rates(self, slopes: Slopes, velocities: Array, time: float) -> Array:
        """Return how fast gaps open, (m,), for velocities (n, 6), less what motors ask."""
        joints = self.joints
        opened = np.einsum("ij,ij->i", slopes.first, velocities[joints.first])
        opened += np.einsum("ij,ij->i", slopes.second, velocities[joints.second])
        for row, drive in self._drives:
            opened[row] -= drive.rate(time)
        return np.asarray(opened)

    def _ends(self, places: Array, turns: Array) -> _Ends:
        first = np.einsum("nij,nj->ni", turns[self._first], self._first_point)
        second = np.einsum("nij,nj->ni", turns[self._second], self._second_point)
        apart = places[self._first] + first - places[self._second] - second
        return _Ends(first, second, apart)

    def _turned(self, turns: Array) -> Array:
        """Return the angles by which first bodies are turned against second ones, rad."""
        rows = self.joints.taken(self._angles)
        own = np.einsum("nij,nj->ni", turns[rows.first], rows.first_point)
        mark = np.einsum("nij,nj->ni", turns[rows.second], rows.second_point)
        axis = np.einsum("nij,nj->ni", turns[rows.second], rows.direction)
        across = np.einsum("ij,ij->i", axis, cross_product(mark, own))
        return np.asarray(np.arctan2(across, np.einsum("ij,ij->i", mark, own)))


def _with_ground(places: Array, turns: Array) -> tuple[Array, Array]:
    """Return poses with that of the ground at the end, which is its number."""
    count = len(places)
    there, turned = np.zeros((count + 1, 3)), np.empty((count + 1, 3, 3))
    there[:count], turned[:count], turned[count] = places, turns, np.eye(3)
    return there, turned
