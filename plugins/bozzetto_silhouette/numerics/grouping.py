"""Grouping of nodes and faces: the connected pieces of a graph, and what lies beside each face."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Faces, Index


def connected_pieces(one: Index | Faces, other: Index | Faces, count: int) -> tuple[int, Faces]:
    """Find the connected pieces of an undirected graph, and number them.

    Parameters
    ----------
    one, other : (e,) int array
        Both ends of each edge; an edge may occur more than once.
    count : int
        Number of nodes; a node without edges is a piece of its own.

    Returns
    -------
    pieces : int
        How many there are.
    number : (count,) int array
        Of the piece that each node is in.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(one), np.int32), (one, other)), shape=(count, count))
    pieces, number = connected_components(graph, directed=False)
    return int(pieces), number


def face_neighbours(faces: Faces | Index, count: int) -> Index:
    """Find the face on the other side of each edge of a mesh.

    Parameters
    ----------
    faces : (f, 3) int array
        Each edge in either direction belongs to one face at the most.
    count : int
        Number of vertices.

    Returns
    -------
    (f, 3) int array
        For the edge from each corner to the next; -1 where there is none.
    """
    begin, end = faces.astype(np.int64), np.roll(faces, -1, axis=1).astype(np.int64)
    along, against = (begin * count + end).ravel(), (end * count + begin).ravel()
    order = np.argsort(along, kind="stable")
    at = np.searchsorted(along, against, sorter=order)
    partner = order[np.minimum(at, len(order) - 1)]
    beyond: Index = np.where(along[partner] == against, partner // 3, -1).reshape(-1, 3)
    return beyond
