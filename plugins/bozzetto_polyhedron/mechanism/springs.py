"""Forces and energy of springs."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto_polyhedron.mechanism.assembly import GROUND, Motion, Springs


def spring_forces(springs: Springs, motion: Motion) -> tuple[Array, Array]:
    """Return the forces of springs on bodies and their moments about the centres, (n, 3) each."""
    forces, moments = np.zeros_like(motion.places), np.zeros_like(motion.places)
    if len(springs.first):
        stretch, along, one, other = _stretched(springs, motion)
        pulls = -(springs.stiffness * stretch)[:, None] * along
        np.add.at(forces, springs.first, pulls)
        np.add.at(moments, springs.first, cross_product(one, pulls))
        held = springs.second != GROUND
        np.add.at(forces, springs.second[held], -pulls[held])
        np.add.at(moments, springs.second[held], -cross_product(other, pulls)[held])
    return forces, moments


def tensions(springs: Springs, motion: Motion) -> Array:
    """Return the force with which each spring pulls its ends together, (k,) N."""
    return np.asarray(springs.stiffness * _stretched(springs, motion)[0])


def spring_energy(springs: Springs, motion: Motion) -> float:
    """Return what is stored in all springs, J."""
    stretch = _stretched(springs, motion)[0]
    return 0.5 * float((springs.stiffness * stretch**2).sum())


def _stretched(springs: Springs, motion: Motion) -> tuple[Array, Array, Array, Array]:
    """Return by how much springs are stretched, their directions, and both arms."""
    one = np.einsum("nij,nj->ni", motion.turns[springs.first], springs.first_point)
    grounded = (springs.second == GROUND)[:, None]
    other = np.einsum("nij,nj->ni", motion.turns[springs.second], springs.second_point)
    there = np.where(grounded, springs.second_point, motion.places[springs.second] + other)
    apart = motion.places[springs.first] + one - there
    lengths = np.linalg.norm(apart, axis=1)
    along = apart / np.maximum(lengths, 1e-300)[:, None]
    return lengths - springs.length, along, one, other
