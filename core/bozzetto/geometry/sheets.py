"""Which sheet of a skin a curve is to lie in, where several are about as near."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.icosphere import Icosphere

__all__ = ["sheet_of"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

STEEP: Final = 0.7
"""Cosine of the angle between a curve and a normal of the skin from which on the curve would
stick in the skin like a nail and not lie in it."""

TOUCHING: Final = 0.5
"""Distance, per edge, below which a curve belongs to a sheet however it lies to it."""

DETOUR: Final = 2.0
"""How much farther than the nearest sheet that one may be which a curve is given to."""

UPWARD: Final = 0.1
"""Share by which squared distances from sheets that look up or down differ: of two films that
close a hole, the upper one takes the curves between them."""


def sheet_of(
    sphere: Icosphere, vertices: Array, points: Array, tangents: Array
) -> tuple[Index, NDArray[np.bool_]]:
    """The nearest vertex of a sheet in which a curve can lie, for each of its places.

    An edge that ends on the flank of a hollow is nearest to the flank at its end, and would dent
    it. It stands upright on it, so it waits there for the sheet over the hollow.

    Parameters
    ----------
    sphere : Icosphere
    vertices : (v, 3) float
        Few: each is compared with each place.
    points, tangents : (n, 3) float

    Returns
    -------
    vertex : (n,) int
    found : (n,) bool
        Whether there is such a sheet within reach.
    """
    a, b, c = np.moveaxis(vertices[sphere.faces], 1, 0)
    normals = np.cross(b - a, c - a)[sphere.rings].sum(axis=1)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(length > 0, length, 1.0)
    along = vertices[sphere.edges[:, 0]] - vertices[sphere.edges[:, 1]]
    edge = np.einsum("ij,ij->i", along, along).mean()
    square = (points**2).sum(axis=1)[:, None] + (vertices**2).sum(axis=1)
    square = np.maximum(square - 2.0 * points @ vertices.T, 0.0)
    nails = (np.abs(tangents @ normals.T) > STEEP) & (square > TOUCHING**2 * edge)
    price = np.where(nails, np.inf, square * (1.0 - UPWARD * normals[:, 2]))
    vertex = np.argmin(price, axis=1)
    best = price[np.arange(len(points)), vertex]
    return vertex, best < np.maximum(DETOUR**2 * square.min(axis=1), edge)
