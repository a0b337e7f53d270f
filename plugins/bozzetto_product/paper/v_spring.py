"""The V-spring (Kara & Shimada, book chapter, section 13.2.3.2; Yamada et al. 1999).

A spring stands on each vertex along its normal, as long as the surface is bent there. Neighbours
move along their normals until the tips of their springs meet: on a common sphere. The displacement
of vertex i due to vertex j is

    (v_j − v_i) · (n_i + n_j) / (1 + n_i · n_j)  along n_i.

The chapter prints the factor 1 / |v_j − v_i| before it, which taken by the letter is no length.
Here it is what weights the mean over the neighbours, so a surface in inches moves as one in mm.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto_product.paper.neighbours import edges_of

STEP: Final = 0.5
"""Share of the displacement along the normal that is gone in one iteration."""

TANGENTIAL: Final = 0.3
"""Share of the way to the mean of the neighbours, within the tangent plane, likewise."""

REST: Final = 1e-3
"""Greatest displacement of one iteration, in mean lengths of edges, at which all are at rest."""

ITERATIONS: Final = 300
"""Most iterations: long waves go slowly, and a cap of any sphere over a circle is at rest, so
there is no end to wait for."""

LEAST_SUM: Final = 0.1
"""Least value of 1 + n_i · n_j: normals that are opposite tell no sphere."""


@dataclass(frozen=True, eq=False)
class Relaxed:
    """Vertices after the V-spring.

    Parameters
    ----------
    points : (n, 3) float
        mm.
    iterations : int
    at_rest : bool
        False where the last iteration still moved a vertex.
    """

    points: Array
    iterations: int
    at_rest: bool


def vertex_normals(points: Array, faces: Index) -> Array:
    """Return unit normals of vertices: the mean over their triangles by area, (n, 3)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    across = cross_product(b - a, c - a)
    rows = faces.ravel()
    sums = [np.bincount(rows, np.repeat(across[:, k], 3), len(points)) for k in range(3)]
    made = np.column_stack(sums)
    return np.asarray(made / np.maximum(np.linalg.norm(made, axis=1), 1e-300)[:, None])


def relaxed(
    points: Array,
    faces: Index,
    freedom: Array,
    *,
    checkpoint: Callable[[], None] = lambda: None,
) -> Relaxed:
    """Move vertices by the V-spring until they rest.

    Parameters
    ----------
    points : (n, 3) float
        mm.
    faces : (m, 3) int
        Counter-clockwise.
    freedom : (n,) float
        Share of each displacement that a vertex takes: 0 holds it, 1 lets it go.
    checkpoint : callable
        Called now and then.
    """
    edges = edges_of(faces)
    ends, others = np.concatenate((edges, edges[:, ::-1])).T
    kept = freedom[ends] > 0.0
    ends, others = ends[kept], others[kept]
    count = len(points)
    degree = np.maximum(np.bincount(ends, minlength=count), 1)[:, None]
    rest = REST * float(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1).mean())
    free = freedom[:, None]
    for iteration in range(ITERATIONS):
        if iteration % 20 == 0:
            checkpoint()
        normals = vertex_normals(points, faces)
        move = free * _displacements(points, normals, ends, others, degree)
        points = points + move
        if not float(np.abs(move).max(initial=0.0)) > rest:
            return Relaxed(points, iteration + 1, True)
    return Relaxed(points, ITERATIONS, False)


def _displacements(
    points: Array, normals: Array, ends: Index, others: Index, degree: Array
) -> Array:
    """Return the displacement of each vertex: along its normal, and evenly in its plane, (n, 3)."""
    count = len(points)
    ways = points[others] - points[ends]
    here, there = normals[ends], normals[others]
    inverse = 1.0 / np.maximum(np.linalg.norm(ways, axis=1), 1e-300)
    heights = np.einsum("ij,ij->i", ways, here + there)
    heights /= np.maximum(1.0 + np.einsum("ij,ij->i", here, there), LEAST_SUM)
    whole = np.bincount(ends, inverse, count)
    height = np.bincount(ends, inverse * heights, count) / np.where(whole > 0.0, whole, 1.0)
    mean = np.column_stack([np.bincount(ends, ways[:, k], count) for k in range(3)]) / degree
    mean -= np.einsum("ij,ij->i", mean, normals)[:, None] * normals
    return np.asarray(STEP * height[:, None] * normals + TANGENTIAL * mean)
