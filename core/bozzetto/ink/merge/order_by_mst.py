"""Order by the longest path through the spanning tree of the ink."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from bozzetto.ink.curves.resample import arc_length
from bozzetto.ink.merge.resample_all import Ordering, ResampledInk

if TYPE_CHECKING:
    from bozzetto.arrays import Array

THINNING: Final = 2.0
"""Side of the squares in which ink is averaged to a point of the ridge, in spacings."""

RIDGE: Final = 6.0
"""Radius within which a point is drawn onto the middle of the ink, in spacings."""

NEIGHBOURS: Final = 8
"""Neighbours a point of the ridge can be tied to."""

EXTENSION: Final = 5.0
"""How far the path is continued at its ends, in spacings: the tree's path stops short, and
the ink beyond gets parameters of its own in this way."""

MEETING: Final = 6.0
"""Gap of the ends of a closed curve, in spacings."""

ROUND: Final = 20.0
"""Least length of a closed curve, in spacings."""


def order_by_mst(ink: ResampledInk) -> Ordering | None:
    """Thin the ink to a ridge, walk the longest path of its spanning tree, project the ink.

    Right for hooks, spirals and closed curves; cuts crossings short.
    """
    path = _longest_path(_ridge(ink))
    if len(path) < 3:
        return None
    gap = float(np.linalg.norm(path[0] - path[-1]))
    closed = gap < MEETING * ink.spacing and arc_length(path)[-1] > ROUND * ink.spacing
    path = _softened(path)
    chain = np.vstack((path, path[:1])) if closed else _extended(path, EXTENSION * ink.spacing)
    along = _projected(ink.points, chain)
    low, high = (0.0, float(arc_length(chain)[-1])) if closed else (along.min(), along.max())
    if not high > low:
        return None
    return Ordering(np.arange(len(along)), (along - low) / (high - low), closed)


def _ridge(ink: ResampledInk) -> Array:
    """Return one point for each square with ink, moved to the middle of the ink around it."""
    from scipy.spatial import cKDTree

    square = np.round(ink.points / (THINNING * ink.spacing)).astype(np.int64)
    _, group = np.unique(square, axis=0, return_inverse=True)
    group = group.ravel()
    mass = np.bincount(group, ink.weights)
    ridge = np.column_stack([np.bincount(group, ink.weights * c) / mass for c in ink.points.T])
    near = np.atleast_1d(cKDTree(ridge).query_ball_point(ink.points, RIDGE * ink.spacing))
    rows = [np.asarray(row, np.intp) for row in near]
    counts = np.array([len(row) for row in rows])
    home = np.concatenate(rows)
    weight = np.repeat(ink.weights, counts)
    mass = np.bincount(home, weight, len(ridge))
    sums = [np.bincount(home, weight * np.repeat(c, counts), len(ridge)) for c in ink.points.T]
    return np.asarray(np.column_stack(sums) / mass[:, None])


def _longest_path(ridge: Array) -> Array:
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components, dijkstra, minimum_spanning_tree
    from scipy.spatial import cKDTree

    ridge = np.unique(ridge, axis=0)
    count = len(ridge)
    if count < 2:
        return ridge
    found = cKDTree(ridge).query(ridge, k=min(NEIGHBOURS + 1, count))
    distance, neighbour = np.asarray(found[0]), np.asarray(found[1])
    rows = np.repeat(np.arange(count), distance.shape[1] - 1)
    pairs = csr_array((distance[:, 1:].ravel(), (rows, neighbour[:, 1:].ravel())), (count, count))
    tree: Any = minimum_spanning_tree(pairs.maximum(pairs.T))  # the stubs know no sparse graphs
    _, island = connected_components(tree, directed=False)
    start = int(np.flatnonzero(island == np.argmax(np.bincount(island)))[0])
    walk: Any = dijkstra  # nor single starts
    first = _farthest(walk(tree, directed=False, indices=start))
    far, before = walk(tree, directed=False, indices=first, return_predecessors=True)
    path = [_farthest(far)]
    while path[-1] != first:
        path.append(int(before[path[-1]]))
    return np.asarray(ridge[path])


def _farthest(distance: Array) -> int:
    return int(np.argmax(np.where(np.isfinite(distance), distance, -1.0)))


def _softened(path: Array) -> Array:
    """Smooth a path by a three-point mean; the ends stay."""
    inner = (path[:-2] + path[1:-1] + path[2:]) / 3.0
    return np.vstack((path[:1], inner, path[-1:]))


def _extended(path: Array, reach: float) -> Array:
    back = min(4, len(path) - 1)
    head, tail = path[0] - path[back], path[-1] - path[-1 - back]
    head, tail = (v / max(float(np.linalg.norm(v)), 1e-300) * reach for v in (head, tail))
    return np.vstack((path[0] + head, path, path[-1] + tail))


def _projected(points: Array, chain: Array) -> Array:
    """Return the arc length of the nearest place of a polyline, beside its nearest point."""
    from scipy.spatial import cKDTree

    nearest = cKDTree(chain).query(points)[1]
    along = arc_length(chain)
    best, found = np.full(len(points), np.inf), np.zeros(len(points))
    for start in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(chain) - 2)):
        step = chain[start + 1] - chain[start]
        squared = np.maximum((step**2).sum(axis=1), 1e-300)
        share = np.clip(((points - chain[start]) * step).sum(axis=1) / squared, 0.0, 1.0)
        distance = np.linalg.norm(chain[start] + share[:, None] * step - points, axis=1)
        at = along[start] + share * (along[start + 1] - along[start])
        found = np.where(distance < best, at, found)
        best = np.minimum(best, distance)
    return found
