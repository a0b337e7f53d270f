"""The surface of any implicit solid: marching cubes in a narrow band, then Newton.

The lattice is refined only where the surface can be: a block of cells is divided further as
long as a corner's value, which is about a distance, says that the surface may pass through
it. That holds for limbs that slip between the corners, too. What is left out has one sign and
is filled with it, so the surface is closed whatever the function does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Faces, Flags
from bozzetto_silhouette.implicit.implicit_solid import Implicit
from bozzetto_silhouette.inflation.sewing import vertex_normals
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore

Nodes = NDArray[np.int64]

BLOCK = 16
"""Cells along the edge of the largest blocks. Larger ones save nothing more."""

SLACK = 1.15
"""Tolerance for values that are not exactly distances."""

NEAREST_CORNER = 0.866 * SLACK
"""Farthest that a place in a block can be from the nearest corner, in edges of the block."""

MEAN_CORNER = 1.122 * SLACK
"""The same for the mean of the distances from all eight corners, greatest at a corner."""

MOST_NODES = 12_000_000
"""Nodes of the whole lattice: 48 MB. Beyond it the step is made coarser."""

CHUNK = 16_384
"""Points evaluated between two checkpoints."""

NEWTON_ROUNDS = 1
"""It brings a vertex from a few hundredths of a cell to 1e-4: nobody sees more."""

LONGEST_MOVE = 0.5
"""Of one Newton step, in cells: a vertex must not overtake its neighbour."""

AWAY = 1e-4
"""Smallest value of a node, in cells. Marching cubes makes triangles without area where a
node lies on the surface."""


class Surface(NamedTuple):
    """A closed triangle mesh with normals.

    Attributes
    ----------
    vertices : (v, 3) float64 array
    faces : (f, 3) int32 array
        Oriented outwards; none where nothing is inside.
    normals : (v, 3) float64 array
        Unit, outwards.
    """

    vertices: Array
    faces: Faces
    normals: Array


def extract(
    implicit: Implicit, bounds: Array, step: float, checkpoint: Checkpoint = ignore
) -> Surface:
    """Extract the zero surface of an implicit solid inside a box, closed at the box's border.

    Parameters
    ----------
    implicit : Implicit
        The solid.
    bounds : (2, 3) float array
        The box. The lattice is a cell wider on every side; what sticks out is cut off.
    step : float
        Edge of a cell. Limbs thinner than two steps may be lost.
    checkpoint : callable
        Called between chunks of work; may raise `Cancelled`.

    Returns
    -------
    Surface
    """
    low, high = bounds
    extent = np.maximum(high - low, step)
    step = max(step, float((np.prod(extent) / MOST_NODES) ** (1.0 / 3.0)))
    blocks = np.ceil((extent / step + 2.0) / BLOCK).astype(np.int64)
    origin = 0.5 * (low + high) - 0.5 * step * BLOCK * blocks
    lattice = _narrow_band(implicit, origin, step, blocks, checkpoint)
    if not (lattice > 0.0).any():
        return Surface(np.zeros((0, 3)), np.zeros((0, 3), np.int32), np.zeros((0, 3)))
    from skimage.measure import marching_cubes

    places, faces, _, _ = marching_cubes(lattice, 0.0, gradient_direction="ascent")
    vertices = origin + step * places.astype(np.float64)
    faces = faces.astype(np.int32)
    border = (places <= 1.0).any(axis=1) | (places >= np.array(lattice.shape) - 2.0).any(axis=1)
    vertices, normals = _polished(implicit, vertices, faces, step, border, checkpoint)
    return Surface(vertices, faces, normals)


def _narrow_band(
    implicit: Implicit, origin: Array, step: float, blocks: Nodes, checkpoint: Checkpoint
) -> NDArray[np.float32]:
    """Return values in cells at the nodes: exact near the surface, negative at the border."""
    shape = BLOCK * blocks + 1
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    lattice = np.full(int(np.prod(shape)), np.nan, np.float32)
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    active = BLOCK * np.argwhere(np.ones(blocks, bool))
    filled: list[tuple[int, Nodes, NDArray[np.float32]]] = []
    size = BLOCK
    while True:
        key = (active[:, None, :] + size * corners) @ strides
        wanted = np.zeros(len(lattice), bool)
        wanted[key] = True
        asked = np.flatnonzero(wanted & np.isnan(lattice))
        place = np.stack(np.unravel_index(asked, shape), axis=1)
        lattice[asked] = _evaluated(implicit, origin + step * place, checkpoint) / step
        if size == 1:
            break
        value = lattice[key]
        away = np.abs(value)
        near = away.min(axis=1) <= NEAREST_CORNER * size
        near &= away.mean(axis=1) <= MEAN_CORNER * size
        near |= (value.min(axis=1) < 0.0) != (value.max(axis=1) < 0.0)
        filled.append((size, active[~near], value[~near, 0]))
        size //= 2
        active = (active[near][:, None, :] + size * corners).reshape(-1, 3)
    grid = lattice.reshape(shape)
    evaluated = ~np.isnan(grid)
    known = grid[evaluated]
    for edge, first, sign in filled:
        inside = first[sign > 0.0]
        spread = np.arange(edge + 1)
        i, j, k = (inside[:, axis, None] + spread for axis in range(3))
        grid[i[:, :, None, None], j[:, None, :, None], k[:, None, None, :]] = 1.0
    grid[np.isnan(grid)] = -1.0
    grid[evaluated] = np.where(np.abs(known) < AWAY, np.copysign(AWAY, known), known)
    for axis in range(3):
        for side in (0, -1):
            face = np.moveaxis(grid, axis, 0)[side]
            np.minimum(face, -AWAY, out=face)
    return grid


def _evaluated(implicit: Implicit, points: Array, checkpoint: Checkpoint) -> Array:
    values = np.empty(len(points))
    for first in range(0, len(points), CHUNK):
        checkpoint(0.5, "surface")
        part = slice(first, first + CHUNK)
        values[part] = implicit.value(points[part])
    return values


def _polished(
    implicit: Implicit,
    vertices: Array,
    faces: Faces,
    step: float,
    border: Flags,
    checkpoint: Checkpoint,
) -> tuple[Array, Array]:
    """Move vertices onto the zero surface, except those on the border; return normals, too."""
    gradient = np.zeros_like(vertices)
    for turn in range(NEWTON_ROUNDS + 1):
        for first in range(0, len(vertices), CHUNK):
            checkpoint(0.7, "surface")
            part = slice(first, first + CHUNK)
            found = implicit.sample(vertices[part])
            gradient[part] = found.gradient
            if turn < NEWTON_ROUNDS:
                slope2 = np.maximum((gradient[part] ** 2).sum(axis=1), 1e-12)
                move = -(found.value / slope2)[:, None] * gradient[part]
                length = np.sqrt((move**2).sum(axis=1))
                move *= np.minimum(1.0, LONGEST_MOVE * step / np.maximum(length, 1e-300))[:, None]
                vertices[part] += np.where(border[part, None], 0.0, move)
    length = np.sqrt((gradient**2).sum(axis=1))
    normals = -gradient / np.maximum(length, 1e-300)[:, None]
    facing = vertex_normals(vertices, faces)
    # Where the function has no slope, or the border cuts it, the faces know better.
    astray = border | (length < 1e-6) | ((normals * facing).sum(axis=1) < 0.0)
    normals[astray] = facing[astray]
    return vertices, normals
