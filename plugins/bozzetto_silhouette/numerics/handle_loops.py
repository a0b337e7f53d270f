"""Loops that go around the handles and through the tunnels of a closed mesh.

A tree of shortest ways, and a tree of faces that crosses none of its edges, leave two edges for
each handle (Eppstein, "Dynamic generators of topologically embedded graphs", 2003). Each closes a
loop that does not divide the mesh. Of all trees of faces the one that crosses the edges of long
loops leaves the short ones (Erickson and Whittlesey, "Greedy optimal homotopy and homology
generators", 2005).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import cached_property
from bozzetto_silhouette.numerics.grouping import connected_pieces

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def shortest_loop(vertices: Array, faces: Index, roots: Index, longest: Array) -> Index | None:
    """Return a short loop that does not divide a mesh, as a row of vertices in order.

    Parameters
    ----------
    vertices, faces : (v, 3) float array, (f, 3) int array
        A closed mesh in which every vertex has faces.
    roots : (n,) int array
        One vertex of each connected piece.
    longest : (v,) float array
        How long a loop is at most that passes a vertex. None where none that is found is as short.
    """
    edges = _Edges(vertices, faces)
    most = float(longest.max())
    found = [
        loop
        for long in edges.loops(roots)
        for loop in edges.loops(long[:1], most)
        if edges.length(loop) <= longest[loop].min()
    ]
    return min(found, key=edges.length, default=None)


class _Edges:
    """The edges of a closed mesh, each with the faces at its sides."""

    def __init__(self, vertices: Array, faces: Index) -> None:
        a, b = faces.ravel().astype(np.int64), np.roll(faces, -1, axis=1).ravel().astype(np.int64)
        low, high = np.minimum(a, b), np.maximum(a, b)
        order = np.argsort(low * len(vertices) + high, kind="stable")
        face = np.repeat(np.arange(len(faces)), 3)[order]
        self.vertices = vertices
        self.faces = len(faces)
        self.ends = np.stack([low, high], axis=1)[order[::2]]
        self.sides = np.stack([face[::2], face[1::2]], axis=1)
        way = vertices[self.ends[:, 0]] - vertices[self.ends[:, 1]]
        self.lengths = np.sqrt(np.einsum("ij,ij->i", way, way))

    def length(self, loop: Index) -> float:
        """Return the length of a loop."""
        way = self.vertices[loop] - self.vertices[np.roll(loop, -1)]
        return float(np.sqrt((way**2).sum(axis=1)).sum())

    def loops(self, roots: Index, reach: float = np.inf) -> list[Index]:
        """Return the loops that one edge each closes, without what leads there from the roots.

        Only edges are looked at whose ends are no farther from the roots than a reach.
        """
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import dijkstra, minimum_spanning_tree

        a, b = self.ends.T
        far, before, _ = dijkstra(
            self._graph, directed=False, indices=roots, return_predecessors=True, min_only=True,
            limit=reach,
        )  # fmt: skip
        near = np.isfinite(far[a]) & np.isfinite(far[b])
        rest = np.flatnonzero(near & (before[a] != b) & (before[b] != a))
        if not len(rest):
            return []
        # Beyond the reach a tree of faces may cross every edge.
        pieces, piece = connected_pieces(self.sides[~near, 0], self.sides[~near, 1], self.faces)
        sides = np.sort(piece[self.sides[rest]].astype(np.int64), axis=1)
        around = far[a[rest]] + far[b[rest]] + self.lengths[rest]
        # Edges of long loops are light; of several between two pieces one is crossed.
        weight = 2.0 - around / max(float(around.max()), 1e-300)
        weight[sides[:, 0] == sides[:, 1]] = np.inf
        keys = sides @ np.array([pieces, 1])
        order = np.argsort(weight, kind="stable")
        once = order[np.unique(keys[order], return_index=True)[1]]
        once = once[np.isfinite(weight[once])]
        dual = csr_array((weight[once], tuple(sides[once].T)), shape=(pieces, pieces))
        tree = minimum_spanning_tree(dual).tocoo()
        crossed = np.sort(np.stack([tree.row, tree.col], axis=1), axis=1).astype(np.int64)
        left = np.ones(len(rest), dtype=bool)
        left[once[np.isin(keys[once], crossed @ np.array([pieces, 1]))]] = False
        ways = before.astype(np.intp)
        return [_closed(ways, int(a[k]), int(b[k])) for k in rest[left]]

    @cached_property
    def _graph(self) -> csr_array:
        from scipy.sparse import csr_array

        count = len(self.vertices)
        lengths = np.maximum(self.lengths, 1e-300)
        return csr_array((lengths, tuple(self.ends.T)), shape=(count, count))


def _closed(before: Index, one: int, other: int) -> Index:
    """Return the loop of the ways from the roots to two vertices, without what both share."""
    first, second = (_way(before, vertex) for vertex in (one, other))
    while len(first) > 1 and len(second) > 1 and first[-2] == second[-2]:
        first.pop()
        second.pop()
    return np.array(first + second[-2::-1], np.intp)


def _way(before: Index, vertex: int) -> list[int]:
    """Return a vertex and those before it, up to a root."""
    way = [vertex]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return way
