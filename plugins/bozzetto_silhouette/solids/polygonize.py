"""The surface of any implicit solid: marching cubes in a narrow band, then Newton.

The lattice is refined only where the surface can be: a block of cells is divided further as
long as a corner's value, which is about a distance, says that the surface may pass through
it. That holds for limbs that slip between the corners, too. What is left out has one sign and
is filled with it, so the surface is closed whatever the function does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Faces, Flags, Index
from bozzetto_silhouette.implicit.implicit_solid import Implicit, sample_each
from bozzetto_silhouette.inflation.closed_surface import vertex_normals
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


FAR = 1.5
"""Distance from the surface, in cells, from which on a node's value is taken from the corners of
the block of two cells around it: off by a cell at most, it has the right sign."""

_CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
_NODES = np.array([[i, j, k] for i in (0, 1, 2) for j in (0, 1, 2) for k in (0, 1, 2)])
_SHARES = (1.0 - 0.5 * np.abs(2 * _CORNERS[:, None] - _NODES)).prod(axis=2).astype(np.float32)


class Wanted(NamedTuple):
    """Solid that is to be polygonized; see `extract`."""

    implicit: Implicit
    bounds: Array
    step: float


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
    return extracted([Wanted(implicit, bounds, step)], checkpoint)[0]


def extracted(wanted: Sequence[Wanted], checkpoint: Checkpoint = ignore) -> list[Surface]:
    """Extract several surfaces as `extract` does, all of them step by step together.

    Small ones have a few thousand nodes each: of many, most of the time would go into the calls.
    """
    lattices = [_Lattice(*some) for some in wanted]
    nodes = np.cumsum([np.prod(lattice.shape) for lattice in lattices])
    surfaces: list[Surface] = []
    while len(surfaces) < len(lattices):
        first = len(surfaces)
        before = int(nodes[first - 1]) if first else 0
        last = int(np.searchsorted(nodes, before + MOST_NODES, side="right"))
        surfaces += _together(lattices[first : max(last, first + 1)], checkpoint)
    return surfaces


def _together(lattices: list[_Lattice], checkpoint: Checkpoint) -> list[Surface]:
    """Extract surfaces whose lattices are kept at the same time."""
    size = BLOCK
    while size:
        places = [lattice.asked(size) for lattice in lattices]
        ends = np.cumsum([0, *map(len, places)])
        solids = [lattice.implicit for lattice in lattices]
        values = np.empty(ends[-1])
        every = np.concatenate(places)
        for part, some, own in _chunks(solids, ends):
            checkpoint(0.5, "surface")
            if len(some) == 1:
                values[part] = some[0].value(every[part])
            else:
                values[part] = sample_each(some, every[part], own).value
        for lattice, found in zip(lattices, np.split(values, ends[1:-1]), strict=True):
            lattice.take(found, size)
        size //= 2
    return _polished(lattices, [lattice.cut() for lattice in lattices], checkpoint)


def _chunks(
    solids: Sequence[Implicit], ends: Index
) -> Iterator[tuple[slice, Sequence[Implicit], Index]]:
    """Cut a row of places, those of each solid in turn, into chunks.

    With each come the solids that have places in it, and where those of each end there.
    """
    for low in range(0, int(ends[-1]), CHUNK):
        high = min(low + CHUNK, int(ends[-1]))
        first = int(np.searchsorted(ends, low, side="right")) - 1
        last = int(np.searchsorted(ends, high, side="left"))
        yield slice(low, high), solids[first:last], np.clip(ends[first : last + 1], low, high) - low


class _Cut(NamedTuple):
    """Mesh by marching cubes of a lattice; `border` (v,) marks vertices at its border."""

    vertices: Array
    faces: Faces
    border: Flags


class _Lattice:
    """The nodes around one solid, refined block by block; parameters are those of `extract`."""

    def __init__(self, implicit: Implicit, bounds: Array, step: float) -> None:
        low, high = bounds
        extent = np.maximum(high - low, step)
        self.implicit = implicit
        self.step = max(step, float((np.prod(extent) / MOST_NODES) ** (1.0 / 3.0)))
        blocks = np.ceil((extent / self.step + 2.0) / BLOCK).astype(np.int64)
        self.origin = 0.5 * (low + high) - 0.5 * self.step * BLOCK * blocks
        self.shape: tuple[int, ...] = tuple((BLOCK * blocks + 1).tolist())
        self._active = BLOCK * np.argwhere(np.ones(blocks, bool))
        self._filled: list[tuple[int, Nodes, NDArray[np.float32]]] = []
        self._values = np.zeros(0, np.float32)

    def asked(self, size: int) -> Array:
        """Return the corners (n, 3) of blocks of a size where the surface may be, not yet known."""
        if not len(self._values):
            self._values = np.full(int(np.prod(self.shape)), np.nan, np.float32)
        self._key = (self._active[:, None, :] + size * _CORNERS) @ self._strides
        wanted = np.zeros(len(self._values), bool)
        wanted[self._key] = True
        self._asked = np.flatnonzero(wanted & np.isnan(self._values))
        place = np.stack(np.unravel_index(self._asked, self.shape), axis=1)
        return np.asarray(self.origin + self.step * place)

    def take(self, values: Array, size: int) -> None:
        """Take the values that were asked for, and divide the blocks where the surface may be."""
        self._values[self._asked] = values / self.step
        if size == 1:
            return
        value = self._values[self._key]
        away = np.abs(value)
        near = away.min(axis=1) <= NEAREST_CORNER * size
        near &= away.mean(axis=1) <= MEAN_CORNER * size
        near |= (value.min(axis=1) < 0.0) != (value.max(axis=1) < 0.0)
        self._filled.append((size, self._active[~near], value[~near, 0]))
        if size == 2:
            nodes = (self._active[near][:, None, :] + _NODES) @ self._strides
            between = value[near] @ _SHARES
            fill = (np.abs(between) > FAR) & np.isnan(self._values[nodes])
            self._values[nodes[fill]] = between[fill]
        half = size // 2
        self._active = (self._active[near][:, None, :] + half * _CORNERS).reshape(-1, 3)

    def cut(self) -> _Cut:
        """Return the surface by marching cubes; the values are gone then."""
        from skimage.measure import marching_cubes

        grid = self._closed()
        self._values = np.zeros(0, np.float32)
        if not (grid > 0.0).any():
            return _Cut(np.zeros((0, 3)), np.zeros((0, 3), np.int32), np.zeros(0, bool))
        places, faces, _, _ = marching_cubes(grid, 0.0, gradient_direction="ascent")
        last = np.array(grid.shape) - 2.0
        border = (places <= 1.0).any(axis=1) | (places >= last).any(axis=1)
        vertices = self.origin + self.step * places.astype(np.float64)
        return _Cut(vertices, faces.astype(np.int32), border)

    @property
    def _strides(self) -> Nodes:
        return np.array([self.shape[1] * self.shape[2], self.shape[2], 1])

    def _closed(self) -> NDArray[np.float32]:
        """Return the values at all nodes: of one sign where none is known, outside at the end."""
        grid = self._values.reshape(self.shape)
        evaluated = ~np.isnan(grid)
        known = grid[evaluated]
        for edge, first, sign in self._filled:
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


def _polished(lattices: list[_Lattice], cuts: list[_Cut], checkpoint: Checkpoint) -> list[Surface]:
    """Move vertices onto the zero surfaces, except those at the borders; find normals, too."""
    ends = np.cumsum([0, *(len(cut.vertices) for cut in cuts)])
    vertices = np.concatenate([cut.vertices for cut in cuts])
    border = np.concatenate([cut.border for cut in cuts])
    longest = LONGEST_MOVE * np.repeat([lattice.step for lattice in lattices], np.diff(ends))
    solids = [lattice.implicit for lattice in lattices]
    gradient = np.zeros_like(vertices)
    for turn in range(NEWTON_ROUNDS + 1):
        for part, some, own in _chunks(solids, ends):
            checkpoint(0.7, "surface")
            found = sample_each(some, vertices[part], own)
            gradient[part] = found.gradient
            if turn < NEWTON_ROUNDS:
                slope2 = np.maximum((gradient[part] ** 2).sum(axis=1), 1e-12)
                move = -(found.value / slope2)[:, None] * gradient[part]
                length = np.sqrt((move**2).sum(axis=1))
                move *= np.minimum(1.0, longest[part] / np.maximum(length, 1e-300))[:, None]
                vertices[part] += np.where(border[part, None], 0.0, move)
    length = np.sqrt((gradient**2).sum(axis=1))
    normals = -gradient / np.maximum(length, 1e-300)[:, None]
    surfaces = []
    for cut, low, high in zip(cuts, ends[:-1], ends[1:], strict=True):
        places, normal = vertices[low:high], normals[low:high]
        facing = vertex_normals(places, cut.faces)
        # Where the function has no slope, or the border cuts it, the faces know better.
        astray = cut.border | (length[low:high] < 1e-6) | ((normal * facing).sum(axis=1) < 0.0)
        normal[astray] = facing[astray]
        surfaces.append(Surface(places, cut.faces, normal))
    return surfaces
