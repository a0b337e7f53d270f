"""The banded system of the forces of joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg import LinAlgError
from scipy.linalg.lapack import dpbtrf, dpbtrs
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.mechanism.assembly import GROUND, Assembly
from bozzetto_polyhedron.mechanism.gaps import Slopes

RIDGE: Final = 1e-10
"""Added to the diagonal, relative to its mean: joints that say the same twice share their force."""


class BandedSystem:
    """Order of the rows in which those that share a body are near one another.

    Reverse Cuthill–McKee makes the matrix of all forces banded: what it costs grows with the
    number of joints, not with its cube.
    """

    def __init__(self, assembly: Assembly) -> None:
        joints, count = assembly.joints, len(assembly.masses)
        rows = len(joints)
        numbers = np.arange(rows)
        anchored = np.where(joints.second == GROUND, count + numbers, joints.second)
        met = coo_matrix(
            (
                np.ones(2 * rows),
                (np.concatenate((numbers, numbers)), np.concatenate((joints.first, anchored))),
            ),
            shape=(rows, count + rows),
        ).tocsr()
        shared = (met @ met.T).tocsr()
        order = reverse_cuthill_mckee(shared, symmetric_mode=True) if rows else numbers
        self.position = np.empty(rows, np.intp)
        self.position[order] = numbers
        one, other = shared.nonzero()
        kept = self.position[one] >= self.position[other]
        one, other = one[kept], other[kept]
        self.below = self.position[one] - self.position[other]
        self.column = self.position[other]
        self.width = int(self.below.max(initial=0)) + 1
        self.joints = joints
        self.count = count
        ends = (joints.first, joints.second)
        self.terms: list[tuple[Index, Index, Index, int, int]] = []
        for mine in (0, 1):
            for theirs in (0, 1):
                same = ends[mine][one] == ends[theirs][other]
                used = np.flatnonzero(same & (ends[mine][one] != GROUND))
                if len(used):
                    pairs = one[used].astype(np.intp), other[used].astype(np.intp)
                    self.terms.append((used, *pairs, mine, theirs))
        bodies = np.concatenate(ends)
        held = np.flatnonzero(bodies != GROUND)
        self.by_body = held[np.argsort(bodies[held], kind="stable")]
        self.bodies, self.starts = np.unique(bodies[self.by_body], return_index=True)

    def factored(self, slopes: Slopes, inverse_masses: Array) -> Factored:
        """Return the factored system of forces at a pose.

        Parameters
        ----------
        slopes : Slopes
            Of all rows.
        inverse_masses : (n, 6, 6) float64
            In the world.
        """
        sides = (slopes.first, slopes.second)
        bodies = (self.joints.first, self.joints.second)
        moved = [
            np.einsum("nij,nj->ni", inverse_masses[body], side)
            for body, side in zip(bodies, sides, strict=True)
        ]
        values = np.zeros(len(self.below))
        for used, one, other, mine, theirs in self.terms:
            values[used] += np.einsum("ij,ij->i", sides[mine][one], moved[theirs][other])
        band = np.zeros((self.width, len(self.joints)), order="F")
        band[self.below, self.column] = values
        if band.size:
            band[0] += RIDGE * float(band[0].mean()) + 1e-300
            band, failed = dpbtrf(band, lower=1, overwrite_ab=1)
            if failed:
                raise LinAlgError("The masses of the pieces are no masses.")
        return Factored(self, np.concatenate(moved)[self.by_body], band)


@dataclass(frozen=True, eq=False)
class Factored:
    """The system of forces at one pose, ready to be solved.

    Parameters
    ----------
    system : BandedSystem
    moved : (r, 6) float64
        Velocities that a unit impulse along each row gives to its bodies, in the order of the
        bodies.
    band : (w, m) float64
        The Cholesky factor, lower, in the order of the system.
    """

    system: BandedSystem
    moved: Array
    band: Array

    def impulses(self, wanted: Array) -> Array:
        """Return the impulses, (m,) or (m, k), that make gaps open at a wanted rate."""
        if not len(wanted):
            return np.zeros_like(wanted)
        ordered = np.empty_like(wanted)
        ordered[self.system.position] = wanted
        found, _ = dpbtrs(self.band, ordered, lower=1)
        return np.asarray(found[self.system.position])

    def velocities(self, impulses: Array) -> Array:
        """Return what impulses (m,) or (m, k) change of the velocities, (n, 6) or (n, 6, k)."""
        system = self.system
        changed = np.zeros((system.count, 6, *impulses.shape[1:]))
        if len(impulses):
            each = impulses[system.by_body % len(impulses)]
            moved = self.moved.reshape(len(self.moved), 6, *(1,) * (impulses.ndim - 1))
            summed = np.add.reduceat(moved * each[:, None], system.starts, axis=0)
            changed[system.bodies] = summed
        return changed
