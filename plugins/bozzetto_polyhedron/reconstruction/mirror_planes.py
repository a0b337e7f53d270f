"""How well planes through the middle of a shape mirror its corners, for many shapes at once."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto_polyhedron.reconstruction.lengths import dots, lengths_of

MOST: Final = 24
"""Most planes that are tried for one shape."""

CLASSES: Final = 6
"""Classes of lines, the first ones, between which planes are tried."""

SAME: Final = 0.99
"""Cosine from which two normals are one."""


def mirror_planes(corners: Array, normals: Array, scale: float) -> Array:
    """Return how well the best plane, and the two after it, map corners onto one another, (k, 2).

    Parameters
    ----------
    corners : (k, n, 3) array
        Of each shape.
    normals : (k, p, 3) array
        Unit normals of the planes that are tried; zeros where there is none. Those that nearly
        repeat an earlier one are left out.
    scale : float
        Distance at which a corner counts half as mirrored, root mean square sizes.
    """
    centred = corners - corners.mean(1, keepdims=True)
    size = np.sqrt(dots(centred, centred).mean(1))
    centred /= np.maximum(1e-12, size)[:, None, None]
    normals, tried = _distinct(normals)
    across = centred @ normals.transpose(0, 2, 1)
    squares = dots(centred, centred)
    # |c_i - 2 (c_i . n) n - c_j|^2, the same for i and j exchanged, without the images themselves
    own = centred @ centred.transpose(0, 2, 1)
    apart = squares[:, :, None] + squares[:, None] - 2.0 * own
    crossed = across.transpose(0, 2, 1)
    images = (4.0 * crossed)[..., None] * crossed[:, :, None]
    images += apart[:, None]
    nearest = images.min(2)
    fits = (1.0 / (1.0 + np.maximum(nearest, 0.0) / scale**2)).mean(2)
    fits = -np.sort(-np.where(tried, fits, 0.0), axis=1)[:, :3]
    fits = np.pad(fits, ((0, 0), (0, 3 - fits.shape[1])))
    further = fits[:, 1:].sum(1) / np.clip(tried.sum(1) - 1, 1, 2)
    return np.column_stack((fits[:, 0], further))


def mirror_normals(directions: Array, faces: Array) -> Array:
    """Return directions of classes and faces, and those halfway between two classes, (k, p, 3).

    Parameters
    ----------
    directions : (k, c, 3) array
        Unit vectors of the classes of each shape.
    faces : (k, f, 3) array
        Unit normals of its faces, zeros where it has none.
    """
    first, second = np.triu_indices(min(directions.shape[1], CLASSES), 1)
    one, other = directions[:, first], directions[:, second]
    normals = np.concatenate((directions, faces, one + other, one - other), axis=1)
    lengths = lengths_of(normals)
    return np.asarray(np.where(lengths > 1e-9, normals / np.maximum(lengths, 1e-9), 0.0))


def _distinct(normals: Array) -> tuple[Array, Flags]:
    """Return the first normals that do not nearly repeat an earlier one, and where there is one."""
    same = np.abs(normals @ normals.transpose(0, 2, 1)) >= SAME
    kept = np.zeros(normals.shape[:2], bool)
    there = (normals != 0.0).any(2)
    for number in range(normals.shape[1]):
        earlier = (same[:, number, :number] & kept[:, :number]).any(1)
        kept[:, number] = there[:, number] & ~earlier
    most = min(MOST, int(kept.sum(1).max(initial=0)))
    order = np.argsort(~kept, axis=1, kind="stable")[:, :most]
    rows = np.arange(len(normals))[:, None]
    return normals[rows, order], kept[rows, order]
