"""The linear space of fills over a domain: n patches of degree five, smooth across the spokes.

Patch k has corner k at (0, 0); its u runs along the first half of side k, its v back along the
second half of the side before. The middles of sides k - 1 and k are at (0, 1) and (1, 0), the
centre at (1, 1). The spoke of side k leads from its middle to the centre: u = 1 of patch k and
v = 1 of patch k + 1.

Over the spoke, parameter t, direction e, with the domain's cross vectors A and B of the patches
on both sides, linear in t, the surface is C1 as a function of the domain exactly if

    det(B, e) X_u + det(e, A) X_v + det(A, B) X_t = 0,

which is linear in the control points (the gluing data of a bilinear domain).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import cached_property, remembered
from bozzetto_product.fill.domain import Domain, cross
from bozzetto_product.fill.domain_energy import local_energies
from bozzetto_product.fill.quintic import DEGREE, POINTS, bernstein, gauss

SIDE_POINTS: Final = 2 * DEGREE
"""Control points of a side: five of each half but the corner after it."""

SIDE_NODES: Final = 11
"""Gauss nodes along half a side at which tangent planes are held."""

RANK: Final = 1e-9
"""Singular values below this share of the largest count as none."""

PLATE: Final = 2
"""Order of the energy of a plate: second derivatives."""

BENDING_RATE: Final = 3
"""Order of the energy of the rate of bending: third derivatives."""


@dataclass(frozen=True, eq=False)
class PatchSpace:
    """All that depends on the domain only.

    A surface is ``basis @ y + particular @ b`` for any ``y``: its free control points, where
    ``b`` are the control points on its sides.

    Parameters
    ----------
    domain : Domain
    numbers : (n, 6, 6) int
        Of the control points of each patch, by u and v: first the free ones, then, in the order
        of the sides, those of the sides.
    basis : (f, z) float
        Orthonormal.
    particular : (f, 10 n) float
    """

    domain: Domain
    numbers: Index
    basis: Array
    particular: Array

    @property
    def count(self) -> int:
        """Number of patches."""
        return len(self.numbers)

    @property
    def free(self) -> int:
        """Number of free control points."""
        return len(self.basis)

    @cached_property
    def own_basis(self) -> Array:
        """The rows of the basis that belong to each patch, (n, 36, z); 0 on the sides."""
        rows = np.vstack((self.basis, np.zeros((SIDE_POINTS * self.count, self.basis.shape[1]))))
        return rows[self.numbers.reshape(self.count, -1)]

    @cached_property
    def own_sides(self) -> Array:
        """Effect of the sides' control points on those of each patch, (n, 36, 10 n)."""
        rows = np.vstack((self.particular, np.eye(SIDE_POINTS * self.count)))
        return rows[self.numbers.reshape(self.count, -1)]

    def nets(self, free: Array, sides: Array) -> Array:
        """Return the control nets, (n, 6, 6, 3), of free control points and those of the sides."""
        return np.concatenate((free, sides))[self.numbers]

    @cached_property
    def plate(self) -> tuple[Array, Array]:
        """Stiffness (z, z) of a plate, and its load by the control points of the sides."""
        return self._energy(self._squares[0])

    @cached_property
    def bending_rate(self) -> tuple[Array, Array]:
        """Stiffness (z, z) of the rate of bending, and its load by those of the sides."""
        return self._energy(self._squares[1])

    def stiffness(self, order: int) -> tuple[Array, Array]:
        """Return stiffness and load of the energy of an order."""
        return self.plate if order == PLATE else self.bending_rate

    @cached_property
    def _squares(self) -> tuple[Array, Array]:
        """Both energies of each patch, (n, 36, 36), which need the same derivatives."""
        plate, rate = local_energies(self.domain.quads, (PLATE, BENDING_RATE))
        return plate.transpose(0, 2, 1) @ plate, rate.transpose(0, 2, 1) @ rate

    def _energy(self, squares: Array) -> tuple[Array, Array]:
        inner, outer = (
            part.reshape(-1, part.shape[-1]) for part in (self.own_basis, self.own_sides)
        )
        half = (squares @ self.own_basis).reshape(inner.shape).T
        return half @ inner, half @ outer

    @cached_property
    def across(self) -> tuple[Array, Array]:
        """Fifths of the derivatives across the halves of sides at the Gauss nodes.

        Returns
        -------
        by_basis : (n, 2, 11, z) float
            The half that leads on from corner k, and the one that leads back from corner k + 1.
        by_sides : (n, 2, 11, 10 n) float
        """
        values = bernstein(side_nodes()[0])
        basis = self.own_basis.reshape(self.count, POINTS, POINTS, -1)
        sides = self.own_sides.reshape(self.count, POINTS, POINTS, -1)
        after = np.roll(np.arange(self.count), -1)
        by_basis = np.stack((basis[:, :, 1], basis[after, 1]), axis=1)
        by_sides = np.stack(
            (sides[:, :, 1] - sides[:, :, 0], (sides[:, 1] - sides[:, 0])[after]), axis=1
        )
        return values @ by_basis, values @ by_sides


@cache
def side_nodes() -> tuple[Array, Array]:
    """Return nodes and weights of the quadrature along half a side, 0 … 1."""
    return gauss(SIDE_NODES)


@remembered(limit=200, key=lambda domain: domain.key)
def space_of(domain: Domain) -> PatchSpace:
    """Return the linear space over a domain."""
    count = len(domain.corners)
    numbers, free = _numbers(count)
    rows = _spoke_rows(domain, numbers, free + SIDE_POINTS * count)
    left, values, right = np.linalg.svd(rows[:, :free])
    rank = int((values > RANK * values[0]).sum())
    inverse = (right[:rank].T / values[:rank]) @ left[:, :rank].T
    return PatchSpace(domain, numbers, right[rank:].T.copy(), -inverse @ rows[:, free:])


def _numbers(count: int) -> tuple[Index, int]:
    """Return the numbers of all control points, (n, 6, 6), and how many are free."""
    p = DEGREE
    numbers = np.zeros((count, POINTS, POINTS), np.intp)
    after = (np.arange(count) + 1) % count
    inner = np.arange(1, p)
    spokes = 1 + (p - 1) * np.arange(count)[:, None] + np.arange(p - 1)
    numbers[:, p, 1:p] = spokes
    numbers[after[:, None], inner, p] = spokes
    start = 1 + (p - 1) * count
    insides = start + np.arange(count * (p - 1) ** 2)
    numbers[:, 1:p, 1:p] = insides.reshape(count, p - 1, p - 1)
    free = start + count * (p - 1) ** 2
    side = free + SIDE_POINTS * np.arange(count)
    numbers[:, :, 0] = side[:, None] + np.arange(POINTS)
    back = np.roll(side, 1)[:, None] + SIDE_POINTS - np.arange(1, POINTS)
    numbers[:, 0, 1:] = back
    return numbers, free


def _spoke_rows(domain: Domain, numbers: Index, total: int) -> Array:
    """Return the conditions over all spokes at as many places as determine them, (7 n, total)."""
    places = DEGREE + 2
    t = 0.5 - 0.5 * np.cos(np.pi * (np.arange(places) + 0.5) / places)
    values, slopes = bernstein(t), bernstein(t, 1)
    share = t[:, None]
    count = len(numbers)
    rows = np.zeros((count, places, total))
    for k in range(count):
        after = (k + 1) % count
        corner, middle = domain.corners[k], domain.middles[k]
        way = domain.centre - middle
        left = (1 - share) * (middle - corner) + share * (domain.centre - domain.middles[k - 1])
        right = (1 - share) * (middle - domain.corners[after]) + share * (
            domain.centre - domain.middles[after]
        )
        first, second = cross(right, way)[:, None], cross(way, left)[:, None]
        along = cross(left, right)[:, None]
        mine, other = numbers[k], numbers[after]
        rows[k][:, mine[-1]] += DEGREE * (first + second) * values + along * slopes
        rows[k][:, mine[-2]] -= DEGREE * first * values
        rows[k][:, other[:, -2]] -= DEGREE * second * values
    return rows.reshape(count * places, total)
