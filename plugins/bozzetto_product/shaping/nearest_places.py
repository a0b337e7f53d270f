"""The places of a fill that are nearest to given points."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import BSplineSurface
from bozzetto_product.fill.fill import Fill

GRID: Final = 17
"""Places along each direction of a patch from which the nearest one is the start."""

STEPS: Final = 12
"""Gauss–Newton steps: each about squares the error where the surface is near."""


def nearest_on(fill: Fill, points: Array) -> tuple[Array, Array]:
    """Return the nearest places of a fill, (n, 3) mm, and unit normals there, (n, 3)."""
    best = np.full(len(points), np.inf)
    places, normals = np.empty((len(points), 3)), np.empty((len(points), 3))
    for patch in fill.patches:
        found, across = _nearest_of(patch, points)
        away = np.linalg.norm(found - points, axis=1)
        nearer = away < best
        best[nearer] = away[nearer]
        places[nearer], normals[nearer] = found[nearer], across[nearer]
    return places, normals


def _nearest_of(patch: BSplineSurface, points: Array) -> tuple[Array, Array]:
    from scipy.spatial import cKDTree

    (low_u, high_u), (low_v, high_v) = patch.ranges
    grid = np.meshgrid(
        np.linspace(low_u, high_u, GRID), np.linspace(low_v, high_v, GRID), indexing="ij"
    )
    u, v = (part.ravel() for part in grid)
    start = cKDTree(patch.value(u, v)).query(points)[1]
    u, v = u[start], v[start]
    off = patch.value(u, v) - points
    for _ in range(STEPS):
        by_u, by_v = patch.derivative(u, v, 1, 0), patch.derivative(u, v, 0, 1)
        a, b, c = (by_u * by_u).sum(1), (by_u * by_v).sum(1), (by_v * by_v).sum(1)
        p, q = (by_u * off).sum(1), (by_v * off).sum(1)
        free = np.maximum(a * c - b * b, 1e-12 * a * c + 1e-300)
        next_u = np.clip(u - (c * p - b * q) / free, low_u, high_u)
        next_v = np.clip(v - (a * q - b * p) / free, low_v, high_v)
        there = patch.value(next_u, next_v) - points
        nearer = (there**2).sum(1) < (off**2).sum(1)
        if not nearer.any():
            break
        u, v = np.where(nearer, next_u, u), np.where(nearer, next_v, v)
        off = np.where(nearer[:, None], there, off)
    return points + off, patch.normals(u, v)
