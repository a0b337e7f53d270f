"""Skins that hang between what they are held by: a membrane, a thin plate, or something between.

On a mesh with vertices p and umbrella operator L (Kobbelt et al., *Interactive multi-resolution
modeling on arbitrary meshes*, 1998), a membrane has the least sum of squared edges and a plate the
least sum of |L p|². Weights are uniform, so that vertices spread evenly as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.icosphere import edges_of, icosphere
from bozzetto.geometry.mesh_feet import Feet

if TYPE_CHECKING:
    from scipy.sparse import csc_array

__all__ = ["Stiffness", "drawn_to", "held_at"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Sparse = Any


@dataclass(frozen=True)
class Stiffness:
    """How a skin resists.

    Parameters
    ----------
    tension : float
        Of the membrane, per unit of a vertex's pull.
    bending : float
        Of the plate. Its ratio to the tension is the square of the number of edges over which
        the skin goes from one to the other.
    """

    tension: float
    bending: float


def drawn_to(
    level: int, feet: Feet, points: Array, weights: Array, stiffness: Stiffness
) -> Array:
    """The skin that is drawn to points by springs.

    Parameters
    ----------
    level : int
        Of the icosphere whose triangles the skin has.
    feet : Feet
        Where each spring takes hold.
    points : (n, 3) float
        Where it leads to.
    weights : (n,) float
        Its strength, above 0.
    stiffness : Stiffness

    Returns
    -------
    (v, 3) float
    """
    from scipy.sparse import csr_array

    count = len(icosphere(level).directions)
    row = np.repeat(np.arange(len(points)), 3)
    shape = (len(points), count)
    hold = csr_array((feet.weights.ravel(), (row, feet.corners.ravel())), shape)
    pulled = hold.multiply(weights[:, None]).tocsr().T
    return _solved((pulled @ hold) + _energy(level, stiffness), pulled @ points)


def held_at(level: int, held: Index, places: Array, stiffness: Stiffness) -> Array:
    """The skin that is held at some of its vertices.

    Parameters
    ----------
    level : int
    held : (k,) int
        Vertices, each once.
    places : (k, 3) float
        Where they are, exactly.
    stiffness : Stiffness

    Returns
    -------
    (v, 3) float
    """
    energy = _energy(level, stiffness)
    free = np.ones(energy.shape[0], bool)
    free[held] = False
    rows = energy[free]
    made = np.empty((len(free), 3))
    made[held] = places
    made[free] = _solved(rows[:, free], -(rows[:, held] @ places))
    return made


def _energy(level: int, stiffness: Stiffness) -> Sparse:
    membrane, plate = _operators(level)
    return stiffness.tension * membrane + stiffness.bending * plate


@lru_cache(maxsize=8)
def _operators(level: int) -> tuple[csc_array, csc_array]:
    """The quadratic forms of the membrane and the plate, (v, v) each."""
    from scipy.sparse import coo_array, diags_array

    sphere = icosphere(level)
    edges, count = edges_of(sphere.faces)[0], len(sphere.directions)
    ends = np.concatenate((edges, edges[:, ::-1])).T
    beside = coo_array((np.ones(len(ends[0])), tuple(ends)), (count, count)).tocsr()
    valence = np.asarray(beside.sum(axis=0))
    membrane = diags_array(valence) - beside
    umbrella = diags_array(1.0 / valence) @ membrane
    return membrane.tocsc(), (umbrella.T @ umbrella).tocsc()


def _solved(matrix: Sparse, right: Array) -> Array:
    """Solve a positive definite system: one factorisation, and a column for each axis."""
    from scipy.sparse.linalg import splu

    factors = splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return np.asarray(factors.solve(np.asarray(right)))
