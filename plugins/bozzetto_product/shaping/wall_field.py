"""The offset of a closed body by its field of distances, where slabs would run into themselves.

Where a wall is thicker than the least radius of a hollow, or two walls grow together, the offset is
where the distance from the body is as asked: marching cubes on a grid of distances find it, on the
inside or the outside. The band about the surface parts both sides, so that no sign is needed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto.geometry import Mesh

CELLS_PER_WALL: Final = 3.0
"""Cells of the grid over the thickness of a wall, where the grid is not too large."""

MOST_CELLS: Final = 1_000_000
"""Cells of a grid at most."""

SAMPLES_PER_WALL: Final = 4.0
"""Places on the surface over a length of the thickness, from which distances are measured."""

MOST_SAMPLES: Final = 400_000
"""Places on the surface at most."""


BAND: Final = 2.2
"""Cells on either side of the offset in which distances are exact: a cell's diagonal, and what a
grid of filled cells is off."""


def places_on(mesh: Mesh, spacing: float) -> Array:
    """Return places of a mesh so dense that every other one is within about the spacing."""
    corners = mesh.vertices.astype(float)[mesh.faces]
    edges = corners - np.roll(corners, 1, axis=1)
    area = 0.5 * np.linalg.norm(cross_product(edges[:, 0], edges[:, 1]), axis=1)
    spacing = max(spacing, float(np.sqrt(area.sum() / MOST_SAMPLES)))
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    steps = np.maximum(np.ceil(longest / spacing), 1.0).astype(int)
    made = [mesh.vertices.astype(float)]
    for step in np.unique(steps):
        own = corners[steps == step]
        i, j = np.indices((step + 1, step + 1)).reshape(2, -1)
        inside = i + j <= step
        weights = np.column_stack((i, j, step - i - j))[inside] / step
        made.append((weights @ own).reshape(-1, 3))
    return np.concatenate(made)


def offset_by_field(
    mesh: Mesh, thickness: float, outward: bool, checkpoint: Callable[[], None]
) -> tuple[Array, Index]:
    """Return the surface at a distance inside or outside of a closed mesh.

    Parameters
    ----------
    mesh : Mesh
        Closed.
    thickness : float
        mm, positive.
    outward : bool
        Whether the outside is meant.
    checkpoint : callable
        Called between the steps.

    Returns
    -------
    vertices : (n, 3) float
        mm; none where nothing is so far inside.
    faces : (m, 3) int
        Looking away from the mesh's inside.
    """
    from scipy.ndimage import label
    from skimage.measure import marching_cubes

    low, high = mesh.bounds.astype(float)
    cell = max(
        thickness / CELLS_PER_WALL,
        float((np.prod(high - low + 4.0 * thickness) / MOST_CELLS) ** (1 / 3)),
    )
    low = low - 2.0 * thickness - 2.0 * cell
    counts = np.ceil((high - low + 2.0 * thickness) / cell).astype(int) + 3
    places = places_on(mesh, min(thickness / SAMPLES_PER_WALL, 0.5 * cell))
    checkpoint()
    field = _distances(places, low, counts, cell, thickness)
    checkpoint()
    regions, _ = label(field > thickness)
    outside = regions == regions[0, 0, 0]
    wanted = outside if outward else (regions > 0) & ~outside
    if not wanted.any():
        return np.empty((0, 3)), np.empty((0, 3), np.intp)
    other = (regions > 0) & ~wanted
    field[other] = 2.0 * thickness - field[other]
    vertices, faces, _, _ = marching_cubes(field, thickness)
    vertices = low + cell * vertices.astype(float)
    corners = vertices[faces]
    volume = np.einsum("ij,ij->", corners[:, 0], cross_product(corners[:, 1], corners[:, 2]))
    return vertices, faces.astype(np.intp)[:, :: 1 if volume > 0.0 else -1]


def _distances(places: Array, low: Array, counts: Index, cell: float, near: float) -> Array:
    """Return distances from places on a grid: exact about one distance, else to a cell or so."""
    from scipy.ndimage import distance_transform_edt
    from scipy.spatial import cKDTree

    empty = np.ones(counts, bool)
    empty[tuple(np.round((places - low) / cell).astype(int).T)] = False
    field = np.asarray(distance_transform_edt(empty, sampling=cell))
    about = np.abs(field - near) <= BAND * cell
    tree = cKDTree(places, balanced_tree=False)
    field[about] = tree.query(low + cell * np.argwhere(about))[0]
    return field
