"""Membranes and thin plates: fair surfaces between given points.

On a mesh with vertices p and umbrella operator L (Kobbelt et al., *Interactive multi-resolution
modeling on arbitrary meshes*, 1998), a membrane has the least sum of squared edges and a plate the
least sum of |L p|². Weights are uniform, so that vertices spread evenly as well.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from bozzetto.geometry.wrap.icosphere import icosphere

if TYPE_CHECKING:
    from scipy.sparse import csc_array

    from bozzetto.arrays import Array, Index
    from bozzetto.geometry.wrap.closest_on_icosphere import MeshPoints


Energy = Any
"""A sparse symmetric matrix, (v, v): half of the second derivative of an energy by the vertices,
the same for each coordinate."""

THINNEST: Final = 1e-3
"""Area of a triangle, per mean of all, from which on down it counts as one of that area."""

COTANGENTS: Final = (0.02, 5.0)
"""Least and greatest weight of an edge: obtuse triangles have weights below zero, with which a
membrane folds, and slivers have huge ones."""


def pull_towards(energy: Energy, feet: MeshPoints, points: Array, weights: Array) -> Array:
    """Return the surface that springs draw to points.

    Parameters
    ----------
    energy : Energy
        With which the skin resists.
    feet : MeshPoints
        Where each spring is attached.
    points : (n, 3) float
        Where it leads to.
    weights : (n,) float
        Its strength, above 0.

    Returns
    -------
    (v, 3) float
    """
    from scipy.sparse import csr_array, diags_array

    row = np.repeat(np.arange(len(points)), 3)
    shape = (len(points), energy.shape[0])
    hold = csr_array((feet.weights.ravel(), (row, feet.corners.ravel())), shape)
    pulled = hold.T @ diags_array(weights)
    return _solved((pulled @ hold) + energy, np.asarray(pulled @ points))


def hold_at(energy: Energy, held: Index, places: Array) -> Array:
    """Return the surface that is held at some of its vertices.

    Parameters
    ----------
    energy : Energy
        Resistance of the surface to stretching and bending.
    held : (k,) int
        Vertices, each once.
    places : (k, 3) float
        Where they are, exactly.

    Returns
    -------
    (v, 3) float
    """
    free = np.ones(energy.shape[0], bool)
    free[held] = False
    rows = energy[free]
    made = np.empty((len(free), 3))
    made[held] = places
    made[free] = _solved(rows[:, free], -(rows[:, held] @ places))
    return made


def even_energy(level: int, tension: float, bending: float) -> Energy:
    """Return the resistance of an icosphere whose edges all weigh the same: even vertices.

    Parameters
    ----------
    level : int
        How often the icosahedron is subdivided.
    tension : float
        Stiffness of the membrane, above 0.
    bending : float
        Stiffness of the plate. Its ratio to the tension is the square of the number of edges
        over which the skin bends.
    """
    membrane, plate = _operators(level)
    return tension * membrane + bending * plate


def true_energy(faces: Index, vertices: Array, length: float) -> Energy:
    """Return the resistance of a mesh as it lies in space, whatever its triangles are like.

    With the cotangent weights of Pinkall & Polthier (*Computing discrete minimal surfaces*,
    1993), each vertex having a third of the area round it, so that uneven steps along a curve do
    not show beside it.

    Parameters
    ----------
    faces : (f, 3) int
        Vertices of each triangle.
    vertices : (v, 3) float
        Places of the vertices, mm.
    length : float
        Over which the skin bends; 0 for a membrane.
    """
    from scipy.sparse import coo_array, diags_array

    count = len(vertices)
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)  # twice
    area = np.maximum(area, THINNEST * area.mean())
    rows, columns, values = [], [], []
    for k in range(3):
        p, q, r = (vertices[faces[:, (k + turn) % 3]] for turn in range(3))
        cotangent = 0.5 * np.einsum("ij,ij->i", q - p, r - p) / area
        rows += [faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]]
        columns += [faces[:, (k + 2) % 3], faces[:, (k + 1) % 3]]
        values += [cotangent, cotangent]
    beside = coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), (count, count)
    ).tocsr()
    beside.data = np.clip(beside.data, *COTANGENTS)
    membrane = diags_array(np.asarray(beside.sum(axis=0))) - beside
    mass = np.bincount(faces.ravel(), np.repeat(area, 3) / 6.0, count)
    return membrane + length**2 * (membrane @ diags_array(1.0 / mass) @ membrane)


@lru_cache(maxsize=8)
def _operators(level: int) -> tuple[csc_array, csc_array]:
    """Return the quadratic forms of the membrane and the plate, (v, v) each."""
    from scipy.sparse import coo_array, diags_array

    sphere = icosphere(level)
    count = len(sphere.directions)
    ends = np.concatenate((sphere.edges, sphere.edges[:, ::-1])).T
    beside = coo_array((np.ones(len(ends[0])), tuple(ends)), (count, count)).tocsr()
    valence = np.asarray(beside.sum(axis=0))
    membrane = diags_array(valence) - beside
    umbrella = diags_array(1.0 / valence) @ membrane
    return membrane.tocsc(), (umbrella.T @ umbrella).tocsc()


def _solved(matrix: Energy, right: Array) -> Array:
    """Solve a positive definite system: one factorisation, and a column for each axis."""
    from scipy.sparse.linalg import splu

    factors = splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return np.asarray(factors.solve(np.asarray(right)))
