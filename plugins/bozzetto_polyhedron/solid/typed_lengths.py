"""A body with other lengths, of which nothing else changes that need not.

A person who types the height of a bracket means its height: not its width, and not how thick its
foot is. So the planes keep their normals, and the sum of the relative changes of all edges is the
least: of absolute values, so that few edges change (basis pursuit; Chen, Donoho and Saunders
1998), and of relative ones, so that long edges change rather than short ones. Edges of like
lengths share a change, as the steps of stairs do. Where edges do not decide it, the planes go that
look up, else those that look to the right or away from the eye: what stands goes on standing.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import block_array, csr_array, eye_array

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.solid.face_rings import tangents

SHARED: Final = 0.1
"""Weight of the largest change of edges that are alike, beside that of the sum of all changes."""

PLANES: Final = 1e-3
"""The same for the ways of planes, as shares of the size: it decides where edges do not."""

STAYS: Final = (0.4, 0.1, 0.03)
"""How much less a plane that looks along one of the directions weighs than others."""

ALIKE: Final = 3.0
"""Standard deviations of a corner within which lengths of parallel edges are alike."""

PARALLEL: Final = 1.0 - 1e-9
"""Cosine from which on edges are parallel."""


def moved_planes(
    vertices: Array,
    pairs: Index,
    edges: Index,
    normals: Array,
    changes: tuple[Array, Array],
    directions: Array,
    noise: float,
) -> tuple[Array, Array] | None:
    """Return the ways of corners and of planes; None where no motion is enough.

    Parameters
    ----------
    vertices : (n, 3) float
        Corners that lie in their planes; a size of about 1.
    pairs : (i, 2) int
        Face and vertex of each incidence.
    edges : (m, 2) int
        Vertices of the edges.
    normals : (f, 3) float
        Unit normals of the planes, which they keep.
    changes : ((r, f) float, (r,) float)
        Equations between the ways that the planes go along their normals.
    directions : (3, 3) float
        Rows: up, to the right, and away from the eye.
    noise : float
        Standard deviation of a corner.

    Returns
    -------
    ((n, 3) float, (f,) float) or None
        Ways of the corners, and of the planes along their normals.
    """
    count, planes, many = len(vertices), len(normals), len(edges)
    along = vertices[edges[:, 1]] - vertices[edges[:, 0]]
    lengths = np.linalg.norm(along, axis=1)
    if not (lengths > 0.0).all():
        return None
    unit = along / lengths[:, None]
    group = _alike(unit, lengths, ALIKE * noise)
    mean = (np.bincount(group, lengths) / np.bincount(group))[group]
    groups = int(group.max()) + 1

    # unknown: ways of corners and of planes; absolute changes of edges along and across them, the
    # largest of those that are alike, absolute ways of planes
    corners = _per_corner(pairs[:, 1], normals[pairs[:, 0]], count)
    onto = _rows(np.arange(len(pairs)), pairs[:, 0], np.ones(len(pairs)), (len(pairs), planes))
    across = np.array([tangents(each) for each in unit])
    ways_of = np.concatenate((unit, across[:, 0], across[:, 1]))
    begin, end = (np.tile(edges[:, side], 3) for side in (0, 1))
    change = _per_corner(end, ways_of, count) - _per_corner(begin, ways_of, count)
    of_group = _rows(np.arange(many), group, np.ones(many), (many, groups))
    longer = _rows(np.arange(many), np.arange(many), np.ones(many), (many, 3 * many))
    edge, plane = eye_array(3 * many, format="csr"), eye_array(planes, format="csr")
    equal = block_array(
        [
            [corners, -onto, _none(len(pairs), 3 * many + groups + planes)],
            [None, csr_array(changes[0]), None],
        ],
        format="csr",
    )
    at_most = block_array(
        [
            [change, None, -edge, None, None],
            [-change, None, -edge, None, None],
            [None, None, longer, -of_group, None],
            [None, plane, None, None, -plane],
            [None, -plane, None, None, -plane],
        ],
        format="csr",
    )
    facing = normals @ directions.T
    cost = np.concatenate(
        (
            np.zeros(3 * count + planes),
            np.tile(1.0 / mean, 3),
            SHARED * np.bincount(group, 1.0 / mean),
            PLANES * (1.0 - facing @ STAYS),
        )
    )
    wanted = np.concatenate((np.zeros(len(pairs)), changes[1]))
    solve: Any = linprog  # whose types do not know sparse arrays
    found = solve(
        cost,
        A_ub=at_most,
        b_ub=np.zeros(at_most.shape[0]),
        A_eq=equal,
        b_eq=wanted,
        bounds=(None, None),
        method="highs",
    )
    if found.x is None:
        return None
    ways = found.x[: 3 * count + planes]
    equations = equal[:, : 3 * count + planes].toarray()
    # the program is solved to 1e-7 of the size; the nearest solution is exact to rounding
    ways = ways - np.linalg.lstsq(equations, equations @ ways - wanted)[0]
    return ways[: 3 * count].reshape(-1, 3), ways[3 * count :]


def _alike(unit: Array, lengths: Array, tolerance: float) -> Index:
    """Return a number for each edge; edges that are parallel and of like lengths share one."""
    group = np.full(len(lengths), -1, np.intp)
    fresh = 0
    for number in np.argsort(lengths, kind="stable"):
        if group[number] >= 0:
            continue
        parallel = np.abs(unit @ unit[number]) > PARALLEL
        near = np.abs(lengths - lengths[number]) <= tolerance + 1e-9
        group[parallel & near & (group < 0)] = fresh
        fresh += 1
    return group


def _per_corner(corners: Index, vectors: Array, count: int) -> csr_array:
    """Return the rows that multiply the way of one corner each with a vector."""
    rows = np.repeat(np.arange(len(corners)), 3)
    columns = (3 * corners[:, None] + np.arange(3)).ravel()
    return _rows(rows, columns, vectors.ravel(), (len(corners), 3 * count))


def _rows(rows: Index, columns: Index, values: Array, shape: tuple[int, int]) -> csr_array:
    return csr_array((values, (rows, columns)), shape=shape)


def _none(rows: int, columns: int) -> csr_array:
    return csr_array((rows, columns))
