"""Corners of bodies on the ground: which of them meet it, and what it gives to the bodies."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.mechanism.assembly import Assembly, Ground, Motion
from bozzetto_polyhedron.mechanism.constraints import Factored
from bozzetto_polyhedron.mechanism.contact import contact_impulses
from bozzetto_polyhedron.mechanism.gaps import Slopes
from bozzetto_polyhedron.mechanism.rotations import cross

PUSH: Final = 0.2
"""Fastest way out of the ground, m/s, for a corner that a turn has taken into it."""

TOUCHING: Final = 1e-5
"""Height over the ground, m, from which on a corner stands on it."""


class Footing:
    """What the ground does to one assembly.

    Parameters
    ----------
    assembly : Assembly
    ground : Ground
    """

    def __init__(self, assembly: Assembly, ground: Ground) -> None:
        self.ground = ground
        self._joints = assembly.joints
        self._freedoms = assembly.freedoms

    def heights(self, motion: Motion) -> Array:
        """Return how high corners are over the ground, (k,) m."""
        return np.asarray(self._arms(motion)[:, 2] + motion.places[self.ground.bodies, 2]) - (
            self.ground.height
        )

    def impulses(
        self,
        motion: Motion,
        velocities: Array,
        inverse: Array,
        joints: tuple[Slopes, Factored],
        h: float,
    ) -> tuple[Array, Array]:
        """Return what the ground gives to the velocities of all bodies in a step, (n, 6).

        The second value is the impulse itself, with its moment about the centres, (n, 6).

        Parameters
        ----------
        motion : Motion
            The pose.
        velocities : (n, 6) float64
            Without the ground, and without those that open joints.
        inverse : (n, 6, 6) float64
            Inverse masses in the world.
        joints : (Slopes, Factored)
            At this pose.
        h : float
            Length of the step, s; 0 for corners that are on the ground to stay there.
        """
        heights = self.heights(motion)
        arms = self._arms(motion)
        falls = self._speeds(arms, velocities, self.ground.bodies)[:, 2]
        reach = np.maximum(-falls, 0.0) * h + TOUCHING
        near = np.flatnonzero(heights <= reach)
        if not len(near):
            return np.zeros_like(velocities), np.zeros_like(velocities)
        bodies, arms = self.ground.bodies[near], arms[near]
        slopes = self._slopes(arms)
        moved = np.einsum("kab,kcb->kac", inverse[bodies], slopes)
        given = np.zeros((len(velocities), 6, 3 * len(near)))
        columns = np.arange(3 * len(near)).reshape(-1, 3)
        for k, body in enumerate(bodies):
            given[body][:, columns[k]] += moved[k]
        given += self._through_joints(given, joints)
        response = np.einsum("kca,kaj->kcj", slopes, given[bodies]).reshape(3 * len(near), -1)
        speeds = self._speeds(arms, velocities, bodies)
        if h > 0.0:
            speeds[:, 2] += np.maximum(heights[near] / h, -PUSH)
        found = contact_impulses(0.5 * (response + response.T), speeds, self.ground.friction)
        pushed = np.zeros_like(velocities)
        np.add.at(pushed, bodies, np.einsum("kca,kc->ka", slopes, found))
        return np.asarray(given @ found.ravel()), pushed

    def _through_joints(self, given: Array, joints: tuple[Slopes, Factored]) -> Array:
        """Return what joints answer to velocities (n, 6, j) so that none of them opens."""
        slopes, factored = joints
        if not len(self._joints):
            return np.zeros_like(given)
        opened = np.einsum("ma,maj->mj", slopes.first, given[self._joints.first])
        opened += np.einsum("ma,maj->mj", slopes.second, given[self._joints.second])
        return factored.velocities(factored.impulses(-opened))

    def _arms(self, motion: Motion) -> Array:
        return np.asarray(
            np.einsum("kij,kj->ki", motion.turns[self.ground.bodies], self.ground.points)
        )

    def _speeds(self, arms: Array, velocities: Array, bodies: Index) -> Array:
        return np.asarray(velocities[bodies, :3] + cross(velocities[bodies, 3:], arms))

    def _slopes(self, arms: Array) -> Array:
        """Return how corners move with the six velocities of their bodies, (k, 3, 6)."""
        slopes = np.zeros((len(arms), 3, 6))
        slopes[:, [0, 1, 2], [0, 1, 2]] = 1.0
        slopes[:, [0, 1, 2], [4, 5, 3]] = arms[:, [2, 0, 1]]
        slopes[:, [0, 1, 2], [5, 3, 4]] = -arms[:, [1, 2, 0]]
        return slopes * self._freedoms
