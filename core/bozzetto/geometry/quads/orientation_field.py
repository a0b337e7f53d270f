"""A direction at each vertex, alike in four turns of 90°, along the bends of a surface.

Of all such fields the smoothest one is sought that follows principal directions, the more the more
they differ: a sparse linear system (Knöppel, Crane, Pinkall, Schröder 2013, *Globally optimal
direction fields*, sections 3 and 6). A direction of angle θ in a vertex's frame is the complex
number exp(4iθ) there, so that a quarter turn changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto.geometry.quads.surface import Edges, Features, across, units

Complex = NDArray[np.complex128]

FOLLOWS: Final = 0.5
"""How much bends count against smoothness: both are without a unit."""

FEATURE: Final = 30.0
"""How much a feature edge counts beside the edges around its vertex."""

SMOOTHED: Final = 4
"""Rounds in which bends are averaged with those of neighbours: triangles are rough."""

FLOOR: Final = 1e-9
"""Added to the diagonal, so that the system has one solution."""


@dataclass(frozen=True, eq=False)
class Frames:
    """Axes at vertices, and how those of neighbours lie to one another.

    Attributes
    ----------
    normal, first, second : (n, 3) float
        Orthonormal, right-handed.
    turn : (e,) float
        For each edge the angle of the first vertex's first axis in the second's frame, carried
        over by the least turn between their normals.
    weight : (e,) float
        Cotangent weight of each edge, between `WEIGHTS`.
    """

    normal: Array
    first: Array
    second: Array
    turn: Array
    weight: Array


WEIGHTS: Final = (0.1, 4.0)
"""Least and largest weight of an edge: slivers have cotangents of any size."""


def frames_of(points: Array, faces: Index, edges: Edges) -> Frames:
    """Return axes at the vertices of a surface."""
    large = across(points, faces)
    normal = np.zeros_like(points)
    corners = points[faces]
    cotangents = np.empty(faces.shape)
    for k in range(3):
        one = corners[:, (k + 1) % 3] - corners[:, k]
        other = corners[:, (k + 2) % 3] - corners[:, k]
        inner = np.einsum("ij,ij->i", one, other)
        outer = np.linalg.norm(large, axis=1)
        angle = np.arctan2(outer, inner)
        cotangents[:, (k + 1) % 3] = inner / np.where(outer > 0.0, outer, 1.0)
        for axis in range(3):
            normal[:, axis] += np.bincount(faces[:, k], angle * units(large)[:, axis], len(points))
    normal = units(normal)
    lost = (normal == 0).all(axis=1)
    normal[lost] = (0.0, 0.0, 1.0)
    weight = np.bincount(edges.of_side.ravel(), 0.5 * cotangents.ravel(), len(edges.ends))
    # The first axis goes towards a neighbour.
    beside = np.zeros(len(points), np.intp)
    beside[edges.ends[::-1, 1]] = edges.ends[::-1, 0]
    beside[edges.ends[::-1, 0]] = edges.ends[::-1, 1]
    first = points[beside] - points
    first = units(first - normal * np.einsum("ij,ij->i", first, normal)[:, None])
    lost = (first == 0).all(axis=1)
    if lost.any():
        axis = np.eye(3)[np.abs(normal[lost]).argmin(axis=1)]
        first[lost] = units(np.cross(normal[lost], axis))
    second = np.cross(normal, first)
    i, j = edges.ends.T
    between = normal[i] + normal[j]
    share = np.einsum("ij,ij->i", first[i], normal[j]) / np.maximum(
        1.0 + np.einsum("ij,ij->i", normal[i], normal[j]), 1e-6
    )
    carried = first[i] - share[:, None] * between
    turn = np.arctan2(
        np.einsum("ij,ij->i", carried, second[j]), np.einsum("ij,ij->i", carried, first[j])
    )
    return Frames(normal, first, second, turn, np.clip(weight, *WEIGHTS))


def orientations(
    points: Array, faces: Index, edges: Edges, features: Features, frames: Frames
) -> Array:
    """Return the angle of a direction in the frame of each vertex, (n,)."""
    from scipy.sparse import coo_array, csc_array, diags_array
    from scipy.sparse.linalg import splu

    count = len(points)
    i, j = edges.ends.T
    carry = np.exp(4j * frames.turn)
    weight = frames.weight
    wanted, strength = _bends(points, faces, edges, frames)
    on_line = features.line & ~features.corner
    angle = np.arctan2(
        np.einsum("ij,ij->i", features.along, frames.second),
        np.einsum("ij,ij->i", features.along, frames.first),
    )
    wanted[on_line] = np.exp(4j * angle[on_line])
    strength[on_line] = FEATURE
    strength[features.corner] = 0.0
    rows = np.concatenate((i, j, i, j))
    columns = np.concatenate((i, j, j, i))
    values = np.concatenate((weight, weight, -weight * carry.conj(), -weight * carry))
    smooth = coo_array((values, (rows, columns)), shape=(count, count))
    matrix = csc_array(smooth + diags_array(strength + FLOOR))
    solved: Any = splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    found = solved.solve((strength + FLOOR) * wanted)
    return np.asarray(np.angle(found) / 4.0)


def _bends(points: Array, faces: Index, edges: Edges, frames: Frames) -> tuple[Complex, Array]:
    """Return principal directions (n,) as complex numbers, and how much they count.

    Cohen-Steiner and Morvan 2003, *Restricted Delaunay triangulations and normal cycle*: each edge
    bends the surface by its angle, across itself.
    """
    from scipy.sparse import csr_array

    count = len(points)
    large = across(points, faces)
    normal, area = units(large), 0.5 * np.linalg.norm(large, axis=1)
    inner = np.flatnonzero(edges.faces[:, 1] >= 0)
    one, other = edges.faces[inner].T
    ends = edges.ends[inner]
    along = points[ends[:, 1]] - points[ends[:, 0]]
    length = np.linalg.norm(along, axis=1)
    # Each triangle has the edge in a direction of its own: a sign for all is enough, as it cancels.
    side = np.einsum("ij,ij->i", np.cross(normal[one], normal[other]), along)
    angle = np.arctan2(
        np.linalg.norm(np.cross(normal[one], normal[other]), axis=1),
        np.einsum("ij,ij->i", normal[one], normal[other]),
    ) * np.sign(side)
    forth = np.take_along_axis(
        faces[one], (edges.of_side[one] == inner[:, None]).argmax(axis=1)[:, None], axis=1
    )[:, 0]
    angle = np.where(forth == ends[:, 0], angle, -angle)
    size = angle / np.where(length > 0.0, length, 1.0)
    tensor = np.zeros((count, 6))
    for place, (a, b) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        own = size * along[:, a] * along[:, b]
        tensor[:, place] = np.bincount(ends.ravel(), np.repeat(0.5 * own, 2), count)
    share = np.bincount(faces.ravel(), np.repeat(area / 3.0, 3), count)
    i, j = edges.ends.T
    ones = np.ones(2 * len(i) + count)
    every = np.arange(count)
    mixing: Any = csr_array(
        (ones, (np.concatenate((i, j, every)), np.concatenate((j, i, every)))), (count, count)
    )
    own_share = share.copy()
    for _ in range(SMOOTHED):
        tensor, share = mixing @ tensor, mixing @ share
    tensor /= np.where(share > 0.0, share, 1.0)[:, None]
    full = tensor[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3)
    a = np.einsum("ni,nij,nj->n", frames.first, full, frames.first)
    b = np.einsum("ni,nij,nj->n", frames.first, full, frames.second)
    c = np.einsum("ni,nij,nj->n", frames.second, full, frames.second)
    double = 0.5 * (a - c) + 1j * b
    size = np.abs(double)
    wanted = np.where(size > 0.0, double / np.where(size > 0.0, size, 1.0), 1.0) ** 2
    return wanted, FOLLOWS * own_share * (2.0 * size) ** 2
