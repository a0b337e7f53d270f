"""Bending energy of a displaced curve, as a band matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

SOFTNESS: Final = 12.0
"""Length, px, at which bending and pull weigh the same (the fourth root of their ratio).
A pull that changes faster along the curve is smoothed away, a slower one is followed."""


def lengths_of(along: Array, ring: float | None) -> Array:
    """Return the length of curve that belongs to each node: half of both its spans, px.

    Parameters
    ----------
    along : (n,) float
        Arc length of the nodes, increasing, px.
    ring : float or None
        Length of a closed curve; None for an open one.
    """
    if ring is not None:
        spans = np.diff(np.append(along, along[0] + ring))
        return np.asarray(0.5 * (spans + np.roll(spans, 1)))
    if len(along) == 1:
        return np.ones(1)
    spans = np.diff(along)
    return np.asarray(0.5 * (np.append(spans, 0.0) + np.append(0.0, spans)))


class Bending:
    """The equation of a displacement that is pulled and resists bending.

    Minimises the integral of ``stiffness SOFTNESS⁴ |U''|² + gain |U − pull|²`` along the
    curve. The matrix is factorised once. It is pentadiagonal for an open curve; a closed
    one is folded at its seam (first, last, second, last but one …), which makes it a band
    of twice that width instead of one with corners.

    Parameters
    ----------
    along : (n,) float
        Arc length of the nodes, increasing, px.
    gain : (n,) float
        How strongly each node is pulled; where the node is free, above 0.
    free : (n,) bool
        The other nodes stay where they are.
    stiffness : float
        Not below 0; compares with the gain.
    ring : float or None
        Length of a closed curve of at least three nodes; None for an open one.
    """

    def __init__(
        self,
        along: Array,
        gain: Array,
        free: Flags,
        stiffness: float,
        ring: float | None,
    ) -> None:
        from scipy.linalg import cholesky_banded

        count = len(along)
        self._free = free
        self._load = np.where(free, lengths_of(along, ring) * gain, 0.0)
        self._row = np.arange(count) if ring is None else _folded(count)
        width = 2 if ring is None else 4
        band = np.zeros((width + 1, count))
        np.add.at(band[width], self._row, np.where(free, self._load, 1.0))
        for nodes, second, length in _second_differences(along, ring):
            for one, a in zip(nodes, second, strict=True):
                for other, b in zip(nodes, second, strict=True):
                    i, j = self._row[one], self._row[other]
                    both = (i <= j) & free[one] & free[other]
                    i, j = i[both], j[both]
                    value = stiffness * SOFTNESS**4 * (length * a * b)[both]
                    np.add.at(band, (width + i - j, j), value)
        self._factor = cholesky_banded(band, check_finite=False)

    def solve(self, pull: Array) -> Array:
        """Return the displacement (n, 2) of nodes on which the forces `pull` (n, 2) act, px."""
        from scipy.linalg import cho_solve_banded

        right = np.zeros_like(pull)
        right[self._row] = self._load[:, None] * pull
        return np.asarray(cho_solve_banded((self._factor, False), right)[self._row], np.float64)


def _folded(count: int) -> Index:
    """Return the row of each node of a ring, so that neighbours are at most two rows apart."""
    numbers = np.arange(count)
    back = count - 1 - numbers
    return np.where(numbers <= back, 2 * numbers, 2 * back + 1)


def _second_differences(
    along: Array, ring: float | None
) -> list[tuple[tuple[Index, ...], tuple[Array, ...], Array]]:
    """Return nodes, coefficients and length of each second difference, on uneven spacing."""
    count = len(along)
    if count < 3:
        return []
    if ring is None:
        middle = np.arange(1, count - 1)
        spans = np.diff(along)
        before, after = spans[:-1], spans[1:]
    else:
        middle = np.arange(count)
        after = np.diff(np.append(along, along[0] + ring))
        before = np.roll(after, 1)
    first, last = 2.0 / (before * (before + after)), 2.0 / (after * (before + after))
    nodes = ((middle - 1) % count, middle, (middle + 1) % count)
    return [(nodes, (first, -first - last, last), 0.5 * (before + after))]
