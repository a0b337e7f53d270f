"""Rotations of many bodies at once."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array

SMALL: Final = 1e-6
"""Angle, rad, below which the first terms of the series are exact to all digits."""


def rotations_by(vectors: Array) -> Array:
    """Return rotations (n, 3, 3) about vectors (n, 3) by their lengths, rad (Rodrigues)."""
    squares = np.einsum("ni,ni->n", vectors, vectors)
    angles = np.sqrt(squares)
    safe = np.maximum(angles, SMALL)
    first = np.where(angles > SMALL, np.sin(safe) / safe, 1.0 - squares / 6.0)
    second = np.where(angles > SMALL, (1.0 - np.cos(safe)) / safe**2, 0.5 - squares / 24.0)
    made = np.einsum("ni,nj->nij", second[:, None] * vectors, vectors)
    flat = made.reshape(len(vectors), 9)
    flat[:, ::4] += (1.0 - second * squares)[:, None]
    turned = first[:, None] * vectors
    flat[:, [7, 2, 3]] += turned
    flat[:, [5, 6, 1]] -= turned
    return np.asarray(made)


def nearest_rotations(matrices: Array) -> Array:
    """Return matrices (n, 3, 3) that are almost rotations with the rounding of many steps removed.

    One step of Newton's method for the polar decomposition.
    """
    return np.asarray(1.5 * matrices - 0.5 * matrices @ np.swapaxes(matrices, 1, 2) @ matrices)
