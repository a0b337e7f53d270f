"""Quadrics that the curves of a loop lie on.

Spheres, ellipsoids, cylinders, cones, paraboloids and hyperboloids are quadrics, and so is much of
what is drawn on rough shapes. Two curves through a corner leave open how normals lean in the middle
of edges, and no energy has an ellipsoid as its least; but curves of which one quadric alone goes
through all tell both. The quadric is that of least mean square distance to first order (Taubin
1991, "Estimation of planar curves, surfaces, and nonplanar space curves defined by implicit
equations"), a generalized eigenvalue problem; the second eigenvalue tells how much farther
off every other one is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array

CLOSE: Final = 5e-4
"""Root mean square distance of places from a quadric, as share of their size, up to which they lie
on it."""

EXACT: Final = 2e-5
"""The same up to which it is meant whatever normals say: curves of CAD lie so, and no hand's."""

ALONE: Final = 90.0
"""How many times farther off the second quadric must be, for the first to be meant."""

FLAT: Final = 1e-3
"""Share of the size below which places lie in a plane, which many quadrics touch."""

TINY: Final = 1e-7
"""Root mean square distance, as share of the size, below which it tells nothing more."""

STEPS: Final = 6
"""Newton steps to the nearest place."""

REACH: Final = 0.1
"""Distance of a place from a quadric, as share of the size, up to which it is brought there."""

FAR_REACH: Final = 0.3
"""The same of an exact one: between creases a surface of least energy may be far from it."""

WEAK: Final = 0.05
"""Share of the middling gradient below which a quadric has no normal: a tip, or two sheets meet."""


@dataclass(frozen=True, eq=False)
class Quadric:
    """A surface of second order, the places x where xᵀ A x + b x + c is nought.

    Parameters
    ----------
    square : (3, 3) float
        A, symmetric.
    linear : (3,) float
        b
    constant : float
        c
    size : float
        Of the places that it was fitted to, mm.
    off : float
        Their root mean square distance, mm.
    alone : float
        How many times farther off every other quadric is.
    """

    square: Array
    linear: Array
    constant: float
    size: float
    off: float
    alone: float

    @property
    def is_exact(self) -> bool:
        """Whether places lie on it as curves of CAD do."""
        return self.off <= EXACT * self.size

    def value(self, places: Array) -> Array:
        """Return the function that is nought on the surface, (n,)."""
        return np.asarray(
            ((places @ self.square) * places).sum(axis=1) + places @ self.linear + self.constant
        )

    def gradient(self, places: Array) -> Array:
        """Return its gradient, (n, 3)."""
        return np.asarray(2.0 * places @ self.square + self.linear)

    def normals(self, places: Array) -> Array:
        """Return unit normals at places, (n, 3), all to the same side."""
        gradient = self.gradient(places)
        length = np.linalg.norm(gradient, axis=1, keepdims=True)
        return np.asarray(gradient / np.maximum(length, 1e-300))

    def nearest(self, places: Array) -> Array | None:
        """Return places of the surface along its gradients; None where some are not there."""
        found, reach = places, (FAR_REACH if self.is_exact else REACH) * self.size
        for _ in range(STEPS):
            gradient = self.gradient(found)
            length = (gradient * gradient).sum(axis=1)
            if not length.min() > WEAK**2 * np.median(length):
                return None
            found = found - (self.value(found) / length)[:, None] * gradient
            if np.linalg.norm(found - places, axis=1).max() > reach:
                return None
        return found


def quadric_through(places: Array, weights: Array) -> Quadric | None:
    """Return the quadric that places lie on, if it is the only one.

    Parameters
    ----------
    places : (n, 3) float
        On the curves.
    weights : (n,) float
        Length that each stands for.
    """
    from scipy.linalg import eigh

    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    if not (size > 0.0 and weights.sum() > 0.0 and np.isfinite(places).all()):
        return None
    share = weights / weights.sum()
    middle = share @ places
    x, y, z = ((places - middle) / size).T
    own = np.column_stack((x, y, z)) * np.sqrt(share)[:, None]
    if np.linalg.svd(own, compute_uv=False)[2] < FLAT:
        return None
    terms = np.stack((x * x, y * y, z * z, x * y, y * z, z * x, x, y, z))
    mean = terms @ share
    lacks = terms - mean[:, None]
    none, one = np.zeros_like(x), np.ones_like(x)
    slopes = np.array(
        (
            (2 * x, none, none, y, none, z, one, none, none),
            (none, 2 * y, none, x, z, none, none, one, none),
            (none, none, 2 * z, none, y, x, none, none, one),
        )
    )
    slopes = slopes.transpose(1, 0, 2).reshape(9, -1)
    length = (slopes * np.tile(share, 3)) @ slopes.T
    try:
        squares, found = eigh((lacks * share) @ lacks.T, length, subset_by_index=(0, 1))
    except np.linalg.LinAlgError:
        return None
    first, second = np.sqrt(np.maximum(squares, 0.0))
    if first > CLOSE or second < ALONE * max(first, TINY):
        return None
    a, b, c, d, e, f, *linear = found[:, 0]
    square = np.array(((a, d / 2, f / 2), (d / 2, b, e / 2), (f / 2, e / 2, c))) / size**2
    along = np.array(linear) / size
    constant = float(middle @ square @ middle - along @ middle - found[:, 0] @ mean)
    return Quadric(
        square,
        along - 2.0 * square @ middle,
        constant,
        size,
        float(first) * size,
        float(second) / max(float(first), TINY),
    )
