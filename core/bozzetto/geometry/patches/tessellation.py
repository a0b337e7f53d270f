"""Triangles for patchworks: for the eye while a hand draws, and for files that hold meshes only."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index, frozen
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.patches.coons import edge_numbers
from bozzetto.geometry.patches.patch import bernstein, grid, grid_normals

if TYPE_CHECKING:
    from bozzetto.geometry.patches.patchwork import Patchwork

TOLERANCE: Final = 1e-4
"""Usual distance of triangles from the surface, per diagonal of what is shown: half a millimetre
on a car, a hair on its model."""

MOST_DIVISIONS: Final = 256
"""Most steps along an edge, whatever the tolerance asks for."""


def tessellated(patchwork: Patchwork, tolerance: float | None = None) -> Mesh:
    """Triangulate within a distance of the surface, closed wherever patches share an edge.

    Patches on both sides of an edge share its vertices. So opposite sides of a patch have
    the same number of steps, and with them whole strips of patches.

    Parameters
    ----------
    patchwork : Patchwork
        The patches.
    tolerance : float, optional
        mm, above 0; by default `TOLERANCE` of the size. Kept unless an edge would need more
        than `MOST_DIVISIONS` steps.

    Returns
    -------
    Mesh
        Without normals, so that vertices on creases are shared as well.
    """
    return counted_patches(patchwork, tolerance)[0]


def counted_patches(
    patchwork: Patchwork, tolerance: float | None = None
) -> tuple[Mesh, tuple[int, ...]]:
    """Triangulate as `tessellated`, and count the triangles of each patch, patch by patch."""
    nodes, ends = patchwork.nodes
    if tolerance is None:
        size = float(np.linalg.norm(np.ptp(patchwork.nets, axis=(0, 1, 2))))
        tolerance = TOLERANCE * size or TOLERANCE
    steps = _divisions(patchwork, tolerance)
    places: list[Array] = [nodes]
    count = len(nodes)
    on_edge: list[Index] = []
    for edge, (start, end), number in zip(patchwork.edges, ends, steps, strict=True):
        between = bernstein(np.arange(1, number) / number) @ edge
        inner = count + np.arange(len(between))
        on_edge.append(np.concatenate(([start], inner, [end])))
        places.append(between)
        count += len(between)
    faces: list[Index] = []
    for net, row in zip(patchwork.nets, patchwork.sides.tolist(), strict=True):
        sides = [on_edge[side] if side >= 0 else on_edge[~side][::-1] for side in row]
        across, along = len(sides[0]) - 1, len(sides[1]) - 1
        u, v = np.arange(1, across) / across, np.arange(1, along) / along
        inside = grid(net, u, v).reshape(-1, 3)
        at = np.empty((across + 1, along + 1), np.intp)
        at[:, 0], at[-1], at[::-1, -1], at[0, ::-1] = sides
        at[1:-1, 1:-1] = count + np.arange(len(inside)).reshape(across - 1, along - 1)
        count += len(inside)
        places.append(inside)
        faces.append(at)
    vertices = np.concatenate(places)
    triangles = [_triangles(at, vertices) for at in faces]
    counts = tuple(len(own) for own in triangles)
    return Mesh(vertices.astype(np.float32), np.vstack(triangles)), counts


def _divisions(patchwork: Patchwork, tolerance: float) -> Index:
    """Return the number of steps along each edge, (m,).

    A triangle with legs of a and b in u and v is nowhere further from the surface than
    (a² M_uu + 2 a b M_uv + b² M_vv) / 8, where M bound the second derivatives (Filip,
    Magedson & Markot 1986, "Surface algorithms using bounds on derivatives"); and 2 a b is at
    most a² + b². The control points bound the derivatives.
    """
    nets = patchwork.nets
    bent_u = 6.0 * _longest(np.diff(nets, 2, axis=1))
    bent_v = 6.0 * _longest(np.diff(nets, 2, axis=2))
    twisted = 9.0 * _longest(np.diff(np.diff(nets, axis=1), axis=2))
    wanted = np.stack((bent_u + twisted, bent_v + twisted), axis=1) / (4.0 * tolerance)
    steps = np.clip(np.ceil(np.sqrt(wanted)), 1, MOST_DIVISIONS).astype(np.intp)
    numbers = edge_numbers(patchwork.sides)
    strips = _strips(numbers, len(patchwork.edges))
    most = np.ones(len(patchwork.edges), np.intp)
    for k in range(4):
        np.maximum.at(most, strips[numbers[:, k]], steps[:, k % 2])
    return np.asarray(most[strips])


def _longest(vectors: Array) -> Array:
    """Return the length of the longest vector of each net, (k,)."""
    return np.asarray(np.linalg.norm(vectors, axis=-1).reshape(len(vectors), -1).max(axis=1))


def _strips(numbers: Index, count: int) -> Index:
    """Return the least edge in the strip of each edge: opposite edges of a patch share a strip."""
    least = np.arange(count)
    pairs = np.vstack((numbers[:, [0, 2]], numbers[:, [1, 3]]))
    while True:
        low = least[pairs].min(axis=1)
        if (least[pairs] == low[:, None]).all():
            return least
        for k in range(2):
            np.minimum.at(least, pairs[:, k], low)


def _triangles(at: Index, vertices: Array) -> Index:
    """Return two triangles in every cell of a grid, on both sides of the shorter diagonal."""
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    first = ((vertices[a] - vertices[c]) ** 2).sum(axis=1)
    second = ((vertices[b] - vertices[d]) ** 2).sum(axis=1)
    turned = (second < first)[:, None]
    one = np.where(turned, np.stack((a, b, d), axis=1), np.stack((a, b, c), axis=1))
    two = np.where(turned, np.stack((b, c, d), axis=1), np.stack((a, c, d), axis=1))
    return np.vstack((one, two))


def shaded(patchwork: Patchwork, divisions: int = 12) -> Mesh:
    """Triangulate for display: every patch on its own with exact normals, so that creases show.

    Made in about a millisecond, to follow a hand. Neighbours have the same places on the edge
    between them, bit for bit.

    Parameters
    ----------
    patchwork : Patchwork
        The patches.
    divisions : int
        Steps along each side of a patch.

    Returns
    -------
    Mesh
        Patch after patch, and in each all v of the first u, then of the next
        (`shaded_parameters`): (k, divisions + 1, divisions + 1) vertices in a row.
    """
    at = shaded_parameters(divisions)
    places = grid(patchwork.nets, at, at)
    lines = bernstein(at) @ patchwork.edges
    signed = np.asarray(patchwork.sides, np.intp)
    sides = np.where(
        (signed < 0)[..., None, None],
        lines[edge_numbers(signed), ::-1],
        lines[edge_numbers(signed)],
    )
    places[:, :, 0], places[:, -1] = sides[:, 0], sides[:, 1]
    places[:, ::-1, -1], places[:, 0, ::-1] = sides[:, 2], sides[:, 3]
    return Mesh(
        places.reshape(-1, 3).astype(np.float32),
        _grid_faces(len(places), divisions),
        grid_normals(patchwork.nets, at, at).reshape(-1, 3).astype(np.float32),
    )


def shaded_parameters(divisions: int = 12) -> Array:
    """Return the parameters u and v of the vertices that `shaded` makes, (divisions + 1,)."""
    return np.linspace(0.0, 1.0, divisions + 1)


@lru_cache(maxsize=8)
def _grid_faces(patches: int, divisions: int) -> NDArray[np.int32]:
    """Return two triangles in every cell of `patches` grids."""
    at = np.arange(patches * (divisions + 1) ** 2).reshape(patches, divisions + 1, divisions + 1)
    a, b, c, d = at[:, :-1, :-1], at[:, 1:, :-1], at[:, 1:, 1:], at[:, :-1, 1:]
    faces = np.stack((np.stack((a, b, c), axis=-1), np.stack((a, c, d), axis=-1)), axis=-2)
    return frozen(faces, np.int32, 3)
