"""Closed meshes from grids: boxes with bent sides, and rings closed at both ends."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Mesh


def box_surface(cells: int) -> tuple[Array, Index]:
    """Return the surface of the cube from -1 to 1 as squares cut into triangles.

    Parameters
    ----------
    cells : int
        Squares along each edge.

    Returns
    -------
    points : (v, 3) float
    faces : (f, 3) int
        Counter-clockwise seen from outside.
    """
    steps = np.arange(cells)
    i, j = (part.ravel() for part in np.meshgrid(steps, steps, indexing="ij"))
    square = np.stack(
        [np.stack((i + a, j + b), axis=1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1
    )
    corners = []
    for axis in range(3):
        for level in (0, cells):
            grid = np.full((len(i), 4, 3), level)
            grid[..., (axis + 1) % 3] = square[..., 0]
            grid[..., (axis + 2) % 3] = square[..., 1]
            corners.append(grid if level else grid[:, ::-1])
    places, numbers = np.unique(np.concatenate(corners).reshape(-1, 3), axis=0, return_inverse=True)
    quads = numbers.reshape(-1, 4)
    return 2.0 * places / cells - 1.0, np.vstack((quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]))


def closed_rings(rings: Array, first: Array, last: Array) -> Mesh:
    """Return the closed surface through rings, with a tip at each end.

    Parameters
    ----------
    rings : (m, n, 3) float
        mm; n places on each of m rings, counter-clockwise seen from the last tip.
    first, last : (3,) float
        The tips, mm.

    Returns
    -------
    Mesh
    """
    count, around = rings.shape[:2]
    number = 1 + np.arange(count * around).reshape(count, around)
    ahead = np.roll(number, -1, axis=1)
    end = count * around + 1
    low, low_ahead, high, high_ahead = number[:-1], ahead[:-1], number[1:], ahead[1:]
    faces = [
        np.stack((np.zeros(around, int), ahead[0], number[0]), axis=1),
        np.stack((low, low_ahead, high_ahead), axis=2).reshape(-1, 3),
        np.stack((low, high_ahead, high), axis=2).reshape(-1, 3),
        np.stack((number[-1], ahead[-1], np.full(around, end)), axis=1),
    ]
    points = np.vstack((first[None], rings.reshape(-1, 3), last[None]))
    return mesh_of(points, np.vstack(faces))


def mesh_of(points: Array, faces: Index) -> Mesh:
    """Return a mesh of points (v, 3), mm, and faces (f, 3)."""
    return Mesh(points.astype(np.float32), faces.astype(np.int32))
