"""Vertices and the means of their neighbours, in which smoothing and membranes are told."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array, Index

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


def edges_of(faces: Index) -> Index:
    """Return the edges of triangles, each once, (k, 2)."""
    sides = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    return np.unique(np.sort(sides, axis=1), axis=0)


def neighbour_means(faces: Index, count: int) -> csr_matrix:
    """Return the matrix that takes values at vertices to the means over their neighbours."""
    from scipy.sparse import csr_matrix

    ends, others = np.concatenate((edges := edges_of(faces), edges[:, ::-1])).T
    degree = np.bincount(ends, minlength=count)
    return csr_matrix((1.0 / degree[ends], (ends, others)), shape=(count, count))


def held_back(means: csr_matrix, border: int) -> Callable[[Array], Array]:
    """Return how inner vertices answer to what moves them, while the first ones, the border, stay.

    With M the matrix of means it solves ``d - M d = load`` for displacements d, factored once.
    """
    from scipy.sparse import csc_matrix, identity
    from scipy.sparse.linalg import splu

    inner = means[border:, border:]
    factor = splu(csc_matrix(identity(inner.shape[0]) - inner))
    return lambda load: np.asarray(factor.solve(load))


def carried_inward(faces: Index, shifts: Array, count: int) -> Array:
    """Return displacements of all vertices that are the means of their neighbours', (n, 3).

    Parameters
    ----------
    faces : (m, 3) int
        Counter-clockwise.
    shifts : (b, 3) float
        Of the border, which comes first.
    count : int
        Of all vertices.
    """
    means = neighbour_means(faces, count)
    border = len(shifts)
    inner = held_back(means, border)(np.asarray(means[border:, :border] @ shifts))
    return np.concatenate((shifts, inner))
