"""Energies of functions of the domain, by quadrature through the bilinear maps of its quads."""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_product.fill.quintic import NODES, WEIGHTS, bernstein

ORDERS: Final = tuple((total - b, b) for total in range(1, 4) for b in range(total + 1))
"""Derivatives by both coordinates, up to the third."""

TERMS: Final = {
    2: (((2, 0), 1.0), ((1, 1), 2.0), ((0, 2), 1.0)),
    3: (((3, 0), 1.0), ((2, 1), 3.0), ((1, 2), 3.0), ((0, 3), 1.0)),
}
"""Squares of derivatives that make an energy that does not depend on the axes."""


def local_energies(quads: Array, orders: Sequence[int]) -> tuple[Array, ...]:
    """Return rows whose squares sum to the energies of each patch.

    Parameters
    ----------
    quads : (n, 4, 2) float
        Quadrangles of the domain.
    orders : sequence of int
        2 for a plate, 3 for the rate of bending.

    Returns
    -------
    tuple of (n, r, 36) float
        Of each order, for the control values of each patch, u major.
    """
    u, v = (x.ravel() for x in np.meshgrid(NODES, NODES, indexing="ij"))
    weights = np.outer(WEIGHTS, WEIGHTS).ravel()
    values = [bernstein(NODES, order) for order in range(4)]
    jets = np.stack(
        [np.einsum("ai,bj->abij", values[a], values[b]).reshape(len(u), 36) for a, b in ORDERS], 1
    )
    maps, area = _jets_of_maps(quads, u, v)
    by_place = np.linalg.inv(maps) @ jets
    size = np.sqrt(weights * np.abs(area))[..., None]
    return tuple(
        np.concatenate(
            [
                np.sqrt(share) * size * by_place[:, :, ORDERS.index(which)]
                for which, share in TERMS[order]
            ],
            axis=1,
        )
        for order in orders
    )


def _jets_of_maps(quads: Array, u: Array, v: Array) -> tuple[Array, Array]:
    """Return what takes derivatives by place to those by parameters, (n, m, 9, 9), and areas."""
    a, b, c, d = (quads[:, k, None] for k in range(4))
    by_u = (1 - v)[:, None] * (b - a) + v[:, None] * (c - d)
    by_v = (1 - u)[:, None] * (d - a) + u[:, None] * (c - b)
    twist = np.broadcast_to(a - b + c - d, by_u.shape)
    shape = by_u.shape[:2]
    steps = np.zeros((4, 4, 2, *shape))
    steps[1, 0], steps[0, 1], steps[1, 1] = (np.moveaxis(x, 2, 0) for x in (by_u, by_v, twist))
    powers = [np.zeros_like(steps)]
    powers[0][0, 0] = 1.0
    for _ in range(3):
        powers.append(_product(powers[-1], steps))
    by_x, by_y = (np.stack([power[:, :, axis] for power in powers], axis=2) for axis in range(2))
    i, j = np.transpose(ORDERS)
    counts = np.array([factorial(a) * factorial(b) for a, b in ORDERS], float)
    terms = _product(by_x[:, :, i], by_y[:, :, j])[i, j]
    maps = np.moveaxis(terms, (0, 1), (2, 3)) * (counts[:, None] / counts)
    return maps, by_u[..., 0] * by_v[..., 1] - by_u[..., 1] * by_v[..., 0]


def _product(one: Array, two: Array) -> Array:
    """Return the product of polynomials in two variables up to the third order, (4, 4, …)."""
    made = np.zeros_like(one)
    for i, j in ((0, 0), *ORDERS):
        for k, m in ((0, 0), *ORDERS):
            if i + j + k + m <= 3:
                made[i + k, j + m] += one[i, j] * two[k, m]
    return made
