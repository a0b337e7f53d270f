"""Degrees of freedom, redundant constraints, and the forces in bars at rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto_polyhedron.mechanism.assembly import GROUND, Assembly, Motion
from bozzetto_polyhedron.mechanism.gaps import Gaps

RANK: Final = 1e-9
"""Singular value, relative to the largest, below which a constraint says nothing new."""


@dataclass(frozen=True, eq=False)
class Mobility:
    """Freedoms of an assembly in one pose.

    Parameters
    ----------
    degrees : int
        Independent motions that open no gap.
    redundant : int
        Rows of joints that others say already.
    motions : (degrees, n, 6) float64
        Velocities of all bodies in each of them, orthonormal.
    """

    degrees: int
    redundant: int
    motions: Array


def mobility_of(assembly: Assembly, motion: Motion) -> Mobility:
    """Return the freedoms of an assembly, by the rank of the slopes of its gaps.

    Point masses have no turn to be counted.
    """
    free = _free_columns(assembly)
    matrix = _dense_slopes(assembly, motion)[:, free]
    count = len(assembly.masses)
    if not len(matrix):
        values, vectors = np.zeros(0), np.eye(int(free.sum()))
    else:
        _, values, vectors = np.linalg.svd(matrix)
    rank = int((values > RANK * values.max(initial=0.0)).sum())
    motions = np.zeros((len(vectors) - rank, 6 * count))
    motions[:, free] = vectors[rank:]
    return Mobility(len(motions), len(matrix) - rank, motions.reshape(len(motions), count, 6))


@dataclass(frozen=True, eq=False)
class Balance:
    """Forces of joints at rest.

    Parameters
    ----------
    rows : (m,) float64
        Along the slopes of all rows, N or N m.
    on_first, on_second : (m, 6) float64
        What each row does to its bodies: force and moment about the centre.
    left : float
        Largest part of the loads that no joint carries, as a share of the largest load: 0 in
        balance.
    """

    rows: Array
    on_first: Array
    on_second: Array
    left: float


def balance_of(assembly: Assembly, motion: Motion, loads: Array) -> Balance:
    """Return the forces with which joints carry loads (n, 6), N and N m, by J^T f = -F.

    Where the bars of a structure could share a load in many ways, the smallest forces are taken.
    """
    free = _free_columns(assembly)
    slopes = Gaps(assembly.joints).slopes(motion.places, motion.turns, assembly.freedoms)
    dense = _dense_slopes(assembly, motion)[:, free]
    wanted = -loads.ravel()[free]
    rows = np.asarray(np.linalg.lstsq(dense.T, wanted, rcond=1e-12)[0])
    missed = float(np.abs(dense.T @ rows - wanted).max(initial=0.0))
    largest = float(np.abs(wanted).max(initial=0.0))
    return Balance(
        rows,
        slopes.first * rows[:, None],
        slopes.second * rows[:, None],
        missed / largest if largest > 0.0 else 0.0,
    )


def weights(assembly: Assembly) -> Array:
    """Return the weights of all bodies as loads, (n, 6)."""
    loads = np.zeros((len(assembly.masses), 6))
    loads[:, :3] = assembly.masses[:, None] * assembly.gravity
    return loads


def _dense_slopes(assembly: Assembly, motion: Motion) -> Array:
    """Return the slopes of all gaps as one matrix, (m, 6 n)."""
    joints, count = assembly.joints, len(assembly.masses)
    slopes = Gaps(joints).slopes(motion.places, motion.turns, assembly.freedoms)
    made = np.zeros((len(joints), count, 6))
    rows = np.arange(len(joints))
    made[rows, joints.first] += slopes.first
    held = joints.second != GROUND
    made[rows[held], joints.second[held]] += slopes.second[held]
    return made.reshape(len(joints), 6 * count)


def _free_columns(assembly: Assembly) -> Flags:
    """Return which of the 6 n velocities there are."""
    turning = np.abs(assembly.inertias).reshape(-1, 9).max(axis=1) > 0.0
    there = np.ones((len(turning), 6), bool)
    there[:, 3:] = turning[:, None]
    return np.asarray((there & (assembly.freedoms > 0.0)).ravel())
